#!/usr/bin/env node
// Rapier (npm @dimforge/rapier2d-compat), in Rust, as WebAssembly and in single precision: a ball or a fan of convex
// polygons on a segment, a ball or a polyline. Its contacts are soft: what sticks creeps.
"use strict";
const common = require("./common.cjs");
const rapier = common.load("@dimforge/rapier2d-compat");

// Facets of a curve, corners of an outline; friction that no forces exhaust.
const FACETS = 2000, VERTICES = 96, RIM = 8, ROUGH = 1e6;
// What is declared, m/s: its contacts are soft, and a polyline is bumpy.
const CREEP = 5e-3;

async function main() {
  const scene = common.readScene("Rapier", ["Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight"]);
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
    world.numSolverIterations = 16;
  }
  const mu = effects.PerfectlyRough ? ROUGH : effects.CoulombFriction?.mu ?? 0;
  const add = (shape, body) => world.createCollider(shape.setFriction(mu).setRestitution(0).setDensity(0), body);
  const flat = (corners) => new Float32Array(corners.flatMap(({ x, y }) => [x, y]));
  const track = common.shape(scene);
  if (track.kind === "line") {
    add(rapier.ColliderDesc.polyline(flat(common.ends(scene))));
  } else if (track.kind === "hill") {
    add(rapier.ColliderDesc.ball(track.radius).setTranslation(track.x, track.y));
  } else {
    add(rapier.ColliderDesc.polyline(flat(common.corners(points.track, FACETS))));
  }
  const made = rapier.RigidBodyDesc.dynamic().setTranslation(start.x, start.y).setRotation(start.theta)
    .setLinvel(start.vx, start.vy).setAngvel(start.omega).setCanSleep(false)
    .setAdditionalMassProperties(plate.mass, { x: 0, y: 0 }, plate.inertia);
  const body = world.createRigidBody(made);
  const shapes = plate.radius === null
    ? common.fan("Rapier", scene, VERTICES, RIM).map((part) => rapier.ColliderDesc.convexHull(flat(part)))
    : [rapier.ColliderDesc.ball(plate.radius)];
  for (const shape of shapes) add(shape, body);
  const get = () => {
    const { x, y } = body.translation(), { x: vx, y: vy } = body.linvel();
    return { x, y, theta: body.rotation(), vx, vy, omega: body.angvel() };
  };
  const move = (x, y, angle) => { body.setTranslation({ x, y }, true); body.setRotation(angle, true); };
  const step = (h) => { world.timestep = h; world.step(); };
  common.run(scene, { get, move }, step, CREEP);
}

main();
