"""Numbers of any type: what is a real number is taken as one, once, where it comes in; nothing else is."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

import cases
import reference
from cases import BadValue, Case, CoulombFriction, Curve, Gravity, Load, Start, Unilateral, disc
from cases.errors import real
from reference.sweeping import Axis

QUARTERS = [
    0.25, Fraction(1, 4), Decimal("0.25"), np.float64(0.25), np.float32(0.25), np.float16(0.25), np.longdouble("0.25"),
    np.array(0.25), sp.Rational(1, 4), sp.Float("0.25"), sp.sqrt(sp.Rational(1, 16)), sp.cos(sp.pi / 3) / 2,
]  # fmt: skip
WHOLE = [3, np.int64(3), np.uint8(3), sp.Integer(3)]
NONE = [
    "0.25", b"1", True, np.bool_(True), None, 1j, np.complex128(0.25), [0.25], np.array([0.25]), sp.Symbol("x"), sp.I,
    np.timedelta64(1, "s"), np.datetime64("2020"), sp.true, object(), float,
]  # fmt: skip
NOT_FINITE = [float("nan"), float("inf"), np.float32("inf"), Decimal("NaN"), sp.oo, sp.nan, 10**400, -(10**400)]


def label(value) -> str:
    """A test's name, the same in every worker: no address in it."""
    text = "" if type(value) is object else f"-{value}"
    return f"{type(value).__module__}.{type(value).__name__}{text}"[:60]


# Where a number comes in: what is made of it, which has to be the same for equal numbers.
PLACES: dict[str, Callable] = {
    "parameter": lambda value: cases.load("disc_in_circle", mu=value),
    "own parameter": lambda value: scene(parameters={"size": value}),
    "effect": lambda value: CoulombFriction(value),
    "load": lambda value: Load(fx=value).at(*[0.0] * 7),
    "start": lambda value: Start(xi1=value),
    "plate": lambda value: disc(value, 1.0),
    "domain": lambda value: Curve(("s", "s**2"), (value, 3)),
    "curve": lambda value: Curve(lambda s: (s, value), (-1, 1)).point(0.0).tolist(),
    "duration": lambda value: scene(duration=value),
    "axis": lambda value: Axis.of("mu", value),
    "axis of some": lambda value: Axis.of("mu", [value, 0.5]),
}
# What else is taken there: text is a formula of a load or of the slip speed, and the values of an axis; a truth value
# may be a parameter.
TAKEN = {"load": str, "effect": str, "axis": (str, bytes, list, np.ndarray), "parameter": bool, "own parameter": bool}


def scene(**how) -> Case:
    usual = dict(duration=1.0, parameters={})
    effects = (Gravity(9.81), Unilateral())
    return Case(cases.library.line(), disc(0.1, 1.0), effects, Start(0.0), **(usual | how))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("value", QUARTERS, ids=label)
def test_equal_numbers_make_equal_things(place, value):
    made, usual = PLACES[place](value), PLACES[place](0.25)
    assert made == usual and str(made) == str(usual)
    if isinstance(made, Case):
        assert made.label == usual.label and repr(made) == repr(usual)
        assert all(type(number) in (int, float) for number in made.parameters.values())


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("value", NONE, ids=label)
def test_what_is_no_number_is_rejected(place, value):
    if isinstance(value, TAKEN.get(place, ())):
        return
    with pytest.raises(cases.CaseError, match="give|use|write"):
        PLACES[place](value)


@pytest.mark.parametrize("value", NOT_FINITE, ids=label)
@pytest.mark.parametrize("place", PLACES)
def test_what_is_not_finite_is_rejected(place, value):
    with pytest.raises(cases.CaseError, match="give"):
        PLACES[place](value)


@pytest.mark.parametrize("value", WHOLE, ids=label)
def test_a_whole_number_stays_one(value):
    case = scene(parameters={"corners": value})
    assert case.label == "unnamed[corners=3]" and type(case.parameters["corners"]) is int
    assert real(value) == 3.0


def test_a_third_is_written_and_read_back():
    case = cases.load("disc_in_circle", mu=Fraction(1, 3))
    assert case.label == "disc_in_circle[mu=0.3333333333333333]"
    assert cases.load(case.label) == case
    assert case == cases.load("disc_in_circle", mu=1 / 3)


@pytest.mark.parametrize("rtol", [Fraction(1, 10**6), Decimal("1e-6"), np.float64(1e-6), sp.Rational(1, 10**6)])
def test_a_tolerance_of_any_type(rtol):
    case = cases.load("disc_in_circle")
    assert reference.simulate(case, rtol=rtol).transitions == reference.simulate(case, rtol=1e-6).transitions


@pytest.mark.parametrize("rtol", ["1e-6", None, True, 1e-15, 0.1, float("nan"), [1e-6]])
def test_another_tolerance_is_rejected(rtol):
    case = cases.load("disc_in_circle")
    with pytest.raises(BadValue, match="rtol is .*; give a number between 1e-14 and 0.01"):
        reference.simulate(case, rtol=rtol)
    with pytest.raises(BadValue, match="rtol is .*; give a number between 1e-14 and 0.01"):
        reference.sweep("disc_in_circle", mu="0.1:0.2:2", rtol=rtol)


def test_a_short_float_of_numpy_loses_no_digits_of_the_formula():
    # SymPy's own conversion works with as few digits as it holds.
    load = Load(fx=np.float32(0.1))
    assert load.fx._prec == 53 and float(load.fx) == float(np.float32(0.1))


LINE = cases.library.line()
CIRCLE = cases.library.circle(1.0)
MOTION = cases.Trajectory(**{name: np.arange(3.0) for name in ("t", *cases.State._fields)})


@pytest.mark.parametrize(
    "call",
    [
        lambda: cases.arc(None, 1.0, 2.0, 3.0),
        lambda: cases.arc((0.0, "1"), 1.0, 2.0, 3.0),
        lambda: cases.case(3),
        lambda: cases.case("name"),
        lambda: cases.case(lambda: None, variants=3),
        lambda: cases.case(lambda: None, variants=[3]),
        lambda: cases.fit_friction(10**400, [1, 2, 3], 0.1),
        lambda: cases.fit_waves([10**400, 1, 2], [1, 2, 3], 0.1),
        lambda: LINE.length(None, 1.0),
        lambda: LINE.length(0.0, np.inf),
        lambda: LINE.even(0.0, 1.0, 1.5),
        lambda: LINE.point(None),
        lambda: LINE.tangent("x"),
        lambda: LINE.curvature(["x"]),
        lambda: LINE.tangent_angle(None),
        lambda: cases.Plate.homogeneous(3, 1.0),
        lambda: cases.Plate.homogeneous(CIRCLE, 1.0, holes=3),
        lambda: cases.Plate.homogeneous(CIRCLE, 1.0, holes=[3]),
        lambda: cases.Plate.homogeneous(CIRCLE, 1.0, inlays=[3]),
        lambda: cases.Plate.homogeneous(CIRCLE, 1.0, inlays=[(CIRCLE,)]),
        lambda: MOTION.times(1.5),
        lambda: MOTION.to_frame("x"),
        lambda: MOTION.to_csv(None),
        lambda: cases.constructions.piecewise(3),
        lambda: cases.constructions.natural(3, 1.0),
        lambda: cases.constructions.natural(lambda s: s, None),
        lambda: cases.constructions.natural(lambda s: s, 1.0, start=None),
        lambda: cases.library.from_support(3),
    ],
)
def test_a_wrong_argument_of_a_public_function_is_one_sentence(call):
    with pytest.raises(cases.CaseError, match="give|there is no"):
        call()
