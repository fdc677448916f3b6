"""Effects at several contacts: the paper's matrix has the same accelerations and forces, and what adapters say."""

from dataclasses import replace
from math import inf, pi

import pytest

import adapters
from adapters import lookup
from cases import Case, CoulombFriction, Gravity, Load, RollingResistance, StartPose, Support, disc
from cases.library import line
from tests.scenes.supports import INELASTIC

SURFACE, WALL = (CoulombFriction(0.3), RollingResistance(0.01)), Support(line(pi / 2), "wall")


@pytest.mark.parametrize("of_wall", [False, True])
def test_adapters_reject_rolling_resistance_on_supports_in_one_sentence(of_wall):
    own, effects = (SURFACE, INELASTIC) if of_wall else ((), (*INELASTIC, *SURFACE))
    case = Case(line(), disc(0.2, 1.0), effects, StartPose(0.2, 0.2), 1.0, supports=(replace(WALL, effects=own),))
    sentences = [
        (adapters.refusal(module, case, route), adapters.refusal_of_several_contacts(module, case, route))
        for module in installed()
        for route in module.routes
    ]
    assert sentences
    for reason, one_only in sentences:
        assert reason and reason.endswith(".") and ("rolling resistance" in reason or "supports" in reason)
        assert one_only.endswith("several contacts with rolling resistance.") or "several places" in one_only


def test_adapters_model_a_plate_that_does_not_turn_or_reject_it_in_one_sentence():
    effects = (Gravity(9.81), *INELASTIC[1:], CoulombFriction(0.2), Load(fx="-1"))
    case = Case(line(), disc(0.2, 1.0, inf), effects, StartPose(0.2, 0.2), 1.0, supports=(WALL,))
    reasons = [adapters.refusal(module, case, route) for module in installed() for route in module.routes]
    assert any(reasons) and all(one is None or one.endswith(".") and "\n" not in one for one in reasons)


def installed() -> list:
    """The adapters of the engines that are installed here."""
    found = []
    for name in lookup.engines():
        try:
            found.append(lookup.engine(name))
        except Exception:  # not installed here
            continue
    return found
