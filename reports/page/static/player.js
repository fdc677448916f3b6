// Player of a motion in SVG: the plate on its track and supports, every engine's plate as a ghost at a setting of its
// ladder, and a timeline of modes.
suite.player = async (place) => {
  const motion = await suite.motion(place.dataset.case);
  if (!motion) return null;
  const NS = "http://www.w3.org/2000/svg", { truth, t, track, supports, outline } = motion, listeners = [];
  const make = (name, parent, attributes = {}) => {
    const node = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    return parent.appendChild(node);
  };
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const span = motion.end - motion.start;

  // --- elements around the picture ---
  const icon = (path) => `<svg class="icon" viewBox="0 0 16 16" aria-hidden="true"><path d="${path}"/></svg>`;
  const ICONS = { play: icon("M3 2l11 6-11 6z"), pause: icon("M3 2h4v12H3zM9 2h4v12H9z"), back: icon("M2 2h2v12H2zM14 2v12L5 8z"), next: icon("M12 2h2v12h-2zM2 2v12l9-6z") };
  place.innerHTML = `
    <div class="stage" tabindex="0" role="group" aria-label="Motion of ${motion.label.replace(/["<&]/g, "")}. Space plays, arrows scrub, comma and full stop go to transitions.">
      <svg role="img"></svg><p class="readout" aria-hidden="true"></p></div>
    <div class="modes" role="group" aria-label="Modes of the contact; each goes to its beginning"></div>
    <div class="controls">
      <button type="button" data-do="play" aria-label="play">${ICONS.play}</button>
      <button type="button" data-do="back" aria-label="previous transition">${ICONS.back}</button>
      <button type="button" data-do="next" aria-label="next transition">${ICONS.next}</button>
      <input type="range" class="time" min="0" max="1000" value="0" step="1" aria-label="time">
      <output class="now"></output>
    </div>
    <div class="ladder"><label>engines' setting <input type="range" class="setting" min="0" value="0" step="1" aria-label="setting of the engines, from default to finest"></label> <output class="rung"></output></div>
    <ul class="engines"></ul>
    <div class="controls more">
      <label>speed <select class="speed" aria-label="speed"></select></label>
      <label>differences <input type="range" class="larger" min="0" max="9" step="0.25" value="0" aria-label="differences enlarged"> <output class="factor">× 1</output></label>
      <label><input type="checkbox" class="forces" checked> forces</label>
      <label><input type="checkbox" class="follow"> follow</label>
    </div>`;
  const part = (selector) => place.querySelector(selector);
  const svg = part(".stage svg"), scrub = part(".time"), speed = part(".speed"), larger = part(".larger");

  // --- the scene ---
  const up = motion.down ? 1 : -1, world = make("g", svg, { transform: `scale(1 ${up})` });
  const polyline = (xs, ys) => {
    let text = "", open = false;
    for (let i = 0; i < xs.length; i++) {
      if (Number.isFinite(xs[i])) { text += `${open ? "L" : "M"}${xs[i]} ${ys[i]}`; open = true; } else open = false;
    }
    return text;
  };
  const range = (values) => values.reduce(([a, b], v) => (Number.isFinite(v) ? [Math.min(a, v), Math.max(b, v)] : [a, b]), [Infinity, -Infinity]);
  const reach = outline.x.reduce((most, x, i) => Math.max(most, Math.hypot(x, outline.y[i])), 0);
  const flying = (values) => values.map((v, i) => (Number.isFinite(truth.xi1[i]) ? NaN : v));
  for (const curve of [track, ...supports]) make("path", world, { d: polyline(curve.x, curve.y), class: "track" });
  make("path", world, { d: polyline(flying(truth.x), flying(truth.y)), class: "flight" });
  const plateOf = (parent, kind, { x, y } = outline) => {
    const group = make("g", parent, { class: kind });
    make("path", group, { d: `${polyline(x, y)}Z` });
    make("path", group, { d: `M0 0L${x[0]} ${y[0]}` });
    make("circle", group, { cx: 0.72 * x[0], cy: 0.72 * y[0], r: 0.09 * reach });
    return group;
  };
  const plate = plateOf(world, "plate"), others = motion.plates.map((one) => ({ ...one, group: plateOf(world, "plate", one.outline) }));
  // Each route's runs, from the default setting to the finest.
  const ladders = [...motion.runs.reduce((map, run) => map.set(`${run.solver} ${run.route}`, [...(map.get(`${run.solver} ${run.route}`) ?? []), run]), new Map()).values()];
  const setting = part(".setting"), engines = part(".engines");
  setting.max = Math.max(0, ...ladders.map((ladder) => ladder.length - 1));
  part(".ladder").hidden = setting.max < 1;
  const ghosts = ladders.map((ladder) => {
    const [{ solver, route }] = ladder, group = make("g", world), line = engines.appendChild(document.createElement("li"));
    const row = document.createElement("div");
    const plates = [undefined, ...motion.plates.map((one) => one.outline)].map((outline) => plateOf(group, "ghost", outline));
    for (const one of [...plates, line, row]) {
      one.style.setProperty("--of", `var(--of-${solver.replace(/[^A-Za-z0-9_-]/g, "_")})`);
      one.dataset.solver = solver;
      one.dataset.route = route;
    }
    if (route !== "native") for (const one of [...plates, line]) one.classList.add("dashed");
    return { ladder, plates, line, row, run: ladder[0] };
  });
  const arrows = make("g", world, { class: "arrows" });
  // A point and two arrows for each contact.
  const contacts = (motion.contacts.length ? motion.contacts : [{ name: "", ...truth }]).map((contact) => {
    const group = make("g", arrows);
    return {
      ...contact, group, on: supports.find(({ name }) => name === contact.curve) ?? track, normalPath: make("path", group, { class: "normal" }), frictionPath: make("path", group, { class: "friction" }),
      touch: make("circle", group, { class: "touch", r: 0.07 * reach }),
    };
  });

  // The room of a plate: of a free one by its own size.
  const around = (axis) => [{ ...truth, outline }, ...motion.plates].flatMap((one) => {
    const size = Math.max(...Array.from(one.outline.x, Math.abs), ...Array.from(one.outline.y, Math.abs), one.outline === outline ? reach : 0);
    return Array.from(one[axis]).flatMap((value) => [value - size, value + size]);
  });
  const xs = range([track, ...supports].flatMap(({ x }) => [...x]).concat(around("x")));
  const ys = range([track, ...supports].flatMap(({ y }) => [...y]).concat(around("y")));
  const width = xs[1] - xs[0], height = ys[1] - ys[0], room = 0.04 * Math.max(width, height);
  const whole = [xs[0] - room, (up > 0 ? ys[0] : -ys[1]) - room, width + 2 * room, height + 2 * room];
  part(".follow").checked = Math.max(width, height) > 40 * reach;

  // The point of a curve at a contact parameter, and the tangent there.
  const onCurve = ({ x, y, low, high, period }, xi) => {
    if (!Number.isFinite(xi)) return null;
    const count = x.length - 1;
    let place = (xi - low) / (high - low);
    if (period) place -= Math.floor(place);
    place = Math.min(1, Math.max(0, place)) * count;
    const i = Math.min(count - 1, Math.floor(place)), dx = x[i + 1] - x[i], dy = y[i + 1] - y[i];
    const size = Math.hypot(dx, dy) || 1;
    return { x: x[i] + (place - i) * dx, y: y[i] + (place - i) * dy, tx: dx / size, ty: dy / size };
  };
  const forces = contacts.flatMap(({ normal }) => Array.from(normal)).filter(Number.isFinite).map(Math.abs).sort((a, b) => a - b);
  const usual = forces[Math.floor(0.9 * forces.length)] || 1;
  const arrow = (from, dx, dy) => {
    const size = Math.hypot(dx, dy);
    if (!(size > 0.02 * reach)) return "";
    const head = Math.min(0.25 * reach, 0.5 * size), ux = dx / size, uy = dy / size, x = from.x + dx, y = from.y + dy;
    return `M${from.x} ${from.y}L${x} ${y}M${x - head * (ux + 0.5 * uy)} ${y - head * (uy - 0.5 * ux)}L${x} ${y}L${x - head * (ux - 0.5 * uy)} ${y - head * (uy + 0.5 * ux)}`;
  };

  // --- time ---
  let time = motion.start, playing = false, before = 0;
  const now = (values) => suite.at(t, values, time);
  const modeAt = () => motion.modes.filter(([begins]) => begins <= time + 1e-12 * span).at(-1) ?? motion.modes[0];
  const words = (mode) => mode.replaceAll("_", " ");

  // Of several contacts, one opens where another closes: between the two samples the nearer one counts.
  const side = (values) => {
    const value = now(values);
    if (Number.isFinite(value) || !motion.contacts.length) return value;
    const later = t.findIndex((one) => one > time), j = later < 0 ? t.length - 1 : later, i = Math.max(0, j - 1);
    return values[time - t[i] < t[j] - time ? i : j];
  };

  // Draws one contact at the current time; whether it is closed.
  function drawContact({ on, xi1, normal, friction, group, normalPath, frictionPath, touch }) {
    const at = onCurve(on, side(xi1));
    group.style.display = at ? "" : "none";
    if (!at) return false;
    touch.setAttribute("cx", at.x);
    touch.setAttribute("cy", at.y);
    const shown = part(".forces").checked, scale = (1.6 * reach) / usual, n = scale * side(normal), f = scale * side(friction);
    normalPath.setAttribute("d", shown && Number.isFinite(n) ? arrow(at, -n * at.ty, n * at.tx) : "");
    frictionPath.setAttribute("d", shown && Number.isFinite(f) ? arrow(at, f * at.tx, f * at.ty) : "");
    return true;
  }

  function draw() {
    const x = now(truth.x), y = now(truth.y), angle = now(truth.angle), factor = 10 ** +larger.value;
    const put = (group, a, b, c) => group.setAttribute("transform", `translate(${a} ${b}) rotate(${(c * 180) / Math.PI})`);
    put(plate, x, y, angle);
    for (const { group, x: cx, y: cy, angle: turn } of others) put(group, now(cx), now(cy), now(turn));
    for (const { run, plates } of ghosts) {
      [truth, ...others].forEach((true_, i) => {
        const off = [run.off, ...run.plates][i], [dx, dy, turn] = ["x", "y", "angle"].map((name) => now(off[name]));
        const there = suite.on(run.solver, run.route) && Number.isFinite(dx);
        plates[i].style.display = there ? "" : "none";
        if (there) put(plates[i], now(true_.x) + factor * dx, now(true_.y) + factor * dy, now(true_.angle) + factor * turn);
      });
    }
    const touching = contacts.filter((contact) => drawContact(contact));
    const wide = 12 * reach;
    svg.setAttribute("viewBox", (part(".follow").checked ? [x - wide / 2, up * y - wide / 3, wide, (2 * wide) / 3] : whole).join(" "));
    const mode = modeAt();
    scrub.value = span ? (1000 * (time - motion.start)) / span : 0;
    scrub.setAttribute("aria-valuetext", `${suite.digits(time)} seconds, ${words(mode[1])}`);
    part(".now").textContent = `${suite.digits(time, 5)} s`;
    const newtons = (force) => suite.digits(Math.abs(force) < 1e-9 * usual ? 0 : force);
    // A force that Coulomb's law leaves open has a range, which may have no greatest value.
    const strength = ({ normal, low, high }) => {
      const force = side(normal);
      if (Number.isFinite(force) || !low) return `${newtons(force)} N`;
      return Number.isFinite(side(high)) ? `${newtons(side(low))} to ${newtons(side(high))} N` : `at least ${newtons(side(low))} N`;
    };
    const pushes = touching.map(strength).join(", ");
    const slipping = contacts.length < 2 ? ` · v = ${suite.digits(now(truth.slip))} m/s` : "";
    part(".readout").textContent = touching.length ? `${words(mode[1])}${slipping} · N = ${pushes}` : words(mode[1]);
    part(".factor").textContent = `× ${factor < 1e4 ? suite.digits(factor, 2) : factor.toExponential(0)}`;
    place.querySelectorAll(".modes button").forEach((one) => one.toggleAttribute("data-now", one.dataset.at <= time + 1e-12 * span && (time < one.dataset.to || +one.dataset.to === motion.end)));
    place.dataset.time = time;
    listeners.forEach((act) => act(time));
  }
  const describe = () => svg.setAttribute("aria-label", `${motion.label} at ${suite.digits(time)} s: ${words(modeAt()[1])}; centre at ${suite.digits(now(truth.x))}, ${suite.digits(now(truth.y))} m, turned by ${suite.digits(now(truth.angle))} rad`);
  const seek = (to) => {
    time = Math.min(motion.end, Math.max(motion.start, to));
    draw();
    if (!playing) describe();
  };
  function play(go = !playing) {
    playing = go;
    if (go && time >= motion.end) time = motion.start;
    const button = part("[data-do=play]");
    button.innerHTML = go ? ICONS.pause : ICONS.play;
    button.setAttribute("aria-label", go ? "pause" : "play");
    place.toggleAttribute("data-playing", go);
    before = 0;
    if (go) requestAnimationFrame(step); else describe();
  }
  function step(stamp) {
    if (!playing) return;
    if (!place.isConnected || place.offsetParent === null) return play(false);
    // After the page was in the background, continue at the same time of the motion.
    const passed = before ? Math.min(0.1, (stamp - before) / 1000) : 0;
    before = stamp;
    time += passed * +speed.value;
    if (time >= motion.end) {
      if (place.dataset.loop === undefined) { seek(motion.end); return play(false); }
      time = motion.start;
    }
    draw();
    requestAnimationFrame(step);
  }
  const begins = motion.modes.map(([when]) => when);
  const jump = (forward) => {
    const near = 1e-9 * span;
    const to = forward ? begins.find((b) => b > time + near) ?? motion.end : begins.filter((b) => b < time - near).at(-1) ?? motion.start;
    play(false);
    seek(to);
  };

  // --- the timeline and the controls ---
  const modes = part(".modes"), percent = (when) => (100 * (when - motion.start)) / (span || 1);
  motion.lanes.forEach(([contact, its]) => {
    const lane = modes.appendChild(document.createElement("div"));
    lane.className = motion.lanes.length > 1 ? "lane thin" : "lane";
    its.slice(0, 120).forEach(([from, mode, cause], i) => {
      const to = its[i + 1]?.[0] ?? motion.end, one = document.createElement("button"), text = `${contact && `${contact}: `}${words(mode)}`;
      one.type = "button";
      one.className = `mode ${mode}`;
      one.style.left = `${percent(from)}%`;
      one.style.width = `max(6px, ${percent(to) - percent(from)}%)`;
      one.textContent = percent(to) - percent(from) > text.length ? text : percent(to) - percent(from) > 9 ? words(mode) : "";
      one.title = `${text} from ${from.toPrecision(9)} s${cause ? `: ${cause}` : ""}`;
      one.setAttribute("aria-label", one.title);
      one.dataset.at = from;
      one.dataset.to = to;
      one.addEventListener("click", () => { play(false); seek(from); });
      lane.append(one);
    });
  });
  const ticks = document.createElement("div");
  ticks.className = "ticks";
  ticks.setAttribute("aria-hidden", "true");
  ghosts.forEach(({ row }) => ticks.append(row));
  modes.after(ticks);
  const needle = modes.appendChild(document.createElement("span"));
  needle.className = "needle";
  listeners.push(() => { needle.style.left = `${percent(time)}%`; });

  // The engines' runs at the chosen setting; a shorter ladder stays at its finest.
  const choosers = [];
  function choose() {
    for (const ghost of ghosts) {
      const { ladder, line, row } = ghost, run = ladder[Math.min(+setting.value, ladder.length - 1)];
      ghost.run = run;
      line.innerHTML = `<span class="of"></span> <small></small>`;
      line.firstChild.textContent = `${run.solver} ${run.route}: ${run.score} off`;
      line.lastChild.textContent = run.setting.replace("rung=defaults", "default").replaceAll(",", ", ");
      row.title = `transitions of ${run.solver} ${run.route}`;
      row.replaceChildren(...run.events.filter((e) => e <= motion.end).map((e) => {
        const tick = document.createElement("i");
        tick.style.left = `${percent(e)}%`;
        return tick;
      }));
    }
    const at = +setting.value, end = +setting.max;
    part(".rung").textContent = at === 0 ? "default" : at === end ? "finest" : `${at} of ${end}, coarse to fine`;
    setting.setAttribute("aria-valuetext", part(".rung").textContent);
    draw();
    choosers.forEach((act) => act());
  }
  setting.addEventListener("input", choose);

  const speeds = [0.001, 0.01, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10, 100];
  const fitting = speeds.reduce((best, s) => (Math.abs(Math.log(s / (span / 6))) < Math.abs(Math.log(best / (span / 6))) ? s : best), 1);
  const usualSpeed = span >= 1.5 && span <= 15 ? 1 : fitting;
  speeds.forEach((s) => speed.add(new Option(`${s} ×`, s, s === usualSpeed, s === usualSpeed)));
  part("[data-do=play]").addEventListener("click", () => play());
  part("[data-do=back]").addEventListener("click", () => jump(false));
  part("[data-do=next]").addEventListener("click", () => jump(true));
  scrub.addEventListener("input", () => { play(false); seek(motion.start + (span * scrub.value) / 1000); });
  [larger, part(".forces"), part(".follow")].forEach((one) => one.addEventListener("input", draw));
  part(".stage").addEventListener("keydown", (event) => {
    const keys = {
      " ": () => play(), ArrowLeft: () => seek(time - span / 200), ArrowRight: () => seek(time + span / 200),
      ",": () => jump(false), ".": () => jump(true), Home: () => seek(motion.start), End: () => seek(motion.end),
    };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  suite.whenSwitched(draw);
  // Where the picture does not move by itself, it begins where an engine is farthest from the truth.
  function farthest() {
    const apart = Array.from(t, (_, i) => Math.max(...ghosts.map(({ run }) => Math.hypot(run.off.x[i], run.off.y[i]) || 0)));
    return ghosts.length ? t[apart.indexOf(Math.max(...apart))] : motion.start;
  }
  // The address of the page has the time and the setting of the first player that it shows.
  const begin = suite.kept("at");
  setting.value = Math.max(0, suite.kept("setting") ?? 0);
  choose();
  seek(begin !== null ? +begin : place.dataset.loop !== undefined && still ? farthest() : motion.start);
  if (place.dataset.loop !== undefined && !still && begin === null) play(true);
  ["click", "input", "keyup"].forEach((kind) => place.addEventListener(kind, () => {
    suite.keep("at", playing ? "" : String(+time.toPrecision(6)));
    suite.keep("setting", +setting.value ? setting.value : "");
  }));
  return { motion, seek, play, time: () => time, runs: () => ghosts.map(({ run }) => run), whenChosen: (act) => choosers.push(act), whenMoved: (act) => { listeners.push(act); act(time); } };
};
