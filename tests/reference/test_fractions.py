"""Ordinary fractions in curves and loads: every integrator takes them, in every precision."""

import numpy as np
import pytest
import sympy as sp

from cases import Case, CoulombFriction, Curve, DoesNotFit, Gravity, Load, Plate, Start, Unilateral, disc
from cases import curves as c
from cases.formulas.expression_graph import from_sympy, symbol
from cases.library import line, superellipse
from reference import simulate
from reference.minimal.integrators import taylor

pytestmark = pytest.mark.taylor

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


@pytest.mark.sampled(2)
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


@pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")
def test_fractions_move_in_quadruple_precision():
    case = SCENES["a third of a square"]
    fine, usual = simulate(case, method="taylor_quadruple"), simulate(case, rtol=1e-14, method="taylor")
    assert fine.x[-1] == pytest.approx(usual.x[-1], abs=1e-14)


@pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")
@pytest.mark.parametrize(
    ("text", "exact"),
    [
        ("x/3", "8/3"),
        ("x**(1/3)", "2"),
        ("x**(-5/3)", "1/32"),
        ("(1 + x/7)**(2/3)/9", "(15/7)**(2/3)/9"),
        ("sqrt(2)*x", "8*sqrt(2)"),
        ("exp(1)*x*pi", "8*exp(1)*pi"),
        ("x*2**(1/3)*cos(1/7)", "8*2**(1/3)*cos(1/7)"),
    ],
)
def test_fractions_keep_all_digits_of_quadruple_precision(text, exact):
    import heyoka as hy

    from reference.minimal.integrators import conversion

    variable = hy.expression("x")
    formula = conversion.convert([from_sympy(sp.sympify(text))], {symbol("x"): variable})
    function = hy.cfunc(formula, [variable], fp_type=hy.real128)
    (value,) = function(np.array([hy.real128(8)]))
    # Quadruple precision has a rounding of 2e-34; a constant held in double precision would be off by 1e-17.
    assert abs(sp.Float(str(value), 40) / sp.N(sp.sympify(exact), 40) - 1) < 1e-32


def test_a_flat_point_on_a_straight_line_is_refused_in_a_sentence():
    with pytest.raises(DoesNotFit, match="does not fit its track"):
        Case(line(), Plate(superellipse(0.2, 0.1, 6), 1.0, 0.01), GROUND, Start(xi1=0.0), 1.0)
