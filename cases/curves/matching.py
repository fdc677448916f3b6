"""Curves of several formulas, one after the other, that join without a corner."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import BadCurve, BadValue
from ..formulas import formula_symbols
from ..formulas import late_sympy as sp
from ..formulas.expressions import lift_constants
from . import Curve
from .jets import Structure
from .pieces import CurvePieces

# Ends that are nearer than this part of the curve's size meet, and tangents meet within this angle, rad: far above the
# rounding of a formula, far below what a person would author.
MEETING = 1e-9


def matched(curves: Sequence[Curve]) -> CurvePieces:
    """The pieces of a curve that runs through all of some curves, in order; closed if its ends meet.

    Its parameter runs on from piece to piece, as long as each one's own. Raises BadValue or BadCurve.
    """
    if len(curves) < 2:
        raise BadValue(f"{len(curves)} curves are given; give at least two with a domain each")
    for number, curve in enumerate(curves, start=1):
        if curve.domain is None or curve.parts is not None or curve.period:
            raise BadValue(f"curve {number} is not one formula with two ends; give Curve(formula, domain=(a, b))")
    domains = [curve.domain for curve in curves if curve.domain is not None]
    size = max(float(np.ptp(c.point(np.linspace(*d, 65)), axis=1).max()) for c, d in zip(curves, domains, strict=True))
    ends = [(np.array(c.jet(d[0])), np.array(c.jet(d[1]))) for c, d in zip(curves, domains, strict=True)]
    last, first = ends[-1][1], ends[0][0]
    closed = float(np.hypot(*(last - first)[:2])) <= MEETING * size and _turn(last, first) <= MEETING
    joints = [(before[1], after[0]) for before, after in zip(ends, ends[1:] + ends[:1], strict=True)]
    for number, (before, after) in enumerate(joints if closed else joints[:-1], start=1):
        _check_joint(number, before, after, size)
    breaks = np.concatenate([[0.0], np.cumsum([high - low for low, high in domains])])
    breaks += domains[0][0]
    forms: dict[Structure, int] = {}
    for curve in curves:
        forms.setdefault(_shifted(curve), len(forms))
    edges = [
        () if c.features is None or c.features.plain else tuple((c.features.edges(*d) - d[0] + b).tolist())
        for c, d, b in zip(curves, domains, breaks, strict=False)
    ]
    return CurvePieces(
        tuple(breaks.tolist()), tuple(forms), tuple(forms[_shifted(curve)] for curve in curves),
        tuple(float(b - d[0]) for b, d in zip(breaks, domains, strict=False)),
        tuple(curve.constants for curve in curves),
        order=min(_order(*joint) for joint in (joints if closed else joints[:-1])),
        period=float(breaks[-1] - breaks[0]) if closed else None, inner_edges=tuple(edges),
    )  # fmt: skip


def _shifted(curve: Curve) -> Structure:
    """The curve's structure with an origin for its parameter."""
    (x, y), symbols = lift_constants(curve.expression)
    origin = sp.Symbol("q0", real=True)
    place = {formula_symbols.PARAMETER: formula_symbols.PARAMETER - origin}
    return (x.xreplace(place), y.xreplace(place)), (origin, *symbols)


def _turn(before: np.ndarray, after: np.ndarray) -> float:
    """The angle between the tangents of two jets, rad."""
    (ax, ay), (bx, by) = before[2:4], after[2:4]
    return abs(float(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))


def _check_joint(number: int, before: np.ndarray, after: np.ndarray, size: float) -> None:
    apart = float(np.hypot(*(after - before)[:2]))
    if apart > MEETING * size:
        raise BadCurve(f"curve {number} ends {apart:.3g} m from where the next one begins; give curves that join")
    turn = _turn(before, after)
    if turn > MEETING:
        raise BadCurve(
            f"curve {number} and the next one join with a corner of {turn:.6g} rad at ({before[0]:.6g}, "
            f"{before[1]:.6g}) m; give curves with one tangent there, or Chain for a corner"
        )


def _order(before: np.ndarray, after: np.ndarray) -> int:
    """How many derivatives by the parameter agree at a joint, at most three."""
    order = 0
    for k in (1, 2, 3):
        one, other = before[2 * k : 2 * k + 2], after[2 * k : 2 * k + 2]
        if np.hypot(*(other - one)) > MEETING * max(np.hypot(*one), np.hypot(*other), np.hypot(*before[2:4])):
            break
        order = k
    return order
