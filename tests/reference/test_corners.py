"""Motions over corners: closed forms and quadratures, the two formulations compared, and where motions end."""

import pickle
from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import reference
from cases import (
    Case,
    Chain,
    CoulombFriction,
    Curve,
    Gravity,
    Load,
    Mode,
    NotSupported,
    Outline,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    arc,
    disc,
    library,
    load,
)
from reference.sweeping import sweep
from tests.scenes import second as second_states

pytestmark = pytest.mark.taylor

G, R = 9.81, 0.1
# Both integrators' step errors at 1e-14 are below a few roundings of the times; quadratures are exact to 1e-14.
EXACT = 1e-12
TABLE = Chain.polyline([(-1, 0), (0, 0), (0, -1)])


def on(track, plate, *effects, duration=4.0, **start):
    return Case(track, plate, (Gravity(G), *effects, Unilateral()), Start(**start), duration)


def integral(function, low, high, parts=8):
    """By Gauss's rule with 60 points on each of some parts: exact to rounding for these smooth functions."""
    places, weights = np.polynomial.legendre.leggauss(60)
    half, edges = 0.5 * (high - low) / parts, np.linspace(low, high, parts + 1)
    return half * sum(
        weight * function(a + half * (1 + x)) for a in edges[:-1] for x, weight in zip(places, weights, strict=True)
    )


def over_an_edge(v, mu):
    """A disc that rolls off a table with speed v: times and angles at which it slips and leaves.

    Pivoting about the edge at the angle φ from the vertical, rolling: r φ̇² = v²/r + (4/3) g (1 − cos φ), friction
    m g sin φ/3, N = m (g cos φ − r φ̇²). It slips where friction is μ N; then u = φ̇² obeys the linear equation
    du/dφ = 2 μ u + 2 (g/r)(sin φ − μ cos φ), and it leaves where g cos φ = r u.
    """
    w0 = v / R

    def rolling(phi):
        return w0**2 + 4 / 3 * G / R * (1 - cos(phi))

    slips = brentq(lambda p: G * sin(p) / 3 - mu * (G * cos(p) - R * rolling(p)), 0.0, 1.2, xtol=1e-16)
    k = 1 + 4 * mu * mu
    a, b = (4 * mu * mu - 2) * G / R / k, (2 * mu * (4 * mu * mu - 2) / k - 2 * mu) * G / R
    c = (rolling(slips) - a * cos(slips) - b * sin(slips)) * exp(-2 * mu * slips)

    def sliding(phi):
        return a * cos(phi) + b * sin(phi) + c * exp(2 * mu * phi)

    leaves = brentq(lambda p: G * cos(p) - R * sliding(p), slips, 1.5, xtol=1e-16)
    way = [integral(lambda p, u=u: 1 / sqrt(u(p)), low, high)
           for u, low, high in ((rolling, 0.0, slips), (sliding, slips, leaves))]  # fmt: skip
    return (slips, leaves), (way[0], way[0] + way[1])


@pytest.mark.parametrize(("v", "mu"), [(0.2, 0.5), (0.4, 0.2), (0.05, 1.5)])
@pytest.mark.parametrize("method", reference.solve.METHODS)
def test_disc_rolls_off_a_table_slips_on_its_edge_and_leaves(v, mu, method):
    case = on(TABLE, disc(R, 1.0), CoulombFriction(mu), xi1=0.5, omega=-v / R, duration=20.0)
    motion = reference.simulate(case, rtol=1e-14, method=method)
    angles, times = over_an_edge(v, mu)
    assert motion.status == "lift_off"
    assert [t.after for t in motion.transitions] == [Mode.SLIP_FORWARD, Mode.FLIGHT]
    for transition, angle, time in zip(motion.transitions, angles, times, strict=True):
        assert transition.time == pytest.approx(0.5 / v + time, rel=EXACT)
        assert transition.xi1 == pytest.approx(1.0 + angle, rel=10 * EXACT)  # the corner's parameter is the angle
    (edge,) = [passage for passage in motion.passages if passage.time < times[0] + 0.5 / v]
    assert (edge.curve, edge.before, edge.after) == ("track", "piece 0", "corner 1")
    assert edge.time == pytest.approx(0.5 / v, rel=EXACT) and edge.xi1 == pytest.approx(1.0, abs=EXACT)


def test_fast_disc_leaves_at_the_edge_itself():
    """Above v² = g r the normal force g − v²/r at the edge is negative."""
    fast, slow = (sqrt(G * R) * factor for factor in (1.001, 0.999))
    motion = reference.simulate(on(TABLE, disc(R, 1.0), CoulombFriction(0.5), xi1=0.5, omega=-fast / R), rtol=1e-14)
    (leap,) = motion.transitions
    assert (
        leap.after is Mode.FLIGHT and leap.time == pytest.approx(0.5 / fast, rel=EXACT) and motion.status == "lift_off"
    )
    later = reference.simulate(on(TABLE, disc(R, 1.0), CoulombFriction(0.5), xi1=0.5, omega=-slow / R), rtol=1e-14)
    assert later.transitions[-1].xi1 > 1.0 + 1e-4


def test_rough_disc_leaves_the_edge_where_the_classical_sphere_leaves_its_top():
    """cos φ = (4 + 3 v²/(g r))/7 for a disc that never slips: at 4/7 from rest."""
    v = 0.1
    motion = reference.simulate(on(TABLE, disc(R, 1.0), PerfectlyRough(), xi1=0.9, omega=-v / R), rtol=1e-14)
    assert cos(motion.transitions[0].xi1 - 1.0) == pytest.approx((4 + 3 * v * v / (G * R)) / 7, rel=EXACT)


def test_disc_goes_over_the_edge_of_a_step():
    """A step with its top on the right: the disc on the step's edge turns up about it, then rolls along the top.

    The polygon of the step climbs a ramp: its convex edge lies between a steep and a flat side. About the edge
    (3/2) r² ω²/2 + g r cos φ is constant.
    """
    steep = 1.2
    step = Chain.polyline([(-cos(steep), -sin(steep)), (0, 0), (2, 0)])
    omega, first = -7.0, 0.3  # passes the edge from the angle 0.3 before the vertical
    start = 1.0 + steep - first
    case = on(step, disc(R, 1.0), CoulombFriction(0.9), xi1=start, omega=omega, duration=1.0)
    motion = reference.simulate(case, rtol=1e-14)

    def squared(phi):
        return omega**2 + 4 / 3 * G / R * (cos(first) - cos(phi))

    time = integral(lambda p: 1 / sqrt(squared(p)), 0.0, first)
    assert [(p.before, p.after) for p in motion.passages] == [("corner 1", "piece 2")]
    assert motion.passages[0].time == pytest.approx(time, rel=EXACT)
    assert not motion.transitions and motion.status == "completed"
    state = motion(1.0)
    assert state.vx == pytest.approx(R * sqrt(squared(0.0)), rel=EXACT)
    assert state.x == pytest.approx(R * sqrt(squared(0.0)) * (1.0 - time), rel=EXACT)


def falling(plate, height, lever, slides):
    """The time in which a plate on its corner falls from the angle 0.3 to the angle at which its edge lies flat.

    Its centre is at the distance `height` above the corner, whose inertia is J, or J + m h² if the corner is fixed:
    (J/m + h² (1 or sin² φ)) φ̇²/2 = g h (cos φ₀ − cos φ).
    """
    J = plate.inertia / plate.mass

    def rate(phi):
        moving = J + height**2 * (sin(phi) ** 2 if slides else 1.0)
        return sqrt(4 * G * height * sin(0.5 * (phi + 0.3)) * sin(0.5 * (phi - 0.3)) / moving)

    # From rest 1/φ̇ has an integrable singularity: φ = φ₀ + s².
    return integral(lambda s: 2 * s / rate(0.3 + s * s), 0.0, sqrt(lever - 0.3))


@pytest.mark.parametrize("slides", [True, False])
def test_plate_falls_about_its_corner(slides):
    """On a smooth table the centre falls vertically, on a rough one the corner is fixed."""
    plate = Plate.rectangle(0.3, 0.1, 2.0)
    height, lever = sqrt(0.15**2 + 0.05**2), np.arctan2(0.15, 0.05)
    # The lower right corner's parameter begins where the bottom lies flat; there the centre is `lever` to the left.
    case = on(library.line(), plate, *([] if slides else [PerfectlyRough()]), xi1=0.0, xi2=0.3 + lever - 0.3)
    motion = reference.simulate(case, rtol=1e-14)
    assert motion.status == "second_contact" and "names no Impact; add Flight() and Impact(0.0)" in motion.reason
    assert motion.t[-1] == pytest.approx(falling(plate, height, lever, slides), rel=EXACT)
    assert motion(motion.t[-1]).theta == pytest.approx(0.0, abs=EXACT)
    assert abs(motion(motion.t[-1]).vx) <= EXACT if slides else motion(motion.t[-1]).slip == 0.0


def test_energy_is_conserved_over_corners_without_slip():
    """A Reuleaux wheel rolls down a rough slope over its corners."""
    case = on(library.line(0.2), Plate.reuleaux(0.2, 1.0), PerfectlyRough(), xi1=0.0, omega=-4.0, duration=0.7)
    motion = reference.simulate(case, rtol=1e-14)
    assert motion.status == "completed" and len(motion.passages) == 3
    s = motion(np.linspace(0, 0.7, 400))
    energy = 0.5 * (s.vx**2 + s.vy**2) + 0.5 * case.plate.inertia * s.omega**2 + G * s.y
    # The energy is no variable of the integration: DOP853's error in it is some times that of the pose.
    assert np.ptp(energy) <= {"taylor": 1, "dop853": 5}[reference.METHODS[0]] * EXACT * np.abs(energy).max()


@pytest.mark.slow
def test_piece_boundaries_of_a_smooth_curve_change_nothing():
    """A circle cut into arcs that join without corners: the motion of the paper's disc is the same."""
    whole = on(library.circle(1.0), disc(R, 1.0), CoulombFriction(0.2), xi1=-pi, duration=2.0)
    parts = Outline([arc((0.0, 0.0), 1.0, low, low + 2 * pi / 3) for low in (-pi, -pi / 3, pi / 3)])
    one, other = (reference.simulate(case, rtol=1e-14) for case in (whole, on(
        parts, disc(R, 1.0), CoulombFriction(0.2), xi1=-pi, duration=2.0)))  # fmt: skip
    assert [t.after for t in one.transitions] == [t.after for t in other.transitions]
    for a, b in zip(one.transitions, other.transitions, strict=True):
        assert a.time == pytest.approx(b.time, rel=EXACT) and a.xi1 == pytest.approx(b.xi1, abs=10 * EXACT)
    assert other.passages and not one.passages


def compare(case, tolerance=1e-10):
    """The motion by both formulations: the same transitions and end. The second's default tolerance is 1e-10."""
    motion = reference.simulate(case, rtol=1e-13)
    second = second_states.motion(case, rtol=1e-12)
    assert motion.status == second.status, (motion.status, second.status)
    assert [(t.before, t.after) for t in motion.transitions] == [(t.before, t.after) for t in second.transitions]
    for a, b in zip(motion.transitions, second.transitions, strict=True):
        assert a.time == pytest.approx(b.time, abs=tolerance) and a.xi1 == pytest.approx(b.xi1, abs=10 * tolerance)
        assert a.xi2 == pytest.approx(b.xi2, abs=10 * tolerance)
    assert motion.t[-1] == pytest.approx(second.end, abs=tolerance)
    return motion


def random_polygon(seed):
    """A convex polygon of 3 to 7 corners on a hill, a slope, or a wide valley, released or pushed at random."""
    chance = np.random.default_rng(seed)
    n = int(chance.integers(3, 8))
    angles = 2 * pi * (np.arange(n) + chance.uniform(-0.3, 0.3, n)) / n
    plate = Plate.polygon((0.15 * np.array([np.cos(angles), np.sin(angles)])).T.tolist(), 1.0)
    track = [library.hill(1.0), library.line(0.2), library.circle(3.0), library.ellipse(3.0, 2.0)][seed % 4]
    s = {0: 0.1, 1: 0.0, 2: -pi / 2, 3: -pi / 2}[seed % 4]
    corner = [e for e in plate.outline.elements if e.number % 2][int(chance.integers(n))]
    xi2 = corner.start + chance.uniform(0.3, 0.7) * corner.piece.domain[1]
    friction = [CoulombFriction(chance.uniform(0.05, 0.8)), PerfectlyRough()][int(chance.integers(5)) == 0]
    slip = 0.0 if isinstance(friction, PerfectlyRough) else chance.choice([0.0, 0.3, -0.3])
    omega = chance.uniform(-2, 2)
    return on(track, plate, friction, xi1=s, xi2=xi2, slip=slip, omega=omega, duration=0.5)


# In the last two a second corner enters a bowl by less than samples of its sides show, or next to another edge.
@pytest.mark.sampled(6, first=1)
@pytest.mark.parametrize("seed", [*range(5), 574, 663])
def test_both_formulations_agree_on_random_polygons(seed):
    compare(random_polygon(seed))


@pytest.mark.slow
def test_both_formulations_agree_on_a_thousand_random_polygons():
    failures = {}
    for seed in range(1000):
        try:
            compare(random_polygon(seed))
        except (AssertionError, FloatingPointError) as problem:
            failures[seed] = str(problem).splitlines()[0]
    assert not failures


@pytest.mark.sampled(3, first=2)
@pytest.mark.parametrize(
    "effects",
    [
        (CoulombFriction(0.4), RollingResistance(0.005)),
        (CoulombFriction(0.4), Load(moment="0.3*sin(5*t) - 0.1*theta")),
        (CoulombFriction(0.3, 0.5),),
    ],
)
def test_other_effects_work_on_corners(effects):
    plate = Plate.reuleaux(0.2, 1.0)
    motion = compare(on(library.hill(1.5), plate, *effects, xi1=0.05, omega=-1.0, duration=1.0))
    assert motion.t[-1] > 0.1


@pytest.mark.slow
def test_chain_may_have_measured_pieces():
    """A ramp through points ends in an edge: within a piece the contact passes its knots, then the corner."""
    x = np.linspace(-1, 0, 41)
    ramp = Curve.spline(np.column_stack([x, 0.1 * x**2]))
    motion = compare(on(Chain([ramp, Curve(("s", "-s"), (0, 1))]), disc(R, 1.0), CoulombFriction(0.4), xi1=0.3))
    assert motion.status == "lift_off" and [p.after for p in motion.passages] == ["corner 1"]


@pytest.mark.parametrize(
    ("case", "status"),
    [
        # A disc on the floor meets a wall: at a distance of its radius.
        (on(Chain.polyline([(-1, 0), (0, 0), (0, 1)]), disc(R, 1.0), CoulombFriction(0.5), xi1=0.5, omega=-2.0),
         "second_contact"),
        (on(Chain.polyline([(-1, 0), (0, 0)]), disc(R, 1.0), CoulombFriction(0.5), xi1=0.5, omega=-2.0), "track_end"),
        # A corner of the plate slides off the table's corner.
        (on(TABLE, Plate.rectangle(0.4, 0.04, 1.0), xi1=0.95, xi2=0.4 + 0.8, slip=1.0), "lift_off"),
    ],
)  # fmt: skip
def test_motions_end_where_one_contact_does(case, status):
    motion = compare(case)
    assert motion.status == status
    if status == "second_contact":
        assert motion.t[-1] == pytest.approx((0.5 - R) / (2.0 * R), rel=EXACT)


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        on(TABLE, disc(R, 1.0), CoulombFriction(0.5), xi1=0.5, omega=-2.0),
        on(library.hill(1.0), Plate.rectangle(0.3, 0.1, 1.0), CoulombFriction(0.5), xi1=0.1, duration=2.0),
        on(library.line(0.2), Plate.reuleaux(0.3, 1.0), CoulombFriction(0.4), xi1=0.1, duration=2.0),
    ],
)
def test_motions_over_corners_are_certified(case):
    certificate = reference.certify(case)
    assert len(certificate.witnesses) == 5 and not certificate.missing
    assert all(time.bar <= EXACT for _, _, time, _ in certificate.transitions) and certificate.transitions


def test_motion_over_corners_travels_to_other_processes():
    case = on(TABLE, disc(R, 1.0), CoulombFriction(0.5), xi1=0.5, omega=-2.0)
    motion = reference.simulate(case)
    copy = pickle.loads(pickle.dumps(motion))
    assert copy.passages == motion.passages and copy.case == case
    np.testing.assert_array_equal(copy(copy.t).x, motion(motion.t).x)


def test_sweep_over_corners_has_the_single_motions():
    rows = sweep("disc_over_edge", mu=[0.2, 0.5])
    for row in rows.to_dict("records"):
        motion = reference.simulate(load("disc_over_edge", mu=row["mu"]))
        assert row["outcome"] == motion.status == "lift_off"
        assert row["first_time"] == pytest.approx(motion.transitions[0].time, rel=EXACT)


def test_what_corners_do_not_have_is_rejected():
    case = on(TABLE, disc(R, 1.0), CoulombFriction(0.5), xi1=0.5)
    with pytest.raises(NotSupported, match="does not integrate over corners"):
        reference.simulate(case, method="augmented")
