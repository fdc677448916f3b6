"""An effect of the value 0 is none: a sweep or a slider may begin there."""

from dataclasses import replace

import pytest

from cases import Belt, CoulombFriction, Load, RollingResistance, Support, library
from tests.scenes.moving import on_line

pytestmark = pytest.mark.taylor


def test_an_effect_of_the_value_0_is_absent():
    """At the end of a range of parameters; without friction a belt does nothing."""
    without = on_line(slip=1.0)
    nothing = Belt(0.0), RollingResistance(0.0), Load(fx=0.0)
    assert replace(without, effects=(*without.effects, *nothing)) == without
    smooth = replace(without, effects=tuple(e for e in without.effects if not isinstance(e, CoulombFriction)))
    assert replace(smooth, effects=(*smooth.effects, CoulombFriction(0.0), Belt(2.0))) == smooth
    assert Support(library.line(1.0), "wall", (CoulombFriction(0.0),)).effects == ()
