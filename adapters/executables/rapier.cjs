#!/usr/bin/env node
// Rapier (npm @dimforge/rapier2d-compat), in Rust, as WebAssembly and in single precision: a ball or a fan of convex
// polygons on a segment, a ball or a polyline. Its contacts give way along the normal alone: friction is solved without
// softness, last of all (contact_with_coulomb_friction.rs, refresh_rhs_wo_bias, in version 0.35).
"use strict";
const common = require("./common.cjs");
const rapier = common.load("@dimforge/rapier2d-compat");

// Facets of a curve, so many that a disc meets one or more in a step of a millisecond (on longer ones the contact pushes
// at their corners alone); corners of an outline; friction that no forces exhaust.
const FACETS = 8000, VERTICES = 96, RIM = 8, ROUGH = 1e6;
// Relative, of its numbers.
const SINGLE = 2 ** -23;

async function main() {
  const scene = common.readScene("Rapier", ["Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact"]);
  const { plate, effects, start, points } = scene, tuned = scene.setting.rung !== "defaults";
  // It says on standard error's sister that its own start is out of date; standard output is the motion's alone.
  const [log, warn] = [console.log, console.warn];
  console.log = console.warn = () => {};
  await rapier.init();
  [console.log, console.warn] = [log, warn];
  const world = new rapier.World(common.gravity(scene));
  if (tuned) {
    // The engine's small lengths are for bodies of a metre.
    world.lengthUnit = 0.01;
    world.numSolverIterations = scene.setting.iterations ?? 16;
  }
  const mu = effects.PerfectlyRough ? ROUGH : effects.CoulombFriction?.mu ?? 0;
  const add = (shape, body) => world.createCollider(shape.setFriction(mu).setRestitution(common.restitution(scene)).setDensity(0), body);
  const flat = (corners) => new Float32Array(corners.flatMap(({ x, y }) => [x, y]));
  const track = common.shape(scene);
  let shape;
  if (track.kind === "line") {
    shape = rapier.ColliderDesc.polyline(flat(common.ends(scene)));
  } else if (track.kind === "disc") {
    shape = rapier.ColliderDesc.ball(track.radius).setTranslation(track.x, track.y);
  } else {
    shape = rapier.ColliderDesc.polyline(flat(common.corners(points.track, scene.setting.facets ?? FACETS)));
  }
  const ground = add(shape);
  const made = rapier.RigidBodyDesc.dynamic().setTranslation(start.x, start.y).setRotation(start.theta)
    .setLinvel(start.vx, start.vy).setAngvel(start.omega).setCanSleep(false)
    .setAdditionalMassProperties(plate.mass, { x: 0, y: 0 }, plate.inertia);
  const body = world.createRigidBody(made);
  const shapes = plate.radius === null
    ? common.fan("Rapier", scene, VERTICES, RIM).map((part) => rapier.ColliderDesc.convexHull(flat(part)))
    : [rapier.ColliderDesc.ball(plate.radius)];
  const colliders = shapes.map((part) => add(part, body));
  const get = () => {
    const { x, y } = body.translation(), { x: vx, y: vy } = body.linvel();
    return { x, y, theta: body.rotation(), vx, vy, omega: body.angvel() };
  };
  const move = (x, y, angle) => { body.setTranslation({ x, y }, true); body.setRotation(angle, true); };
  // Friction acts in the middle of the overlap: half of it away from the fixed shape's point, which stays where it was at
  // the step's begin.
  const touched = (from) => {
    let most = 0, found;
    const { x: cx, y: cy } = ground.translation();
    for (const collider of colliders) {
      world.contactPair(ground, collider, (manifold, flipped) => {
        for (let i = 0; i < manifold.numContacts(); i++) {
          const impulse = manifold.contactImpulse(i);
          if (impulse <= most) continue;
          const local = flipped ? manifold.localContactPoint2(i) : manifold.localContactPoint1(i);
          const x = local.x + cx, y = local.y + cy, normal = manifold.normal();
          const towards = Math.sign((from.x - x) * normal.x + (from.y - y) * normal.y);
          const half = (towards * manifold.contactDist(i)) / 2;
          [most, found] = [impulse, { x: x + half * normal.x, y: y + half * normal.y }];
        }
      });
    }
    return found;
  };
  const step = (h) => {
    const from = get();
    world.timestep = h;
    world.step();
    return touched(from);
  };
  common.run(scene, { get, move }, step, SINGLE);
}

main();
