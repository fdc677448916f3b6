"""A case gets the equations, events and cost of the effects it names, and of no other."""

from dataclasses import replace

import pytest

import cases
from cases import Belt, CoulombFriction, Drive, Load, RollingResistance, Support, library
from cases.formulas.expression_graph import in_order
from cases.moving_frame import relative_case
from reference.minimal.modes import candidates, phase_at, start_state
from tests.scenes.moving import Adhesion, on_line

# Numbers of operations of the equations of all regimes of contact before there were belts, driven tracks, friction
# by slip speed, effects of a user's own and plates that do not turn (commit bf32a94).
OPERATIONS = {
    "disc_in_circle[mu=0.2]": [51, 52, 52],
    "ellipse_in_circle": [122, 122, 122],
    "disc_on_line": [25, 33, 33],
    "disc_rolling_to_rest": [24, 38, 38, 32, 45, 45, 32, 45, 45],
}


def operations(case) -> list[int]:
    """Number of different operations, inputs and constants in the equations and conditions of each regime of a case."""
    case = relative_case(case)
    systems = [phase_at(case, regime, start_state(case)).system for regime in candidates(case)]
    return [
        len(in_order([*s.rates, *s.outputs, *s.load_quantities, *(e for some in _named(s) for e in some.values())]))
        for s in systems
    ]


def _named(system):
    return system.conditions, system.condition_rates, system.guards


@pytest.mark.parametrize("label", OPERATIONS)
def test_scenes_without_them_have_the_operations_they_had_before_there_were_more_effects(label):
    assert operations(cases.select(label)[0]) == OPERATIONS[label]


@pytest.mark.parametrize("effect", [Belt("0.1*t"), Drive(x="0.1*t**2"), Adhesion(1.0, 0.1, 0.1)])
def test_each_effect_has_operations_of_its_own(effect):
    without = on_line(slip=1.0)
    case = replace(without, effects=(*without.effects, effect))
    assert all(more > less for more, less in zip(operations(case)[:-1], operations(without)[:-1], strict=True))


def test_an_effect_of_the_value_0_is_absent():
    """At the end of a range of parameters; without friction a belt does nothing."""
    without = on_line(slip=1.0)
    nothing = Belt(0.0), RollingResistance(0.0), Load(fx=0.0)
    assert replace(without, effects=(*without.effects, *nothing)) == without
    smooth = replace(without, effects=tuple(e for e in without.effects if not isinstance(e, CoulombFriction)))
    assert replace(smooth, effects=(*smooth.effects, CoulombFriction(0.0), Belt(2.0))) == smooth
    assert Support(library.line(1.0), "wall", (CoulombFriction(0.0),)).effects == ()
