// State shared by all parts of the page: the motions' numbers, and which solvers and routes are switched on.
const suite = (() => {
  const hidden = { solver: new Set(), route: new Set() }, listeners = [];
  const style = document.head.appendChild(document.createElement("style"));

  const on = (solver, route) => !hidden.solver.has(solver) && !hidden.route.has(route);
  const whenSwitched = (act) => listeners.push(act);
  const announce = () => listeners.forEach((act) => act());

  // What a reader has set is in the address: switches, and time and setting of the player.
  const kept = (name) => new URLSearchParams(location.search).get(name);
  function keep(name, value) {
    const all = new URLSearchParams(location.search);
    if (value) all.set(name, value); else all.delete(name);
    history.replaceState(null, "", `${location.pathname}${all.size ? `?${all}` : ""}${location.hash}`);
  }
  const boxes = [...document.querySelectorAll("[data-switch]")];
  function hide() {
    boxes.forEach((box) => hidden[box.dataset.switch][box.checked ? "delete" : "add"](box.value));
    style.textContent = Object.entries(hidden).flatMap(([kind, names]) => [...names].map(
      (name) => `main [data-${kind}="${CSS.escape(name)}"]{display:none!important}`)).join("");
  }
  const without = kept("without")?.split(",") ?? [];
  boxes.forEach((box) => { box.checked = !without.includes(box.value); });
  hide();
  boxes.forEach((box) => box.addEventListener("change", () => {
    hide();
    keep("without", boxes.filter((one) => !one.checked).map((one) => one.value).join(","));
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

  // The bytes of base64 text of compressed data.
  async function inflate(text) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());
  }

  // Decode numbers from motions.py: second differences of ordered floats, grouped by byte position.
  async function numbers(text) {
    const bytes = await inflate(text), [rest] = bytes, planes = bytes.subarray(1);
    const count = planes.length / 4, words = new Uint32Array(count);
    for (let i = 0, slope = 0, ordered = 0; i < count; i++) {
      const folded = planes[i] | planes[count + i] << 8 | planes[2 * count + i] << 16 | planes[3 * count + i] << 24;
      slope = slope + ((folded >>> 1) ^ -(folded & 1)) | 0;
      ordered = ordered + slope | 0;
      words[i] = ordered < 0 ? (-ordered << rest | 0x80000000) : ordered << rest;
    }
    return new Float32Array(words.buffer);
  }

  // The text of a table's file, which is inside the page; null if it is not.
  const file = async (name) => {
    const block = [...document.querySelectorAll("script.file")].find((one) => one.dataset.name === name);
    return block ? new TextDecoder().decode(await inflate(block.textContent)) : null;
  };

  // The records of comma-separated values, as lists of texts.
  function parse(text) {
    const rows = [[]];
    for (const [, quoted, plain, end] of text.matchAll(/(?:"((?:[^"]|"")*)"|([^",\r\n]*))(,|\r?\n|$)/g)) {
      rows.at(-1).push(quoted === undefined ? plain : quoted.replaceAll('""', '"'));
      if (end === "") break;
      if (end !== ",") rows.push([]);
    }
    return rows.filter((row) => row.length > 1 || row[0]);
  }

  // A table's rows as objects of texts.
  const tables = new Map(), rows = (name) => tables.get(name) ?? (tables.set(name, parsed(name)), tables.get(name));
  async function parsed(name) {
    const text = await file(name);
    if (text === null) return null;
    const [names, ...records] = parse(text);
    return records.map((record) => Object.fromEntries(names.map((column, i) => [column, record[i] ?? ""])));
  }

  const columns = (names, all) => {
    const count = all.length / names.length;
    return Object.fromEntries(names.map((name, i) => [name, all.subarray(i * count, (i + 1) * count)]));
  };

  const TRUE = ["x", "y", "angle", "slip", "xi1", "normal", "friction"];
  const OFF = ["x", "y", "angle", "slip"];
  const cache = new Map();

  async function read(label) {
    const block = [...document.querySelectorAll("script.motion")].find((one) => one.dataset.case === label);
    if (!block) return null;
    const data = JSON.parse(block.textContent), t = await numbers(data.t);
    const truth = columns(TRUE, await numbers(data.truth));
    const drawn = async (curve) => ({ ...curve, ...columns(["x", "y"], await numbers(curve.points)) });
    const track = await drawn(data.track), supports = await Promise.all(data.supports.map(drawn));
    // Sample times are rounded to 32 bits; start and end are exact. Differences have every second sample and the last.
    const runs = [], coarse = t.filter((_, i) => i % 2 === 0 || i === t.length - 1);
    const fill = (values) => Float32Array.from(t, (time) => at(coarse, values, time));
    for (const run of data.runs) {
      const filled = async (names, packed) => {
        const given = columns(names, await numbers(packed));
        return Object.fromEntries(names.map((name) => [name, fill(given[name])]));
      };
      const further = [];
      for (const packed of run.plates) further.push(await filled(OFF.slice(0, 3), packed));
      runs.push({ ...run, off: await filled(OFF, run.data), plates: further });
    }
    const contacts = [];
    for (const { name, curve, data: packed } of data.contacts) contacts.push({ name, curve, ...columns(["xi1", "normal", "friction", "low", "high"], await numbers(packed)) });
    const plates = [];
    for (const { outline, data: packed } of data.plates)
      plates.push({ outline: columns(["x", "y"], await numbers(outline)), ...columns(["x", "y", "angle"], await numbers(packed)) });
    return { ...data, t, truth, runs, contacts, plates, track, supports, outline: columns(["x", "y"], await numbers(data.outline)) };
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

  // Two significant digits, as `number` and `seconds` of the tables' texts: 1,700, 0.29; 340 µs, 170 ms, 0.5 s.
  const number = (value) => (+value.toPrecision(2)).toLocaleString("en-US", { maximumSignificantDigits: 2 });
  const seconds = (value) => value >= 0.45 ? `${number(value)} s` : value >= 0.995e-3 ? `${number(1e3 * value)} ms` : `${number(1e6 * value)} µs`;
  const isWhole = () => hidden.solver.size + hidden.route.size === 0;

  return { on, kept, keep, isWhole, whenSwitched, announce, colour, colourOf, motion, file, rows, at, digits, number, seconds };
})();
