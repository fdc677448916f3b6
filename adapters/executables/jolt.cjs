#!/usr/bin/env node
// Jolt Physics (npm jolt-physics), in C++, as WebAssembly and in single precision: a sphere on a plane, a sphere or a
// mesh, moved in one plane. Its contacts are rigid, solved by sequential impulses; friction is a cone over the normal
// impulse of the last iteration; its step is semi-implicit Euler. Overlap up to mPenetrationSlop is left alone.
"use strict";
const common = require("./common.cjs");
const loading = common.loadModule("jolt-physics");

// Facets of a curve without a setting; half the width of the track and a friction coefficient that no force exceeds.
const FACETS = 8000, WIDTH = 10, ROUGH = 1e6;
// Relative, of its numbers.
const SINGLE = 2 ** -23;

async function main() {
  const { default: start } = await loading;
  const scene = common.readScene("Jolt", ["Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact"]);
  const { plate, effects, points, setting } = scene, tuned = setting.rung !== "defaults", track = common.shape(scene);
  if (plate.radius === null) common.refuse("Jolt is given spheres: this outline is no circle about the centre of mass.");
  const Jolt = await start();
  const mu = effects.PerfectlyRough ? ROUGH : effects.CoulombFriction?.mu ?? 0, pull = common.gravity(scene);

  // Two layers, one for what moves and one for what does not, that collide with each other.
  const settings = new Jolt.JoltSettings(), pairs = new Jolt.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(0, 1);
  const layers = new Jolt.BroadPhaseLayerInterfaceTable(2, 2);
  layers.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
  layers.MapObjectToBroadPhaseLayer(1, new Jolt.BroadPhaseLayer(1));
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
  const world = new Jolt.JoltInterface(settings), system = world.GetPhysicsSystem(), bodies = system.GetBodyInterface();
  system.SetGravity(new Jolt.Vec3(pull.x, pull.y, 0));
  if (tuned) {
    const physics = system.GetPhysicsSettings();
    // Contact points are kept while a body has moved less than 1 mm and 2 degrees, a whole step or more of 1 ms: a disc on a
    // line then rolls 5e-4 s too early, and without that 1e-6 s.
    physics.mUseBodyPairContactCache = false;
    // The engine's small lengths, 2 cm each, are for bodies of a metre. In a mesh the plate would touch the next facet too:
    // with 1e-4 of the radius, off in disc_in_circle[mu=0.2] is 9.6, 11 and 38 % at 1, 0.5 and 0.2 ms, with 1e-6 6.9, 4.2 and 1.5.
    const slop = plate.radius * (setting.slop ?? (track.kind === "chain" ? 1e-6 : 1e-3));
    physics.mPenetrationSlop = physics.mSpeculativeContactDistance = slop;
    physics.mNumVelocitySteps = setting.iterations ?? 20;
    physics.mMinVelocityForRestitution = 0;
    system.SetPhysicsSettings(physics);
  }

  const zero = new Jolt.Quat(0, 0, 0, 1), at = (x, y) => new Jolt.RVec3(x, y, 0);
  const add = (shape, x, y) => {
    const fixed = new Jolt.BodyCreationSettings(shape, at(x, y), zero, Jolt.EMotionType_Static, 0);
    fixed.mFriction = mu; // the engine takes the geometric mean of both bodies' coefficients
    bodies.CreateAndAddBody(fixed, Jolt.EActivation_DontActivate);
  };
  if (track.kind === "line") {
    const { x, y, normal_x: nx, normal_y: ny } = points.track;
    const plane = new Jolt.Plane(new Jolt.Vec3(nx[0], ny[0], 0), -(nx[0] * x[0] + ny[0] * y[0]));
    add(new Jolt.PlaneShapeSettings(plane, null, 1000).Create().Get(), 0, 0);
  } else if (track.kind === "disc") {
    add(new Jolt.SphereShape(track.radius), track.x, track.y);
  } else {
    add(mesh(Jolt, common.corners(points.track, setting.facets ?? FACETS)), 0, 0);
  }

  const body = ball(Jolt, scene, mu, tuned, at), made = bodies.CreateBody(body), id = made.GetID();
  bodies.AddBody(id, Jolt.EActivation_Activate);
  // The engine keeps a quaternion, whose angle forgets whole turns.
  let theta = scene.start.theta;
  const get = () => {
    const place = made.GetPosition(), turn = made.GetRotation(), v = made.GetLinearVelocity(), w = made.GetAngularVelocity();
    const angle = 2 * Math.atan2(turn.GetZ(), turn.GetW());
    theta = angle + 2 * Math.PI * Math.round((theta - angle) / (2 * Math.PI));
    return { x: place.GetX(), y: place.GetY(), theta, vx: v.GetX(), vy: v.GetY(), omega: w.GetZ() };
  };
  const move = (x, y, angle) => {
    theta = angle;
    const turn = new Jolt.Quat(0, 0, Math.sin(angle / 2), Math.cos(angle / 2));
    bodies.SetPositionAndRotation(id, at(x, y), turn, Jolt.EActivation_Activate);
  };
  const nearest = common.normals(scene);
  const step = (h) => {
    const before = get();
    world.Step(h, 1);
    const after = get(), dvx = after.vx - before.vx - h * pull.x, dvy = after.vy - before.vy - h * pull.y;
    // The engine reports no impulse: what the velocity gains beyond gravity comes from the contact, up to rounding.
    const rounding = 10 * SINGLE * (Math.hypot(after.vx, after.vy) + h * Math.hypot(pull.x, pull.y));
    if (Math.hypot(dvx, dvy) <= rounding) return undefined;
    const normal = nearest(before);
    return { x: before.x - plate.radius * normal.x, y: before.y - plate.radius * normal.y };
  };
  common.run(scene, { get, move }, step, SINGLE);
}

/** Two triangles for each facet, with their front towards the plate. */
function mesh(Jolt, corners) {
  const triangles = new Jolt.TriangleList(), count = corners.length - 1;
  triangles.resize(2 * count);
  const put = (number, ...places) => places.forEach(([{ x, y }, z], k) => {
    const corner = triangles.at(number).get_mV(k);
    [corner.x, corner.y, corner.z] = [x, y, z];
  });
  for (let i = 0; i < count; i++) {
    const [a, b] = [corners[i], corners[i + 1]];
    put(2 * i, [a, WIDTH], [b, WIDTH], [b, -WIDTH]);
    put(2 * i + 1, [a, WIDTH], [b, -WIDTH], [a, -WIDTH]);
  }
  return new Jolt.MeshShapeSettings(triangles, new Jolt.PhysicsMaterialList()).Create().Get();
}

/** The plate as a sphere that moves in the plane, with its mass and inertia. */
function ball(Jolt, scene, mu, tuned, at) {
  const { plate, start } = scene;
  const turn = new Jolt.Quat(0, 0, Math.sin(start.theta / 2), Math.cos(start.theta / 2));
  const shape = new Jolt.SphereShape(plate.radius);
  const body = new Jolt.BodyCreationSettings(shape, at(start.x, start.y), turn, Jolt.EMotionType_Dynamic, 1);
  body.mAllowedDOFs = Jolt.EAllowedDOFs_Plane2D;
  body.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
  body.mMassPropertiesOverride.mMass = plate.mass;
  body.mMassPropertiesOverride.mInertia = Jolt.Mat44.prototype.sScale(plate.inertia);
  body.mLinearVelocity = new Jolt.Vec3(start.vx, start.vy, 0);
  body.mAngularVelocity = new Jolt.Vec3(0, 0, start.omega);
  body.mFriction = mu;
  body.mRestitution = common.restitution(scene);
  if (tuned) {
    body.mLinearDamping = body.mAngularDamping = 0;
    body.mMaxLinearVelocity = body.mMaxAngularVelocity = 1e4;
    body.mAllowSleeping = false;
  }
  return body;
}

main();
