"""Every adapter, once registered, obeys the laws of `adapters.laws`."""

from __future__ import annotations

import numpy as np
import pytest

import adapters
from adapters.laws import LAWS, MissingQuantity, Route, effects, judge
from adapters.laws.law_process import AdapterProcess
from cases import NotSupported
from tests.sampling import quick_every

from .engines import routes
from .mutants import of_case, of_motion

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


# They take seconds; Exudyn's pile stands and moves apart in `test_free_plates`, too.
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
    for place, (name, route) in enumerate(routes()):
        for law in LAWS:
            fault = KNOWN_FAULTS.get((name, route, law))
            marks = [pytest.mark.xfail(strict=True, reason=fault)] if fault else []
            marks += [] if _is_quick(place, name, law) else [pytest.mark.slow]
            yield pytest.param(name, route, law, marks=marks, id=f"{name}-{route}-{law}")


@pytest.mark.parametrize(("name", "route", "law"), list(_all()))
def test_adapter_obeys_law(name, route, law):
    try:
        LAWS[law](Route(adapters.engine(name), route))
    except (NotSupported, MissingQuantity) as reason:
        pytest.skip(str(reason))


# --- verdicts (`test_mutants` has the wrong adapters) -----------------------------------------------------------------


@quick_every(2)
@pytest.mark.parametrize("column", ["normal_force", "friction_force"])
def test_what_an_engine_does_not_tell_is_neither_kept_nor_broken(column):
    silent = of_motion(**{column: lambda m: np.full_like(m.t, np.nan)})
    laws = ["cone[disc in a circle]", "friction_opposes_slip[disc in a circle]", "momentum_balance[disc in a circle]"]
    verdicts = list(judge(silent, [*laws, "friction_torque", "no_friction_no_spin"]))
    output = f"it reports no {column.replace('_', ' ')}"
    assert [(v.outcome, v.reason) for v in verdicts[:3]] == [("not reported", output)] * 3
    assert [v.outcome for v in verdicts[3:]] == ["kept", "kept"]


def test_a_hole_in_what_is_told_is_no_way_round_a_law():
    holed = of_motion(friction_force=lambda m: np.where(m.t > 0.5, np.nan, 1.2 * m.friction_force))
    (verdict,) = judge(holed, ["cone[disc in a circle]"])
    assert verdict.outcome == "broken" and "is no number (" in verdict.reason and "nan" not in verdict.reason


def test_a_refusal_is_no_pass():
    refusing = of_case()
    refusing.refuses = lambda case, route: "It has level lines only."
    with pytest.raises(NotSupported, match="level lines only"):
        LAWS["cone[disc in a circle]"](Route(refusing, "native"))


@pytest.mark.parametrize("name", dict(routes()))
def test_every_effect_that_an_adapter_claims_has_a_law(name):
    adapter, laws = adapters.engine(name), {law.partition("[")[0] for law in LAWS}
    for effect in getattr(adapter, "adapter", adapter).KNOWN_EFFECTS:
        assert effects.OF_EFFECT[effect] and laws >= {*effects.OF_EFFECT[effect]}


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
