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

  // The bytes of compressed data in base 85, as `compress` of fragments.py writes them.
  const DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;,=>?@^_`{|}~";
  const VALUE = Object.fromEntries([...DIGITS].map((c, i) => [c, i]));
  async function inflate(text) {
    const groups = Math.ceil(text.length / 5), view = new DataView(new ArrayBuffer(4 * groups));
    for (let i = 0; i < groups; i++) {
      let word = 0;
      for (let j = 5 * i; j < 5 * i + 5; j++) word = 85 * word + (VALUE[text[j]] ?? 84);
      view.setUint32(4 * i, word);
    }
    const bytes = new Uint8Array(view.buffer, 0, text.length - groups);
    return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());
  }

  // Decode an array of motions.py: second differences of ordered floats, grouped by byte position.
  function numbers(planes, count, rest) {
    const words = new Uint32Array(count);
    for (let i = 0, slope = 0, ordered = 0; i < count; i++) {
      const folded = planes[i] | planes[count + i] << 8 | planes[2 * count + i] << 16 | planes[3 * count + i] << 24;
      slope = slope + ((folded >>> 1) ^ -(folded & 1)) | 0;
      ordered = ordered + slope | 0;
      words[i] = ordered < 0 ? (-ordered << rest | 0x80000000) : ordered << rest;
    }
    return new Float32Array(words.buffer);
  }

  // A table's columns, each its name and its cells, from its file inside the page; null if it is not there.
  const columnsOf = async (name) => {
    const block = [...document.querySelectorAll("script.file")].find((one) => one.dataset.name === name);
    return block ? new TextDecoder().decode(await inflate(block.textContent)).split("\x1e").map((column) => column.split("\x1f")) : null;
  };
  const quoted = (value) => (/[",\r\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  const csv = (lines) => lines.map((line) => `${line.map(quoted).join(",")}\n`).join("");
  // The text of a table's file.
  const file = async (name) => {
    const all = await columnsOf(name);
    return all && csv(all[0].map((_, i) => all.map((column) => column[i])));
  };

  // A table's rows as objects of texts.
  const tables = new Map(), rows = (name) => tables.get(name) ?? (tables.set(name, parsed(name)), tables.get(name));
  async function parsed(name) {
    const all = await columnsOf(name);
    return all && all[0].slice(1).map((_, i) => Object.fromEntries(all.map((column) => [column[0], column[i + 1]])));
  }

  const columns = (names, all) => {
    const count = all.length / names.length;
    return Object.fromEntries(names.map((name, i) => [name, all.subarray(i * count, (i + 1) * count)]));
  };

  const OFF = ["x", "y", "angle", "slip"], XY = ["x", "y"], POSE = ["x", "y", "angle"];
  const cache = new Map();

  // Start, words and cause of each mode: those of the contact, of several those of all that are closed.
  function modesOf(lanes) {
    if (lanes.length === 1) return lanes[0][1];
    const closed = (when) => lanes.map(([name, its]) => [its.filter(([begins]) => begins <= when).at(-1), name]).filter(([[, mode]]) => mode !== "flight");
    const begins = [...new Set(lanes.flatMap(([, its]) => its.map(([when]) => when)))].sort((a, b) => a - b);
    return begins.map((when) => [when, closed(when).map(([[, mode], name]) => `${mode} at ${name}`).join(", ") || "flight"]);
  }

  async function read(label) {
    const block = [...document.querySelectorAll("script.motion")].find((one) => one.dataset.case === label);
    if (!block) return null;
    const bytes = await inflate(block.textContent), text = (from, to) => JSON.parse(new TextDecoder().decode(bytes.subarray(from, to)));
    const first = bytes.indexOf(0), second = bytes.indexOf(0, first + 1), data = text(0, first);
    let place = second + 1;
    const arrays = text(first + 1, second).map(([count, rest]) => numbers(bytes.subarray(place, place += 4 * count), count, rest));
    const drawn = (curve) => ({ ...curve, ...columns(XY, arrays[curve.points]) });
    const t = arrays[data.t], truth = { ...columns([...POSE, "xi1"], arrays[data.truth[0]]), ...columns(["slip", "normal", "friction"], arrays[data.truth[1]]) };
    // Sample times are rounded to 32 bits; start and end are exact. Differences have every second sample and the last.
    const coarse = t.filter((_, i) => i % 2 === 0 || i === t.length - 1), length = coarse.length;
    const filled = (names, values, from) => Object.fromEntries(names.map((name, i) => {
      const given = values.subarray((from + i) * length, (from + i + 1) * length);
      return [name, Float32Array.from(t, (time) => at(coarse, given, time))];
    }));
    return {
      ...data, t, truth, modes: modesOf(data.lanes), track: drawn(data.track), supports: data.supports.map(drawn), outline: columns(XY, arrays[data.outline]),
      runs: data.runs.map((run) => ({ ...run, off: filled(OFF, arrays[run.off], 0), plates: data.plates.map((_, k) => filled(POSE, arrays[run.off], 4 + 3 * k)) })),
      contacts: data.contacts.map(({ data: given, ...one }) => ({ ...one, ...columns(["xi1", "normal", "friction", "low", "high"], arrays[given]) })),
      plates: data.plates.map((one) => ({ outline: columns(XY, arrays[one.outline]), ...columns(POSE, arrays[one.data]) })),
    };
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

  return { on, kept, keep, isWhole, whenSwitched, announce, colour, colourOf, motion, file, csv, rows, at, digits, number, seconds };
})();
