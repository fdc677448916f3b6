"""The search for the nearest pair of points of two curves, as one Python function written for the two formulas.

Newton's method evaluates both curves in each step. With their formulas written into its loop a search takes a fifth
less time than with two calls, and has the same digits; a run of an engine searches a hundred thousand times.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import hypot, inf
from typing import NamedTuple

from ..curves import Curve
from ..curves.jets import Structure, jet_rows
from ..derivation import in_one_thread
from ..errors import DoesNotFit
from ..formulas.expression_code import ON_FLOATS, statements


class Contact(NamedTuple):
    """Contact parameters and the gap (m, negative where the plate overlaps its track)."""

    xi1: float
    xi2: float
    gap: float


# The most steps of Newton's method. A step turns neither tangent by more than LONGEST (rad), and is no longer than that
# fraction of the plate, or STRAIGHTER times as long along a track that is straight there.
MOST_STEPS, LONGEST, STRAIGHTER = 100, 0.5, 16.0
# Relative rounding of a position (to its distance from the origin plus the plate's size) and of a parameter: the
# formulas of pose and curve have about twenty roundings.
ROUNDINGS = 4e-15
# Steps below this many such roundings are tested for convergence: the last one or two of a search.
CLOSE = 1e6
# Largest residual of the two contact conditions, relative as above and in radians, where Newton's steps do not
# converge. The error of the gap is then its square.
CONVERGENCE = 1e-12

# The tangents are parallel (6), and the gap vector is normal to the track. Upper case: the track; lower case: the
# outline, first in its own frame and then (r) in that of the track.
_CODE = """
def make(sizes1, sizes2, reach, tightest, furthest):
    {sizes}
    far = (LONGEST * tightest) ** 2

    def search(x, y, theta, near):
        xi1, xi2 = near
        c, s = cos(theta), sin(theta)
        rounding = ROUNDINGS * (abs(x) + abs(y) + reach)
        close = (CLOSE * rounding) ** 2
        for _ in range(MOST_STEPS):
            {track}
            {outline}
            dx, dy = x + c * u - s * v - X, y + s * u + c * v - Y
            rpx, rpy = c * up - s * vp, s * up + c * vp
            rsx, rsy = c * us - s * vs, s * us + c * vs
            pace1, pace2 = Xp * Xp + Yp * Yp, rpx * rpx + rpy * rpy
            f, g = dx * Xp + dy * Yp, Xp * rpy - Yp * rpx
            f1, f2 = dx * Xs + dy * Ys - pace1, rpx * Xp + rpy * Yp
            g1, g2 = Xs * rpy - Ys * rpx, Xp * rsy - Yp * rsx
            det = f1 * g2 - f2 * g1
            if not (det > 0.0 or det < 0.0):  # zero, or not a number
                raise no_contact(x, y, near)
            step1, step2 = (f * g2 - f2 * g) / det, (f1 * g - f * g1) / det
            squared_step = step1 * step1 * pace1 + step2 * step2 * pace2
            if squared_step > far:
                part = shorten((step1, Xp, Yp, Xs, Ys), (step2, rpx, rpy, rsx, rsy), reach, furthest)
                step1, step2 = part * step1, part * step2
            xi1, xi2 = xi1 - step1, xi2 - step2
            # Converged if a step moves both points by no more than a few roundings of positions and parameters.
            if (
                squared_step <= close
                and sqrt(pace1) * (abs(step1) - ROUNDINGS * abs(xi1)) <= rounding
                and sqrt(pace2) * (abs(step2) - ROUNDINGS * abs(xi2)) <= rounding
            ):
                break
        else:
            # Where the curves nearly coincide a rounding moves the pair by more than that: accept the pair if the
            # residuals of both conditions are rounding.
            P, p = sqrt(pace1), sqrt(pace2)
            off = abs(f) / P <= CONVERGENCE * (abs(x) + abs(y) + reach + P * abs(xi1) + p * abs(xi2))
            if not (off and abs(g) <= CONVERGENCE * P * p):
                raise no_contact(x, y, near)
        # The last step changes the gap by its square.
        return Contact(xi1, xi2, (dy * Xp - dx * Yp) / sqrt(pace1))

    return search
"""
_ROWS = {1: "X, Y, Xp, Yp, Xs, Ys", 2: "u, v, up, vp, us, vs"}

# Takes a pose and the pair of parameters to start from; raises DoesNotFit if Newton's method does not converge.
Search = Callable[[float, float, float, tuple[float, float]], Contact]


@lru_cache(maxsize=64)
def pair_search(track: Curve, outline: Curve) -> Search:
    """The search for a track and an outline that are no chains; `geometry.find` says for what."""
    make = _search_maker(*(curve.structure if curve.parts is None else None for curve in (track, outline)))
    sizes = [curve.constants if curve.parts is None else curve.parts.jet for curve in (track, outline)]
    reach, tightest = outline.sizes
    # On a straight line Newton's method is exact over any distance.
    return make(*sizes, reach, tightest, STRAIGHTER * reach if track.features else inf)


@lru_cache(maxsize=256)
@in_one_thread
def _search_maker(track: Structure | None, outline: Structure | None) -> Callable[..., Search]:
    """Takes the curves' sizes, the outline's reach and its tightest radius (m), and the furthest step along the track
    (m), and returns the search; None: a curve in pieces, whose function stands for its sizes."""
    scope = ON_FLOATS | dict(Contact=Contact, no_contact=_no_contact, shorten=_shorten)
    scope |= dict(MOST_STEPS=MOST_STEPS, LONGEST=LONGEST, ROUNDINGS=ROUNDINGS, CLOSE=CLOSE, CONVERGENCE=CONVERGENCE)
    unpacking, parts = [], dict[str, str]()
    for number, name, structure in ((1, "track", track), (2, "outline", outline)):
        sizes, lines, functions = _evaluation(structure, number)
        unpacking += sizes
        parts[name] = "\n            ".join(lines)
        scope |= functions
    exec(_CODE.format(sizes="\n    ".join(unpacking), **parts), scope)
    return scope["make"]


def _evaluation(structure: Structure | None, number: int) -> tuple[list[str], list[str], dict[str, Callable]]:
    """The lines that unpack a curve's sizes, those that evaluate it at its parameter, and the functions they call."""
    rows, sizes, parameter = _ROWS[number], f"sizes{number}", f"xi{number}"
    if structure is None:
        return [], [f"{rows}, _, _ = {sizes}({parameter})"], {}
    (s, constants), outputs = jet_rows(structure)
    names = {constant: f"c{number}_{i}" for i, constant in enumerate(constants)}
    code = statements({s: parameter, **names}, outputs[:6], f"v{number}_")
    unpacking = [f"{', '.join(names.values())}, = {sizes}"] if names else []
    return unpacking, [*code.lines, f"{rows} = {', '.join(code.values)}"], code.functions(ON_FLOATS)


def _no_contact(x: float, y: float, near: tuple[float, float]) -> DoesNotFit:
    return DoesNotFit(f"no contact point near xi1 = {near[0]:.6g}, xi2 = {near[1]:.6g} for the pose ({x:.6g}, {y:.6g})")


def _shorten(along_track: tuple[float, ...], along_outline: tuple[float, ...], reach: float, furthest: float) -> float:
    """The fraction of a step of Newton's method that stays in its region of convergence; `reach` (m) of the outline,
    and the `furthest` step along the track (m).

    `along_track`, `along_outline`: the step in the parameter, the first and the second derivative, in one frame.
    """
    (way1, radius1), (way2, radius2) = _way(*along_track), _way(*along_outline)
    longest1, longest2 = min(max(radius1, reach), furthest), min(radius2, reach)
    return min(1.0, LONGEST * longest1 / way1 if way1 else 1.0, LONGEST * longest2 / way2 if way2 else 1.0)


def _way(step: float, xp: float, yp: float, xs: float, ys: float) -> tuple[float, float]:
    """The length of a step of a curve's parameter, and the radius of curvature where it begins, m."""
    speed, turn = hypot(xp, yp), abs(xp * ys - yp * xs)
    return abs(step) * speed, speed**3 / turn if turn else inf
