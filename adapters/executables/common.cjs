// What engines in JavaScript share: the scene from standard input, refusals, the track's shape, the motion as text.
"use strict";

/** Ends the program by refusing the scene, in one sentence (exit status 3); `limit`: the engine's documented limit that
 * says so, if the engine cannot. */
function refuse(why, limit = "") {
  console.error(limit ? `${why}\nlimit: ${limit}` : why);
  process.exit(3);
}

/** A package by its name, looked for beside this file and its parents and in NODE_PATH; exit status 1 if it is not
 * installed. Asked with --version, the program ends here with the package's name and version. */
function load(name) {
  version(name);
  return require(name);
}

/** The same for a package that is an ES module; a promise. */
function loadModule(name) {
  const { folder, main } = version(name);
  return import(require("url").pathToFileURL(require("path").join(folder, main)));
}

/** Folder and main file of a package, or the end of the program as `load` says. */
function version(name) {
  const path = require("path"), { existsSync, readFileSync } = require("fs");
  // Not every package lets its package.json be required.
  const folder = require.resolve.paths(name).map((each) => path.join(each, name)).find((each) => existsSync(path.join(each, "package.json")));
  if (!folder) {
    console.error(`${name} is not installed: npm install ${name}, where NODE_PATH or this file's folder finds it`);
    process.exit(1);
  }
  const { version, main } = JSON.parse(readFileSync(path.join(folder, "package.json")));
  if (process.argv.includes("--version")) {
    console.log(`${name} ${version}`);
    process.exit(0);
  }
  return { folder, main };
}

// Effects whose name in a scene is not the one that a case has.
const WORDS = { CoulombFrictionBySpeed: "friction that depends on the slip velocity" };

/** The scene, refused if it has what `known` does not name or what no engine of games has. */
function readScene(engine, known) {
  const scene = JSON.parse(require("fs").readFileSync(0, "utf8"));
  const strange = Object.keys(scene.effects).filter((name) => !known.includes(name));
  if (strange.length) refuse(`${engine} has no implementation here of ${strange.map((name) => WORDS[name] ?? name).join(" and ")}.`);
  if (scene.plate.inertia === null) refuse(`${engine}'s bodies have a finite inertia here, and this plate does not turn.`);
  if (!scene.effects.Unilateral) refuse(`${engine}'s contacts only push, and this plate is guided from both sides.`);
  const friction = scene.effects.CoulombFriction;
  if (friction && friction.mu_static !== null && friction.mu_static !== friction.mu) {
    refuse(`${engine} has one friction coefficient for slip and stick.`, "its materials have one number for friction");
  }
  return scene;
}

/** The constant speed of a belt, m/s, 0 for a track at rest; refused if it changes with time. */
function belt(engine, { effects: { Belt } }) {
  const speed = Number(Belt?.speed ?? 0);
  if (Number.isNaN(speed)) refuse(`${engine} is given belts of constant speed here, and this one's changes with time.`);
  return speed;
}

/** The restitution of the case's impacts, 0 without one: Newton's, whatever law the case has. */
function restitution({ effects: { Impact } }) {
  return Impact?.restitution ?? 0;
}

/** The acceleration of gravity, m/s². */
function gravity({ effects: { Gravity } }) {
  return Gravity ? { x: Gravity.g * Math.cos(Gravity.direction), y: Gravity.g * Math.sin(Gravity.direction) } : { x: 0, y: 0 };
}

/** The track as a solid of the scene: "line"; "disc", met from outside, with its centre and radius; or "chain". */
function shape({ solids: [track] }) {
  return track;
}

/** A straight track's two ends, each a hundred times its length farther out than its samples. */
function ends({ points: { track: { x, y } } }) {
  const last = x.length - 1, dx = 100 * (x[last] - x[0]), dy = 100 * (y[last] - y[0]);
  return [{ x: x[0] - dx, y: y[0] - dy }, { x: x[last] + dx, y: y[last] + dy }];
}

/** The smooth pieces of an outline between its corners, where samples lie on each other with normals of their own. */
function pieces(curve) {
  const found = [], names = Object.keys(curve), last = curve.x.length - 1;
  const moves = (i) => Math.hypot(curve.x[i + 1] - curve.x[i], curve.y[i + 1] - curve.y[i]) > 1e-12;
  for (let first = 0, i = 0; i < last; i++) {
    if (!moves(i)) continue;
    if (i === 0 || !moves(i - 1)) first = i;
    if (i === last - 1 || !moves(i + 1)) {
      found.push(Object.fromEntries(names.map((name) => [name, curve[name].slice(first, i + 2)])));
    }
  }
  return found;
}

/** The corners of an outline and about `count` in all on its curved pieces; the first one once more at the end. */
function around(outline, count) {
  const parts = pieces(outline);
  if (parts.length < 2) return corners(outline, count);
  const places = parts.flatMap((part) => {
    const bends = part.curvature.slice(1, -1).some((curvature) => curvature);
    return corners(part, bends ? Math.ceil(count / parts.length) : 1).slice(0, -1);
  });
  return [...places, places[0]];
}

/** A convex outline as one polygon, or as several around the centre of mass, `rim` edges of about `count` to each; else
 * refused. */
function fan(engine, { points: { outline }, closed }, count, rim) {
  if (!closed.outline || Math.min(...outline.curvature) < 0) {
    refuse(`${engine} is given circles and convex polygons, and this outline is none.`);
  }
  const places = around(outline, count), parts = [];
  if (places.length - 1 <= rim) return [places.slice(0, -1)];
  for (let first = 0; first < places.length - 1; first += rim) {
    parts.push([{ x: 0, y: 0 }, ...places.slice(first, first + rim + 1)]);
  }
  return parts;
}

/** About `count` corners on the curve, each shifted outwards by a twelfth of κ L², so that the chain's mean distance is
 * the curve's. Between samples the curve is the cubic through both points along both tangents. */
function corners(curve, count) {
  const last = curve.x.length - 1, lengths = [], found = [];
  for (let i = 0; i < last; i++) {
    const chord = Math.hypot(curve.x[i + 1] - curve.x[i], curve.y[i + 1] - curve.y[i]);
    lengths.push(chord * (1 + (curve.curvature[i] * chord) ** 2 / 24));
  }
  const whole = lengths.reduce((sum, length) => sum + length, 0), step = whole / count;
  let i = 0, before = 0;
  for (let k = 0; k <= count; k++) {
    while (i < last - 1 && before + lengths[i] < k * step) before += lengths[i++];
    const u = Math.min(1, (k * step - before) / lengths[i]), L = lengths[i], w = 1 - u;
    const mix = (p, q, tp, tq) => p * w * w * (1 + 2 * u) + q * u * u * (3 - 2 * u) + L * u * w * (tp * w - tq * u);
    const { normal_x: nx, normal_y: ny } = curve;
    const x = mix(curve.x[i], curve.x[i + 1], ny[i], ny[i + 1]), y = mix(curve.y[i], curve.y[i + 1], -nx[i], -nx[i + 1]);
    const off = (curve.curvature[i] * w + curve.curvature[i + 1] * u) * step ** 2 / 12;
    found.push({ x: x - off * (nx[i] * w + nx[i + 1] * u), y: y - off * (ny[i] * w + ny[i + 1] * u) });
  }
  return found;
}

/** About `count` chords of the curve as boxes that reach `depth` behind it on either side of their middle: the middle,
 * the angle of the direction, and half the length. */
function boxes(curve, count, depth) {
  const places = corners(curve, count), found = [];
  for (let i = 0; i + 1 < places.length; i++) {
    const [a, b] = [places[i], places[i + 1]], angle = Math.atan2(b.y - a.y, b.x - a.x);
    const x = (a.x + b.x) / 2 + depth * Math.sin(angle), y = (a.y + b.y) / 2 - depth * Math.cos(angle);
    found.push({ x, y, angle, half: Math.hypot(b.x - a.x, b.y - a.y) / 2 });
  }
  return found;
}

/** A function that gives the track's left unit normal at the place nearest to a point, which moves little by little. */
function normals({ points: { track }, closed }) {
  const { x, y, normal_x: nx, normal_y: ny } = track, last = x.length - 2;
  // How far along the track's direction a point is ahead of a sample.
  const ahead = (i, p) => (p.x - x[i]) * ny[i] - (p.y - y[i]) * nx[i];
  let i = null;
  return (p) => {
    if (i === null) {
      const away = x.map((each, k) => Math.hypot(p.x - each, p.y - y[k]));
      i = Math.min(last, away.indexOf(Math.min(...away)));
    }
    for (let tries = 0; tries < last && ahead(i + 1, p) > 0 && (closed.track || i < last); tries++) i = (i + 1) % (last + 1);
    for (let tries = 0; tries < last && ahead(i, p) < 0 && (closed.track || i > 0); tries++) i = (i + last) % (last + 1);
    const behind = ahead(i, p), before = -ahead(i + 1, p), u = Math.min(1, Math.max(0, behind / (behind + before)));
    const mixed = { x: nx[i] * (1 - u) + nx[i + 1] * u, y: ny[i] * (1 - u) + ny[i + 1] * u };
    const length = Math.hypot(mixed.x, mixed.y);
    return { x: mixed.x / length, y: mixed.y / length };
  };
}

const NAMES = ["t", "x", "y", "theta", "vx", "vy", "omega", "slip", "normal_force", "friction_force"];

// Below this share of the cone friction surely sticks: solvers leave a thousandth at most.
const INSIDE = 0.999;

/** The slip velocity (m/s) that one step leaves where the normal force falls short, in all but one in a hundred.
 *
 * On corners it scatters from step to step, and friction with it: half the difference of two neighbours, one of them
 * inside its cone, is their distance from what they scatter about, and mu times as much is missing on mass and inertia
 * for a step h. Rows end with normal and friction force. */
function missing({ plate, effects, points: { outline } }, rows, h) {
  const mu = effects.CoulombFriction?.mu ?? 0, scatter = [];
  const sticks = rows.map((row) => row.at(-2) > 0 && Math.abs(row.at(-1)) < INSIDE * mu * row.at(-2));
  for (let k = 1; k < rows.length; k++) {
    if (sticks[k] || sticks[k - 1]) scatter.push(Math.abs(rows[k].at(-2) - rows[k - 1].at(-2)) / 2);
  }
  scatter.sort((a, b) => a - b);
  const reach = Math.max(...outline.x.map((x, i) => Math.hypot(x, outline.y[i])));
  return mu * (1 / plate.mass + reach ** 2 / plate.inertia) * h * (scatter[Math.floor(0.99 * scatter.length)] ?? 0);
}

/** Runs an engine of semi-implicit Euler's kind and writes the motion.
 *
 * `plate.get()` gives {x, y, theta, vx, vy, omega}, `plate.move(x, y, theta)` sets the pose; `step(h)` is one step of the
 * engine's and gives the point {x, y} of contact that it took at the step's begin, or nothing in flight.
 * Poses stand at k h; velocities, half kicked first, half a step later: a pose's is the mean of the two beside it. So are
 * slip, of the engine's own point of contact, and forces, from the momentum, in which numbers are rounded, relatively, by
 * `rounding`. Both engines' friction is rigid: what is declared as creep is that rounding, and what friction falls
 * short of. Slip is relative to a belt of the speed `running`, m/s. */
function run(scene, plate, step, rounding, running = 0) {
  const n = Math.max(60, Math.ceil(scene.duration / scene.setting.h - 1e-9)), h = scene.duration / n;
  const pull = gravity(scene), { mass } = scene.plate, normal = normals(scene), rows = [];
  const begun = process.cpuUsage();
  let pose = scene.start, before = null, fastest = 0;
  for (let k = 0; k <= n; k++) {
    const touched = step(k ? h : h / 2), after = plate.get(), place = normal(touched ?? pose);
    const tangent = { x: place.y, y: -place.x };
    // At the start the velocity is known, and half a step of force.
    const last = before ?? pose, span = k ? h : h / 2;
    const fx = mass * ((after.vx - last.vx) / span - pull.x), fy = mass * ((after.vy - last.vy) / span - pull.y);
    after.slip = null;
    if (touched) {
      const x = touched.x - pose.x, y = touched.y - pose.y;
      after.slip = (after.vx - after.omega * y) * tangent.x + (after.vy + after.omega * x) * tangent.y - running;
      fastest = Math.max(fastest, Math.hypot(after.vx, after.vy) + Math.abs(after.omega) * Math.hypot(x, y));
    }
    const mean = (name) => (k ? (before[name] + after[name]) / 2 : scene.start[name] ?? 0);
    // Where nothing touches before or after, the pose tells.
    const slip = k && (before.slip === null || after.slip === null) ? "" : mean("slip");
    rows.push([k * h, pose.x, pose.y, pose.theta, mean("vx"), mean("vy"), mean("omega"), slip,
      touched ? fx * place.x + fy * place.y : 0, touched ? fx * tangent.x + fy * tangent.y : 0]);
    if (!k) plate.move(pose.x + h * after.vx, pose.y + h * after.vy, pose.theta + h * after.omega);
    // An engine's angle may forget whole turns.
    const moved = plate.get(), turns = Math.round((pose.theta - moved.theta) / (2 * Math.PI));
    pose = { ...moved, theta: moved.theta + 2 * Math.PI * turns };
    before = after;
  }
  const cpu = process.cpuUsage(begun);
  // A slip is a difference of velocities, each off by a few roundings.
  console.log(`# creep = ${10 * rounding * fastest + missing(scene, rows, h)}`);
  // An impact changes the slip within a step: then the suite computes the slip from the poses.
  const slips = NAMES.indexOf("slip"), has = !scene.effects.Impact;
  console.log([NAMES, ...rows].map((row) => (has ? row : row.toSpliced(slips, 1)).join(",")).join("\n"));
  console.log(`# cost cpu_s=${(cpu.user + cpu.system) / 1e6} steps=${n + 1}`);
}

module.exports = { refuse, load, loadModule, readScene, belt, restitution, gravity, shape, ends, corners, boxes, fan, normals, run };
