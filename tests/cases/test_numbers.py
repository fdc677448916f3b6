"""Numbers of any type: what is a real number is taken as one, once, where it comes in; nothing else is."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
import sympy as sp

import cases
import reference
from cases import Case, CoulombFriction, Curve, Load, Start, disc
from reference.sweeping import Axis
from tests.scenes.public_calls import CALLS, scene

QUARTERS = [
    0.25, Fraction(1, 4), Decimal("0.25"), np.float64(0.25), np.float32(0.25), np.float16(0.25), np.longdouble("0.25"),
    np.array(0.25), sp.Rational(1, 4), sp.Float("0.25"), sp.sqrt(sp.Rational(1, 16)), sp.cos(sp.pi / 3) / 2,
]  # fmt: skip
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


@pytest.mark.parametrize("rtol", [Fraction(1, 10**6), Decimal("1e-6"), np.float64(1e-6), sp.Rational(1, 10**6)])
def test_a_tolerance_of_any_type(rtol):
    case = cases.load("disc_in_circle")
    assert reference.simulate(case, rtol=rtol).transitions == reference.simulate(case, rtol=1e-6).transitions


NONSENSE = [
    None, "x", b"x", "\ud800", 10**400, 2**63, 1e308, 5e-324, float("nan"), float("inf"), -1, 0, 3, 1.5, 1j, True, [],
    {}, [None], ("a", "b"), object(), int, lambda *some: None, sp.Symbol("q"), np.array([1, np.nan]), np.zeros((2, 2)),
]  # fmt: skip


@pytest.mark.parametrize("name", CALLS)
def test_nonsense_in_a_public_function_is_one_sentence_or_a_result(name):
    """Nothing but CaseError is raised, whichever argument is wrong."""
    call, right = CALLS[name]
    for argument, value in product(right, NONSENSE):
        try:
            with np.errstate(all="ignore"):
                call(**(right | {argument: value}))
        except cases.CaseError as error:
            assert "\n" not in str(error) and str(error)
