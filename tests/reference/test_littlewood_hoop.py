"""Littlewood's hoop: a light hoop with a weight on its rim, rolling on a line. When does it hop?

What is said of it, in the sources' own terms:

- Littlewood, A Mathematician's Miscellany (1953), and Tokieda (by geometry), as Theron & Maritz tell of them: the hoop
  has no mass; it hops when the radius to the weight is level.
- Pritchett, "The hopping hoop revisited", Am. Math. Monthly, August-September 1999 (abstract looked up): such a hoop
  slips before it can hop. Butler is said to have it, too (not looked up).
- Theron & Maritz, "The amazing variety of motions of a loaded hoop", Math. Comput. Modelling 47 (2008) 1077–1088
  (beginning looked up): a hoop with mass rolls and slips in turns, and whether it hops depends on its eccentricity,
  friction and first spin.
"""

from math import acos, cos, pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import reference
from cases import Case, CoulombFriction, Curve, Flight, Gravity, Impact, Mode, PerfectlyRough, Plate, Start, Unilateral
from cases import curves as c
from cases.library import line
from tests.sampling import quick_every
from tests.scenes import second as second_states

G, R = 9.81, 0.5
GRIP = (Gravity(G), Unilateral())


def solve(case: Case, times=()):
    return second_states.solve(case, rtol=1e-13, times=times)


def check_against_the_first_formulation(case: Case, answer) -> None:
    ours = reference.simulate(case, rtol=1e-12)
    assert modes(answer) == modes(ours)
    # Two integrations at 1e-12 and better; the hop's own sensitivity is moderate.
    assert [t.time for t in answer.transitions] == pytest.approx([t.time for t in ours.transitions], abs=1e-10)


def modes(answer) -> list[tuple[Mode, Mode]]:
    return [(t.before, t.after) for t in answer.transitions]


def hoop(share: float, *effects, angle=0.0, speed=0.0, duration=1.5) -> Case:
    """A hoop of radius R with a weight on its rim that has `share` of the mass, `angle` past the top.

    It begins to roll with ω² = (g/R)(speed + what rolling down from the top gives).
    """
    e = R * share
    squared = G / R * (speed + share * (1 - cos(angle)) / (1 + share * cos(angle)))
    outline = Curve(lambda s: (R * c.cos(s) - e, R * c.sin(s)))
    start = Start(0.0, angle - pi, omega=-sqrt(squared))
    return Case(line(), Plate(outline, 1.0, R**2 - e**2), (*GRIP, *effects), start, duration)


def normal_force_of_a_rolling_hoop(share: float, turned: float) -> float:
    """N/(m g) of a hoop that rolls down from rest at the top, its weight at the angle `turned` from the top.

    ω² = (g/r) q (1 − cos φ)/(1 + q cos φ) from its energy (J about the contact is 2 m r² (1 + q cos φ)), and
    N = m (g − q r (φ̈ sin φ + φ̇² cos φ)).
    """
    q, s, k = share, sin(turned), cos(turned)
    return 1 - q * (s * s * q * (1 + q) / (2 * (1 + q * k) ** 2) + k * q * (1 - k) / (1 + q * k))


def weight_at(case: Case, time: float) -> float:
    """Angle of the weight from the top at that time, rad."""
    return pi / 2 - solve(case, [time]).motions[2, 0]


@pytest.mark.parametrize("share", [0.93, 0.95, 0.99, 0.9999])
def test_a_hoop_that_cannot_slip_loses_its_normal_force_near_littlewoods_right_angle(share, accuracy):
    # Littlewood (A Mathematician's Miscellany, 1953): the hoop is weightless and hops when the radius to the weight is
    # level. With a hoop that weighs something N vanishes later, at an angle that goes to 90° with its weight. (It does
    # not hop there: see the next test but one.)
    case = hoop(share, PerfectlyRough(), angle=0.4)
    answer = solve(case)
    assert (modes(answer), answer.status) == ([], "paradox")
    grid = np.linspace(0.4, pi, 2001)
    first = grid[np.argmax([normal_force_of_a_rolling_hoop(share, a) < 0 for a in grid])]
    exact = brentq(lambda a: normal_force_of_a_rolling_hoop(share, a), first - pi / 2000, first, xtol=1e-15)
    assert pi / 2 < exact < pi / 2 + 1.6 * sqrt(1 - share)
    accuracy(
        case=f"rough hoop, share {share:g}", solver="reference", route="contact_frame",
        quantity="angle without normal force / rad", error=weight_at(case, answer.end) - exact, tolerance=1e-11,
    )  # fmt: skip


def test_a_rough_hoop_let_go_at_the_top_keeps_its_contact_unless_the_weight_is_thirteen_fourteenths():
    # The minimum of N over one turn is zero for q = 13/14, at cos φ = −5/13.
    assert normal_force_of_a_rolling_hoop(13 / 14, acos(-5 / 13)) == pytest.approx(0.0, abs=1e-15)
    # Half a thousandth beyond it N is negative for a twentieth of a turn, which no step strides over.
    for share, status in ((13 / 14 - 5e-4, "completed"), (13 / 14 + 5e-4, "paradox")):
        assert solve(hoop(share, PerfectlyRough(), angle=0.4)).status == status


@pytest.mark.parametrize("flight", [(), (Flight(), Impact(0.0))], ids=["ends", "flies"])
def test_a_hoop_that_cannot_slip_can_neither_stay_nor_hop(flight):
    # With (a, b) the arm from the centre of mass to the contact, m γ̈ = (1 + a² m/J) N − (a b m/J) T + …, which is zero
    # while it rolls. Where N vanishes friction T = m dvx/dt still acts; without it m γ̈ = (a b m/J) T.
    case = hoop(0.95, PerfectlyRough(), *flight, angle=0.4)
    answer = solve(case)
    assert answer.status == reference.simulate(case, rtol=1e-12).status == "paradox"
    assert answer.transitions == ()
    seen = solve(case, [answer.end - 1e-6, answer.end])
    friction = np.diff(seen.motions[3])[0] / 1e-6
    a, b = seen.states[0, 1] - seen.motions[0, 1], -seen.motions[1, 1]
    assert a * b * friction / case.plate.inertia < -1.0


def test_coulomb_friction_of_any_strength_slips_where_a_rough_hoop_is_lost():
    # The cone closes where N = |T|/μ, so that the slip begins earlier by a time in proportion to 1/μ, and goes on.
    lost = solve(hoop(0.95, PerfectlyRough(), angle=0.4)).end
    early = []
    for mu in (1e2, 1e3, 1e4):
        answer = solve(hoop(0.95, CoulombFriction(mu), Flight(), Impact(0.0), angle=0.4))
        assert answer.status == "completed"
        assert (answer.transitions[0].before, answer.transitions[0].after) == (Mode.ROLL, Mode.SLIP_FORWARD)
        assert answer.transitions[1].time - answer.transitions[0].time > 0.09
        early.append(mu * (lost - answer.transitions[0].time))
    # N' is the same but for a part of 1/μ.
    assert early[1] == pytest.approx(early[2], rel=1e-2)
    assert early[0] == pytest.approx(early[2], rel=1e-1)


@quick_every(6)
@pytest.mark.parametrize("mu", [0.1, 0.2, 0.5, 1.0, 3.0])
def test_with_finite_friction_a_hoop_let_go_at_the_top_slips_and_does_not_hop(mu):
    # Butler's objection: the friction that rolling takes outgrows its cone before the normal force vanishes.
    for share in (0.8, 0.95, 0.999):
        answer = solve(hoop(share, CoulombFriction(mu), Flight(), Impact(0.0), angle=0.4))
        assert answer.status == "completed"
        assert all(t.after is not Mode.FLIGHT for t in answer.transitions)
        if share > 13 / 14:
            assert any(t.before is Mode.ROLL and t.after is not Mode.ROLL for t in answer.transitions)


@pytest.mark.slow
def test_a_pushed_hoop_rolls_slips_hops_and_lands(accuracy):
    # With a spin of √(g/R) at the top: it hops when the weight comes up the other side, after slipping both ways.
    share = 0.9
    case = hoop(share, CoulombFriction(0.3), Flight(), Impact(0.0), speed=1.0)
    answer = solve(case)
    assert [t.after for t in answer.transitions] == [
        Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD, Mode.FLIGHT, Mode.SLIP_FORWARD,
    ]  # fmt: skip
    check_against_the_first_formulation(case, answer)
    hop, landing = answer.transitions[2:]
    x, y, theta, vx, vy, omega, _ = solve(case, [hop.time]).motions[:, 0]
    common = dict(case="pushed hoop", solver="reference", route="contact_frame", tolerance=1e-10)
    # Where N has vanished the spin no longer changes and the centre of the hoop runs straight: g = e ω² cos φ.
    from_top = pi / 2 - theta
    assert 290 < np.degrees(from_top) < 300
    accuracy(**common, quantity="g - e w^2 cos(phi) / m/s²", error=G - share * R * omega**2 * cos(from_top))

    # The hoop's centre is e below the weight's side of the centre of mass, and lands at the height R.
    def height(t):
        return y + vy * t - G * t**2 / 2 - share * R * sin(theta + omega * t) - R

    grid = np.linspace(1e-2, 1.0, 1001)
    after = grid[np.argmax([height(t) < 0 for t in grid])]
    exact = brentq(height, after - 1e-3, after, xtol=1e-15)
    accuracy(**common, quantity="duration of the hop / s", error=landing.time - hop.time - exact)


def test_a_start_with_a_spin_beyond_what_gravity_holds_hops_at_once():
    # At the top N = m (g − e ω²): let go with e ω² > g the hoop is off the ground from the first instant.
    for squared, first in ((0.99, Mode.ROLL), (1.01, Mode.FLIGHT)):
        case = hoop(0.5, CoulombFriction(0.5), Flight(), Impact(0.0), speed=squared / 0.5, duration=0.2)
        slip = solve(case, [1e-4]).motions[6, 0]
        assert np.isnan(slip) == (first is Mode.FLIGHT)
