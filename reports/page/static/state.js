// State shared by all parts of the page: the motions' numbers, and which solvers and routes are switched on.
const suite = (() => {
  const hidden = { solver: new Set(), route: new Set() }, listeners = [];
  const style = document.head.appendChild(document.createElement("style"));

  const on = (solver, route) => !hidden.solver.has(solver) && !hidden.route.has(route);
  const whenSwitched = (act) => listeners.push(act);
  const announce = () => listeners.forEach((act) => act());

  document.querySelectorAll("[data-switch]").forEach((box) => box.addEventListener("change", () => {
    hidden[box.dataset.switch][box.checked ? "delete" : "add"](box.value);
    style.textContent = Object.entries(hidden).flatMap(([kind, names]) => [...names].map(
      (name) => `main [data-${kind}="${CSS.escape(name)}"]{display:none!important}`)).join("");
    announce();
  }));

  // A colour for a canvas, computed from the page's CSS variables, light or dark.
  const probe = document.createElement("i");
  probe.hidden = true;
  document.body.append(probe);
  const colour = (name) => {
    probe.style.color = `var(${name})`;
    return getComputedStyle(probe).color;
  };
  const colourOf = (solver) => colour(`--of-${solver.replace(/[^A-Za-z0-9_-]/g, "_")}`);

  // Decode numbers from motions.py: base64, compressed, grouped by byte position.
  async function numbers(text) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const planes = new Uint8Array(await new Response(stream).arrayBuffer());
    const count = planes.length / 4, whole = new Uint8Array(planes.length);
    for (let byte = 0; byte < 4; byte++)
      for (let i = 0; i < count; i++) whole[4 * i + byte] = planes[byte * count + i];
    return new Float32Array(whole.buffer);
  }

  const columns = (names, all) => {
    const count = all.length / names.length;
    return Object.fromEntries(names.map((name, i) => [name, all.subarray(i * count, (i + 1) * count)]));
  };

  const TRUE = ["x", "y", "angle", "slip", "xi1", "xi2", "lambda", "normal", "friction"];
  const OFF = ["x", "y", "angle", "slip", "xi1", "xi2", "lambda", "friction"];
  const cache = new Map();

  async function read(label) {
    const block = [...document.querySelectorAll("script.motion")].find((one) => one.dataset.case === label);
    if (!block) return null;
    const data = JSON.parse(block.textContent), t = await numbers(data.t);
    const truth = columns(TRUE, await numbers(data.truth)), track = columns(["x", "y"], await numbers(data.track.points));
    // Sample times are rounded to 32 bits; start and end are exact.
    const runs = [];
    for (const run of data.runs) runs.push({ ...run, off: columns(OFF, await numbers(run.data)) });
    return { ...data, t, truth, runs, track: { ...data.track, ...track }, outline: columns(["x", "y"], await numbers(data.outline)) };
  }

  const motion = (label) => cache.get(label) ?? (cache.set(label, read(label)), cache.get(label));

  // A column's value at a time, interpolated between its samples.
  function at(t, values, time) {
    let low = 0, high = t.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle; else high = middle;
    }
    const part = Math.min(1, Math.max(0, (time - t[low]) / (t[high] - t[low] || 1)));
    const a = values[low], b = values[high];
    return Number.isFinite(a) && Number.isFinite(b) ? a + part * (b - a) : part < 0.5 ? a : b;
  }

  const digits = (value, count = 4) => !Number.isFinite(value) ? "–" : value === 0 ? "0"
    : Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toExponential(Math.min(count, 2) - 1) : String(+value.toPrecision(count));

  return { on, whenSwitched, announce, colour, colourOf, motion, at, digits };
})();
