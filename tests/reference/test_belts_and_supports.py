"""A belt together with a second contact: exact motions, two formulations, the paper's matrix, and the belts' work."""

from dataclasses import replace
from math import atan, cos, exp, inf, pi, sin, sqrt

import numpy as np
import pytest

import reference
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Load,
    Mode,
    Pair,
    PerfectlyRough,
    Plate,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.contact import belt_speed
from cases.library import line
from cases.motion.mechanics import energy
from reference.certification.witnesses import _by_second
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.motions import contact_case, work_done
from tests.scenes.supports import simulated, slow

G = 9.81
INELASTIC = Gravity(G), Unilateral(), Flight(), Impact(0.0, "moreau")
METHODS = pytest.mark.parametrize("method", [reference.METHODS[0], "second", *slow(*reference.METHODS[1:])])


def motion_by(case: Case, method: str):
    """Transitions, status and states of a motion by the first or the second formulation."""
    return _by_second(case, "second", 1e-13) if method == "second" else reference.simulate(case, 1e-14, method)


# --- a disc between a belt and a wall ---------------------------------------------------------------------------------

R, PRESS, MU, MU_WALL = 0.5, 3.0, 0.3, 0.4


def disc_at_wall(speed, mirrored: bool = False, duration: float = 2.0) -> Case:
    """A disc of 1 kg on a belt, pressed by a load against a wall on its left (mirrored: on its right)."""
    side = -1.0 if mirrored else 1.0
    wall = Support(line(side * pi / 2), "wall", (CoulombFriction(MU_WALL),))
    effects = (*INELASTIC, CoulombFriction(MU), Belt(speed), Load(fx=-side * PRESS))
    return Case(line(), disc(R, 1.0), effects, StartPose(side * R, R), duration, supports=(wall,))


@quick_every(6)
@METHODS
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_belt_spins_a_disc_up_against_two_slipping_contacts(method, mirrored):
    """The belt runs towards the wall: F₁ = μ₁ N₁, N₂ = P + F₁, F₂ = μ₂ N₂ down, N₁ = m g + F₂, so that
    F₁ = μ₁ (m g + μ₂ P)/(1 − μ₁ μ₂). m r² ω̇/2 = r (F₁ − F₂) until r ω is the speed. Then the disc sticks to the belt
    and slips at the wall: F₁ = F₂ = μ₂ P/(1 − μ₂)."""
    speed, side = 2.0, -1.0 if mirrored else 1.0
    case = disc_at_wall(-side * speed, mirrored)
    first = MU * (G + MU_WALL * PRESS) / (1.0 - MU * MU_WALL)
    spin_up = 2.0 * (first - MU_WALL * (PRESS + first)) / R
    motion = motion_by(case, method)
    (change,) = motion.transitions
    assert (change.contact, change.after) == ("plate/track", Mode.ROLL)
    assert change.time == pytest.approx(speed / (R * spin_up), abs=1e-13)
    if method != "second":
        sticking = MU_WALL * PRESS / (1.0 - MU_WALL)
        at = motion.contact_columns("plate/track", np.array([0.1, 1.9]))
        assert np.abs(at.friction_force) == pytest.approx([first, sticking], rel=1e-12)
        assert at.normal_force == pytest.approx([first / MU, G + sticking], rel=1e-12)
        end = motion(2.0)
        assert (end.x, end.y, R * end.omega) == pytest.approx((side * R, R, -side * speed), abs=1e-12)


@quick_every(6)
@METHODS
@pytest.mark.parametrize("towards", [True, False])
def test_a_disc_at_a_wall_slips_where_the_belt_accelerates_too_much(method, towards):
    """On a belt of speed c t² the disc spins with ω̇ = 2 c t/r, and F₁ − F₂ = m c t. Towards the wall, where
    F₁ = (μ₂ P + m c t)/(1 − μ₂), F₁ reaches μ₁ (m g + F₂). Away from it it is (μ₂ P + m c t)/(1 + μ₂), and reaches
    μ₁ (m g − F₂) with F₂ = μ₂ (P − F₁)."""
    c, sign = 2.0, 1.0 if towards else -1.0
    most = MU * (G + sign * MU_WALL * PRESS) / (1.0 - MU * MU_WALL)
    case = disc_at_wall(f"{-sign * c}*t**2", duration=1.6)
    (change,) = motion_by(case, method).transitions
    assert change.before is Mode.ROLL and change.contact == "plate/track"
    assert change.time == pytest.approx((most * (1.0 - sign * MU_WALL) - MU_WALL * PRESS) / c, abs=1e-12)


@quick_every(2)
@METHODS
def test_a_v_of_two_belts_spins_a_disc_up_until_it_rolls_on_both(method):
    """Both slip: the sum S of the normal forces has S (1 + μ²) cos α = m g, and m r ω̇/2 = μ S (`disc_spinning_in_v`).
    Then four rows determine the motion, and the forces are not unique."""
    speed, mu, alpha = 1.5, 0.3, pi / 6
    effects = (*INELASTIC, CoulombFriction(mu), Belt(speed))
    right = Support(line(-alpha), "right", (CoulombFriction(mu), Belt(speed)))
    case = Case(line(alpha), disc(R, 1.0), effects, StartPose(0.0, R / cos(alpha)), 2.0, supports=(right,))
    motion = motion_by(case, method)
    assert [t.after for t in motion.transitions] == [Mode.ROLL, Mode.ROLL]
    exact = speed * (1.0 + mu * mu) * cos(alpha) / (2.0 * mu * G)
    assert [t.time for t in motion.transitions] == pytest.approx([exact] * 2, abs=1e-13)
    if method != "second":
        assert R * motion(2.0).omega == pytest.approx(speed, rel=1e-12)
        ranges = motion.contact_columns("plate/right", np.array([1.9]))
        assert ranges.friction_range[0] < 0.0 < ranges.friction_range[1] and np.isnan(ranges.friction_force[0])


# --- a block on a belt ------------------------------------------------------------------------------------------------

STATIC, KINETIC, STIFFNESS = 0.4, 0.2, 20.0


def block_on_belt(
    speed, mu=KINETIC, static=None, turn=0.0, mirrored=False, length=1.0, time=1.0, k=0.0, end=1.2, supports=()
) -> Case:
    """A block of 1 kg on a belt, with a spring along it; turned, mirrored, and in other units of length and time."""
    side = -1.0 if mirrored else 1.0
    c, s, stiffness = cos(turn), sin(turn), k / time**2
    along = f"-{stiffness!r}*({c!r}*x + {s!r}*y)"
    spring = (Load(fx=f"{c!r}*({along})", fy=f"{s!r}*({along})"),) if k else ()
    belt = Belt(speed if isinstance(speed, str) else side * speed * length / time)
    effects = (
        Gravity(G * length / time**2, turn - pi / 2), *INELASTIC[1:], CoulombFriction(mu, static), belt, *spring,
    )  # fmt: skip
    plate, high = Plate.rectangle(0.6 * length, 0.4 * length, 1.0), 0.2 * length
    return Case(line(-turn), plate, effects, StartPose(-s * high, c * high, turn), end * time, supports=supports)


@quick_every(2)
@METHODS
@pytest.mark.parametrize("form", [{}, *slow({"mirrored": True}, {"turn": 0.7}, {"length": 100.0, "time": 10.0})])
def test_stick_slip_of_a_block_with_two_contacts_on_a_belt(method, form):
    """Both corners stick until the spring has μₛ m g, whatever their shares, and slip with μ m g about x = μ g/ω²: with
    d = (μₛ − μ) g/ω² they stick for 2 d/b and slip for (2 π − 2 atan(ω d/b))/ω."""
    b, omega, time = 0.3, sqrt(STIFFNESS), form.get("time", 1.0)
    case = block_on_belt(b, KINETIC, STATIC, k=STIFFNESS, end=2.5, **form)
    motion = motion_by(case, method)
    d = (STATIC - KINETIC) * G / omega**2
    sticks, slips = 2.0 * d / b, (2.0 * pi - 2.0 * atan(omega * d / b)) / omega
    times = np.array([t.time for t in motion.transitions])
    assert len(times) == 8 and np.array_equal(times[::2], times[1::2])
    # The second formulation notices a limit when accelerations exceed 1e-12 of their terms.
    within = (1e-10 if method == "second" else 1e-12) * time
    assert np.diff(times[::2])[1:] == pytest.approx([slips * time, sticks * time], abs=within)
    assert [t.after for t in motion.transitions[::2]][:2] == [Mode.ROLL, motion.transitions[0].before]


@quick_every(2)
@METHODS
def test_a_block_on_a_belt_that_accelerates_slips_at_mu_g(method):
    case = block_on_belt("2*t*t", mu=0.3)
    motion = motion_by(case, method)
    assert [t.contact for t in motion.transitions] == ["plate/track", "plate/track 2"]
    assert [t.time for t in motion.transitions] == pytest.approx([0.3 * G / 4.0] * 2, abs=1e-10)
    if method != "second":
        # Before that, the friction of both is m v̇, and their normal forces have the moment that takes.
        at = motion.contacts["plate/track"], motion.contacts["plate/track 2"]
        now = [motion.contact_columns(name, np.array([0.5])) for name in motion.contact_names]
        assert abs(now[0].normal_force[0] - now[1].normal_force[0]) == pytest.approx(2.0 * 0.2 / 0.3, rel=1e-10)
        assert np.isnan(now[0].friction_force[0]) and len(at[0].slip) == len(motion.t)


@quick_every(2)
@METHODS
def test_a_block_tips_on_a_belt_that_accelerates_where_its_moment_does(method):
    """A block of width w and height h tips about its rear corner at v̇ = g w/h."""
    case = block_on_belt("8*t*t", mu=2.0)
    first = motion_by(case, method).transitions[0]
    assert first.after is Mode.FLIGHT
    assert first.time == pytest.approx(G * 1.5 / 16.0, abs=1e-10)


# --- a box on a belt that runs for a moment ---------------------------------------------------------------------------


@quick_every(2)
@METHODS
@pytest.mark.parametrize("width", [1e-2, 1e-3])
def test_no_step_passes_over_a_moment_in_which_a_belt_runs(method, width):
    """Below both corners of a box the belt has the speed V e^(-u²), u = (t - 1/2)/w: the box slips as soon as the
    belt's acceleration 2 V |u| e^(-u²)/w is μ g, by Newton's method from |u| = 2 and 2.6, and ends at rest."""
    speed, u = 0.5, 2.0 if width == 1e-2 else 2.6
    for _ in range(20):
        excess = 2.0 * speed * u * exp(-u * u) / width - MU * G
        u -= excess / (2.0 * speed * exp(-u * u) * (1.0 - 2.0 * u * u) / width)
    effects = (*INELASTIC, CoulombFriction(MU), Belt(f"{speed}*exp(-((t-0.5)/{width})**2)"))
    motion = motion_by(Case(line(), Plate.rectangle(0.6, 0.4, 1.0), effects, StartPose(0.0, 0.2), 1.0), method)
    begin = [change.time for change in motion.transitions if change.after is Mode.SLIP_BACKWARD]
    assert len(begin) == 2 and begin == pytest.approx([0.5 - width * u] * 2, abs=1e-12)
    assert motion.transitions[-1].after in (Mode.ROLL, Mode.REST) and motion.status == "completed"


# --- impacts ----------------------------------------------------------------------------------------------------------


@quick_every(6)
@METHODS
@pytest.mark.parametrize("mu", [0.2, None])
def test_an_impact_slips_against_the_belt_of_a_support(method, mu):
    """A disc hits a wall whose surface runs up with b: the impulse along it is μ (1 + e) m v, or without bound that
    after which the disc rolls on it, a third of its mass by the slip."""
    b, v, e, r = 10.0, 4.0, 0.5, 0.1
    own = (CoulombFriction(mu) if mu else PerfectlyRough(), Belt(-b), Impact(e, "moreau"))
    case = Case(
        line(), disc(r, 1.0), (*INELASTIC[:3], Impact(0.2, "moreau")), StartPose(0.6, 1.0, vx=-v), 0.2,
        supports=(Support(line(pi / 2), "wall", own),),
    )  # fmt: skip
    motion = motion_by(case, method)
    assert motion.transitions[0].time == pytest.approx(0.125, abs=1e-14)
    along = mu * (1.0 + e) * v if mu else (b + G * 0.125) / 3.0
    if method == "second":
        assert second_states.poses(case, [0.2])[1, 0] == pytest.approx(1.0 - 0.5 * G * 0.04 + along * 0.075, abs=1e-13)
        return
    end = motion(0.2)
    assert (end.vx, end.vy) == pytest.approx((e * v, along - G * 0.2), abs=1e-13)
    assert r * end.omega == pytest.approx(-2.0 * along, rel=1e-12)


# --- work -------------------------------------------------------------------------------------------------------------


def test_the_work_of_belts_and_friction_is_the_gain_of_energy():
    """A disc in a V of two planes, one of them a belt of changing speed: it slips and sticks."""
    effects = (*INELASTIC, CoulombFriction(0.3), Belt("1.5 + sin(5*t)"))
    right = Support(line(-0.7), "right", (CoulombFriction(0.2),))
    start = StartPose(0.0, R / cos(0.7))
    motion = simulated(Case(line(0.7), disc(R, 1.0), effects, start, 2.0, supports=(right,)))
    assert len(motion.transitions) >= 2
    total = energy(motion.case, motion)
    gain, work = total[-1] - total[0], work_done(motion.case, motion)
    assert abs(work) > 0.1 and gain == pytest.approx(work, abs=1e-10)
    belt = contact_case(motion.case, "plate/track"), contact_case(motion.case, "plate/right")
    assert (belt_speed(belt[0], 0.0), belt_speed(belt[1], 0.0)) == (1.5, 0.0)


# --- the checks -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("inertia", [None, inf])
def test_a_belt_drives_what_lies_on_it_and_nothing_that_lies_on_that(inertia):
    """A box slips on a belt until μ g t is its speed, and a disc on the box rolls: its centre has a third of μ g. Then
    both go on as they are: the disc with its centre at a third of the belt's speed and the rim at the box's."""
    speed, mu = 0.6, 0.2
    effects = (*(e for e in INELASTIC if not isinstance(e, CoulombFriction)), CoulombFriction(mu), Belt(speed))
    pairs = (Pair("upper/plate", (PerfectlyRough(),)),)
    box = replace(Plate.rectangle(1.0, 0.2, 1e6), **({} if inertia is None else {"inertia": inertia}))
    upper = FreePlate(disc(R, 1.0), StartPose(0.0, 0.2 + R), "upper")
    motion = reference.simulate(Case(line(), box, effects, StartPose(0.0, 0.1), 0.4, others=(upper,), pairs=pairs))
    assert motion.status == "completed"
    assert motion.transitions[0].time == pytest.approx(
        speed / (mu * G), rel=1e-6
    )  # of a box as heavy as a million discs
    assert motion.vx[-1] == pytest.approx(speed, rel=1e-12)
    assert motion.plate("upper").vx[-1] == pytest.approx(speed / 3.0, rel=1e-9)
