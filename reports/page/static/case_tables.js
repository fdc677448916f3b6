// The tables of one case, from the files inside the page: its engines, its transitions, its impacts and their impulses.
// Impacts whose impulses are listed.
const MOST_IMPACTS = 12;
suite.ofCase = async (place) => {
  const label = place.dataset.case, of = async (name) => ((await suite.rows(name)) ?? []).filter((row) => row.case === label);
  const [all, truth, transitions, impacts, impulses] = await Promise.all(["headline", "truth", "transitions", "impacts", "impulses"].map(of));
  const engines = all.filter((row) => row.route && row.solver !== "reference");
  const power = (value) => (+value === 0 ? "0" : (+value).toExponential(1).replace("e+", "e")), signed = (value) => `${value < 0 ? "" : "+"}${power(value)}`;

  // A table: heads with title, tip, `number`, solver and route; lines of cells, each a text, or a text, a sort key and a class.
  function add(name, heads, lines) {
    if (!lines.length) return;
    const frame = place.appendChild(document.createElement("div"));
    frame.className = "scroll";
    for (const [key, value] of Object.entries({ tabindex: 0, role: "region", "aria-label": `table: ${name}, ${label}` })) frame.setAttribute(key, value);
    const table = frame.appendChild(document.createElement("table"));
    table.className = "data short grades";
    table.dataset.name = name;
    const top = table.createTHead().insertRow(), body = table.createTBody();
    for (const head of heads) {
      const cell = top.appendChild(document.createElement("th"));
      cell.scope = "col";
      cell.textContent = head.title;
      if (head.unit) cell.append(" ", Object.assign(document.createElement("small"), { textContent: head.unit }));
      cell.title = head.tip ?? "";
      cell.className = head.number ? "number" : "";
      suite.mark(cell, head);
    }
    for (const line of lines) suite.row(body, line, line.cells.map((one, i) => {
      const [text, order, kind = ""] = [one].flat();
      return { ...heads[i], title: "", text, order, kind: `${heads[i].number ? "number" : ""} ${kind}`.trim() };
    }));
  }
  // A heading of each engine's route for a column of its own.
  const each = (unit, tip, title = "") => ({ solver, route }) => ({ title: title || `${solver} ${route}`, unit, tip, number: true, solver, route });
  const fine = (rows, engine) => rows.filter((row) => row.solver === engine.solver && row.route === engine.route && row.setting === engine.finest_setting);

  const off = (value) => (value === "" ? "–" : +value < 1e-6 ? "<0.0001" : suite.number(100 * value));
  const level = (row) => (row.level === "" ? (row.finest_off === "" ? "" : "none") : `${suite.number(100 * row.level)} % by ${row.settings_within} setting${+row.settings_within === 1 ? "" : "s"}`);
  const factor = (row, which) => (row[`${which}_friction_factor`] === "" ? "" : suite.number(+row[`${which}_friction_factor`]));
  add("engines", [
    { title: "engine" }, { title: "route" }, { title: "default", unit: "%", number: true, tip: "off with default settings: the median, and the range over usual values" },
    { title: "friction ×", number: true, tip: "friction and other losses as a multiple of the law's, with default settings" }, { title: "finest", unit: "%", number: true, tip: "off at the finest setting run" },
    { title: "friction ×", number: true, tip: "the same at the finest setting run" }, { title: "reaches", tip: "the smallest level that the ladder stays within, and by how many of its settings, the finest included" },
  ], engines.map((row) => {
    const range = +row.default_settings > 1 ? ` (${off(row.default_off_best)} to ${off(row.default_off_worst)})` : "";
    const cell = (which, more = "") => [off(row[`${which}_off`]) + more, row[`${which}_off`], row[`${which}_grade`].replace(" ", "-")];
    return { ...row, cells: [row.solver, row.route, cell("default", range), [factor(row, "default"), row.default_friction_factor], cell("finest"), [factor(row, "finest"), row.finest_friction_factor], level(row)] };
  }));

  const events = truth.filter((row) => row.event !== "0"), own = engines.map((engine) => fine(transitions, engine));
  const error = (row) => !row ? "" : row.error === "" ? row.pairing : Math.abs(row.error) > +row.truth_error_bar ? signed(row.error) : `< ${power(row.truth_error_bar)}`;
  add("transitions", [
    { title: "transition" }, { title: "at", unit: "s", number: true, tip: "time of the truth" }, { title: "±", unit: "s", number: true, tip: "error bar: the largest difference between the witnesses of the truth" },
    { title: "certificate", tip: "proved: a theorem encloses it; else witnessed by independent solvers" }, ...engines.map(each("s", "error of the time at the finest setting run, solver minus truth")),
  ], events.map((row) => ({ cells: [
    `${row.contact && `${row.contact}: `}${row.before} → ${row.after}`.replaceAll("_", " "), String(+(+row.time).toPrecision(9)), power(row.truth_error_bar), row.certificate,
    ...own.map((rows) => error(rows.find((one) => one.event === row.event && one.pairing !== "spurious"))),
  ] })));
  const spurious = engines.map((engine, i) => [engine, own[i].filter((row) => row.pairing === "spurious").length]).filter(([, many]) => many);
  if (spurious.length) place.appendChild(Object.assign(document.createElement("p"), { className: "cue", textContent: `More transitions than the truth has: ${spurious.map(([{ solver, route }, many]) => `${solver} ${route} ${many}`).join(", ")}.` }));

  // An impact by its time and contact; the time of rest has no contact, and is last. Rows of the truth, and each engine's at the finest setting.
  const key = (row) => `${row.event === "0"} ${row.reference_time} ${row.contact}`;
  const ofTruth = (rows) => [...new Map(rows.filter((row) => row.reference_time !== "").map((row) => [key(row), row])).values()].sort((a, b) => (a.event === "0") - (b.event === "0") || a.reference_time - b.reference_time);
  const same = (rows, row) => rows.find((found) => key(found) === key(row));
  const digits = (value, count = 4) => value && String(+(+value).toPrecision(count));
  const several = impacts.filter((row) => row.contact || row.event === "0"), mine = engines.map((engine) => fine(several, engine));
  add("impacts", [
    { title: "impact", tip: "at rest: the kinetic energy stays below 1e-4 of its largest" }, { title: "at", unit: "s", number: true, tip: "time of the truth" }, { title: "swing", unit: "rad", number: true, tip: "largest turn of the plate before the next impact" },
    ...engines.flatMap((engine) => [each("s", "time minus that of the truth, at the finest setting run")(engine), each("rad", "swing minus that of the truth", "swing")(engine)]),
  ], ofTruth(mine.flat()).map((row) => ({ cells: [
    row.event === "0" ? "at rest" : `impact at ${row.contact}`, digits(row.reference_time, 6), digits(row.reference_swing),
    ...mine.flatMap((rows) => {
      const one = same(rows, row), swing = one && one.swing !== "" && one.reference_swing !== "" ? signed(one.swing - one.reference_swing) : "";
      return one && one.error !== "" ? [signed(one.error), swing] : ["–", ""];
    }),
  ] })));

  // Impulses of the truth and of each engine, those that velocities determine.
  const hits = engines.map((engine) => fine(impulses, engine));
  // Roundings of the largest one are zero.
  const largest = Math.max(0, ...hits.flat().map((row) => Math.abs(row.reference_normal)));
  const impulse = (value) => (value === "" ? "–" : Math.abs(value) < 1e-9 * largest ? "0" : digits(value, 3));
  const pair = (row, which = "") => (!row || row[`${which}normal`] === "" ? "–" : `${impulse(row[`${which}normal`])}, ${impulse(row[`${which}friction`])}`);
  add("impulses", [
    { title: "impulses at" }, { title: "at", unit: "s", number: true, tip: "time of the truth" }, { title: "truth", unit: "N s", number: true, tip: "along normal and tangent; –: not unique" },
    ...engines.map(each("N s", "at the finest setting run, from its velocities; –: not known")),
  ], ofTruth(hits.flat()).slice(0, MOST_IMPACTS).map((row) => ({ cells: [row.contact, digits(row.reference_time, 6), pair(row, "reference_"), ...hits.map((rows) => pair(same(rows, row)))] })));
};
