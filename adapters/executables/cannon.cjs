#!/usr/bin/env node
// cannon-es (npm cannon-es), a fork of cannon.js: a sphere on a plane, a sphere or a ring of boxes, moved in one plane.
// Its contacts are springs with damping, solved by Gauss-Seidel; its step is semi-implicit Euler. Friction is bounded by
// mu |g| and the reduced mass, not by the contact's own normal force (World.internalStep, createFrictionEquations).
"use strict";
const common = require("./common.cjs");
const cannon = common.load("cannon-es");

// Facets of a curve without a setting; a friction coefficient that no force exceeds.
const FACETS = 800, ROUGH = 1e6;

const scene = common.readScene("cannon-es", ["Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact"]);
const { plate, effects, start, points } = scene, tuned = scene.setting.rung !== "defaults";
if (plate.radius === null) common.refuse("cannon-es is given spheres: this outline is no circle about the centre of mass.");
const mu = effects.PerfectlyRough ? ROUGH : effects.CoulombFriction?.mu ?? 0;
const pull = common.gravity(scene), world = new cannon.World({ gravity: new cannon.Vec3(pull.x, pull.y, 0) });
world.defaultContactMaterial.friction = mu;
world.defaultContactMaterial.restitution = common.restitution(scene);
// Each body with each other in turn, the default, takes seconds where a track has hundreds of boxes.
world.broadphase = new cannon.SAPBroadphase(world);
if (tuned) {
  world.solver.iterations = scene.setting.iterations ?? 50;
  world.solver.tolerance = 0;
  // The default stiffness, 1e7, and relaxation, 3 steps, are for bodies of a metre and a kilogram.
  world.defaultContactMaterial.contactEquationStiffness = 1e9;
  world.defaultContactMaterial.frictionEquationStiffness = 1e9;
}

function fix(shape, x, y, angle) {
  const body = new cannon.Body({ type: cannon.Body.STATIC, shape, position: new cannon.Vec3(x, y, 0) });
  body.quaternion.setFromAxisAngle(new cannon.Vec3(0, 0, 1), angle);
  world.addBody(body);
}
const track = common.shape(scene);
if (track.kind === "line") {
  // A plane's normal is its own z axis.
  const { x, y, normal_x: nx, normal_y: ny } = points.track;
  const body = new cannon.Body({ type: cannon.Body.STATIC, shape: new cannon.Plane(), position: new cannon.Vec3(x[0], y[0], 0) });
  body.quaternion.setFromVectors(new cannon.Vec3(0, 0, 1), new cannon.Vec3(nx[0], ny[0], 0));
  world.addBody(body);
} else if (track.kind === "disc") {
  fix(new cannon.Sphere(track.radius), track.x, track.y, 0);
} else {
  for (const { x, y, angle, half } of common.boxes(points.track, scene.setting.facets ?? FACETS, plate.radius)) {
    fix(new cannon.Box(new cannon.Vec3(half, plate.radius, plate.radius)), x, y, angle);
  }
}
const how = tuned ? { linearDamping: 0, angularDamping: 0 } : {};
const body = new cannon.Body({
  mass: plate.mass, shape: new cannon.Sphere(plate.radius), position: new cannon.Vec3(start.x, start.y, 0),
  velocity: new cannon.Vec3(start.vx, start.vy, 0), angularVelocity: new cannon.Vec3(0, 0, start.omega),
  linearFactor: new cannon.Vec3(1, 1, 0), angularFactor: new cannon.Vec3(0, 0, 1), ...how,
});
world.addBody(body);
body.inertia.set(plate.inertia, plate.inertia, plate.inertia);
body.invInertia.set(1 / plate.inertia, 1 / plate.inertia, 1 / plate.inertia);
body.updateInertiaWorld(true);

// The engine keeps a quaternion, whose angle forgets whole turns.
let theta = start.theta;
body.quaternion.setFromAxisAngle(new cannon.Vec3(0, 0, 1), theta);
function get() {
  const angle = 2 * Math.atan2(body.quaternion.z, body.quaternion.w);
  theta = angle + 2 * Math.PI * Math.round((theta - angle) / (2 * Math.PI));
  const { position: { x, y }, velocity: { x: vx, y: vy } } = body;
  return { x, y, theta, vx, vy, omega: body.angularVelocity.z };
}
function move(x, y, angle) {
  theta = angle;
  body.position.set(x, y, 0);
  body.quaternion.setFromAxisAngle(new cannon.Vec3(0, 0, 1), angle);
  body.aabbNeedsUpdate = true;
}
function step(h) {
  const { x, y } = get();
  world.step(h);
  let most = 0, found;
  for (const contact of world.contacts) {
    if (!(contact.multiplier > most)) continue;
    // The lever from the plate's centre, where it was when the step began.
    const lever = contact.bi === body ? contact.ri : contact.rj;
    [most, found] = [contact.multiplier, { x: x + lever.x, y: y + lever.y }];
  }
  return found;
}

common.run(scene, { get, move }, step, Number.EPSILON);
