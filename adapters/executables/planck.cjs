#!/usr/bin/env node
// planck.js (npm planck), Box2D 2.4 in JavaScript and in doubles: a circle or a fan of polygons on an edge, a circle or
// a chain of facets. Its Gauss-Seidel contacts are rigid, its step is semi-implicit Euler. A belt is the tangent speed of
// each contact, which has the same sign whichever of the two bodies is the first.
"use strict";
const common = require("./common.cjs");
const planck = common.load("planck");

// Facets of a curve for a disc, and for polygons, each of which is tried on every facet near it; corners of an outline,
// of which a polygon may have twelve in all; friction that no forces exhaust.
const FACETS = 8000, FEWER = 500, VERTICES = 96, RIM = 8, ROUGH = 1e6;

const scene = common.readScene("planck", ["Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact", "Belt"]);
const { plate, effects, start, points, closed } = scene, running = common.belt("planck", scene);
const tuned = scene.setting.rung !== "defaults", track = common.shape(scene);
// A step along the tangent of a hill takes a disc off it by (v h)²/2R, and what does not overlap is in flight: so the
// two overlap at first, by 1 m/s times the step, and the engine is told to leave that alone.
const overlap = tuned && track.kind === "disc" && plate.radius !== null ? scene.setting.h : 0;
// As it comes, edges have a skin of 1 cm and overlaps of 5 mm are left alone: a twentieth of a plate of 0.1 m.
if (tuned) planck.Settings.linearSlop = overlap || 1e-5;
// By default nothing rebounds below 1 m/s.
if (tuned) planck.Settings.velocityThreshold = 0;

// A sweep to the first time of impact stops a plate in a bowl at every facet.
const how = tuned ? { allowSleep: false, continuousPhysics: false } : {};
const world = new planck.World({ gravity: common.gravity(scene), ...how });
const material = { friction: effects.PerfectlyRough ? ROUGH : effects.CoulombFriction?.mu ?? 0, restitution: common.restitution(scene) };
const ground = world.createBody();
if (track.kind === "line") {
  ground.createFixture(new planck.Edge(...common.ends(scene)), material);
} else if (track.kind === "disc") {
  ground.createFixture(new planck.Circle({ x: track.x, y: track.y }, track.radius + overlap), material);
} else {
  const corners = common.corners(points.track, plate.radius === null ? FEWER : scene.setting.facets ?? FACETS);
  ground.createFixture(new planck.Chain(closed.track ? corners.slice(0, -1) : corners, closed.track), material);
}
const body = world.createBody({
  type: "dynamic", position: start, angle: start.theta,
  linearVelocity: { x: start.vx, y: start.vy }, angularVelocity: start.omega,
});
const shapes = plate.radius === null
  ? common.fan("planck", scene, VERTICES, RIM).map((part) => new planck.Polygon(part))
  : [new planck.Circle(plate.radius)];
for (const shape of shapes) body.createFixture(shape, material);
body.setMassData({ mass: plate.mass, center: { x: 0, y: 0 }, I: plate.inertia });

// The points of contact that a step begins with: afterwards they are where the bodies are then.
let touching = [];
world.on("pre-solve", (contact) => {
  contact.setTangentSpeed(running);
  touching.push([contact.getManifold(), contact.getWorldManifold(null).points]);
});

function step(h) {
  touching = [];
  world.step(h, scene.setting.iterations ?? 8, 3);
  let most = 0, found;
  for (const [manifold, places] of touching) {
    for (let i = 0; i < manifold.pointCount; i++) {
      const { normalImpulse } = manifold.points[i];
      if (normalImpulse > most) [most, found] = [normalImpulse, { x: places[i].x, y: places[i].y }];
    }
  }
  return found;
}

function get() {
  const { x, y } = body.getPosition(), { x: vx, y: vy } = body.getLinearVelocity();
  return { x, y, theta: body.getAngle(), vx, vy, omega: body.getAngularVelocity() };
}

common.run(scene, { get, move: (x, y, theta) => body.setTransform({ x, y }, theta) }, step, Number.EPSILON, running);
