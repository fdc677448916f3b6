// Show one tab, and of its pages (cases, studies) one at a time; each is initialised when it is first shown.
(() => {
  const root = document.documentElement, chapters = [...document.querySelectorAll("main > .chapter")];
  const links = [...document.querySelectorAll("nav.chapters a")], pages = (chapter) => [...chapter.querySelectorAll("article")];
  const hide = (node, away) => { if (away) node.setAttribute("hidden", "until-found"); else node.removeAttribute("hidden"); };
  const awake = new Set(), title = document.title, unknown = document.querySelector(".unknown");

  async function wake(node) {
    if (awake.has(node)) return;
    awake.add(node);
    for (const place of node.querySelectorAll(".player")) {
      const player = await suite.player(place), plots = place.closest("article")?.querySelector(".plots");
      if (player && plots) suite.plots(plots, player);
    }
    for (const place of node.querySelectorAll(".by-route")) await suite.ofCase(place);
    node.querySelectorAll("table.data").forEach((table) => { if (!table.closest("details:not([open])")) suite.table(table); });
    node.querySelectorAll("table.cells").forEach((table) => suite.cells(table));
  }
  document.querySelectorAll("details").forEach((one) => one.addEventListener("toggle", () => one.open && one.querySelectorAll("table.data").forEach((table) => suite.table(table))));

  function show(scroll = true) {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const chapter = target?.closest("main > .chapter") ?? chapters[0], articles = pages(chapter);
    unknown.hidden = !location.hash || Boolean(target);
    unknown.textContent = `This page has no part “${location.hash.slice(1)}”. Find a case in the list of the tab Cases.`;
    chapters.forEach((one) => hide(one, one !== chapter));
    links.forEach((one) => { if (one.hash === `#${chapter.id}`) one.setAttribute("aria-current", "page"); else one.removeAttribute("aria-current"); });
    let name = chapter === chapters[0] ? "" : links.find((one) => one.hash === `#${chapter.id}`)?.textContent;
    if (articles.length) {
      const article = target?.closest("article") ?? articles.find((one) => !one.hidden) ?? articles[0];
      articles.forEach((one) => hide(one, one !== article));
      chapter.querySelectorAll(".index a").forEach((one) => { if (one.hash === `#${article.id}`) one.setAttribute("aria-current", "true"); else one.removeAttribute("aria-current"); });
      wake(article);
      name = article.querySelector("h3")?.textContent ?? name;
    } else wake(chapter);
    document.title = name ? `${name} · ${title}` : title;
    if (scroll) { if (target && target !== chapter && !target.matches("article, article > span, section > span")) target.scrollIntoView(); else scrollTo(0, 0); }
  }
  addEventListener("hashchange", () => { ["at", "setting"].forEach((name) => suite.keep(name)); show(); });
  // When the browser's search finds text in another chapter, show that chapter.
  document.addEventListener("beforematch", (event) => {
    const section = event.target.closest("article") ?? event.target.closest(".chapter");
    if (section) { history.replaceState(null, "", `#${section.id}`); show(false); }
  });

  const field = document.querySelector(".index input");
  field?.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean), index = field.closest(".index");
    // A case's name, family and summary.
    const text = (one) => [one, one.closest("section")?.querySelector("h3"), document.querySelector(`[id="${one.firstChild.hash.slice(1)}"] > h3 + p`)].map((part) => part?.textContent ?? "").join(" ").toLowerCase();
    index.querySelectorAll("li").forEach((one) => { one.hidden = !words.every((word) => text(one).includes(word)); });
    index.querySelectorAll("section").forEach((one) => { one.hidden = ![...one.querySelectorAll("li")].some((row) => !row.hidden); });
  });

  const theme = document.querySelector(".theme");
  theme?.addEventListener("click", () => {
    const dark = getComputedStyle(root).colorScheme === "dark" || (getComputedStyle(root).colorScheme !== "light" && matchMedia("(prefers-color-scheme: dark)").matches);
    root.dataset.theme = dark ? "light" : "dark";
    suite.announce();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => suite.announce());
  // What is shown alone, without the other tabs and cases.
  document.querySelector(".print")?.addEventListener("click", () => { root.classList.add("alone"); print(); root.classList.remove("alone"); });
  chapters.forEach((chapter) => pages(chapter).forEach((one, i) => hide(one, i > 0)));
  root.classList.add("ready");
  show(Boolean(location.hash));
})();
