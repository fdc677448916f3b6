#!/usr/bin/env node
// A complete engine for `--engine`: a disc with Coulomb friction on a line or a circle. Replace `step` by your engine.
// It reads one scene as JSON and writes the motion as CSV (docs/process_protocol.md). SI units, radians.

const { plate, start, effects, duration, setting, points } = JSON.parse(require("fs").readFileSync(0));
const { mass: m, radius: r } = plate, J = plate.inertia ?? Infinity; // null: the disc does not turn
const known = ["Gravity", "CoulombFriction", "Unilateral"], bend = points.track.curvature[0];
const supported = r !== null && start.xi1 !== null && Object.keys(effects).every((name) => known.includes(name))
  && !effects.CoulombFriction?.mu_static && typeof (effects.CoulombFriction?.mu ?? 0) === "number" // not a formula
  && points.track.curvature.every((c) => Math.abs(c - bend) <= 1e-9 * Math.abs(bend));
if (!supported) {
  console.error("Only discs in contact with a line or a circle, with one coefficient of friction, are supported.");
  process.exit(3); // unsupported; any other status but 0 is a crash
}
const mu = effects.CoulombFriction?.mu ?? 0;
const { g, direction } = effects.Gravity ?? { g: 0, direction: 0 };
const gx = g * Math.cos(direction), gy = g * Math.sin(direction);

// Place of the centre, direction and size of its velocity along the track, angle and its rate.
function startState() {
  const first = (name) => points.track[name][0];
  let nx = first("normal_x"), ny = first("normal_y");
  if (bend !== 0) { // the track's left normal; of a circle, along the line from the disc's centre to the circle's
    nx += (first("x") - start.x) * bend;
    ny += (first("y") - start.y) * bend;
  }
  const heading = Math.atan2(-nx, ny), u = start.vx * Math.cos(heading) + start.vy * Math.sin(heading);
  return { x: start.x, y: start.y, heading, u, theta: start.theta, omega: start.omega };
}

// The next state by the midpoint rule, and both forces at this one. Friction is as large as sticking until the end of
// the step needs, up to mu times the normal force.
function step({ x, y, heading, u, theta, omega }, h) {
  const rates = (angle, speed) => {
    const tx = Math.cos(angle), ty = Math.sin(angle), turning = bend * speed / (1 - bend * r);
    const along = gx * tx + gy * ty, normal = m * (turning * speed - (gy * tx - gx * ty)), most = mu * Math.abs(normal);
    const stop = -((u + r * omega) / h + along) / (1 / m + r * r / J);
    const tangential = Math.max(-most, Math.min(most, stop));
    return { turning, du: along + tangential / m, domega: r * tangential / J, normal, tangential };
  };
  const first = rates(heading, u);
  const angle = heading + 0.5 * h * first.turning, speed = u + 0.5 * h * first.du, k = rates(angle, speed);
  const next = {
    x: x + h * speed * Math.cos(angle), y: y + h * speed * Math.sin(angle), heading: heading + h * k.turning,
    u: u + h * k.du, theta: theta + h * (omega + 0.5 * h * k.domega), omega: omega + h * k.domega,
  };
  return { next, normal: first.normal, tangential: first.tangential };
}

const steps = Math.max(60, Math.ceil(duration / setting.h)), h = duration / steps;
// An engine whose contacts creep while they stick may report the speed: lines.push("# creep = 5e-3")
const lines = ["t,x,y,theta,vx,vy,omega,normal_force,friction_force"];
let state = startState();
for (let k = 0; k <= steps; k++) {
  const { next, normal, tangential } = step(state, h), { x, y, heading, u, theta, omega } = state;
  if (normal < 0 && effects.Unilateral) break; // the disc leaves the track: the output ends
  const velocity = [u * Math.cos(heading), u * Math.sin(heading)];
  lines.push([k * h, x, y, theta, ...velocity, omega, normal, tangential].join(","));
  state = next;
}
process.stdout.write(lines.join("\n") + "\n");
