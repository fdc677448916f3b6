"""Curves in the frame of their tangent: their quantities, and how few operations they take."""

import numpy as np
import pytest

import cases
from cases import Chain, Curve
from cases import curves as c
from cases.formulas.expression_code import ON_FLOATS, python_function
from cases.formulas.expression_graph import symbol
from cases.formulas.expressions import PARAMETER
from cases.library import circle, ellipse, line
from reference.minimal.frames import Frame, frame
from reference.minimal.tangent_algebra import from_node, operations, shorter

S = symbol("xi")


def frame_of(curve: Curve) -> Frame:
    return frame(curve.structure, S, "track_")


def values(curve: Curve, quantities, at: float) -> list[float]:
    sizes = [symbol(f"track_c{i}") for i in range(len(curve.constants))]
    return python_function([S, sizes], quantities, ON_FLOATS)(at, curve.constants)


def has_formula(name: str, part: str) -> bool:
    """Whether a curve has one formula: frames of others are those of their pieces."""
    case = cases.load(name)
    curve = case.track if part == "track" else case.plate.outline
    return not isinstance(curve, Chain) and curve.parts is None


EVERY = [(name, part) for name in cases.names(hard=False) for part in ("track", "outline")]
CURVES = {f"{name}, {part}": (name, part) for name, part in EVERY if has_formula(name, part)}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name, part", CURVES.values(), ids=CURVES)
def test_quantities_are_those_of_the_curves_derivatives(name, part):
    case = cases.load(name)
    curve = case.track if part == "track" else case.plate.outline
    for at in np.linspace(*curve.span, 7)[1:-1] + 0.0123 * curve.unit:
        x, y, xp, yp, xs, ys, xt, yt = curve.jet(float(at))
        P = np.hypot(xp, yp)
        exact = [
            x, y, P, (xp * xs + yp * ys) / P, (xp * ys - yp * xs) / P, (xp * yt - yp * xt) / P,
            (x * xp + y * yp) / P, (xp * y - yp * x) / P, xp / P, yp / P,
        ]  # fmt: skip
        terms = [
            abs(x), abs(y), P, abs(xp * xs) + abs(yp * ys), abs(xp * ys) + abs(yp * xs), abs(xp * yt) + abs(yp * xt),
            abs(x * xp) + abs(y * yp), abs(xp * y) + abs(yp * x), P, P,
        ]  # fmt: skip
        # Some tens of operations; a measured outline is a difference of terms a thousand times as large.
        bounds = [1e-12 * (1.0 + term / P) * (1.0 + term) for term in terms]
        for value, other, bound in zip(values(curve, frame_of(curve)[:-1], float(at)), exact, bounds, strict=True):
            assert abs(value - other) <= bound


@pytest.mark.parametrize("curve", [circle(0.7), line(), Curve(lambda s: (0.3 * s, 0.4 * s))])
def test_speed_and_curvature_of_circles_and_lines_do_not_change_along_them(curve):
    f = frame_of(curve)
    assert operations([f.P, f.a, f.b, f.c, f.curvature], {S}) == 0


def test_an_ellipse_has_the_constant_a_b_in_its_curvature():
    f = frame_of(ellipse(0.3, 0.2))
    assert operations([f.b * f.P], {S}) <= operations([f.P], {S}) + 2


def test_arguments_of_functions_stay_as_written():
    curve = Curve(lambda s: (s, 1e-6 * c.exp(-(((s - 1.3) / 1e-4) ** 2))), domain=(-3.0, 3.0))
    # Multiplied out, exp(-s²/w²) exp(2 s c/w²) exp(-c²/w²) has factors that a double cannot hold.
    f = frame_of(curve)
    x, y, xp, yp, *_ = curve.jet(1.3 + 1e-4)
    assert y == pytest.approx(1e-6 * np.exp(-1.0), rel=1e-9)
    ours = values(curve, [f.y, f.ht], 1.3 + 1e-4)
    assert ours == pytest.approx([y, (x * xp + y * yp) / np.hypot(xp, yp)], rel=1e-12)


def test_multiplying_out_keeps_the_value():
    x, y = symbol("c1"), symbol("c2")
    assert from_node((x + y) * (x - y)).node() is x**2 - y**2
    longer = x * y + 2 * x * y + x * y * 3
    assert shorter(longer, {x, y}) is 6 * x * y or operations([shorter(longer, {x, y})], {x, y}) == 2
    assert PARAMETER.name == "s"
