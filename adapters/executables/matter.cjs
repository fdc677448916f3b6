#!/usr/bin/env node
// matter-js (npm matter-js): a regular polygon for a disc, on a rectangle, a polygon or a ring of rectangles.
// Positions are advanced by Verlet's method. Sliding friction is friction times the cube of the time scale, without the
// normal force; the normal force bounds only static friction (Resolver.solveVelocity). So the deceleration depends on the
// step. Poses are reported at the engine's own times; it reports no forces.
"use strict";
const common = require("./common.cjs");
const Matter = common.load("matter-js");

// Facets of a curve without a setting; sides of the polygon that stands for a disc, 25 by the engine's default; pixels to
// a metre, since the engine's constants are lengths in pixels: a disc of 0.1 m has 20 pixels, as in its examples.
const FACETS = 800, SIDES = 200, OWN_SIDES = 25, PIXELS = 200;
// A friction coefficient that no force exceeds.
const ROUGH = 1e6;

const scene = common.readScene("matter-js", ["Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact"]);
const { plate, effects, start, points, duration } = scene, tuned = scene.setting.rung !== "defaults";
if (plate.radius === null) common.refuse("matter-js is given circles: this outline is no circle about the centre of mass.");
const mu = effects.PerfectlyRough ? ROUGH : effects.CoulombFriction?.mu ?? 0;
const n = Math.max(60, Math.ceil(duration / scene.setting.h - 1e-9)), h = duration / n, pull = common.gravity(scene);
const iterations = scene.setting.velocity_iterations ?? 10;
const how = tuned ? { velocityIterations: iterations, positionIterations: iterations } : {};
const engine = Matter.Engine.create(how), { world } = engine;
// Lengths in pixels and times in milliseconds.
Object.assign(engine.gravity, { x: pull.x, y: pull.y, scale: PIXELS * 1e-6 });
const material = { friction: mu, restitution: common.restitution(scene), ...(tuned ? { frictionAir: 0, slop: 0.001 } : {}) };
// Without friction in the case there is none at rest either.
if (!mu) material.frictionStatic = 0;

const fixed = { isStatic: true, ...material }, track = common.shape(scene), thick = 2 * plate.radius;
const add = (body) => Matter.Composite.add(world, body);
const rectangle = (x, y, length, angle) =>
  add(Matter.Bodies.rectangle(PIXELS * x, PIXELS * y, PIXELS * length, PIXELS * thick, { ...fixed, angle }));
if (track.kind === "line") {
  const { x, y, normal_x: nx, normal_y: ny } = points.track;
  rectangle(x[0] - plate.radius * nx[0], y[0] - plate.radius * ny[0], 200, Math.atan2(-nx[0], ny[0]));
} else if (track.kind === "disc") {
  const sides = scene.setting.facets ?? FACETS;
  add(Matter.Bodies.polygon(PIXELS * track.x, PIXELS * track.y, sides, PIXELS * track.radius, fixed));
} else {
  for (const { x, y, angle, half } of common.boxes(points.track, scene.setting.facets ?? FACETS, plate.radius)) {
    rectangle(x, y, 2 * half, angle);
  }
}
const sides = tuned ? SIDES : OWN_SIDES;
const body = Matter.Bodies.polygon(PIXELS * start.x, PIXELS * start.y, sides, PIXELS * plate.radius, material);
Matter.Body.setMass(body, plate.mass);
Matter.Body.setInertia(body, plate.inertia * PIXELS ** 2);
Matter.Body.setAngle(body, start.theta);
add(body);
// The engine's velocities are displacements in a sixtieth of a second; its step changes them to its own.
body.deltaTime = 1000 * h;
const base = 1 / 60;
Matter.Body.setVelocity(body, { x: PIXELS * start.vx * base, y: PIXELS * start.vy * base });
Matter.Body.setAngularVelocity(body, start.omega * base);

const begun = process.cpuUsage(), rows = [];
const note = (k) => rows.push([k * h, body.position.x / PIXELS, body.position.y / PIXELS, body.angle].join(","));
note(0);
for (let k = 1; k <= n; k++) {
  Matter.Engine.update(engine, 1000 * h);
  note(k);
}
const cpu = process.cpuUsage(begun);
console.log(["t,x,y,theta", ...rows].join("\n"));
console.log(`# cost cpu_s=${(cpu.user + cpu.system) / 1e6} steps=${n}`);
