// Work-precision plot of the timed cases, logarithmic on both axes; a point shows its setting.
suite.precision = async (place) => {
  const NUMBERS = ["cpu_s", "call_s", "steps", "absolute_error", "floor_error"];
  const points = (await suite.rows("work_precision"))?.map((row) => ({ ...row, ...Object.fromEntries(NUMBERS.map((name) => [name, row[name] === "" ? NaN : +row[name]])) }));
  if (!points?.length) return;
  const cases = [...new Set(points.map((p) => p.case))], quantities = [...new Set(points.map((p) => p.quantity))];
  const options = (all) => all.map((one) => `<option>${one.replace(/[<&]/g, "")}</option>`).join("");
  const WORK = { call_s: "CPU time of a whole call, s", cpu_s: "CPU time of a run, s", steps: "steps" };
  place.innerHTML = `<div class="controls"><label>case <select class="case">${options(cases)}</select></label>
    <label>error of <select class="quantity">${quantities.map((q) => `<option value="${q}"${q === "off" ? " selected" : ""}>${q.replaceAll("_", " ")}</option>`).join("")}</select></label>
    <label>against <select class="work">${Object.entries(WORK).map(([name, text]) => `<option value="${name}">${text}</option>`).join("")}</select></label></div>
    <svg viewBox="0 0 900 420" tabindex="0" role="application" aria-label="Error against work. Arrow keys go from point to point."></svg>
    <p class="note legend">Open markers: default settings. Dashed: not native. Grey: below ten times the truth's error bar, so the size is not known.</p>
    <p class="details" aria-live="polite">Point at a setting, or use the arrow keys, to see it and its command here.</p>`;
  const svg = place.querySelector("svg"), details = place.querySelector(".details"), of = (name) => place.querySelector(`.${name}`).value;
  const NS = "http://www.w3.org/2000/svg", box = { left: 70, right: 880, top: 14, bottom: 372 };
  const make = (name, attributes, parent = svg) => {
    const node = parent.appendChild(document.createElementNS(NS, name));
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    return node;
  };
  const isDefault = (p) => p.setting.startsWith("rung=defaults");
  const amount = (p) => p.quantity === "off" ? `${suite.digits(100 * p.absolute_error, 2)} % off` : `error ${suite.digits(p.absolute_error, 2)} ${p.unit}`;
  let marks = [], chosen = -1;

  function select(i) {
    marks.forEach(({ node }, k) => node.classList.toggle("chosen", k === i));
    chosen = i;
    const { p } = marks[i];
    details.innerHTML = "";
    const add = (name, text) => { const node = details.appendChild(document.createElement(name)); node.textContent = text; return node; };
    add("strong", `${p.solver} ${p.route}, ${p.setting}`);
    details.append(`: ${amount(p)}, ${suite.seconds(p.cpu_s)} a run, ${suite.seconds(p.call_s)} a whole call, ${suite.number(p.steps)} steps. `);
    add("code", `${place.dataset.command} --case "${p.case}" --solver ${p.solver}`);
  }

  function draw() {
    svg.replaceChildren();
    marks = [];
    chosen = -1;
    const work = of("work"), shown = points.filter((p) => p.case === of("case") && p.quantity === of("quantity") && p[work] > 0 && Number.isFinite(p.absolute_error) && suite.on(p.solver, p.route));
    if (!shown.length) { make("text", { x: 450, y: 190, "text-anchor": "middle" }).textContent = "no timings here, or all solvers are switched off"; return; }
    const least = 1e-17, value = (p) => Math.max(p.absolute_error, least);
    const bounds = (values) => { const logs = values.map(Math.log10); return [Math.floor(Math.min(...logs)), Math.max(Math.ceil(Math.max(...logs)), Math.floor(Math.min(...logs)) + 1)]; };
    const [x0, x1] = bounds(shown.map((p) => p[work])), [y0, y1] = bounds(shown.map(value));
    const X = (v) => box.left + ((Math.log10(v) - x0) / (x1 - x0)) * (box.right - box.left), Y = (v) => box.bottom - ((Math.log10(v) - y0) / (y1 - y0)) * (box.bottom - box.top);
    const every = Math.ceil((y1 - y0) / 9);
    for (let k = x0; k <= x1; k++) { make("line", { x1: X(10 ** k), x2: X(10 ** k), y1: box.top, y2: box.bottom, class: "grid" }); make("text", { x: X(10 ** k), y: box.bottom + 18, "text-anchor": "middle" }).textContent = `1e${k}`; }
    for (let k = y0; k <= y1; k += every) { make("line", { x1: box.left, x2: box.right, y1: Y(10 ** k), y2: Y(10 ** k), class: "grid" }); make("text", { x: box.left - 8, y: Y(10 ** k) + 4, "text-anchor": "end" }).textContent = `1e${k}`; }
    make("text", { x: 475, y: 412, "text-anchor": "middle" }).textContent = WORK[work];
    make("text", { x: 16, y: 195, "text-anchor": "middle", transform: "rotate(-90 16 195)" }).textContent = shown[0].quantity === "off" ? "off: share of the error of ignoring friction" : `error, ${shown[0].unit}`;
    const floor = shown[0].floor_error;
    if (floor > 10 ** y0) make("rect", { x: box.left, width: box.right - box.left, y: Y(floor), height: box.bottom - Y(floor), class: "floor" }).appendChild(document.createElementNS(NS, "title")).textContent = "below the error bar of the truth";
    const routes = new Map(), labels = [];
    shown.forEach((p) => { const key = `${p.solver} ${p.route}`; routes.set(key, [...(routes.get(key) ?? []), p]); });
    for (const [, group] of routes) {
      const colour = `var(--of-${group[0].solver.replace(/[^A-Za-z0-9_-]/g, "_")})`, ladder = group.filter((p) => !isDefault(p));
      make("path", { d: ladder.map((p, i) => `${i ? "L" : "M"}${X(p[work])} ${Y(value(p))}`).join(""), fill: "none", stroke: colour, "stroke-dasharray": group[0].route === "native" || group[0].solver === "reference" ? "none" : "6 3" });
      const last = group.reduce((a, b) => (value(b) < value(a) ? b : a));
      labels.push({ x: Math.min(X(last[work]) + 8, box.right - 130), y: Y(value(last)) + 14, colour, text: `${last.solver} ${last.route}` });
      for (const p of group) {
        const node = make("circle", { cx: X(p[work]), cy: Y(value(p)), r: 5, fill: isDefault(p) ? "var(--ground)" : colour, stroke: colour, class: "point" });
        const i = marks.push({ p, node }) - 1;
        make("title", {}, node).textContent = `${p.solver} ${p.route}, ${p.setting}`;
        node.addEventListener("pointerenter", () => select(i));
      }
    }
    // Labels that would touch are moved down, one line each.
    labels.sort((a, b) => a.y - b.y).forEach((label, i) => {
      for (const other of labels.slice(0, i)) if (Math.abs(other.x - label.x) < 130 && label.y - other.y < 14) label.y = other.y + 14;
      make("text", { x: label.x, y: Math.min(label.y, box.bottom - 4), style: `fill:${label.colour}` }).textContent = label.text;
    });
  }
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (step && marks.length) { event.preventDefault(); select((chosen + step + marks.length) % marks.length); }
  });
  place.querySelectorAll("select").forEach((one) => one.addEventListener("change", draw));
  suite.whenSwitched(draw);
  draw();
};
