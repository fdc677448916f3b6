"""Every adapter, once registered, obeys the laws of `adapters.laws`; and wrong ones are caught by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import adapters
from adapters import Setting
from adapters.laws import LAWS, MissingQuantity, Route, effects, judge, mechanics, scene
from adapters.laws.law_process import AdapterProcess
from cases import (
    Case,
    CoulombFriction,
    Gravity,
    Impact,
    Load,
    NotSupported,
    PerfectlyRough,
    Trajectory,
    Unilateral,
)
from cases.contact import start_motion
from cases.curves.line_or_circle import as_line
from cases.motion.mechanics import gravity

from . import mutant_list
from .mutants import Hashable, load, osculating

# What a law found wrong, until the adapter is right: (adapter, route, law) -> what was measured. Strict: a mended
# adapter fails here until its line is taken out.
KNOWN_FAULTS: dict[tuple[str, str, str], str] = {
    (
        "box2d",
        "native",
        "sticking_threshold",
    ): "0.1 % above the threshold slip is off by 0.00150 m/s after 1 s at h = 5e-4 s, 0.00141 is allowed: a rolling "
    "disc presses by m r omega domega/dt h / 2 too little, since the contact's spring follows the plate's own point",
    (
        "box2d",
        "native",
        "equations_of_motion[resisted disc]",
    ): "vy is off by 0.0221 m/s after 0.68 s at h = 5e-4 s, 0.0188 is allowed: the same force lacks, and two steps "
    "of gravity at the start",
}


def _scenes(law: str) -> list[str]:
    """The law's entries in LAWS: one, or one for each scene."""
    return [name for name in LAWS if name.partition("[")[0] == law]


def _routes(name: str) -> tuple[str, ...]:
    try:
        return adapters.engine(name).routes
    except ImportError:
        return ("",)


# They take seconds; the pile stands and moves apart in `test_exudyn_free_plates`, too.
LONG = ("equations_of_motion[off-centre disc in a valley]", "equations_of_motion[loaded disc in a valley]")
LONG_IN_EXUDYN = "pile_of_free_plates"


def _is_quick(place: int, name: str, law: str) -> bool:
    """Whether the quick tests hold an engine's route, the one at this place among all routes, to a law: in the first of
    the law's scenes, to the equations of motion, which have a scene for each effect, in most; to every other law, and
    the next route to those between. Laws of free plates, which few routes obey, hold for each of them."""
    family = law.partition("[")[0]
    if law in LONG or (name, law) == ("exudyn", LONG_IN_EXUDYN):
        return False
    if family != "equations_of_motion" and law != _scenes(family)[0]:
        return False
    return family.endswith("free_plates") or (place + tuple(LAWS).index(law)) % 2 == 0


def _all():
    routes = [(name, route) for name in adapters.engines() for route in _routes(name)]
    for place, (name, route) in enumerate(routes):
        for law in LAWS:
            fault = KNOWN_FAULTS.get((name, route, law))
            marks = [pytest.mark.xfail(strict=True, reason=fault)] if fault else []
            marks += [] if _is_quick(place, name, law) else [pytest.mark.slow]
            yield pytest.param(name, route, law, marks=marks, id=f"{name}-{route}-{law}")


@pytest.mark.parametrize(("name", "route", "law"), list(_all()))
def test_adapter_obeys_law(name, route, law):
    try:
        adapter = adapters.engine(name)
    except ImportError as problem:
        pytest.skip(f"{name} is not installed: {problem}")
    try:
        LAWS[law](Route(adapter, route))
    except (NotSupported, MissingQuantity) as reason:
        pytest.skip(str(reason))


# --- the tests bite --------------------------------------------------------------------------------------------------


def closed_form(read, refuses=lambda case, route: None):
    """An adapter whose answer is a formula: `read(case)`."""
    return Hashable(
        refuses=refuses,
        ladder=lambda case, route: (Setting.of(), Setting.of()),
        build=lambda case, route, setting: case,
        run=lambda model: None,
        read=read,
    )


def sliding_disc(torque: float = 1.0):
    """The textbook's formula for a disc that slides on a level line; `torque`: share of r T."""

    def refuses(case: Case, route: str) -> str | None:
        line = as_line(case.track)
        return None if line and line.direction[1] == 0.0 and case.plate.radius else "It knows level lines alone."

    def read(case: Case) -> Trajectory:
        friction, gravity, start = case.effect(CoulombFriction), case.effect(Gravity), start_motion(case)
        assert friction and gravity
        plate, radius = case.plate, case.plate.radius
        t = np.linspace(0.0, case.duration, 1001)
        one, decay = np.ones_like(t), friction.mu * gravity.g * t
        spin = torque * plate.mass * radius / plate.inertia
        x = start.x + start.vx * t - 0.5 * decay * t
        return Trajectory(
            t=t, x=x, y=start.y * one, theta=start.theta - 0.5 * spin * decay * t,
            vx=start.vx - decay, vy=0.0 * t, omega=-spin * decay, slip=start.vx - decay - radius * spin * decay,
            normal_force=plate.mass * gravity.g * one, friction_force=-friction.mu * plate.mass * gravity.g * one,
            xi1=x, xi2=start.xi2 - (start.theta - 0.5 * spin * decay * t),
        )  # fmt: skip

    return closed_form(read, refuses)


def falling_disc(spoil=lambda motion: motion):
    """The parabola of a plate in flight, spoiled."""

    def read(case: Case) -> Trajectory:
        start, (_, pull) = start_motion(case), gravity(case)
        t = np.linspace(0.0, case.duration, 1001)
        none, zero, one = np.full_like(t, np.nan), np.zeros_like(t), np.ones_like(t)
        return spoil(Trajectory(
            t=t, x=start.x + start.vx * t, y=start.y + start.vy * t + 0.5 * pull * t**2,
            theta=start.theta + start.omega * t, vx=start.vx * one, vy=start.vy + pull * t,
            omega=start.omega * one, slip=none, normal_force=zero, friction_force=zero, xi1=none, xi2=none,
        ))  # fmt: skip

    return closed_form(read)


def mutant(change=lambda model: None, spoil=lambda case, motion: motion):
    """pymunk's assisted route with `change(model)` done to what it builds, `spoil(case, motion)` to what it reads."""
    pymunk = pytest.importorskip("adapters.pymunk")

    def build(case: Case, route: str, setting: Setting):
        model = pymunk.build(case, route, setting)
        change(model)
        return model

    return Hashable(
        refuses=pymunk.refuses,
        ladder=pymunk.ladder,
        build=build,
        run=pymunk.run,
        read=lambda model: spoil(model.case, pymunk.read(model)),
    )


def never_turning(model) -> None:
    """Friction without torque: the engine is given a plate that nothing turns."""
    model.bodies[0].moment *= 1e6


def half_the_friction(model) -> None:
    """The trap of engines that multiply two coefficients, of which one was left at a half."""
    for shape in model.space.shapes:
        shape.friction *= 0.5**0.5


def stronger_gravity(model) -> None:
    """Gravity of another planet, 3 % stronger than the case's."""
    gx, gy = model.space.gravity
    model.space.gravity = 1.03 * gx, 1.03 * gy


def spoiled(**columns):
    """A mutant whose columns are changed after the fact: name=function of the motion."""
    return mutant(spoil=lambda case, m: replace(m, **{name: change(m) for name, change in columns.items()}))


def drifting():
    """Five centimetres a second are added along X, whichever way the scene lies."""
    return spoiled(x=lambda m: m.x + 0.05 * m.t)


def of_another(change, route: str = "assisted"):
    """pymunk with the case replaced by `change(case)`: an effect that is claimed and modelled by another law."""
    pymunk = pytest.importorskip("adapters.pymunk")
    return Hashable(
        refuses=lambda case, _: pymunk.refuses(change(case), route),
        ladder=lambda case, _: pymunk.ladder(change(case), route),
        build=lambda case, _, setting: pymunk.build(change(case), route, setting),
        run=pymunk.run,
        read=pymunk.read,
    )


def other_effects(*others, route: str = "assisted"):
    """pymunk with effects in the place of the case's of their kind, or beside them; a type alone is left out."""

    def change(case: Case) -> Case:
        kinds = tuple(other if isinstance(other, type) else type(other) for other in others)
        kept = tuple(effect for effect in case.effects if not isinstance(effect, kinds))
        return replace(case, effects=(*kept, *(other for other in others if not isinstance(other, type))))

    return of_another(change, route)


def never_slowed():
    """A disc that rolls on for ever, whatever couple resists it."""

    def read(case: Case) -> Trajectory:
        start, t = start_motion(case), np.linspace(0.0, case.duration, 1001)
        one, zero = np.ones_like(t), np.zeros_like(t)
        return Trajectory(
            t=t, x=start.x + start.vx * t, y=start.y * one, theta=start.theta + start.omega * t, vx=start.vx * one,
            vy=zero, omega=start.omega * one, slip=zero, normal_force=one, friction_force=zero,
            xi1=start.xi1 + start.vx * t, xi2=start.xi2 - start.omega * t,
        )  # fmt: skip

    return closed_form(read)


# Law, what its message begins with, and an adapter that breaks it.
MUTANTS = [
    ("on_its_track", "on its track: the gap", lambda: spoiled(y=lambda m: m.y + 0.01 * m.t)),
    ("on_its_track", "on its track: the slip", lambda: spoiled(slip=lambda m: m.slip + 0.2)),
    ("load", "load: vx", lambda: other_effects(Load)),
    ("load", "load: vx", lambda: of_another(load(lambda p, c: p | {"fx": 1.1 * p["fx"]}))),
    ("load", "load: omega", lambda: of_another(load(lambda p, c: p | {"moment": 1.1 * p["moment"]}))),
    ("bounce", "bounce: the height", lambda: other_effects(Impact(0.46), route="native")),
    ("bounce_with_friction", "bounce with friction: vx", lambda: other_effects(CoulombFriction(0.11), route="native")),
    ("bounce_with_friction", "bounce with friction: vx", lambda: other_effects(Impact(0.4), route="native")),
    ("landing", "landing: vx", lambda: other_effects(CoulombFriction(0.11))),
    ("perfectly_rough", "perfectly rough: the spin", lambda: other_effects(PerfectlyRough, CoulombFriction(0.3))),
    ("guide", "guide: the end of the motion", lambda: other_effects(Unilateral())),
    ("guide", "guide: the normal force", lambda: spoiled(normal_force=lambda m: np.abs(m.normal_force))),
    ("rolling_resistance", "rolling resistance: the spin", never_slowed),
    ("friction_torque", "friction torque: the spin", lambda: sliding_disc(torque=0.0)),
    ("friction_torque", "friction torque: the spin", lambda: mutant(never_turning)),
    ("sticking_threshold", "sticking threshold", lambda: mutant(half_the_friction)),
    ("sticking_threshold", "sticking threshold", lambda: spoiled(slip=lambda m: m.slip + 2e-3 * m.t)),
    ("no_friction_no_spin", "no spin-up", lambda: spoiled(omega=lambda m: m.omega * (1 + 1e-6 * m.t))),
    ("lift_off", "lift-off: cos phi", lambda: spoiled(xi1=lambda m: m.xi1 + 0.02)),
    ("lift_off", "lift-off: the motion should end", lambda: spoiled(status=lambda m: "completed")),
    ("free_fall", "free fall: vy", lambda: falling_disc(lambda m: replace(m, vy=1.01 * m.vy))),
    ("free_fall", "free fall: x", lambda: falling_disc(lambda m: replace(m, x=m.x * (1 - 1e-3 * m.t)))),
    ("free_fall", "free fall: omega", lambda: falling_disc(lambda m: replace(m, omega=m.omega * (1 - 0.04 * m.t)))),
    ("cone", "cone: friction", lambda: spoiled(friction_force=lambda m: 1.1 * m.friction_force)),
    ("cone", "cone: the normal force", lambda: spoiled(normal_force=lambda m: -m.normal_force)),
    ("friction_opposes_slip", "friction opposes slip", lambda: mutant(half_the_friction)),
    ("friction_opposes_slip", "friction opposes slip", lambda: spoiled(friction_force=lambda m: -m.friction_force)),
    ("energy_conservation", "energy conservation", lambda: mutant(stronger_gravity)),
    (
        "energy_never_grows",
        "energy never grows",
        lambda: spoiled(vx=lambda m: m.vx * (1 + 2 * m.t), vy=lambda m: m.vy * (1 + 2 * m.t)),
    ),
    ("mirror_image", "mirror image: the centre", drifting),
    ("turn_frame", "turned frame: the centre", drifting),
    ("momentum_balance", "momentum balance: m v", lambda: spoiled(normal_force=lambda m: 1.05 * m.normal_force)),
    ("momentum_balance", "momentum balance: J omega", lambda: mutant(never_turning)),
]


FIRST = {law: i for i, (law, *_) in reversed([*enumerate(MUTANTS)])}
IDS = [f"{law}-{i}" for i, (law, *_) in enumerate(MUTANTS)]
every_mutant = pytest.mark.parametrize(("law", "words", "wrong"), MUTANTS, ids=IDS)


@pytest.mark.parametrize(
    ("law", "words", "wrong"),
    [
        pytest.param(*one, id=IDS[i], marks=() if i in FIRST.values() else pytest.mark.slow)
        for i, one in enumerate(MUTANTS)
    ],
)
def test_wrong_adapter_fails_its_law_by_name(law, words, wrong):
    """In the first of the law's scenes; of the wrong adapters of one law the first is quick."""
    with pytest.raises(AssertionError, match=f"^{words}"):
        LAWS[_scenes(law)[0]](Route(wrong(), "assisted"))


@pytest.mark.slow
@every_mutant
def test_wrong_adapter_fails_its_law_in_every_scene(law, words, wrong):
    for name in _scenes(law):
        with pytest.raises(AssertionError, match=f"^{words}"):
            LAWS[name](Route(wrong(), "assisted"))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("column", ["normal_force", "friction_force"])
def test_what_an_engine_does_not_tell_is_neither_kept_nor_broken(column):
    silent = spoiled(**{column: lambda m: np.full_like(m.t, np.nan)})
    laws = ["cone[disc in a circle]", "friction_opposes_slip[disc in a circle]", "momentum_balance[disc in a circle]"]
    verdicts = list(judge(silent, [*laws, "friction_torque", "no_friction_no_spin"], ["assisted"]))
    output = f"it reports no {column.replace('_', ' ')}"
    assert [(v.outcome, v.reason) for v in verdicts[:3]] == [("not reported", output)] * 3
    assert [v.outcome for v in verdicts[3:]] == ["kept", "kept"]


def test_a_hole_in_what_is_told_is_no_way_round_a_law():
    holed = spoiled(friction_force=lambda m: np.where(m.t > 0.5, np.nan, 1.2 * m.friction_force))
    (verdict,) = judge(holed, ["cone[disc in a circle]"], ["assisted"])
    assert verdict.outcome == "broken" and "is no number (" in verdict.reason and "nan" not in verdict.reason


def test_a_solver_that_bends_its_tracks_to_circles_is_caught_where_the_curvature_changes():
    drawn = ("on_its_track", "momentum_balance")
    laws = [law for law in LAWS if law.partition("[")[0] in drawn]
    broken = [v.law for v in judge(of_another(osculating), laws, ["assisted"]) if v.outcome == "broken"]
    assert "on_its_track[disc in a valley]" in broken and "momentum_balance[disc in a valley]" in broken
    # Where tracks are circles there is nothing to find.
    assert not any("circle" in law or "hill" in law or "[" not in law for law in broken)


@pytest.mark.parametrize("name", adapters.engines())
def test_every_effect_that_an_adapter_claims_has_a_law(name):
    try:
        claimed = adapters.engine(name).adapter.KNOWN_EFFECTS
    except ImportError as problem:
        pytest.skip(f"{name} is not installed: {problem}")
    except AttributeError:
        claimed = adapters.engine(name).KNOWN_EFFECTS
    laws = {law.partition("[")[0] for law in LAWS}
    for effect in claimed:
        assert effects.OF_EFFECT[effect] and laws >= {*effects.OF_EFFECT[effect]}


def test_every_law_has_a_wrong_adapter_that_it_catches():
    caught = {law for law, *_ in MUTANTS} | {mutant.law.partition("[")[0] for mutant in mutant_list.MUTANTS}
    assert caught == {name.partition("[")[0] for name in LAWS}


@pytest.mark.parametrize(("law", "right"), [("friction_torque", sliding_disc), ("free_fall", falling_disc)])
def test_textbook_formula_passes_its_law(law, right):
    LAWS[law](Route(right(), "closed form"))


@pytest.mark.parametrize("seed", [0, pytest.param(range(1, 12), marks=pytest.mark.slow)])
def test_pymunks_hops_before_it_leaves_a_hill_are_as_long_as_derived(seed):
    """Its contact acts in single steps, so it leaves up to a term of order √h early (`adapters.laws.mechanics`)."""
    pymunk = pytest.importorskip("adapters.pymunk")
    for each in [seed] if isinstance(seed, int) else seed:
        for fine in (0, 1, 2, 3):
            finer = Hashable(**{name: getattr(pymunk, name) for name in ("refuses", "build", "run", "read")})
            finer.ladder = lambda case, route, fine=fine: pymunk.ladder(case, route)[
                : len(pymunk.ladder(case, route)) - fine
            ]
            LAWS["lift_off"](Route(finer, "native", each))


def test_refusal_is_no_pass():
    with pytest.raises(NotSupported, match="level lines alone"):
        mechanics.cone(Route(sliding_disc(), "closed form"), scene("disc in a circle"))


@pytest.mark.builds
@pytest.mark.parametrize(
    ("fault", "outcome"),
    [
        ("os.kill(os.getpid(), 11)", "crashed"),
        pytest.param("time.sleep(60)", "timed_out", marks=pytest.mark.slow),
        pytest.param("sys.exit(0)", "crashed", marks=pytest.mark.slow),
    ],
)
def test_an_adapter_that_ends_its_process_costs_one_verdict_and_no_other(fault, outcome, tmp_path):
    # It fails on frictionless scenes alone.
    file = tmp_path / "unruly.py"
    file.write_text(
        "import os, sys, time\nfrom cases import CoulombFriction\nfrom adapters.pymunk import *\n"
        "from adapters.pymunk import build as built\n\n\n"
        "def build(case, route, setting):\n"
        f"    if case.effect(CoulombFriction) is None:\n        {fault}\n"
        "    print('noise')\n    return built(case, route, setting)\n"
    )
    laws = ["friction_torque", "no_friction_no_spin", "cone[disc in a circle]"]
    # s: what ends its process does so at once. The one that sleeps costs the limit, which is room for a busy machine.
    with AdapterProcess(str(file), limit=20.0) as adapter:
        tried = list(adapter.try_laws("native", laws))
    assert [result for _, result, _ in tried] == ["kept", outcome, "kept"], tried


@pytest.mark.slow
def test_an_adapter_whose_import_ends_the_process_is_one_sentence(tmp_path):
    file = tmp_path / "dies.py"
    file.write_text("import os\nos._exit(3)\n")
    with pytest.raises(ImportError, match="crashed while it is imported: its process ended with exit code 3"):
        AdapterProcess(str(file))
