"""pymunk on scenes whose answers are known: closed forms, the paper's application, and the reference for the rest."""

from __future__ import annotations

from itertools import pairwise
from math import acos, cos, sin, tan

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, Setting, engine
from cases import Case, CoulombFriction, Curve, Gravity, Plate, Start, Trajectory, Unilateral, curves, disc
from tests.authorities.paper_application import FIRST_TRANSITION, SEQUENCE
from tests.scenes.elliptic import ellipse

G, PUSH = Gravity(9.81), Unilateral()
adapter = engine("pymunk")


# --- helpers ---------------------------------------------------------------------------------------------------------


def rung(case: Case, route: str, h: float) -> Setting:
    """The setting of the case's ladder with that step."""
    return next(s for s in adapter.ladder(case, route) if s["h"] == h)


def play(case: Case, route: str, setting: Setting) -> Trajectory:
    model = adapter.build(case, route, setting)
    adapter.run(model)
    return adapter.read(model)


def motion(case: Case, route: str, h: float) -> Trajectory:
    return play(case, route, rung(case, route, h))


def first_zero_of_slip(moved: Trajectory, degree: int = 3) -> float:
    """Where a polynomial through the last 50 ms before the slip's first change of sign meets zero.

    The last two samples are left out: their velocities are means over the transition. The first is a hard start.
    A cubic evens out what facets scatter and is good to 2e-7 s; a smooth slip deserves a higher degree.
    """
    t, v = moved.t, moved.slip
    over = 3 + int(np.argmax(v[3:] * v[3] <= abs(v[3]) * moved.slip_resolution))
    branch = slice(max(1, over - 2 - round(0.05 / t[1])), over - 2)
    fit = np.polynomial.Polynomial.fit(t[branch], v[branch], degree)
    roots = [float(r.real) for r in fit.roots() if abs(r.imag) < 1e-9]
    return min(roots, key=lambda r: abs(r - t[over]))


def orders(errors, steps) -> np.ndarray:
    """Observed orders of convergence between neighbours."""
    return np.diff(np.log(np.abs(errors))) / np.diff(np.log(steps))


def elliptic_plate(a: float = 0.15, b: float = 0.1) -> Plate:
    return Plate(ellipse(a, b), 1.0, (a * a + b * b) / 4)


def ellipse_in_circle(mu: float = 0.2) -> Case:
    friction = (CoulombFriction(mu),) if mu else ()
    return Case(ellipse(1.0, 1.0), elliptic_plate(), (G, *friction, PUSH), Start(-1.2, 0.3), duration=1.0)


def ellipse_on_line() -> Case:
    track = Curve(lambda s: (s, 0))
    return Case(track, elliptic_plate(), (G, CoulombFriction(0.2), PUSH), Start(0.0, -1.2, slip=1.0), duration=0.7)


def disc_on_parabola(duration: float = 0.7, domain=(-3, 3)) -> Case:
    track = Curve(lambda s: (s, s * s), domain=domain)
    return Case(track, disc(0.1, 1.0), (G, CoulombFriction(0.1), PUSH), Start(-1.0), duration)


def disc_on_hill(*effects, duration: float = 1.2) -> Case:
    """A disc let go 0.1 rad from the top of a circle of radius 1."""
    track = Curve(lambda s: (curves.sin(s), curves.cos(s)))
    return Case(track, disc(0.1, 1.0), (G, *effects), Start(0.1), duration)


def distance(case: Case, moved: Trajectory) -> float:
    """Largest distance (m) of the centre from where the reference has it."""
    t = np.linspace(0.0, case.duration, 40)
    here, there = moved(t), reference.simulate(case, rtol=1e-10, method="dop853")(t)
    return float(np.hypot(here.x - there.x, here.y - there.y).max())


# --- refusals and settings -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("route", adapter.routes)
def test_what_the_engine_lacks_is_refused_in_one_sentence_that_names_it(route):
    case = Case(ellipse(1.0, 1.0), disc(0.1, 1.0), (G, CoulombFriction(0.1, mu_static=0.2), PUSH), Start(0.0), 1.0)
    reason = adapter.refuses(case, route)
    assert "coefficient" in reason and reason.endswith(".") and reason.count(". ") == 0


def test_native_refuses_a_guide_on_both_sides():
    assert "bilateral guide" in adapter.refuses(disc_on_hill(), "native")
    assert adapter.refuses(disc_on_hill(), "assisted") is None


def bean_on_line() -> Case:
    """A plate with a waist, rocking on a line."""
    bean = Curve(
        lambda s: ((0.1 + 0.04 * curves.cos(2 * s)) * curves.cos(s), (0.1 + 0.04 * curves.cos(2 * s)) * curves.sin(s))
    )
    effects = (G, CoulombFriction(0.5), PUSH)
    return Case(Curve(lambda s: (s, 0)), Plate(bean, 1.0, 0.004), effects, Start(0.0, xi2=0.05), 0.4)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "case",
    [bean_on_line(), *map(cases.load, ("superellipse_on_hill", "straight_edge_on_catenary", "spiral_on_incline"))],
    ids=["a waist", "flat for an instant", "straight and open", "curved and open"],
)
def test_any_outline_is_made_of_the_engine_s_shapes(case):
    exact = reference.simulate(case)
    off = [
        float(np.hypot(moved.x[-1] - end.x, moved.y[-1] - end.y))
        for moved in (play(case, "native", adapter.ladder(case, "native")[place]) for place in (2, 4))
        for end in [exact(min(moved.t[-1], exact.t[-1]))]
    ]
    # A hundredth of the plate's size, with facets and corners of a thousandth.
    assert off[1] < 0.05 * case.plate.reach, off


@pytest.mark.parametrize(
    "case",
    [
        cases.load("disc_in_circle"),
        cases.load("disc_in_circle", duration=20.0),
        ellipse_in_circle(),
        ellipse_on_line(),
        disc_on_hill(PUSH),
    ],
)
@pytest.mark.parametrize("route", adapter.routes)
def test_ladder_goes_from_coarse_to_fine_and_begins_with_the_engine_as_it_comes(case, route):
    settings = adapter.ladder(case, route)
    knobs = [dict(s) for s in settings]
    assert len(settings) >= 6
    assert all(coarse["h"] > fine["h"] for coarse, fine in pairwise(knobs))
    for count in ("facets", "vertices"):
        assert all(coarse.get(count, 0) <= fine.get(count, 0) for coarse, fine in pairwise(knobs))
    assert knobs[0]["rung"] == "defaults"
    assert not {"collision_slop", "collision_bias", "iterations"} & knobs[0].keys()


# --- straight tracks: exact ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("route", adapter.routes)
@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_bowling_rolls_at_the_exact_time_with_two_thirds_of_its_speed(route, mu, accuracy):
    case = cases.load("disc_on_line", mu=mu)
    moved = motion(case, route, 2e-3)
    exact = 1.0 / (3 * mu * 9.81)
    slipping = moved.t < exact - 2 * moved.t[1]
    slope, first = np.polyfit(moved.t[slipping], moved.slip[slipping], 1)
    # Constant forces: semi-implicit Euler has no error here, only the rounding of a few hundred steps.
    row = dict(case=case.label, solver="pymunk", route=route, tolerance=1e-12)
    accuracy(**row, quantity="transition time (s)", error=-first / slope - exact)
    accuracy(**row, quantity="final speed (m/s)", error=moved.vx[-1] - 2 / 3)
    assert np.abs(moved.slip[moved.t > exact + 2 * moved.t[1]]).max() <= 1e-14


@pytest.mark.parametrize("route", adapter.routes)
@pytest.mark.parametrize("slope", [0.2, 0.4, -0.4])
def test_incline_rolls_where_tan_slope_is_within_three_mu_and_slips_else(route, slope):
    case = cases.load("disc_on_incline", slope=slope, mu=0.1)
    moved = motion(case, route, 2e-3)
    rolls = abs(tan(slope)) <= 0.3
    pull = 2 / 3 * 9.81 * sin(slope) if rolls else 9.81 * (sin(slope) - np.sign(slope) * 0.1 * cos(slope))
    assert moved.xi1[-1] == pytest.approx(pull * case.duration**2 / 2, abs=1e-12)
    assert (abs(moved.slip[-1]) < 1e-13) == rolls
    assert moved.normal_force[1:] == pytest.approx(9.81 * cos(slope), abs=1e-9)


def test_tilting_the_whole_scene_changes_nothing():
    def scene(turn: float) -> Case:
        c, s = cos(turn), sin(turn)
        track = Curve(lambda p: (0.3 + c * p - 0.2 * s, -0.7 + s * p + 0.2 * c))
        effects = (Gravity(9.81, turn - np.pi / 2), CoulombFriction(0.2), PUSH)
        return Case(track, disc(0.1, 2.0), effects, Start(0.5, slip=-1.0, omega=3.0), 0.4)

    level, tilted = motion(scene(0.0), "native", 2e-3), motion(scene(2.0), "native", 2e-3)
    for name in ("slip", "omega", "xi1", "normal_force", "friction_force"):
        assert getattr(tilted, name) == pytest.approx(getattr(level, name), abs=1e-9)


# --- the paper's application -----------------------------------------------------------------------------------------

# Errors of the first transition at the finest rung used here, twice what was measured.
NATIVE_TRANSITION = {0.01: 4e-4, 0.1: 1e-4, 0.2: 5e-5}
ASSISTED_TRANSITION = {0.01: 9e-7, 0.1: 6e-7, 0.2: 4e-7}


@pytest.mark.sampled(3, first=2)
@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_native_meets_the_first_transition_of_the_paper(mu, accuracy):
    case = cases.load("disc_in_circle", mu=mu)
    error = first_zero_of_slip(motion(case, "native", 2e-4)) - FIRST_TRANSITION[mu][0]
    row = dict(case=case.label, solver="pymunk", route="native", quantity="first transition (s)")
    accuracy(**row, error=error, tolerance=NATIVE_TRANSITION[mu])


@pytest.mark.slow
def test_native_at_its_finest_is_within_a_ten_thousandth_of_a_second(accuracy):
    case = cases.load("disc_in_circle", mu=0.01, duration=1.2)
    error = first_zero_of_slip(play(case, "native", adapter.ladder(case, "native")[-1])) - FIRST_TRANSITION[0.01][0]
    row = dict(case=case.label, solver="pymunk", route="native", quantity="first transition, finest (s)")
    accuracy(**row, error=error, tolerance=1e-4)


def test_native_converges_with_order_one():
    case, steps = cases.load("disc_in_circle", mu=0.01, duration=1.2), (2e-3, 1e-3, 5e-4, 2e-4)
    errors = [first_zero_of_slip(motion(case, "native", h)) - FIRST_TRANSITION[0.01][0] for h in steps]
    assert orders(errors, steps) == pytest.approx(1.0, abs=0.3)


@pytest.mark.sampled(3, first=2)
@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_assisted_meets_the_first_transition_with_order_two(mu, accuracy):
    case, steps = cases.load("disc_in_circle", mu=mu, duration=1.2), (4e-3, 2e-3, 1e-3, 5e-4)
    errors = [first_zero_of_slip(motion(case, "assisted", h), degree=5) - FIRST_TRANSITION[mu][0] for h in steps]
    assert orders(errors, steps) == pytest.approx(2.0, abs=0.3)
    row = dict(case=case.label, solver="pymunk", route="assisted", quantity="first transition (s)")
    accuracy(**row, error=errors[-1], tolerance=ASSISTED_TRANSITION[mu])


def signs_of_slip(moved: Trajectory) -> list[tuple[int, float]]:
    """Runs of forward (1), backward (-1) or no slip (0) of at least five samples, each with its first time."""
    signs = np.where(np.abs(moved.slip) > 2 * moved.slip_resolution, np.sign(moved.slip), 0).astype(int)
    edges = [0, *(np.flatnonzero(np.diff(signs)) + 1), len(signs)]
    runs: list[tuple[int, float]] = []
    for a, b in pairwise(edges):
        if b - a >= 5 and (not runs or runs[-1][0] != signs[a]):
            runs.append((int(signs[a]), float(moved.t[a])))
    return runs


def test_assisted_finds_the_four_transitions_of_the_rolling_disc():
    moved = motion(cases.load("disc_in_circle", mu=0.2), "assisted", 5e-4)
    runs = [run for run in signs_of_slip(moved) if run[1] > 0.1 or run[0]]
    assert [sign for sign, _ in runs] == [1, 0, -1, 0, 1]
    # Slip sets in with zero slope: a threshold sees it late, by some steps.
    assert [when for _, when in runs[1:]] == pytest.approx([time for time, *_ in SEQUENCE[:4]], abs=5e-3)


@pytest.mark.parametrize(("route", "h"), [("native", 5e-4), ("assisted", 1e-3)])
def test_creep_in_stick_stays_below_the_slip_resolution(route, h):
    moved = motion(cases.load("disc_in_circle", mu=0.2, duration=0.9), route, h)
    rolling = (moved.t > 0.65) & (moved.t < 0.88)
    assert 0.0 < np.percentile(np.abs(moved.slip[rolling]), 99) <= moved.slip_resolution < 0.01


# --- forces ----------------------------------------------------------------------------------------------------------


def test_friction_spins_a_sliding_disc_up_by_its_torque():
    for route in adapter.routes:
        moved = motion(cases.load("disc_in_circle", mu=0.1, duration=0.6), route, 5e-4)
        # Before the first facet bears there is no force; then every step turns the disc the same way.
        assert np.all(np.diff(moved.omega[moved.t > 0.02]) < 0.0)
        # The track's tangent turns left inside a circle: friction at the lever r turns the disc by r T / J.
        spun = np.sum(moved.friction_force) * moved.t[1] * 0.1 / (0.5 * 0.1**2)
        assert spun == pytest.approx(moved.omega[-1], rel=5e-3)


@pytest.mark.parametrize("case", [cases.load("disc_in_circle", mu=0.2), ellipse_in_circle(), disc_on_parabola()])
def test_friction_force_stays_inside_cone(case):
    moved, mu = motion(case, "assisted", 1e-3), case.effect(CoulombFriction).mu
    assert np.all(moved.normal_force >= -1e-9)
    assert np.all(np.abs(moved.friction_force) <= mu * moved.normal_force + 1e-8)


def test_force_read_from_the_momentum_is_the_engines_own_impulse():
    case = cases.load("disc_in_circle", mu=0.1, duration=0.2)
    model = adapter.build(case, "native", rung(case, "native", 1e-3))
    impulses: list[tuple[float, float]] = []
    model.space.on_collision(2, 1, post_solve=lambda arbiter, space, data: impulses.append(arbiter.total_impulse))
    adapter.run(model)
    # The plate touches in the first step, of h/2. The second, of h, begins with twice that impulse and reports it once:
    # its velocity changes by 3.184e-7 m/s, of which the engine tells 1.592e-7.
    output = np.hypot(*np.sum([*impulses, impulses[0]], axis=0))
    moved = adapter.read(model)
    kicks = np.full(len(moved.t), model.h)
    kicks[0] /= 2
    force = moved.normal_force * case.track.normal(moved.xi1) + moved.friction_force * case.track.tangent(moved.xi1)
    assert np.hypot(*np.sum(kicks * force, axis=1)) == pytest.approx(output, rel=1e-9)


# --- other curves and plates -----------------------------------------------------------------------------------------


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "case", [ellipse_in_circle(), ellipse_in_circle(mu=0.0), disc_on_parabola(), ellipse_on_line()]
)
def test_assisted_follows_any_curve_and_plate_with_order_two(case, accuracy):
    # 2e-3 is half of 4e-3, and steps and transitions meet differently: the mean order over two halvings is judged.
    steps = (4e-3, 1e-3)
    errors = [distance(case, motion(case, "assisted", h)) for h in steps]
    assert orders(errors, steps) == pytest.approx(2.0, abs=0.3)
    row = dict(case=repr(case.start), solver="pymunk", route="assisted", quantity="distance (m)")
    accuracy(**row, error=errors[-1], tolerance=1e-5)


@pytest.mark.parametrize(
    ("case", "h", "tolerance"), [(disc_on_parabola(), 2e-4, 2e-3), (ellipse_on_line(), 5e-4, 2e-3)]
)
def test_native_segments_and_polygons_stay_near_the_reference(case, h, tolerance, accuracy):
    error = distance(case, motion(case, "native", h))
    row = dict(case=repr(case.start), solver="pymunk", route="native", quantity="distance (m)")
    accuracy(**row, error=error, tolerance=tolerance)


def test_assisted_contact_stays_closed():
    case = ellipse_in_circle()
    moved = motion(case, "assisted", 1e-3)
    gap = cases.contact.follow(case, moved.x, moved.y, moved.theta)[2]
    assert np.abs(gap).max() < 1e-7


# --- what ends a motion ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("route", "h", "tolerance"), [("native", 1e-3, 0.04), ("assisted", 1e-3, 2e-3)])
def test_frictionless_disc_leaves_the_cylinder_where_energy_says(route, h, tolerance, accuracy):
    moved = motion(disc_on_hill(PUSH), route, h)
    assert moved.status == "lift_off" and moved.reason.endswith(".")
    assert moved.t[-1] < 1.2
    # N = 0 where v² = g L cos φ, and v² = 2 g L (cos 0.1 − cos φ).
    error = moved.xi1[-1] - acos(2 / 3 * cos(0.1))
    accuracy(
        case="disc on hill",
        solver="pymunk",
        route=route,
        quantity="angle of lift-off",
        error=error,
        tolerance=tolerance,
    )


@pytest.mark.parametrize("route", adapter.routes)
def test_disc_hung_below_its_track_leaves_it_at_once(route):
    ceiling = Curve(lambda s: (-s, 0))
    moved = motion(Case(ceiling, disc(0.1, 1.0), (G, PUSH), Start(0.0, slip=1.0), 0.5), route, 1e-3)
    assert (moved.status, moved.t[-1]) == ("lift_off", 0.0)


def test_guide_on_both_sides_holds_the_disc_beyond_lift_off():
    moved = motion(disc_on_hill(), "assisted", 1e-3)
    assert moved.status == "completed" and moved.normal_force.min() < -10.0
    energy = 0.5 * (moved.vx**2 + moved.vy**2) + 9.81 * moved.y
    assert np.ptp(energy) < 1e-4 * 9.81


@pytest.mark.parametrize("route", adapter.routes)
def test_motion_ends_where_the_track_does(route):
    moved = motion(disc_on_parabola(domain=(-1.2, 0.3), duration=1.0), route, 1e-3)
    assert moved.status == "track_end"
    assert 0.28 < moved.xi1[-1] <= 0.3


def test_disc_that_sinks_through_a_coarse_polygon_is_told():
    case = cases.load("disc_in_circle", mu=0.01)
    # The engine's own slop, a tenth of a metre, is the disc's radius.
    moved = play(case, "native", Setting.of(h=1 / 60, facets=64, neighbors=1, thickness=0.1))
    assert moved.status == "fell_through"
    assert len(moved.t) < 150


@pytest.mark.parametrize("route", adapter.routes)
def test_numbers_that_are_not_finite_are_a_failure_and_no_motion(route):
    case = cases.load("disc_in_circle", duration=0.1)
    model = adapter.build(case, route, rung(case, route, 4e-3))
    model.bodies[0].velocity = (float("nan"), 0.0)
    adapter.run(model)
    with pytest.raises(EngineFailure, match="not finite"):
        adapter.read(model)


@pytest.mark.parametrize("route", adapter.routes)
def test_nothing_is_printed(route, capfd):
    motion(ellipse_in_circle(), route, 4e-3)
    assert capfd.readouterr() == ("", "")


def test_a_chain_that_would_fill_the_memory_is_refused():
    pymunk, case = engine("pymunk"), cases.load("nearly_conforming", gap=1e-8)
    fine = pymunk.ladder(case, "native")[3]
    assert fine["facets"] > 10**6
    with pytest.raises(cases.NotSupported, match="needs .* facets, .* give a coarser setting"):
        pymunk.build(case, "native", fine)
