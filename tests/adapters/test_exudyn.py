"""The Exudyn adapter against exact values, facts of mechanics and its contract; no engine is compared with another."""

from dataclasses import replace
from math import atan, cos, pi, sin, tan
from types import SimpleNamespace

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, Setting, engines
from cases import Case, CoulombFriction, Curve, Gravity, Plate, Start, UnknownName, curves, disc
from cases import Unilateral as Pushes
from reports.judging import slip_phases
from tests.authorities.paper_application import FIRST_TRANSITION, SEQUENCE
from tests.scenes.elliptic import ellipse

exudyn = pytest.importorskip("adapters.exudyn")

G, FREE = 9.81, (Gravity(9.81), Pushes())


def solve(case: Case, route: str = "native", rung: int = -1, setting: Setting | None = None):
    model = exudyn.build(case, route, setting or exudyn.ladder(case, route)[rung])
    exudyn.run(model)
    return exudyn.read(model)


def end_of_slip(motion, after: float = 0.0) -> float:
    """First time the sliding branch of the slip velocity, extrapolated by a cubic, is zero.

    Ten samples end before the zone in which regularised friction falls short.
    """
    t, slip = motion.t, motion.slip * np.sign(motion.slip[np.searchsorted(motion.t, after) + 1])
    sliding = slip > 2 * motion.slip_resolution
    begin = int(np.argmax(sliding & (t > after)))
    end = begin + int(np.argmin(sliding[begin:]))
    last = slice(end - 10, end)
    roots = np.polynomial.Polynomial.fit(t[last] - t[end], slip[last], 3).roots()
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(t[end] + real[np.argmin(np.abs(real))])


def energy(case: Case, motion) -> np.ndarray:
    """Of a case whose gravity, if any, pulls along −Y."""
    gravity = case.effect(Gravity)
    kinetic = case.plate.mass * (motion.vx**2 + motion.vy**2) + case.plate.inertia * motion.omega**2
    return 0.5 * kinetic + case.plate.mass * (gravity.g if gravity else 0.0) * motion.y


def hill(start=0.2, effects=FREE, **how) -> Case:
    track = Curve(lambda s: (curves.sin(s), curves.cos(s)))
    return Case(track, disc(0.1, 1.0), effects, Start(xi1=start, **how), duration=1.0)


def elliptic_plate(a=0.2, b=0.1) -> Plate:
    return Plate(ellipse(a, b), 1.0, (a * a + b * b) / 4)


# --- against exact values -------------------------------------------------------------------------------------------


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "mu", [0.1, *(pytest.param(mu, marks=pytest.mark.slow) for mu in FIRST_TRANSITION if mu != 0.1)]
)
@pytest.mark.parametrize(("route", "tolerance"), [("native", 1e-7), ("integrator", 1e-6)])
def test_first_transition_in_a_circle_is_exact_on_the_finest_rung(mu, route, tolerance, accuracy):
    case = cases.load("disc_in_circle", mu=mu)
    error = end_of_slip(solve(case, route), after=0.02) - FIRST_TRANSITION[mu][0]
    # The coarser rungs show an error C/k with C of 50 to 100 s N/m; k is 1e9 and 3e8 N/m here.
    accuracy(case=case.label, solver="exudyn", route=route, quantity="first transition / s", error=error,
             tolerance=tolerance)  # fmt: skip


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", exudyn.routes)
def test_first_transition_converges_with_every_rung(route):
    case = cases.load("disc_in_circle", mu=0.1)
    exact = FIRST_TRANSITION[0.1][0]
    errors = [abs(end_of_slip(solve(case, route, rung), after=0.02) - exact) for rung in (1, 2, 3, 4, -1)]
    # A rung's step is shorter by 1.7 or more, and the rest goes with it; the error must at least halve.
    assert all(fine < 0.5 * coarse for coarse, fine in zip(errors, errors[1:], strict=False)), errors
    assert errors[-1] < 5e-3 * errors[0]


def test_disc_about_another_point_than_its_centre_is_the_engine_s_own(accuracy):
    case = cases.load("eccentric_disc_on_line")
    assert exudyn.refuses(case, "native") is None
    exact = reference.simulate(case, rtol=1e-12)
    motion = solve(case, rung=5)
    off = float(np.hypot(motion.x - exact(motion.t).x, motion.y - exact(motion.t).y).max())
    # Creep, 1.2e-5 m/s for a second, and the penetration of 4e-8 m.
    accuracy(case=case.label, solver="exudyn", route="native", quantity="centre / m", error=off, tolerance=3e-5)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "label", ["driven_disc", "rolling_loop[ratio=3.5]", "disc_rolling_off_hill", "ellipse_on_hill"]
)
def test_first_step_presses_and_rubs_as_the_rigid_plate_does(label):
    (case,) = cases.select(label)
    route = "integrator" if exudyn.refuses(case, "native") else "native"
    motion, exact = solve(case, route, rung=3), reference.simulate(case)
    begin = slice(1, 6)
    # Within the curvature of the path in five steps; set down by hand it is off by several times the weight.
    weight = case.plate.mass * G
    for name in ("normal_force", "friction_force"):
        apart = getattr(motion, name)[begin] - getattr(exact(motion.t[begin]), name)
        assert np.abs(apart).max() < 0.05 * weight, name


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", exudyn.routes)
def test_four_transitions_at_a_friction_of_a_fifth(route):
    motion = solve(cases.load("disc_in_circle", mu=0.2), route)
    sticking = np.abs(motion.slip) < motion.slip_resolution
    # The start, at rest, is a slip of zero too.
    changes = motion.t[1:][np.diff(sticking.astype(int)) != 0][1:]
    # Without shorter steps at zero slip the engine's own contact swings through zero for two samples.
    changes = changes[np.diff(changes, prepend=0.0) > 1e-4]
    # Stick ends where creep passes vreg, read at the next sample; half a millisecond is two steps of the coarser of
    # the two routes' finest rungs.
    assert changes == pytest.approx([time for time, _ in SEQUENCE], abs=5e-4)


def crossings(motion) -> int:
    """How often the slip, where it surely is one, turns to the other side."""
    signs = np.sign(motion.slip[np.abs(motion.slip) > 2 * motion.slip_resolution])
    return int(np.sum(np.diff(signs) != 0))


@pytest.mark.sampled(3, first=1)
@pytest.mark.parametrize("rung", [1, 3, 6])
def test_wheel_driven_to_and_fro_rolls_in_between_if_steps_are_cut_where_its_slip_ends(rung):
    case = cases.load("driven_disc")
    setting = exudyn.ladder(case, "integrator")[rung]
    uncut = setting.but(cut=None)
    exact = [(event.before, event.after) for event in reference.simulate(case).transitions]
    found, without = (
        [
            (event.before, event.after)
            for event in slip_phases.read_transitions(solve(case, "integrator", setting=s), 0.15)
        ]
        for s in (setting, uncut)
    )
    assert found == exact and without != exact


@pytest.mark.parametrize("rung", [1, 2, 3])
def test_slip_that_ends_in_stick_does_not_overshoot_to_the_other_side(rung):
    # In the valley the cone is used up to 0.87 where the slip ends: an overshoot would last for tens of steps.
    case = replace(cases.load("disc_in_cosine"), duration=0.885)
    setting = exudyn.ladder(case, "integrator")[rung]
    uncut = setting.but(cut=None)
    assert crossings(solve(case, "integrator", setting=uncut)) == 1
    assert crossings(solve(case, "integrator", setting=setting)) == 0


@pytest.mark.sampled(2)
def test_slip_that_reverses_leaves_less_error_if_steps_are_cut_there():
    case, route = cases.load("disc_in_circle", mu=0.1), "integrator"
    setting = exudyn.ladder(case, route)[-1]
    assert not any("cut" in setting for setting in exudyn.ladder(case, "native"))
    uncut = setting.but(cut=None)
    truth = reference.simulate(case, rtol=1e-12)
    off = [float(np.hypot(m.x[-1] - truth.x[-1], m.y[-1] - truth.y[-1])) for m in
           (solve(case, route, setting=s) for s in (uncut, setting))]  # fmt: skip
    # Measured 1.1e-4 and 2.4e-5 m.
    assert off[1] < 0.3 * off[0]


@pytest.mark.sampled(3)
@pytest.mark.parametrize("route", exudyn.routes)
@pytest.mark.parametrize(("v0", "mu"), [(1.0, 0.1), (2.0, 0.3)])
def test_bowling_disc_rolls_after_v0_over_three_mu_g(route, v0, mu, accuracy):
    case = cases.load("disc_on_line", v0=v0, mu=mu)
    motion = solve(case, route)
    # The contact's deflection m g/k shortens the arm of friction: 4/3 of its share of the radius, 3e-7 of the time.
    accuracy(case=case.label, solver="exudyn", route=route, quantity="first transition / s",
             error=end_of_slip(motion) - v0 / (3 * mu * G), tolerance=1e-6)  # fmt: skip
    assert motion.vx[-1] == pytest.approx(2 * v0 / 3, rel=1e-6)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", exudyn.routes)
def test_rounding_of_the_penetration_ends_no_rung(route):
    """Asked for 1e-10 N, less than what the stiffest springs round by, Newton's method gave up on three rungs."""
    case, exact = cases.load("disc_on_line", mu=0.3), 1 / (3 * 0.3 * G)
    off = [abs(end_of_slip(solve(case, route, setting=s)) - exact) for s in exudyn.ladder(case, route)[1:]]
    assert off[-1] < off[0] < 1e-3 * exact


@pytest.mark.sampled(5)
@pytest.mark.parametrize("route", exudyn.routes)
@pytest.mark.parametrize("slope", [0.1, atan(0.3) - 0.02, atan(0.3) + 0.02, 0.6])
def test_disc_rolls_down_an_incline_up_to_tan_equal_three_mu_and_slips_beyond(route, slope):
    motion = solve(cases.load("disc_on_incline", slope=slope, mu=0.1), route)
    rolls = tan(slope) < 0.3
    acceleration = G * (2 / 3 * sin(slope) if rolls else sin(slope) - 0.1 * cos(slope))
    assert bool(abs(motion.slip[-1]) < motion.slip_resolution) is rolls
    # What sticks creeps by less than vreg = 1e-5 m/s, a third of which the centre gains.
    assert np.hypot(motion.vx[-1], motion.vy[-1]) == pytest.approx(acceleration * motion.t[-1], abs=1e-5)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", exudyn.routes)
def test_frictionless_disc_leaves_a_hill_at_two_thirds_of_its_starting_height(route):
    motion = solve(hill(start=0.2), route)
    assert motion.status == "lift_off"
    assert "left its track" in motion.reason
    # The penetration (1e-6 of the radius) and the step (h² of the time scale) both stay below.
    assert cos(motion.xi1[-1]) == pytest.approx(2 / 3 * cos(0.2), abs=3e-6)
    assert motion.normal_force[-1] == 0.0


# --- facts of mechanics ---------------------------------------------------------------------------------------------


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", exudyn.routes)
@pytest.mark.parametrize("mu", [0.1, 0.5])
def test_friction_force_stays_inside_cone_and_opposes_slip(route, mu):
    motion = solve(cases.load("disc_in_circle", mu=mu), route, rung=4)
    # Rounding of forces of some tens of newtons, magnified by the stiffness: the penetration is known to 1e-16 m.
    assert np.all(np.abs(motion.friction_force) <= mu * np.abs(motion.normal_force) + 1e-6)
    assert np.all(motion.friction_force * motion.slip <= 1e-12)
    slipping = np.abs(motion.slip) > motion.slip_resolution
    pressed = motion.normal_force > 1.0
    ratio = np.abs(motion.friction_force / np.where(pressed, motion.normal_force, 1.0))
    assert ratio[slipping & pressed] == pytest.approx(mu, rel=1e-6)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", exudyn.routes)
def test_motion_does_not_depend_on_where_and_how_the_scene_lies(route):
    turn, X, Y = 2.1, 3.0, -4.0

    def placed(function):
        def curve(s):
            x, y = function(s)
            return X + x * cos(turn) - y * sin(turn), Y + x * sin(turn) + y * cos(turn)

        return Curve(curve)

    for function, start in (
        (lambda s: (2 * s, -s), Start(xi1=0.0, slip=1.0, omega=-3.0)),
        (lambda s: (curves.cos(s), curves.sin(s)), Start(xi1=-1.0, slip=-2.0, omega=5.0)),
        (lambda s: (curves.sin(s), curves.cos(s)), Start(xi1=-0.1, slip=0.5)),
    ):
        effects = (Gravity(G), CoulombFriction(0.2), Pushes())
        here = Case(Curve(function), disc(0.1, 1.0), effects, start, 0.3)
        effects = (Gravity(G, turn - pi / 2), CoulombFriction(0.2), Pushes())
        there = Case(placed(function), here.plate, effects, start, 0.3)
        a, b = solve(here, route, rung=3), solve(there, route, rung=3)
        assert a.t[-1] == pytest.approx(b.t[-1], abs=1e-9)
        # Positions of a few metres are rounded to 1e-15 m, and the stiffness of 1e7 N/m and the start magnify it;
        # a step of 1e-3 s that meets the friction law's kink on the other side of it differs by 1e-5 m/s.
        for time in (0.1, 0.2, 0.3):
            assert a(time).slip == pytest.approx(b(time).slip, abs=1e-5)
            assert a(time).xi1 == pytest.approx(b(time).xi1, abs=1e-5)
            assert a(time).normal_force == pytest.approx(b(time).normal_force, abs=1e-2)


def test_disc_inside_a_circle_may_run_its_track_either_way():
    effects = (Gravity(G), CoulombFriction(0.1), Pushes())
    left = Case(Curve(lambda s: (curves.cos(s), curves.sin(s))), disc(0.1, 1.0), effects, Start(-1.0), 1.0)
    right = Case(Curve(lambda s: (-curves.cos(2 * s), curves.sin(-2 * s))), left.plate, effects, Start(0.3), 1.0)
    for case in (left, right):
        assert exudyn.refuses(case, "native") is None
        motion = solve(case, rung=3)
        assert np.hypot(motion.x, motion.y).max() == pytest.approx(0.9, abs=1e-5)
        assert energy(case, motion)[-1] < energy(case, motion)[0]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "case",
    [
        Case(ellipse(1.0, 1.0), elliptic_plate(), FREE, Start(xi1=-2.5, xi2=-1.2), 1.0),
        Case(Curve(lambda s: (s, s * s)), disc(0.1, 1.0), FREE, Start(xi1=-1.0), 1.0),
        hill(effects=(Gravity(G),)),
    ],
    ids=["ellipse in circle", "disc on parabola", "disc on both sides of a hill"],
)
def test_frictionless_energy_is_kept_better_on_finer_rungs(case):
    drift, stiffness = [], []
    for rung in (3, 5, 6):
        E = energy(case, solve(case, "integrator", rung))
        drift.append(np.abs(E - E[0]).max())
        stiffness.append(exudyn.ladder(case, "integrator")[rung]["k"])
    # The penalty's own energy N²/2k falls as the stiffness grows, and the step's error faster than that.
    assert drift[0] * stiffness[0] > drift[1] * stiffness[1] > drift[2] * stiffness[2]
    # A ten-thousandth of m g times a metre, the energy these scenes turn over.
    assert drift[2] < 1e-4 * G


def test_energy_only_falls_with_friction_for_an_elliptic_plate_in_a_circle():
    effects = (Gravity(G), CoulombFriction(0.1), Pushes())
    case = Case(ellipse(1.0, 1.0), elliptic_plate(), effects, Start(xi1=-2.5, xi2=-1.2), 1.5)
    motion = solve(case, "integrator", rung=4)
    E = energy(case, motion)
    work = np.concatenate([[0.0], np.cumsum(np.diff(motion.t) * 0.5 * (
        motion.friction_force[1:] * motion.slip[1:] + motion.friction_force[:-1] * motion.slip[:-1]))])  # fmt: skip
    assert motion.status == "completed"
    assert E[-1] < E[0] - 0.1
    # What is lost is the work of friction on the slip, to the trapezoidal rule at the one reversal of the slip.
    assert E - E[0] == pytest.approx(work, abs=2e-3)


def test_track_that_also_pulls_holds_the_disc_through_negative_normal_force():
    motion = solve(hill(effects=(Gravity(G), CoulombFriction(0.3))), "integrator", rung=3)
    assert motion.status == "completed"
    assert motion.normal_force[-1] < -1.0
    assert np.hypot(motion.x, motion.y) == pytest.approx(1.1, abs=1e-4)


@pytest.mark.parametrize("route", exudyn.routes)
def test_release_without_pressure_and_being_set_down_are_no_lift_off(route):
    for case in (cases.load("disc_in_circle", mu=0.01), cases.load("disc_on_line"), hill()):
        for rung in (1, 2, 3, 4):
            motion = solve(replace(case, duration=0.15), route, rung)
            assert motion.status == "completed"
            assert motion.t[-1] == pytest.approx(0.15, abs=1e-12)


@pytest.mark.parametrize("route", exudyn.routes)
def test_disc_too_fast_for_its_hill_leaves_at_once(route):
    motion = solve(hill(start=0.0, slip=5.0), route, rung=4)
    assert motion.status == "lift_off"
    assert motion.t[-1] == 0.0


def test_motion_ends_where_the_tracks_domain_ends():
    bowl = Curve(lambda s: (s, -curves.sqrt(1 - s * s)), domain=(-0.9, 0.9))
    case = Case(bowl, disc(0.1, 1.0), FREE, Start(xi1=0.8, slip=-4.0), duration=1.0)
    for route in exudyn.routes:
        motion = solve(case, route, rung=3)
        assert motion.status == "track_end"
        assert motion.xi1[-1] == pytest.approx(-0.9, abs=1e-12)
        # What the disc gains in sliding down 0.9 (cos of the two angles): energy, to the penetration of 1e-5 of it.
        E = energy(case, motion)
        assert E[-1] == pytest.approx(E[0], abs=1e-3)


# --- the contract ---------------------------------------------------------------------------------------------------


def test_adapter_is_found_by_its_name_and_its_parts_are_not_engines():
    assert "exudyn" in engines()
    assert not any(name.startswith("_") for name in engines())
    assert exudyn.version().startswith("1.")


@pytest.mark.parametrize("route", exudyn.routes)
def test_ladder_has_six_rungs_or_more_that_tighten_every_knob(route):
    ladder = exudyn.ladder(cases.load("disc_in_circle"), route)
    assert len(ladder) >= 6
    assert ladder[0]["rung"] == "defaults"
    for coarse, fine in zip(ladder[1:], ladder[2:], strict=False):
        assert fine["h"] < coarse["h"] and fine["k"] > coarse["k"] and fine["vreg"] < coarse["vreg"]


@pytest.mark.parametrize("route", exudyn.routes)
def test_engine_defaults_take_a_hundred_steps_or_more_and_give_a_motion(route):
    case = cases.load("disc_in_circle", mu=0.1)
    motion = solve(case, route, rung=0)
    assert motion.cost.steps >= 100
    assert motion.slip_resolution == 1e-3
    # Coarse, and of the right kind: a penetration of a thousandth of the radius.
    assert end_of_slip(motion, after=0.05) == pytest.approx(FIRST_TRANSITION[0.1][0], abs=1e-2)


@pytest.mark.parametrize(
    ("case", "word"),
    [
        (Case(ellipse(1.0, 1.0), elliptic_plate(), FREE, Start(xi1=-2.5, xi2=-1.2), 1.0), "outline"),
        (Case(Curve(lambda s: (s, s * s)), disc(0.1, 1.0), FREE, Start(xi1=-1.0), 1.0), "track"),
        (hill(effects=(Gravity(G), CoulombFriction(0.1))), "Unilateral"),
        (hill(effects=(Gravity(G), CoulombFriction(0.1, mu_static=0.2), Pushes())), "mu_static"),
    ],
)
def test_native_route_refuses_in_one_sentence_that_names_what_is_missing(case, word):
    reason = exudyn.refuses(case, "native")
    assert word in reason
    assert reason.endswith(".") and reason.count(". ") == 0


def test_effect_nobody_modelled_is_refused_by_name_on_both_routes():
    class Magnetism:
        pass

    case = SimpleNamespace(effects=(Gravity(G), Magnetism()))
    for route in exudyn.routes:
        assert "Magnetism" in exudyn.refuses(case, route)


def test_integrator_route_takes_any_shape_and_a_track_that_pulls():
    assert exudyn.refuses(Case(ellipse(1.0, 1.0), elliptic_plate(), FREE, Start(-2.5, -1.2), 1.0), "integrator") is None
    assert exudyn.refuses(hill(effects=(Gravity(G),)), "integrator") is None


def test_unknown_route_is_told():
    with pytest.raises(UnknownName, match="native"):
        exudyn.refuses(cases.load("disc_in_circle"), "magic")


# The contact's own period is 2 ms; Runge–Kutta of order 4 at 10 ms is far outside its region of stability.
UNSTABLE = Setting.of(rung="unstable", solver="RK44", newton="full", h=1e-2, k=1e7, vreg=1e-3)
# A stiffness at which the penetration is below the rounding of the position: no Newton iteration can converge.
HOPELESS = Setting.of(rung="hopeless", solver="TrapezoidalIndex2", newton="full", h=1e-3, k=1e16, vreg=1e-9)


def test_explicit_run_that_blows_up_without_an_error_is_a_failure():
    with pytest.raises(EngineFailure, match="not finite"):
        solve(cases.load("disc_in_circle"), setting=UNSTABLE)


def test_engine_that_gives_up_is_a_failure_in_its_own_words():
    with pytest.raises(EngineFailure, match="terminated"):
        solve(cases.load("disc_in_circle", mu=0.1), setting=HOPELESS)


def test_run_leaves_no_files_and_prints_nothing(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    case = cases.load("disc_in_circle", mu=0.1)
    for route in exudyn.routes:
        solve(case, route, rung=2)
    for setting in (UNSTABLE, HOPELESS):
        with pytest.raises(EngineFailure):
            solve(case, setting=setting)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", exudyn.routes)
def test_same_case_gives_the_same_numbers_again(route):
    case = cases.load("disc_in_circle", mu=0.2)
    first, second = solve(case, route, rung=2), solve(case, route, rung=2)
    assert np.array_equal(first.t, second.t)
    assert np.array_equal(first.slip, second.slip)


def test_long_motion_is_sampled_at_most_so_often():
    setting = Setting.of(rung="long", solver="TrapezoidalIndex2", newton="full", h=5e-5, k=1e6, vreg=1e-4)
    motion = solve(cases.load("disc_in_circle", mu=0.1), setting=setting)
    assert motion.cost.steps >= 50_000
    # The engine writes a sample at the first step past each period.
    assert 15_000 < len(motion.t) <= exudyn.adapter.MOST_SAMPLES + 1
    assert motion.t[-1] == pytest.approx(2.5, abs=1e-9)


def test_steps_are_those_that_the_engine_took():
    """Newton's method fails at the kinks of the contact law, and the engine halves its steps there."""
    case = cases.load("eccentric_disc_on_line")
    setting = exudyn.ladder(case, "integrator")[4]
    motion = solve(case, "integrator", setting=setting)
    asked = round(case.duration / setting["h"])
    assert motion.cost.steps == pytest.approx(len(motion.t), abs=1)
    assert motion.cost.steps > 1.5 * asked
