"""Ordinary fractions in curves and loads: every integrator takes them, in every precision."""

import pytest
import sympy as sp

from cases import Case, CoulombFriction, Curve, Gravity, Load, Start, Unilateral, disc
from cases import curves as c
from cases.library import line, superellipse
from reference import simulate
from reference.minimal.integrators import taylor
from tests.sampling import quick_every

GROUND = (Gravity(9.81), CoulombFriction(0.1), Unilateral())
THIRD = sp.Rational(1, 3)


def on(track: Curve, *loads: Load, xi1: float = 0.5) -> Case:
    return Case(track, disc(0.1, 1.0), (*GROUND, *loads), Start(xi1=xi1), 0.4)


SCENES = {
    "a third of a square": on(Curve(lambda s: (s, s**2 / 3), domain=(-3, 3))),
    "a third inside a cosine": on(Curve(lambda s: (s, c.cos(s / 3)), domain=(-9, 9))),
    "a text with a third": on(Curve(("s", "cos(s/3)"), domain=(-9, 9))),
    "a cube root": on(Curve(lambda s: (s, s**THIRD), domain=(0.2, 3))),
    "its square": on(Curve(lambda s: (s, s ** (2 * THIRD) / 4), domain=(0.2, 3))),
    "a root and Euler's number": on(Curve(lambda s: (s, sp.sqrt(2) * s**2 / c.exp(1)), domain=(-3, 3))),
    "a load of a third": on(line(), Load(fx="-x/3")),
    "a sixth root": on(superellipse(1.0, 0.8, 6), xi1=-0.5),
}


# Each is derived and compiled twice. Those left to the slow tests have what another of these has.
LONGER = ("a third inside a cosine", "its square", "a sixth root")


@quick_every(2)
@pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")
@pytest.mark.parametrize(
    "case",
    [pytest.param(case, id=name, marks=pytest.mark.slow if name in LONGER else ()) for name, case in SCENES.items()],
)
def test_fractions_in_curves_and_loads_move_alike_by_both_integrators(case):
    ours, theirs = simulate(case, rtol=1e-13, method="taylor"), simulate(case, rtol=1e-13, method="dop853")
    assert ours.status == theirs.status == "completed"
    assert [t.after for t in ours.transitions] == [t.after for t in theirs.transitions]
    assert len(ours.t) > 1
    # DOP853's own error at its tightest over a motion of half a metre; times of transitions come as close.
    for quantity in ("x", "y", "theta", "omega"):
        end, other = getattr(ours, quantity)[-1], getattr(theirs, quantity)[-1]
        assert end == pytest.approx(other, abs=3e-12), quantity
