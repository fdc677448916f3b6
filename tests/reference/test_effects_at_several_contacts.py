"""Effects at several contacts: the paper's matrix has the same accelerations and forces, and what adapters say."""

from dataclasses import replace
from math import inf, pi

import pytest

import adapters
from adapters import lookup
from cases import Case, CoulombFriction, Drive, Gravity, Load, Mode, RollingResistance, StartPose, Support, disc
from cases.library import line
from cases.moving_frame import relative_case
from tests.scenes.slip_laws import STRIBECK
from tests.scenes.supports import INELASTIC, compare_with_matrix
from tests.taylor import test_fixed_rotation_and_contacts as still

from . import test_belts_and_supports as belts
from . import test_driven_contacts as driven
from . import test_rolling_resistance_and_contacts as rolling
from . import test_slip_laws_and_contacts as slip_laws

SCENES = {
    "plates that do not turn": lambda: (still.in_v(), still.in_v(0.1, 0.2, 0.8)),
    "couples": lambda: (rolling.disc_in_v(omega=25.0),),
    "belts": lambda: (belts.disc_at_wall(-2.0),),
    "driven tracks": lambda: (relative_case(driven.in_v(Drive(x="0.05*sin(9*t)", angle="0.2*sin(5*t)"))),),
    "friction by slip speed": lambda: (slip_laws.disc_at_wall(0.4), slip_laws.block(STRIBECK, slope=0.1)),
}


@pytest.mark.parametrize(
    "name", [name if i < 2 else pytest.param(name, marks=pytest.mark.slow) for i, name in enumerate(SCENES)]
)
def test_the_papers_matrix_gives_the_same_accelerations_and_forces(name):
    modes = {mode for each in compare_with_matrix(SCENES[name]()) for mode in each}
    assert modes & {Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD, Mode.SLIDE}


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
        assert (
            reason
            and reason.endswith(".")
            and any(word in reason for word in ("rolling resistance", "RollingResistance", "supports"))
        )
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
