"""Motions over corners: closed forms and quadratures, the two formulations compared, and where motions end."""

from math import cos, exp, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import reference
from cases import (
    Case,
    Chain,
    CoulombFriction,
    Gravity,
    Mode,
    PerfectlyRough,
    Plate,
    Start,
    Unilateral,
    disc,
    library,
)
from tests.scenes.agreement import unlike_second

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
@pytest.mark.parametrize("method", reference.METHODS)
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
    motion = reference.simulate(case, rtol=1e-13)
    assert unlike_second(case, motion) == ""
    assert motion.status == status
    if status == "second_contact":
        assert motion.t[-1] == pytest.approx((0.5 - R) / (2.0 * R), rel=EXACT)
