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
from cases import Case, CoulombFriction, Curve, Gravity, Load, Start, Unilateral, disc
from reference.sweeping import Axis

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


@pytest.mark.parametrize("rtol", [Fraction(1, 10**6), Decimal("1e-6"), np.float64(1e-6), sp.Rational(1, 10**6)])
def test_a_tolerance_of_any_type(rtol):
    case = cases.load("disc_in_circle")
    assert reference.simulate(case, rtol=rtol).transitions == reference.simulate(case, rtol=1e-6).transitions


LINE, CIRCLE, DISC = cases.library.line(), cases.library.circle(1.0), disc(0.1, 1.0)
PARABOLA = Curve(("s", "s**2"), (-1, 1))
CHAIN = cases.Chain.polyline([(0, 0), (1, 0), (1.5, 1)])
SQUARE = cases.Outline.polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
SPLINE = Curve.spline([(0.1 * i, 0.01 * i * i) for i in range(12)])
SCENE = scene()
SAMPLES = {name: np.arange(3.0) for name in ("t", *cases.State._fields)}
MOTION = cases.Trajectory(**SAMPLES)
NONSENSE = [
    None, "x", b"x", "\ud800", 10**400, 2**63, 1e308, 5e-324, float("nan"), float("inf"), -1, 0, 3, 1.5, 1j, True, [],
    {}, [None], ("a", "b"), object(), int, lambda *some: None, sp.Symbol("q"), np.array([1, np.nan]), np.zeros((2, 2)),
]  # fmt: skip
AT_PLACES = "at curvature jet jets normal place point speed tangent tangent_angle element_at".split()
# Public functions and valid arguments of each; one at a time is replaced.
CALLS: dict[str, tuple[Callable, dict]] = {
    "Case": (Case, dict(track=CIRCLE, plate=DISC, effects=(Gravity(9.81),), start=Start(0.1), duration=0.1, name="mine",
                        parameters={}, supports=(), others=())),
    "Chain": (cases.Chain, dict(pieces=[LINE], is_closed=False)),
    "Curve": (Curve, dict(function=("s", "s**2"), domain=(-1, 1), residual=None, may_cross=False)),
    "FreePlate": (cases.FreePlate, dict(plate=DISC, start=cases.StartPose(0, 0), name="b")),
    "Outline": (cases.Outline, dict(pieces=[CIRCLE])),
    "Plate": (cases.Plate, dict(outline=CIRCLE, mass=1.0, inertia=1.0)),
    "Support": (cases.Support, dict(curve=LINE, name="b", effects=None)),
    "Trajectory": (cases.Trajectory, SAMPLES),
    "arc": (cases.arc, dict(centre=(0, 0), radius=1.0, start=0.0, end=1.0)),
    "fit_friction": (cases.fit_friction, dict(v=np.arange(1.0, 9), mu=np.full(8, 0.2), within=0.01)),
    "fit_waves": (cases.fit_waves, dict(t=np.arange(9.0), values=np.sin(np.arange(9.0)), within=0.1, integrals=0)),
    "load_file": (cases.load_file, dict(path="nowhere.py")),
    "names": (cases.names, dict(hard=None)),
    "select": (cases.select, dict(text="disc_in_circle", long=False)),
    "Chain.polyline": (cases.Chain.polyline, dict(points=[(0, 0), (1, 0)])),
    "Curve.in_pieces": (Curve.in_pieces, dict(pieces=SPLINE.parts, may_cross=False)),
    "Curve.spline": (Curve.spline, dict(points=[(0.1 * i, 0.01 * i * i) for i in range(12)], smoothing=0.0,
                                        closed=False, scale=1.0, may_cross=False)),
    "Outline.polygon": (cases.Outline.polygon, dict(points=[(0, 0), (1, 0), (1, 1), (0, 1)], radius=0.0)),
    "Plate.gear": (cases.Plate.gear, dict(radius=1.0, teeth=8, depth=0.1, mass=1.0, rounding=0.0)),
    "Plate.homogeneous": (cases.Plate.homogeneous, dict(outline=CIRCLE, mass=1.0, holes=(), inlays=())),
    "Plate.rectangle": (cases.Plate.rectangle, dict(width=1.0, height=1.0, mass=1.0, radius=0.0)),
    "Case.effect": (SCENE.effect, dict(kind=Gravity)),
    "Case.with_name": (SCENE.with_name, dict(name="a", parameters={})),
    "Start.check": (Start(0.1).check, dict(track=CIRCLE, outline=DISC.outline, effects=SCENE.effects)),
    "Start.motion": (Start(0.1).motion, dict(track=CIRCLE, outline=DISC.outline)),
    "Support.acting": (cases.Support(LINE, "a").acting, dict(of_case=SCENE.effects)),
    "Drive.at_times": (cases.Drive("sin(t)").at_times, dict(t=np.zeros(2))),
    "Trajectory.of": (MOTION.of, dict(contact="plate/track")),
    "Trajectory.plate": (MOTION.plate, dict(name="plate")),
    "Trajectory.times": (MOTION.times, dict(count=5)),
    "Trajectory.to_frame": (MOTION.to_frame, dict(count=5)),
    "Trajectory()": (MOTION, dict(t=0.5)),
    "polar": (cases.constructions.polar, dict(radius=lambda s: 1 + 0 * s, domain=None)),
    "natural": (cases.constructions.natural,
                dict(curvature=lambda s: s, length=1.0, start=(0.0, 0.0), angle=0.0, may_cross=False)),
    "piecewise": (cases.constructions.piecewise, dict(curves=[LINE], may_cross=False)),
    "from_support": (cases.library.from_support, dict(support=lambda s: 1 + 0 * s)),
    "integral": (cases.curves.integral, dict(formula=lambda s: s, upper=1.0, lower=0.0)),
    "simulate": (reference.simulate, dict(case=SCENE, rtol=1e-6, method="dop853")),
    "check": (reference.check, dict(case=SCENE, motion=MOTION, rtol=1e-6)),
    "sweep": (reference.sweep, dict(case="disc_on_line", mu="0.1", sample="grid", number=None, seed=0, rtol=1e-6)),
}  # fmt: skip
for number, curve in enumerate((LINE, CIRCLE, PARABOLA, CHAIN, SQUARE, SPLINE)):
    arguments = dict.fromkeys(AT_PLACES, {"s": 0.1}) | {
        "angle_table": {"span": (0.0, 0.5)}, "even": {"low": 0.0, "high": 0.5, "count": 4}, "element": {"number": 0},
        "length": {"low": 0.0, "high": 0.5}, "part": {"number": 0}, "translate": {"x": 0.0, "y": 0.0},
        "vertices": {"longest_turn": 0.1},
    }  # fmt: skip
    CALLS |= {
        f"{name} of curve {number}": (getattr(curve, name), right)
        for name, right in arguments.items()
        if hasattr(curve, name)
    }


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
