"""A plate with several contacts: exact motions, and agreement of two formulations that share no code."""

from functools import lru_cache
from math import cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

import reference
from cases import Case, CoulombFriction, Curve, Flight, Gravity, Impact, Load, Mode, Plate, Start, Unilateral, disc
from cases import curves as c
from reference import contact_frame, delassus

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
    assert {t.after for t in motion.transitions} == {Mode.SLIP_BACKWARD} or len(motion.transitions) == 2
    assert [t.time for t in motion.transitions] == pytest.approx([limit / rate] * 2, abs=1e-12)
    ranges = motion.contact_columns("plate/track", np.array([0.0, 0.999999 * limit / rate])).normal_range
    assert np.diff(ranges, axis=0)[0, 1] < 1e-4 * np.diff(ranges, axis=0)[0, 0]  # the forces become unique at the limit


def test_a_disc_rocks_in_a_v_and_comes_to_rest():
    # It rolls down and up with the acceleration (2/3) g sin α; each hand-over multiplies its speed by (1 + 2 cos 2α)/3:
    # angular momentum about the new contact. The V is rounded at the bottom by 1e-7, which moves the flanks by 1e-13 m.
    alpha, radius, way = radians(20), 0.5, 0.4
    track = groove(alpha, 1e-7)
    begin = -(radius * sin(alpha) + way * cos(alpha))
    case = case_in(track, Start(begin), CoulombFriction(1.0), radius=radius, duration=9.0)
    motion = reference.simulate(case, rtol=1e-14)
    pull, factor = 2 / 3 * G * sin(alpha), (1 + 2 * cos(2 * alpha)) / 3
    speed, times = sqrt(2 * pull * way), [sqrt(2 * way / pull)]
    for _ in range(19):
        speed *= factor
        times.append(times[-1] + 2 * speed / pull)
    impacts = [t.time for t in motion.transitions if t.after is Mode.ROLL][:20]
    assert impacts == pytest.approx(times, abs=1e-11)
    rest = times[0] + 2 * sqrt(2 * pull * way) / pull * factor / (1 - factor)
    last = motion.transitions[-1]
    assert last.cause == "bouncing came to rest" and last.time == pytest.approx(rest, abs=1e-9)
    assert motion(9.0).omega == 0.0


def test_a_disc_without_friction_slides_from_flank_to_flank():
    # Without friction the velocity along the next flank is kept: cos 2α of it.
    alpha, radius, way = radians(30), 0.3, 0.4
    begin = -(radius * sin(alpha) + way * cos(alpha))
    motion = reference.simulate(case_in(groove(alpha, 1e-7), Start(begin), radius=radius, duration=2.5), rtol=1e-14)
    pull, speed, time = G * sin(alpha), sqrt(2 * G * sin(alpha) * way), sqrt(2 * way / (G * sin(alpha)))
    impacts = [t.time for t in motion.transitions if t.after is Mode.SLIDE][:8]
    exact = []
    for _ in range(8):
        exact.append(time)
        speed *= cos(2 * alpha)
        time += 2 * speed / pull
    assert impacts == pytest.approx(exact, abs=1e-11)


def test_contacts_that_may_press_against_each_other_have_no_unique_motion():
    # Steep flanks: each contact lies in the other's cone, so they may hold a disc that a load would lift. Coulomb's law
    # allows both.
    track = Curve(lambda s: (s, 3.0 * c.sqrt(s * s + 0.01)), domain=(-3, 3))
    xi1, alpha = held(track, 0.5)
    assert alpha > 0.5 * np.pi - np.arctan(1.2)
    case = case_in(track, Start(xi1), CoulombFriction(1.2), Load(fy=20.0))
    motion = reference.simulate(case)
    assert motion.status == "not_unique" and "plate/track flight, plate/track 2 flight" in motion.reason


def test_a_second_contact_without_a_law_of_impact_ends_the_motion_and_says_what_to_add():
    effects = Gravity(G), CoulombFriction(0.2), Unilateral()
    motion = reference.simulate(Case(groove(radians(20), 0.01), disc(0.5, 1.0), effects, Start(-0.6), 3.0))
    assert motion.status == "second_contact" and "add Flight() and Impact(0.0)" in motion.reason
