"""A free polygon and discs: exact motions, the paper's matrix at instants, and both formulations in whole sequences."""

from dataclasses import replace
from math import atan, cos, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import cases
import reference
from adapters import pymunk
from adapters.interface import refusal
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Mode,
    Plate,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.contact.geometry import find
from cases.contact.nearest_samples import nearest_samples
from cases.contact.polygon_features import region_of, regions
from cases.curves.corner import Corner
from cases.library import hill, line
from cases.scene.free_plates import plates_of, start_poses
from reference.paper.bodies import BodyContact, solve_bodies
from reference.solver.places import place
from reference.solver.plate_numbers import bodies as numbers_of
from reference.solver.plate_numbers import load_at
from reference.solver.touching import touching_contacts
from reference.witness.contacts import plates_at

G = 9.81


def scene(polygon: Plate, pose: StartPose, ball: Plate, at: StartPose, floor: float = 0.0, mu: float = 0.0, time=1.0):
    """A polygon and a disc on a floor with friction of its own; the track is far below."""
    own = (CoulombFriction(floor),) if floor else ()
    effects = (Gravity(G), Unilateral(), Flight(), Impact(0.0), *((CoulombFriction(mu),) if mu else ()))
    support = Support(Curve(lambda s: (s, 5.0 + 0 * s)), "floor", own)
    up = (replace(pose, y=pose.y + 5.0), replace(at, y=at.y + 5.0))
    return Case(line(), polygon, effects, up[0], time, supports=(support,), others=(FreePlate(ball, up[1], "disc"),))


def over_the_edge(mass: float, speed: float, floor: float) -> Case:
    """A disc of 1 kg slides without friction over the edge of a block of width 1 m and height 0.4 m."""
    ball, at = disc(0.1, 1.0), StartPose(0.3, 0.5, vx=speed)
    return scene(Plate.rectangle(1.0, 0.4, mass), StartPose(0.0, 0.2), ball, at, floor)


# --- exact motions ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "mass,floor",
    [(2.0, 0.0), pytest.param(0.3, 0.0, marks=pytest.mark.slow), pytest.param(5.0, 0.9, marks=pytest.mark.slow)],
)
def test_a_disc_passes_from_an_edge_to_a_corner_and_leaves_it_at_the_exact_time(mass, floor):
    """With u = r φ̇ about the corner, momentum and energy in the frame of the centre of mass give
    u² (1 − κ cos²φ) = v² (1 − κ) + 2 g r (1 − cos φ), κ = m/(M + m), and κ = 0 if the block sticks; the force vanishes
    where u² = g r cos φ, as the block has no acceleration there."""
    kappa, speed, r = 0.0 if floor else 1.0 / (1.0 + mass), 0.4, 0.1

    def square(phi: float) -> float:
        return (speed**2 * (1.0 - kappa) + 4.0 * G * r * sin(0.5 * phi) ** 2) / (1.0 - kappa * cos(phi) ** 2)

    end = brentq(lambda phi: square(phi) - G * r * cos(phi), 0.0, 1.5, xtol=1e-15)
    turning, _ = quad(lambda phi: r / sqrt(square(phi)), 0.0, end, epsabs=1e-14, epsrel=1e-14)
    motion = reference.simulate(over_the_edge(mass, speed, floor), rtol=1e-12)
    first = motion.transitions[0]
    assert (first.contact, first.before, first.after) == ("disc/plate", Mode.SLIDE, Mode.FLIGHT)
    assert first.time == pytest.approx(0.2 / speed + turning, abs=1e-12)  # the slack of the handing over: 1e-13 m
    arm = motion.plate("disc")(first.time).x - motion(first.time).x - 0.5
    assert arm == pytest.approx(r * sin(end), abs=1e-12)
    assert (np.abs(motion.vx).max() < 1e-14) == bool(floor)  # a block that sticks moves by rounding


def test_a_free_wedge_has_the_exact_acceleration():
    """m g sin α cos α/(M + m sin²α), by momentum and the constraint of the slope."""
    case, angle = cases.load("disc_on_free_wedge"), atan(0.5)
    motion = reference.simulate(case, rtol=1e-12)
    exact = -G * sin(angle) * cos(angle) / (3.0 + sin(angle) ** 2)
    assert motion(0.4).vx == pytest.approx(0.4 * exact, abs=1e-13)
    assert motion.plate("disc")(0.4).vx * 1.0 + 3.0 * motion(0.4).vx == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("share,sticks", [(1.001, True), (0.999, False)])
def test_a_wedge_under_a_sliding_disc_sticks_up_to_the_exact_coefficient(share, sticks):
    """N = (M + m cos²α) g and T = m g sin α cos α. Two corners share T: each within its own bound."""
    wedge, angle = Plate.polygon([(0, 0), (2, 0), (0, 1)], 3.0), atan(0.5)
    normal, friction = (3.0 + cos(angle) ** 2) * G, G * sin(angle) * cos(angle)
    at = StartPose(0.5 + 0.1 * sin(angle), 0.75 + 0.1 * cos(angle))
    mu = share * friction / normal
    motion = reference.simulate(
        scene(wedge, StartPose(2 / 3, 1 / 3), disc(0.1, 1.0), at, floor=mu, time=0.1), rtol=1e-12
    )
    assert motion.status == "completed" and (np.abs(motion.vx).max() < 1e-14) == sticks
    columns = [motion.contacts[name] for name in ("plate/floor", "plate/floor 3")]
    if not sticks:
        assert {t.after for t in motion.transitions} == set() and columns[0].slip[-1] != 0.0
        return
    forces = [one.normal_force[0] for one in columns]
    assert sum(forces) == pytest.approx(normal, rel=1e-12)
    for one, own, other in zip(columns, forces, forces[::-1], strict=True):
        low, high = max(-mu * own, friction - mu * other), min(mu * own, friction + mu * other)
        assert one.friction_range[:, 0] == pytest.approx([low, high], abs=1e-12 * normal)
        assert np.isnan(one.friction_force[0])


def test_the_region_of_a_point_is_that_of_its_nearest_point():
    """Against the nearest of 4,000 points of the outline, at random points outside a triangle."""
    polygon, numbers = Plate.polygon([(0, 0), (1, 0), (0.2, 0.7)], 1.0), np.random.default_rng(3)
    outline, around = polygon.outline, regions(polygon)
    s = np.linspace(*outline.span, 4001)
    points = outline.point(s)
    for x, y in numbers.uniform(-2.0, 2.0, (200, 2)).tolist():
        distances = np.hypot(points[0] - x, points[1] - y)
        one = around[int(region_of(around, x, y))]
        far = np.hypot(x - one.x, y - one.y) if one.corner else (x - one.x) * one.ty - (y - one.y) * one.tx
        if distances.min() > 0.8:  # outside: inside, all distances are below the inscribed circle's
            assert far == pytest.approx(distances.min(), abs=1e-5)  # samples are 1e-3 m apart: (1e-3)²/(8·0.8)


# --- the paper's matrix at instants -----------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", [pytest.param(Mode.SLIDE, marks=pytest.mark.slow), Mode.ROLL])
@pytest.mark.parametrize("where", ["edge", "corner"])
def test_the_papers_matrix_has_the_same_accelerations(where, mode):
    """A block on one corner and a disc on it, both turning; rates of parameters by central differences of 1e-5 s."""
    mu = 0.6 if mode is Mode.ROLL else 0.0
    case = replace(_touching(where), effects=(*_touching(where).effects[:4], *((CoulombFriction(mu),) if mu else ())))
    poses = start_poses(case)
    pairs, plates = [], plates_of(case)
    state = np.concatenate([poses[:, :3].ravel(), poses[:, 3:].ravel()])
    now = [place(pair, state, points) for pair, points in touching_contacts(case, state)]
    assert [at.pair.whole.base is None for at in now] == [True, False]
    velocity = _without_lift(now, numbers_of(case).inverse, state, mode is Mode.ROLL)
    moving = np.concatenate([state[:6], velocity])
    now = [place(at.pair, moving, (at.xi1, at.xi2)) for at in now]
    motions = [(0.0, *state[3 * b : 3 * b + 3], *velocity[3 * b : 3 * b + 3]) for b in range(2)]
    for at in now:
        pair, points, own, base = at.pair, (at.xi1, at.xi2), *plates_at(at.pair)
        if isinstance(pair.track, Corner):  # the matrix has no corner of a track: the corner on the disc's boundary
            corner = next(one for one in plates[0].outline.corners if (one.x, one.y) == (pair.track.x, pair.track.y))
            pair = SimpleNamespace(track=hill(0.1), plate=SimpleNamespace(outline=corner), effect=pair.effect)
            points, own, base = None, base, own

        def when(step, pair=pair, points=points, own=own, base=base):
            x, y, theta, u, v, turn = state[:6] + step * velocity
            if base is None:
                return find(pair.track, pair.plate.outline, x, y, theta, points)
            (x, y, theta), (u, v, turn) = ((x, y, theta), (u, v, turn))[:: 1 - 2 * own]
            c, s, dx, dy = cos(turn), sin(turn), x - u, y - v
            relative = c * dx + s * dy, c * dy - s * dx, theta - turn
            near = points or nearest_samples(pair.track, pair.plate.outline, *relative)[0]
            return find(pair.track, pair.plate.outline, *relative, near)

        early, here, late = when(-1e-5), when(0.0), when(1e-5)
        rates = [(late.xi1 - early.xi1) / 2e-5, (late.xi2 - early.xi2) / 2e-5]
        pairs.append(BodyContact(pair, mode, (here.xi1, here.xi2, *rates), own, base))
    bodies = [replace(case, plate=plate, start=cases.Start(0.0, 0.0), others=(), supports=()) for plate in plates]
    answer = solve_bodies(bodies, pairs, motions)
    rows, biases = [], []
    for at in now:
        rows.append(at.lift_row)
        biases.append(at.lift_bias)
        if mode is Mode.ROLL:
            rows.append(at.slip_row)
            biases.append(at.slip_bias)
    matrix, inverse, load = np.array(rows), numbers_of(case).inverse, load_at(case, 0.0, moving)
    force = np.linalg.solve(matrix * inverse @ matrix.T, -(matrix @ load + biases))
    exact = load + inverse * (matrix.T @ force)
    # Differences of 1e-5 s: 1e-10 of the rates, times speeds of some m/s and 10/m.
    assert answer.q1_ddot.ravel() == pytest.approx(exact, abs=1e-6)


def _touching(where: str) -> Case:
    """A block on one corner, and a disc that touches an edge or a corner of it."""
    block, theta, r = Plate.rectangle(1.0, 0.4, 2.0), 0.3, 0.1
    turn = np.array([[cos(theta), -sin(theta)], [sin(theta), cos(theta)]])
    height = 5.0 - float((turn @ (-0.5, -0.2))[1])
    touches = turn @ ((0.1, 0.2 + r) if where == "edge" else (0.5 + r * sin(0.7), 0.2 + r * cos(0.7)))
    at = StartPose(float(touches[0]), height - 5.0 + float(touches[1]), 0.4, 0.3, -0.2, 2.0)
    return scene(block, StartPose(0.0, height - 5.0, theta, 0.5, 0.1, 0.7), disc(r, 1.0), at)


def _without_lift(now, inverse, state, sticks) -> np.ndarray:
    rows = np.array([at.lift_row for at in now] + [at.slip_row for at in now if sticks])
    off = np.linalg.solve(rows * inverse @ rows.T, rows @ state[6:])
    return state[6:] - inverse * (rows.T @ off)


# --- both formulations ------------------------------------------------------------------------------------------------


def test_a_motion_that_ends_where_it_begins_has_all_plates():
    """A block that slides at mu = 1,000 has no consistent forces; the motion had the first plate alone, and a report
    whose truth has such a null motion ended with an error."""
    ball, at = disc(0.1, 1.0), StartPose(1.0, 0.1)
    case = scene(Plate.rectangle(0.2, 0.2, 1.0), StartPose(0.0, 0.1, vx=-0.3), ball, at, floor=1e3)
    motion = reference.simulate(case)
    assert motion.status == "paradox" and motion.t.tolist() == [0.0]
    assert motion.plate_names == ("plate", "disc") and motion.plate("disc").x.tolist() == [1.0]


# --- invalid cases ----------------------------------------------------------------------------------------------------


def test_engines_refuse_shapes_whose_contacts_have_no_closed_form():
    good = over_the_edge(2.0, 0.4, 0.0)
    second = FreePlate(Plate.rectangle(0.2, 0.2, 1.0), StartPose(3.0, 5.1), "second")
    polygons = replace(good, others=(*good.others, second))
    assert "'plate' and 'second' are polygons" in refusal(pymunk, polygons, "native")
    for plate in (Plate.half_disc(0.2, 1.0), Plate.polygon([(0, 0), (1, 0), (0.3, 0.3), (0, 1)], 1.0)):
        other = replace(good, others=(replace(good.others[0], plate=plate, start=StartPose(3.0, 7.0)),))
        assert "'disc' is no disc and no convex polygon" in refusal(pymunk, other, "native")
    # As any adapter that does not list its routes in FREE_POLYGONS.
    engine = SimpleNamespace(NAME="discs", SEVERAL_PLATES=("native",), SUPPORTS=("native",), refuses=lambda *_: None)
    sentence = "The native route does not support several plates unless all of them are discs."
    assert refusal(engine, good, "native") == sentence
    assert refusal(pymunk, good, "native") is None
