// Tables that can be sorted, filtered, copied and saved as CSV; each is initialised when its chapter is first shown.
suite.table = (table) => {
  if (table.dataset.awake) return;
  table.dataset.awake = "yes";
  const rows = table.tBodies[0]?.rows.length ?? 0, name = table.dataset.name || "table";
  new DataTable(table, {
    paging: false, info: rows > 12, searching: rows > 6, order: [], autoWidth: false, typeDetect: true,
    layout: { topStart: rows > 6 ? { search: { placeholder: "filter rows" } } : null, topEnd: null, bottomStart: rows > 12 ? "info" : null, bottomEnd: null },
    language: { search: "", info: "_TOTAL_ rows", infoFiltered: "of _MAX_", infoEmpty: "no rows" },
  });
  const text = (cell) => cell.innerText.replace(/\s*\n\s*/g, " ").replace(/[⇅▲▼]/g, "").trim();
  const quoted = (value) => (/[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  // The visible rows, with all digits if the cell has a sort key.
  const csv = () => [table.tHead.rows[table.tHead.rows.length - 1], ...table.tBodies[0].rows].filter((row) => getComputedStyle(row).display !== "none")
    .map((row) => [...row.cells].filter((cell) => getComputedStyle(cell).display !== "none").map((cell) => quoted(+cell.dataset.order < 1e300 ? cell.dataset.order : text(cell))).join(",")).join("\n") + "\n";
  const tools = document.createElement("div");
  tools.className = "tools";
  const button = (label, act) => {
    const one = tools.appendChild(document.createElement("button"));
    one.type = "button";
    one.textContent = label;
    one.setAttribute("aria-label", `${label}: ${name}`);
    one.addEventListener("click", () => act(one));
  };
  button("copy", async (one) => {
    try { await navigator.clipboard.writeText(csv()); one.textContent = "copied"; } catch { one.textContent = "not allowed"; }
    setTimeout(() => { one.textContent = "copy"; }, 1500);
  });
  button("CSV", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([csv()], { type: "text/csv" }));
    link.download = `${name}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  });
  const search = table.closest(".dt-container").querySelector(".dt-search");
  if (search) {
    search.querySelector("input").setAttribute("aria-label", `filter rows of ${name}`);
    search.querySelector("label")?.remove();
    tools.prepend(search);
  }
  (table.closest(".scroll") ?? table).before(tools);
};

// The first sentence names the most accurate engine of the rows that are shown, and those tied with it.
suite.verdict = () => {
  const place = document.querySelector("p.verdict[data-lead]");
  const rows = [...document.querySelectorAll("tr[data-phrase]")].filter((row) => suite.on(row.dataset.solver, row.dataset.route));
  if (!rows.length) { place.textContent = "No engine is shown."; return; }
  const best = rows.reduce((one, row) => (+row.dataset.digits > +one.dataset.digits ? row : one));
  const tied = (row) => +best.dataset.digits - +row.dataset.digits <= Math.max(+place.dataset.tie, Math.hypot(+best.dataset.doubt, +row.dataset.doubt));
  place.textContent = `${place.dataset.lead} ${rows.filter(tied).map((row) => row.dataset.phrase).join("; tied with it ")}.`;
};
if (document.querySelector("tr[data-phrase]")) suite.whenSwitched(suite.verdict);
