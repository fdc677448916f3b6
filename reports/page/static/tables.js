// Tables that can be sorted, filtered and copied; each is initialised when it is first shown. Of a long one only the
// first rows are elements of the page: the others are read from its file, which is inside the page, when they are wanted.
const EMPTY = 1e300;
// Cells without a number are last in both directions.
DataTable.ext.type.order["num-asc"] = (a, b) => a - b;
DataTable.ext.type.order["num-desc"] = (a, b) => (a >= EMPTY) - (b >= EMPTY) || b - a;
// What belongs to a route, which the switches hide.
suite.mark = (node, { solver, route }) => { if (solver) node.dataset.solver = solver; if (solver && route) node.dataset.route = route; };
// A row of cells, each with text, sort key, class, tooltip, solver and route.
suite.row = (body, of, cells) => {
  const row = body.insertRow();
  suite.mark(row, of);
  for (const one of cells) {
    const cell = row.insertCell();
    cell.textContent = one.text;
    if (one.order !== undefined) cell.dataset.order = one.order || "1e308";
    if (one.kind) cell.className = one.kind;
    if (one.title) cell.title = one.title;
    suite.mark(cell, one);
  }
};
suite.table = (table) => {
  if (table.dataset.awake) return;
  table.dataset.awake = "yes";
  const { file, name = "table", count } = table.dataset, cue = (table.closest(".scroll") ?? table).nextElementSibling;
  const shown = () => table.tBodies[0]?.rows.length ?? 0, isPart = Boolean(file) && shown() < +count;
  const tools = document.createElement("div");
  tools.className = "tools";
  const button = (label, act) => {
    const one = tools.appendChild(document.createElement("button"));
    one.type = "button";
    one.textContent = label;
    one.setAttribute("aria-label", `${label}: ${name}`);
    one.addEventListener("click", () => act(one));
    return one;
  };
  (table.closest(".scroll") ?? table).before(tools);
  let grid = null;

  function begin(length) {
    const long = length > 50;
    grid = new DataTable(table, {
      paging: long, pageLength: 50, lengthMenu: [50, 200, { label: "all", value: -1 }], info: long, searching: length > 6, order: [], autoWidth: false,
      layout: { topStart: length > 6 ? { search: { placeholder: "filter rows" } } : null, topEnd: null, bottomStart: long ? "info" : null, bottomEnd: long ? ["pageLength", "paging"] : null },
      language: { search: "", info: "rows _START_ to _END_ of _TOTAL_", infoFiltered: "(of _MAX_)", infoEmpty: "no rows", lengthMenu: "rows a page _MENU_" },
    });
    const search = table.closest(".dt-container").querySelector(".dt-search");
    if (search) {
      search.querySelector("input").setAttribute("aria-label", `filter rows of ${name}`);
      search.querySelector("label")?.remove();
      tools.prepend(search);
    }
  }

  // All rows of the file, in the columns that are shown.
  async function complete() {
    const heads = [...table.tHead.rows[0].cells], rows = await suite.rows(file);
    if (!rows) return;
    const body = document.createElement("tbody");
    for (const row of rows) suite.row(body, { ...row, route: row.solver === "reference" ? "" : row.route }, heads.map((head) => {
      const column = head.dataset.column, value = row[column], isShare = head.querySelector("small")?.textContent === "%" && value !== "";
      if (head.classList.contains("number")) return { kind: "number", order: value, title: value, text: isShare ? (+value ? suite.number(100 * value) : "0") : suite.shorten(value, column, true) };
      const isWord = /^(answered|excellent|very good|good|rough|poor|unusable|not decided|crashed|timed_out|paired|missed|spurious)$/.test(value), isLong = /^(reason|notes?)$/.test(column) || value.length > 40;
      return { kind: isWord ? value.replace(" ", "-") : column.includes("setting") ? "setting" : isLong ? "reason" : "", text: suite.shorten(value, column, false) };
    }));
    table.tBodies[0].replaceWith(body);
    cue?.querySelector(".part")?.remove();
    begin(rows.length);
  }

  if (isPart) {
    const all = button(`all ${(+count).toLocaleString("en-US")} rows`, async () => { all.disabled = true; await complete(); all.remove(); });
    if (!shown()) all.click();
  } else begin(shown());
  const text = (cell) => cell.innerText.replace(/\s*\n\s*/g, " ").replace(/[⇅▲▼]/g, "").trim();
  // The rows that the filter and the switches leave, on all pages, with all digits if the cell has a sort key.
  const visible = () => (grid ? [...grid.rows({ search: "applied", order: "applied" }).nodes().toArray()] : [...table.tBodies[0].rows]).filter((row) => !row.dataset.solver || suite.on(row.dataset.solver, row.dataset.route));
  const csv = () => suite.csv([table.tHead.rows[table.tHead.rows.length - 1], ...visible()]
    .map((row) => [...row.cells].map((cell) => (+cell.dataset.order < EMPTY ? cell.dataset.order : row.parentNode ? text(cell) : cell.textContent))));
  button("copy", async (one) => {
    try { await navigator.clipboard.writeText(csv()); one.textContent = "copied"; } catch { one.textContent = "not allowed"; }
    setTimeout(() => { one.textContent = "copy"; }, 1500);
  });
};

// A cell belongs to its column's route, which the switches hide.
document.querySelectorAll("table.cells").forEach((table) => [...table.tHead.rows[0].cells].forEach((head, i) => {
  head.dataset.name = head.innerText.replace(/\s+/g, " ").trim();
  for (const row of table.tBodies[0].rows) suite.mark(row.cells[i], head.dataset);
}));

// The details of a cell on tap, click and focus: one stop of Tab for the whole table, then the arrow keys.
suite.cells = (table) => {
  const details = table.closest("article").querySelector(".details"), heads = table.tHead.rows[0].cells;
  let now = null;
  const go = (cell) => {
    if (!cell?.title) return;
    if (now) { now.tabIndex = -1; now.classList.remove("now"); }
    now = cell;
    cell.tabIndex = 0;
    cell.classList.add("now");
    cell.focus();
  };
  table.addEventListener("click", (event) => go(event.target.closest("td[title]")));
  table.addEventListener("focusin", ({ target }) => { if (target.matches("td[title]")) details.textContent = `${target.parentNode.querySelector("th").textContent}, ${heads[target.cellIndex].dataset.name}: ${target.title}`; });
  table.addEventListener("keydown", (event) => {
    const [down, right] = { ArrowDown: [1, 0], ArrowUp: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] }[event.key] ?? [];
    if (down === undefined || !event.target.matches("td")) return;
    event.preventDefault();
    go(table.tBodies[0].rows[event.target.parentNode.sectionRowIndex + down]?.cells[event.target.cellIndex + right]);
  });
  const first = table.querySelector("tbody td[title]");
  if (first) { now = first; first.tabIndex = 0; }
};

// A value of a file rounded for reading, as in the rows of the page: times to nine digits, errors to two.
suite.shorten = (value, column, isNumber) => {
  if (value === "True" || value === "False") return value === "True" ? "yes" : "";
  if (!isNumber || value === "" || /^-?\d+$/.test(value)) return value;
  const size = +value, power = (text) => text.replace("e+", "e"), plain = (digits) => {
    const short = +size.toPrecision(digits), exponent = short ? Math.floor(Math.log10(Math.abs(short))) : 0;
    return exponent < -4 || exponent >= digits ? power(short.toExponential()) : String(short);
  };
  if (column === "level") return size >= 1e-3 ? String(size) : power(size.toExponential(0));
  if (["time", "reference_time", "published", "ours"].includes(column)) return plain(9);
  if (/(error|error_bar|_max|_rms|_mean|_final|_doubt)$/.test(column)) return size === 0 ? "0" : power(size.toExponential(1));
  if (column.startsWith("order")) return size.toFixed(2);
  return Math.abs(size) >= 100 ? suite.number(size) : plain(2);
};

// The button of a file saves it from the page, so that a page without its folder has it as well.
document.querySelectorAll("a.csv").forEach((link) => link.addEventListener("click", async (event) => {
  if (link.dataset.saving) return;
  event.preventDefault();
  const address = link.href, name = link.textContent, text = await suite.file(name.replace(".csv", ""));
  if (text !== null) link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.dataset.saving = "yes";
  link.click();
  delete link.dataset.saving;
  if (text !== null) { URL.revokeObjectURL(link.href); link.href = address; }
}));

// Of each case the fastest routes that are shown are bold; the sentence above compares two of them.
suite.fastest = () => {
  const rows = [...document.querySelectorAll("table.calls tbody tr")].filter((row) => suite.on(row.dataset.solver, row.dataset.route));
  const cost = (row, place) => +row.cells[place].dataset.order;
  const groups = Map.groupBy ? Map.groupBy(rows, (row) => row.dataset.group) : rows.reduce((map, row) => map.set(row.dataset.group, [...(map.get(row.dataset.group) ?? []), row]), new Map());
  for (const group of groups.values())
    for (const place of [2, 3, 4]) {
      const least = Math.min(...group.map((row) => cost(row, place)));
      group.forEach((row) => row.cells[place].classList.toggle("best", cost(row, place) === least && least < 1e300));
    }
  const sentence = document.querySelector(".cheapest strong"), rest = document.querySelector(".of-all");
  if (!sentence) return;
  sentence.dataset.whole ??= sentence.textContent;
  rest.hidden = !suite.isWhole();
  if (suite.isWhole()) { sentence.textContent = sentence.dataset.whole; return; }
  const [name, group] = [...groups].find(([, all]) => all.some((row) => cost(row, 2) < 1e300)) ?? [];
  if (!name) { sentence.textContent = "No route with times is shown."; return; }
  const fastest = (place) => group.reduce((one, row) => (cost(row, place) < cost(one, place) ? row : one));
  const clause = (what, place) => `${what} ${suite.seconds(cost(fastest(place), place))} with ${fastest(place).cells[1].textContent}`;
  sentence.textContent = `Of the routes shown, called from Python, the fastest in ${name}: ${clause("the first run takes", 2)}; ${clause("1,000 runs take", 3)}.`;
};
suite.whenSwitched(suite.fastest);
suite.fastest();
