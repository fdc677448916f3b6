"""Flights, landings, impacts and belts where track or plate has corners: closed forms, and both formulations."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

import reference
from cases import (
    Belt,
    Case,
    Chain,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Mode,
    PerfectlyRough,
    Plate,
    Start,
    Unilateral,
    disc,
    library,
)
from cases.contact import pose
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.taylor.test_corners import over_an_edge

G, R, DEPTH = 9.81, 0.1, 1.0
# Both integrators' step errors at 1e-14 are below a few roundings of the times; quadratures are exact to 1e-14.
EXACT = 1e-12
# A table with a floor DEPTH below it.
TABLE = Chain.polyline([(-1, 0), (0, 0), (0, -DEPTH), (3, -DEPTH)])


def on(track, plate, *effects, duration=1.5, **start):
    return Case(track, plate, (Gravity(G), *effects, Unilateral(), Flight()), Start(**start), duration)


@quick_every(6)
@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_fast_disc_leaves_the_table_and_bounces_on_the_floor(e, method):
    """It falls for √(2h/g); then rebounds take 2 eᵏ of that each, and it rolls on as fast as before."""
    v, fall = 1.5, sqrt(2 * DEPTH / G)
    case = on(TABLE, disc(R, 1.0), CoulombFriction(0.5), Impact(e), xi1=0.5, omega=-v / R)
    motion = reference.simulate(case, rtol=1e-14, method=method)
    landings = [0.5 / v + fall * (1 + 2 * sum(e**k for k in range(1, i + 1))) for i in range(4 if e else 1)]
    landings = [t for t in landings if t < 1.5]
    assert [t.after for t in motion.transitions] == [
        Mode.FLIGHT,
        *(Mode.FLIGHT if e else Mode.ROLL for _ in landings),
    ]
    assert motion.transitions[0].time == pytest.approx(0.5 / v, rel=EXACT)
    for transition, time in zip(motion.transitions[1:], landings, strict=True):
        assert transition.time == pytest.approx(time, rel=EXACT)
        # The floor begins after the table, a right angle to the right, the side, and one to the left.
        assert transition.xi1 == pytest.approx(1 + pi / 2 + DEPTH + pi / 2 + v * (time - 0.5 / v), rel=EXACT)
    assert motion(1.5).vx == pytest.approx(v, rel=EXACT) and motion(1.5).omega == pytest.approx(-v / R, rel=EXACT)


@quick_every(2)
@pytest.mark.parametrize(("v", "mu"), [(0.2, 0.5), (0.4, 0.2)])
def test_slow_disc_turns_about_the_edge_and_lands_after_its_throw(v, mu):
    """It leaves the edge at the angle φ with speed √(g r cos φ), and falls by h + r cos φ − r on a parabola."""
    (_, angle), (_, leaves) = over_an_edge(v, mu)
    speed, drop = sqrt(G * R * cos(angle)), DEPTH + R * cos(angle) - R
    down = speed * sin(angle)
    fall = (sqrt(down**2 + 2 * G * drop) - down) / G
    case = on(TABLE, disc(R, 1.0), CoulombFriction(mu), Impact(0.0), xi1=0.9, omega=-v / R, duration=2.0)
    motion = reference.simulate(case, rtol=1e-14)
    thrown, landed = (t for t in motion.transitions if Mode.FLIGHT in (t.before, t.after))
    assert thrown.time == pytest.approx(0.1 / v + leaves, rel=EXACT)
    assert landed.time == pytest.approx(0.1 / v + leaves + fall, rel=EXACT)
    x = R * sin(angle) + speed * cos(angle) * fall
    assert landed.xi1 == pytest.approx(1 + pi + DEPTH + x, rel=EXACT)


@pytest.mark.parametrize("law", ["newton", "poisson", "moreau"])
def test_plate_lands_on_its_corner_and_starts_to_turn(law):
    """Without friction P = (1 + e) v/(1/m + a²/J) and ω = a P/J, the corner a horizontal distance a from the centre."""
    plate, e, tilt, height = Plate.rectangle(0.3, 0.1, 2.0), 0.4, 0.5, 0.2
    case = on(
        library.line(),
        plate,
        Impact(e, law=law),
        xi1=0.0,
        xi2=0.3 + tilt,
        gap=height,
        duration=sqrt(2 * height / G) + 1e-3,
    )
    motion = reference.simulate(case, rtol=1e-14)
    theta = -tilt
    a = 0.15 * cos(theta) + 0.05 * sin(theta)
    v = sqrt(2 * G * height)
    impulse = (1 + e) * v / (1 / plate.mass + a * a / plate.inertia)
    (impact,) = motion.transitions
    assert impact.time == pytest.approx(v / G, rel=EXACT) and impact.xi2 == pytest.approx(0.3 + tilt, rel=EXACT)
    after = motion(motion.t[-1])
    assert after.omega == pytest.approx(a * impulse / plate.inertia, rel=EXACT)
    assert after.vy == pytest.approx(-v + impulse / plate.mass - G * 1e-3, rel=10 * EXACT)


def test_disc_lands_on_the_edge_of_a_table():
    """Its centre at x = d > 0 is √(r² − d²) above the edge then; the smooth edge pushes along (d, √(r² − d²))/r."""
    d, e, height = 0.06, 0.5, 0.3
    nx, ny = d / R, sqrt(1 - (d / R) ** 2)
    # The start is next to the table's edge, seen from its direction there; the disc moves straight down.
    angle = np.arctan2(nx, ny)
    case = on(TABLE, disc(R, 1.0), Impact(e), xi1=1.0 + angle, gap=0.0, gap_rate=0.0, duration=1.0)
    x, y, _ = pose(case, 1.0 + angle, case.start.motion(case.track, case.plate.outline).xi2)
    assert (float(x), float(y)) == pytest.approx((R * nx, R * ny))
    # Thrown up along the normal and sideways so that it moves straight up, it comes down on the same place.
    up = sqrt(2 * G * height)
    thrown = on(TABLE, disc(R, 1.0), Impact(e), xi1=1.0 + angle, gap_rate=up * ny, slip=-up * nx, duration=1.0)
    motion = reference.simulate(thrown, rtol=1e-14)
    start = motion(0.0)
    assert (start.vx, start.vy) == pytest.approx((0.0, up), abs=1e-14)
    impact = motion.transitions[0]
    assert impact.time == pytest.approx(2 * up / G, rel=EXACT) and impact.xi1 == pytest.approx(1.0 + angle, abs=1e-11)
    after = motion(impact.time + 1e-3)
    push = (1 + e) * up * ny
    assert after.vx == pytest.approx(push * nx, rel=1e-11)
    assert after.vy == pytest.approx(-up + push * ny - G * 1e-3, rel=1e-11)


def test_block_on_its_corner_is_carried_by_a_belt():
    """It falls about its corner, which rolls with the belt: seen from the belt as on a rough table."""
    plate, u = Plate.rectangle(0.3, 0.1, 2.0), 0.8
    carried, still = (
        reference.simulate(
            Case(library.line(), plate, (Gravity(G), PerfectlyRough(), Unilateral(), *more), Start(0.0, 1.2), 0.2),
            1e-14,
        )
        for more in ((Belt(u),), ())
    )
    t = np.linspace(0.0, 0.2, 50)
    one, other = carried(t), still(t)
    np.testing.assert_allclose(one.x, other.x + u * t, atol=EXACT)
    np.testing.assert_allclose([one.y, one.theta, one.omega], [other.y, other.theta, other.omega], atol=EXACT)


@pytest.mark.parametrize(
    ("case", "status", "words"),
    [
        (on(TABLE, disc(R, 1.0), CoulombFriction(0.5), xi1=0.5, omega=-15.0), "landing", "names no Impact"),
        (on(Chain.polyline([(-1, -1), (0, 0), (1, -1)]), Plate.polygon([(-0.1, 0.1), (0, -0.1), (0.1, 0.1)], 1.0),
            Impact(0.3), xi1=sqrt(2) + pi / 4, xi2=sqrt(0.05) + 0.5 * (pi - 2 * np.arctan2(0.1, 0.2)), gap=0.2),
         "landing", "meets a corner"),
    ],
)  # fmt: skip
def test_landings_that_have_no_impact_end_the_motion_with_a_sentence(case, status, words):
    motion, second = reference.simulate(case), second_states.motion(case)
    assert motion.status == status == second.status and words in motion.reason
    assert motion.t[-1] == pytest.approx(second.end, abs=1e-9)
