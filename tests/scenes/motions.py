"""The same scene seen otherwise: in a mirror, turned, in other units. And a case's reference motion, solved once."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import pi

import numpy as np

import reference
from cases import (
    Belt,
    Case,
    Chain,
    CoulombFriction,
    Curve,
    Drive,
    FreePlate,
    Gravity,
    Load,
    Outline,
    RollingResistance,
    Start,
    StartPose,
    Trajectory,
)
from cases import curves as c
from cases.contact import start_motion
from cases.curves.pieces import CurvePieces
from cases.effects import MOTION
from cases.formulas.expressions import PARAMETER
from cases.motion.mechanics import contact_power
from cases.moving_surface import TIME
from cases.scene.contact_pairs import PairCase, pairs
from cases.slip_laws import SLIP_SPEED
from reference import solve


def motion_of(case: Case) -> Trajectory:
    """The reference's motion at 1e-12, by the default method of the test's file."""
    return _motion_by(case, solve.METHODS[0])


@lru_cache(maxsize=256)
def _motion_by(case: Case, method: str) -> Trajectory:
    """`method` is part of the cache's key only, as files of tests have different default methods. It is not passed on:
    the default falls back to DOP853 for equations with an integral, which the Taylor method rejects."""
    return reference.simulate(case, rtol=1e-12)


def _effects(case: Case, how: dict):
    """The case's effects, those of a kind in `how` changed."""
    return tuple(how.get(type(e), lambda same: same)(e) for e in case.effects)


def _mirrored_load(load: Load) -> Load:
    seen = {s: -s for s in MOTION if s.name in ("x", "theta", "vx", "omega")}
    fx, fy, moment = (e.subs(seen, simultaneous=True) for e in load.expression)
    return Load(-fx, fy, -moment)


def _turned_load(load: Load, length: float, time: float, mass: float, turn: float) -> Load:
    t, x, y, theta, vx, vy, omega = MOTION
    a, b = c.cos(turn), c.sin(turn)
    back = {
        t: t / time,
        x: (a * x + b * y) / length,
        y: (a * y - b * x) / length,
        theta: theta - turn,
        vx: (a * vx + b * vy) * time / length,
        vy: (a * vy - b * vx) * time / length,
        omega: omega * time,
    }
    fx, fy, moment = (e.subs(back, simultaneous=True) for e in load.expression)
    force = mass * length / time**2
    return Load(force * (a * fx - b * fy), force * (b * fx + a * fy), force * length * moment)


def _scaled_friction(friction: CoulombFriction, per_speed: float) -> CoulombFriction:
    """The same friction for slip speeds in another unit; `per_speed`: the old number of a new speed of one."""
    if not friction.by_speed:
        return friction
    return CoulombFriction(friction.mu.subs(SLIP_SPEED, per_speed * SLIP_SPEED), friction.mu_static)


def _turned_drive(drive: Drive, length: float, time: float, turn: float) -> Drive:
    x, y, angle = (part.subs(TIME, TIME / time) for part in drive.expression)
    a, b = c.cos(turn), c.sin(turn)
    return Drive(length * (a * x - b * y), length * (b * x + a * y), angle)


def _chain(curve: Chain, pieces: list[Curve], start: float) -> Chain:
    """A chain of the same kind from pieces in another order or place, whose parameter begins at `start`."""
    first = pieces[0]
    shift = start - first.span[0]
    pieces[0] = Curve(lambda s: first.at(s - shift), tuple(end + shift for end in first.span))
    return type(curve)(pieces) if isinstance(curve, Outline) else Chain(pieces, curve.is_closed)


def _mirrored_chain(curve: Chain) -> Chain:
    """Its pieces in the other order; the parameter has the other sign, also at corners."""
    ends = [e.start + e.piece.span[1] - e.low for e in curve.elements if isinstance(e.piece, Curve)]
    return _chain(curve, [_mirrored_curve(piece) for piece in reversed(curve.pieces)], -ends[-1])


def _turned_chain(curve: Chain, length: float, angle: float) -> Chain:
    """Its pieces, turned; a piece's parameter is what it was, so that a corner's and the others' stay in step."""
    return _chain(curve, [_turned_curve(piece, length, angle) for piece in curve.pieces], curve.span[0])


def _mirrored_curve(curve: Curve) -> Curve:
    if isinstance(curve, Chain):
        return _mirrored_chain(curve)
    if curve.parts:
        return Curve.in_pieces(_mirrored_pieces(curve.parts), may_cross=curve.may_cross)
    x, y = curve.expression
    domain = curve.domain and (-curve.domain[1], -curve.domain[0])
    return Curve(lambda s: (-x.subs(PARAMETER, -s), y.subs(PARAMETER, -s)), domain)


def _mirrored_pieces(pieces: CurvePieces) -> CurvePieces:
    """The pieces in the other order; a formula of s - q0 is one of q0 - s then."""

    def back(row, numbers):
        return row.subs({PARAMETER: -PARAMETER, numbers[0]: -numbers[0]}, simultaneous=True)

    return replace(
        pieces,
        breaks=tuple(-edge for edge in reversed(pieces.breaks)),
        forms=tuple(((-back(x, numbers), back(y, numbers)), numbers) for (x, y), numbers in pieces.forms),
        form_numbers=pieces.form_numbers[::-1],
        origins=tuple(-origin for origin in reversed(pieces.origins)),
        sizes=pieces.sizes[::-1],
        inner_edges=tuple(tuple(-edge for edge in reversed(edges)) for edges in reversed(pieces.inner_edges)),
    )


def _turned_curve(curve: Curve, length: float, angle: float) -> Curve:
    if isinstance(curve, Chain):
        return _turned_chain(curve, length, angle)
    a, b = c.cos(angle), c.sin(angle)

    def turned(x, y):
        return length * (a * x - b * y), length * (b * x + a * y)

    if curve.parts:
        forms = tuple((turned(*rows), numbers) for rows, numbers in curve.parts.forms)
        return Curve.in_pieces(replace(curve.parts, forms=forms), may_cross=curve.may_cross)
    x, y = curve.expression
    return Curve(lambda s: turned(x, y), curve.domain)


def mirrored(case: Case) -> Case:
    """In a mirror along Y; parameters run backwards, so that the plate is still on the left."""
    start = start_motion(case)
    return replace(
        case,
        track=_mirrored_curve(case.track),
        plate=replace(case.plate, outline=_mirrored_curve(case.plate.outline)),
        effects=_effects(
            case,
            {
                Gravity: lambda e: Gravity(e.g, pi - e.direction),
                Load: _mirrored_load,
                Belt: lambda e: Belt(-e.expression),
                Drive: lambda e: Drive(-e.expression[0], e.expression[1], -e.expression[2]),
            },
        ),
        start=Start(-start.xi1, -start.xi2, -start.slip, -start.omega, case.start.gap, case.start.gap_rate),
        supports=tuple(replace(support, curve=_mirrored_curve(support.curve)) for support in case.supports),
        others=tuple(_mirrored_plate(other) for other in case.others),
    )


def _mirrored_plate(other: FreePlate) -> FreePlate:
    s = other.start
    start = StartPose(-s.x, s.y, -s.theta, -s.vx, s.vy, -s.omega)
    return replace(other, plate=replace(other.plate, outline=_mirrored_curve(other.plate.outline)), start=start)


def _turned_plate(other: FreePlate, length: float, time: float, mass: float, turn: float) -> FreePlate:
    s, plate = other.start, other.plate
    place, velocity = ((x + 1j * y) * np.exp(1j * turn) * length for x, y in ((s.x, s.y), (s.vx, s.vy)))
    start = StartPose(
        place.real, place.imag, s.theta + turn, velocity.real / time, velocity.imag / time, s.omega / time
    )
    outline, inertia = _turned_curve(plate.outline, length, 0), mass * length**2 * plate.inertia
    return replace(other, plate=replace(plate, outline=outline, mass=mass * plate.mass, inertia=inertia), start=start)


def in_other_units(case: Case, length: float, time: float, mass: float, turn: float) -> Case:
    """Turned by an angle, and with all lengths, times and masses multiplied."""
    start = start_motion(case)
    plate = case.plate
    return replace(
        case,
        track=_turned_curve(case.track, length, turn),
        supports=tuple(replace(one, curve=_turned_curve(one.curve, length, turn)) for one in case.supports),
        plate=replace(
            plate,
            outline=_turned_curve(plate.outline, length, 0),
            mass=mass * plate.mass,
            inertia=mass * length**2 * plate.inertia,
        ),
        effects=_effects(
            case,
            {
                Gravity: lambda e: Gravity(e.g * length / time**2, e.direction + turn),
                CoulombFriction: lambda e: _scaled_friction(e, time / length),
                Load: lambda e: _turned_load(e, length, time, mass, turn),
                RollingResistance: lambda e: RollingResistance(e.arm * length),
                Belt: lambda e: Belt(e.expression.subs(TIME, TIME / time) * length / time),
                Drive: lambda e: _turned_drive(e, length, time, turn),
            },
        ),
        start=Start(
            start.xi1,
            start.xi2,
            start.slip * length / time,
            start.omega / time,
            case.start.gap * length,
            case.start.gap_rate * length / time,
        ),
        duration=case.duration * time,
        others=tuple(_turned_plate(other, length, time, mass, turn) for other in case.others),
    )


def _by(case: Case, track: Curve, xi1: float, outline: Curve, xi2: float) -> Case:
    """The same case by other parameters of its curves, in which it starts there."""
    start = replace(case.start, xi1=xi1, xi2=xi2)
    return replace(case, track=track, plate=replace(case.plate, outline=outline), start=start)


def in_other_parameters(case: Case, unit: float) -> Case:
    """Both curves by parameters of which there are so many to the old one."""

    def by(curve: Curve) -> Curve:
        return Curve(lambda s: curve.at(s / unit), curve.domain and tuple(unit * end for end in curve.domain))

    start = start_motion(case)
    return _by(case, by(case.track), unit * start.xi1, by(case.plate.outline), unit * start.xi2)


# By how much a warped parameter runs faster and slower than the old one, in parts.
WARP = 0.3


def warped(case: Case) -> Case:
    """Both curves by parameters that run fast and slowly in turns, and begin and end as the old ones do."""

    def by(curve: Curve, xi: float) -> tuple[Curve, float]:
        low, high = curve.domain or (0.0, curve.period or 2 * pi)
        often = 2 * pi / (high - low)
        s = xi
        for _ in range(100):  # the old one's distance from the new one is a contraction by WARP
            s = xi - WARP / often * np.sin(often * (s - low))
        return Curve(lambda s: curve.at(s + WARP / often * c.sin(often * (s - low))), curve.domain), float(s)

    start = start_motion(case)
    return _by(case, *by(case.track, start.xi1), *by(case.plate.outline, start.xi2))


def energy(case: Case, state) -> np.ndarray:
    """Kinetic and potential energy, J."""
    gravity = case.effect(Gravity) or Gravity(0.0)
    height = -(state.x * np.cos(gravity.direction) + state.y * np.sin(gravity.direction))
    kinetic = 0.5 * case.plate.mass * (state.vx**2 + state.vy**2)
    if case.plate.turns:
        kinetic = kinetic + 0.5 * case.plate.inertia * state.omega**2
    total = kinetic + case.plate.mass * gravity.g * height
    for other in case.others:
        alone = replace(case, plate=other.plate, start=Start(0.0), others=())
        total = total + energy(alone, state.plate(other.name))
    return total


def contact_case(case, contact: str) -> PairCase:
    """The first pair of a support, by the name of its contact."""
    return next(pair for pair in pairs(case) if f"plate/{pair.support}" == contact.partition(" ")[0])


def work_done(case: Case, motion: Trajectory) -> float:
    """Work of friction at all contacts (by belts too), load and rolling resistance, J, by Gauss's rule phase by
    phase."""
    load, resistance = case.effect(Load), case.effect(RollingResistance)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    # Two equal times mark what is not smooth, also where no mode changes (a guide that presses from its other side).
    ends = [0.0, *motion.t[1:][np.diff(motion.t) == 0.0], float(motion.t[-1])]
    total = 0.0
    for low, high in zip(ends[:-1], ends[1:], strict=True):
        # Between the motion's steps, too, which are shorter where a friction law is narrow.
        edges = np.union1d(np.linspace(low, high, 41), motion.t[(motion.t > low) & (motion.t < high)])
        half = np.diff(edges)[:, None] / 2
        times = (edges[:-1, None] + half + half * nodes).ravel()
        state = motion(times)
        if case.supports or len(motion.contact_names) > 1:
            power = sum(contact_power(contact_case(case, n), times, motion.of(n)(times)) for n in motion.contact_names)
        else:
            power = contact_power(case, times, state)
        if resistance:
            power -= resistance.arm * np.abs(state.normal_force * state.omega)
        if load:
            moves = np.array([state.x, state.y, state.theta, state.vx, state.vy, state.omega])
            forces = np.array([load.at(t, *column) for t, column in zip(times, moves.T, strict=True)])
            power += np.sum(forces * moves[3:].T, axis=1)
        total += float(np.sum((half * weights).ravel() * power))
    return total


def sampled(exact: Trajectory, count: int) -> Trajectory:
    """The exact motion as an engine would give it: on a uniform grid, without its transitions."""
    t = np.linspace(exact.t[0], exact.t[-1], count)
    return Trajectory(t=t, **exact(t)._asdict())
