"""A plate with several contacts: exact motions, and agreement of two formulations that share no code."""

from math import cos, radians, sin, sqrt, tan

import numpy as np
import pytest

import cases
import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    Start,
    StartPose,
    Support,
    Unilateral,
    disc,
)  # fmt: skip
from cases import curves as c
from cases.library import line
from cases.motion.mechanics import energy
from reference.certification.witnesses import _by_second
from tests.sampling import quick_every
from tests.scenes import second as second_states

G = 9.81


def groove(alpha: float, rounding: float) -> Curve:
    """A hyperbola with asymptotes inclined at ±alpha: a V, rounded at the bottom."""
    return Curve(lambda s: (s, tan(alpha) * c.sqrt(s * s + rounding**2)), domain=(-6, 6))


def case_in(track: Curve, start: Start, *effects, radius: float = 0.5, duration: float = 3.0) -> Case:
    """A disc of 1 kg with inelastic impacts on a track."""
    always = (Gravity(G), Unilateral(), Flight())
    law = () if any(isinstance(effect, Impact) for effect in effects) else (Impact(0.0, "moreau"),)
    return Case(track, disc(radius, 1.0), (*always, *law, *effects), start, duration)


# --- exact motions ----------------------------------------------------------------------------------------------------


def held(track: Curve, radius: float, low: float = 0.2) -> tuple[float, float]:
    """The left contact's parameter of a disc with its centre above a symmetric valley's bottom, and the inclination of
    the track there (rad)."""
    from scipy.optimize import brentq

    s = brentq(lambda s: s - radius * sin(track.tangent_angle(s)), low, radius, xtol=1e-16, rtol=8.9e-16)
    return -s, float(track.tangent_angle(s))


@quick_every(2, first=1)
@pytest.mark.parametrize("method", reference.METHODS)
def test_a_disc_that_spins_in_a_valley_stops_when_both_contacts_have_used_its_momentum(method):
    # Friction μN at both contacts; the sum S of the normal forces balances the weight: S (1 + μ²) cos α = m g. Then
    # J ω̇ = −μ r S with J = m r²/2.
    mu, omega, radius = 0.3, 20.0, 0.5
    track = groove(radians(50), 0.05)
    xi1, alpha = held(track, radius)
    case = case_in(track, Start(xi1, slip=radius * omega, omega=omega), CoulombFriction(mu), radius=radius)
    motion = reference.simulate(case, method=method)
    stop = radius * omega * (1 + mu**2) * cos(alpha) / (2 * mu * G)
    assert motion.status == "completed"
    ends = [t for t in motion.transitions if t.after is Mode.ROLL]
    assert {t.contact for t in ends} == {"plate/track", "plate/track 2"}
    assert all(abs(t.time - stop) < 1e-12 * 3 for t in ends)
    assert motion(2.9).omega == 0.0 and motion(2.9).x == pytest.approx(0.0, abs=1e-12)
    left = motion.contacts["plate/track"]
    total = G / ((1 + mu**2) * cos(alpha))  # S for 1 kg
    ratio = mu / tan(alpha)  # N₁ − N₂ = −μ S cot α, friction along both tangents
    moving = motion.contact_columns("plate/track", np.array([0.5]))
    assert moving.normal_force[0] in (
        pytest.approx(0.5 * total * (1 + ratio), rel=1e-11), pytest.approx(0.5 * total * (1 - ratio), rel=1e-11),
    )  # fmt: skip
    assert np.isnan(left.normal_force[-1]) and left.normal_range[0, -1] < left.normal_range[1, -1]


@quick_every(2, first=1)
@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_disc_held_in_a_valley_begins_to_turn_under_a_growing_moment(mu):
    # Both contacts reach their cone at the moment μ r S.
    radius, rate = 0.5, 0.5
    track = groove(radians(50), 0.05)
    xi1, alpha = held(track, radius)
    limit = mu * radius * G / ((1 + mu**2) * cos(alpha))
    effects = CoulombFriction(mu), Load(moment=f"{rate}*t")
    case = case_in(track, Start(xi1), *effects, radius=radius, duration=1.05 * limit / rate)
    motion = reference.simulate(case)
    assert [(t.before, t.after) for t in motion.transitions] == [(Mode.ROLL, Mode.SLIP_FORWARD)] * 2
    assert [t.time for t in motion.transitions] == pytest.approx([limit / rate] * 2, abs=1e-12)
    ranges = motion.contact_columns("plate/track", np.array([0.0, 0.999999 * limit / rate])).normal_range
    assert np.diff(ranges, axis=0)[0, 1] < 1e-4 * np.diff(ranges, axis=0)[0, 0]  # the forces become unique at the limit


@pytest.mark.slow
def test_a_disc_rocks_in_a_valley_and_comes_to_rest():
    # In a symmetric valley every hand-over is at the same pose. Angular momentum about the new contact gives the
    # factor (1 + 2 cos 2α)/3 of the spin, with the flanks' inclination α there; between two of them energy is kept.
    radius = 0.5
    track = groove(radians(20), 0.01)
    _, alpha = held(track, radius, low=0.1)
    case = case_in(track, Start(-0.6), CoulombFriction(1.0), radius=radius, duration=8.0)
    motion = reference.simulate(case, rtol=1e-14)
    factor = (1 + 2 * cos(2 * alpha)) / 3
    jumps = np.flatnonzero((np.diff(motion.t) == 0.0) & (np.abs(np.diff(motion.omega)) > 1e-6))[:20]
    assert len(jumps) == 20
    assert motion.omega[jumps + 1] / motion.omega[jumps] == pytest.approx([factor] * 20, rel=1e-9)
    assert motion.omega[jumps[:8] + 1] / motion.omega[jumps[:8]] == pytest.approx([factor] * 8, rel=1e-12)
    total = energy(case, motion)
    for first, last in zip(jumps[:-1] + 1, jumps[1:], strict=True):
        assert np.ptp(total[first : last + 1]) < 1e-13 * total[0]
    last = motion.transitions[-1]
    assert last.cause == "bouncing came to rest" and motion(8.0).omega == 0.0
    # The intervals become a geometric series with the same factor.
    times = motion.t[jumps]
    rest = times[-1] + (times[-1] - times[-2]) * factor / (1 - factor)
    assert last.time == pytest.approx(rest, abs=1e-3 * (last.time - times[-1]))


def test_without_friction_the_speed_along_the_next_flank_is_kept():
    # cos 2α of it, with the flanks' inclination α where the disc touches both.
    radius = 0.3
    track = groove(radians(30), 0.01)
    _, alpha = held(track, radius, low=0.1)
    motion = reference.simulate(case_in(track, Start(-0.5), radius=radius, duration=2.0), rtol=1e-14)
    jumps = np.flatnonzero((np.diff(motion.t) == 0.0) & (np.abs(np.diff(motion.vx)) > 1e-6))[:6]
    speeds = np.hypot(motion.vx, motion.vy)
    assert speeds[jumps + 1] / speeds[jumps] == pytest.approx([cos(2 * alpha)] * 6, rel=1e-10)


@quick_every(2, first=1)
@pytest.mark.parametrize(("name", "digits"), [("ladder_at_wall", 4), ("round_ladder_at_wall", 3.75)])
def test_a_closed_contact_is_not_struck_where_another_one_opens(name, digits):
    """At a coarse tolerance a closed contact has a velocity along its normal, which was taken as an impact's."""
    motion = reference.simulate(cases.load(name), rtol=10.0**-digits, method="dop853")
    exact = reference.simulate(cases.load(name), rtol=1e-12)
    assert motion.status == "completed", motion.reason
    assert [(e.contact, e.after) for e in motion.transitions] == [(e.contact, e.after) for e in exact.transitions]
    assert [e.time for e in motion.transitions] == pytest.approx([e.time for e in exact.transitions], rel=1e-4)


@pytest.mark.parametrize("law", ["newton", "poisson", "moreau"])
def test_a_disc_that_falls_into_a_v_rebounds_alike_by_each_law_and_formulation(law):
    """Both contacts close at once; without friction the centre rises with e times the speed of its fall."""
    alpha, e, fall, later = 0.6, 0.5, 0.2, 0.05
    low, hits = 0.5 / cos(alpha), sqrt(2.0 * fall / G)
    effects, start = (Gravity(G), Unilateral(), Flight(), Impact(e, law)), StartPose(0.0, low + fall)
    case = Case(line(alpha), disc(0.5, 1.0), effects, start, 0.3, supports=(Support(line(-alpha), "right"),))
    exact = low + e * G * hits * later - 0.5 * G * later**2
    assert reference.simulate(case)(hits + later).y == pytest.approx(exact, abs=1e-13)
    assert second_states.poses(case, [hits + later])[1, 0] == pytest.approx(exact, abs=1e-13)


def test_a_second_contact_without_a_law_of_impact_ends_the_motion_and_says_what_to_add():
    effects = Gravity(G), CoulombFriction(0.2), Unilateral()
    motion = reference.simulate(Case(groove(radians(20), 0.01), disc(0.5, 1.0), effects, Start(-0.6), 3.0))
    assert motion.status == "second_contact" and "add Flight() and Impact(0.0)" in motion.reason


# --- two formulations -------------------------------------------------------------------------------------------------


def _agree(case: Case, within: float) -> int:
    """Compare both formulations' whole sequences; returns the number of changes, or raises AssertionError."""
    motion = reference.simulate(case, rtol=1e-14)
    second = _by_second(case, "second", 1e-13)
    changes = [(t.contact, t.before, t.after) for t in motion.transitions]
    assert (second.status, [(t.contact, t.before, t.after) for t in second.transitions]) == (motion.status, changes)
    for one, other in zip(motion.transitions, second.transitions, strict=True):
        assert abs(one.time - other.time) < within
    return len(changes)


def test_an_impact_in_a_groove_has_two_outcomes_where_the_disc_may_be_wedged():
    """Forces along the line of both contacts hold each other where that line is in both cones of friction, for
    μ tan α > 1: the disc stops, or rocks on as it does without them."""
    for incline, status in ((0.78, "completed"), (0.79, "not_unique")):  # μ = 1, and tan α = 1 at 0.7854
        case = cases.load("disc_rocking_in_groove", incline=incline, rounding=1e-6, duration=0.5)
        assert reference.simulate(case, method="dop853").status == status


def test_a_disc_that_a_load_lifts_off_one_flank_at_once_rolls_on_the_other_one():
    # At rest N = m g cos α + F_x sin α, and a third of the load along the flank is friction.
    alpha, radius, fx = radians(47), 0.2, 12.5
    track = groove(alpha, 0.01)
    xi1, slope = held(track, radius, low=0.05)
    case = case_in(track, Start(xi1), CoulombFriction(0.5), Load(fx=fx), radius=radius, duration=0.2)
    assert _agree(case, 1e-12) == 0
    now = reference.simulate(case).contact_columns("plate/track 2", np.zeros(1))
    assert now.normal_force == pytest.approx(G * cos(slope) + fx * sin(slope), rel=1e-12)
    assert now.friction_force == pytest.approx((G * sin(slope) - fx * cos(slope)) / 3.0, rel=1e-12)
