"""Whether the plate can touch its track in a second place: what is proved about it, and what is assumed.

Two theorems exclude a second contact, whatever the motion. Both need a plate whose closed outline is strictly convex
(curvature k > 0 everywhere).

- Separation: the track is concave towards the plate (κ ≤ 0) and bounds a convex set. The common tangent separates it
  from the plate, which touches that tangent in one point only.
- Blaschke's rolling theorem (1916; known to us, not looked up): the track is convex around the plate (κ ≥ 0) and its
  largest curvature is below the outline's smallest. Then the plate fits inside at every place and touches in one point.
  An open track that is a graph is continued by its tangents at its ends.

For a disc on any other track the distance of the track's points from the centre is bounded directly, for all places
that the motion reaches (branch and bound): near the contact by the second derivative of the squared distance, elsewhere
by its value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import sympy as sp
from flint import arb, arb_series, ctx

from cases import Curve
from cases.formulas.expressions import PARAMETER

from .equations import CurveSeries, number
from .formulas import Formula
from .scene import Pair, Scene
from .steps import exact, interval

# Balls are bounded with this precision; parts of a curve that are bounded before the search ends without a proof.
PRECISION, MOST_PARTS = 64, 20_000


class ContactProof(NamedTuple):
    """Whether one contact is proved, and the sentence for the record."""

    proved: bool
    sentence: str


def second_contact(scene: Scene, track: Curve, outline: Curve, reached: arb | None) -> ContactProof:
    """What excludes a second contact while ξ₁ is in the ball `reached`."""
    precision, cap = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = PRECISION, 1
    try:
        return _second_contact(scene, track, outline, reached)
    finally:
        ctx.prec, ctx.cap = precision, cap


def _second_contact(scene: Scene, track: Curve, outline: Curve, reached: arb | None) -> ContactProof:
    smallest = 1 / number(scene.disc) if scene.disc is not None else _least_curvature(scene, outline)
    if smallest is None or not smallest > 0:
        return ContactProof(False, "assumed: the plate touches its track in one place only (its outline is not convex)")
    span = _whole(scene, track)
    if span is not None:
        formula = CurveSeries(scene.track)
        closed_or_graph = track.period is not None or _is_graph(scene.track, span)
        if closed_or_graph and _bounded(formula, span, above=arb(0)):
            return ContactProof(True, "proved: one contact, by separation (the track is concave, the outline convex)")
        if closed_or_graph and _bounded(formula, span, above=smallest, below=arb(0)):
            return ContactProof(True, "proved: one contact, by Blaschke's rolling theorem (curvatures bounded)")
        if scene.disc is not None and reached is not None and track.period is None:
            if _apart(scene, span, reached):
                return ContactProof(True, "proved: one contact, by the distance of the track from the disc's centre")
    return ContactProof(False, "assumed: the plate touches its track in one place only")


def _whole(scene: Scene, track: Curve) -> arb | None:
    """All parameters of the track as a ball: its domain, a little more than one period, any one for a straight line."""
    if scene.track_domain is not None:
        low, high = scene.track_domain
        return interval(number(low), number(high))
    if track.period is not None:
        return interval(arb(0), arb(track.period) * (1 + arb(2) ** -40))
    straight = all(sp.diff(part, PARAMETER, 2) == 0 for part in scene.track)
    return interval(arb(-1), arb(1)) if straight else None


def _least_curvature(scene: Scene, outline: Curve) -> arb | None:
    """A lower bound of a closed outline's curvature, at most a tenth below it, or None."""
    if outline.period is None:
        return None
    formula, parts = CurveSeries(scene.outline), 64
    for _ in range(5):
        edges = [arb(outline.period) * (1 + arb(2) ** -40) * i / parts for i in range(parts + 1)]
        balls = [_curvature(formula, interval(a, b)) for a, b in zip(edges, edges[1:], strict=False)]
        lows = [ball.lower() for ball in balls]
        least = min(lows, key=float)
        if min(float(ball.mid()) for ball in balls) * 0.9 < float(least):
            return least
        parts *= 4
    return least if least > 0 else None


def _curvature(formula: CurveSeries, part: arb) -> arb:
    try:
        return formula(arb_series([part]))[3][0]
    except (ValueError, ZeroDivisionError):
        return arb(0, float("inf"))


def _bounded(formula: CurveSeries, span: arb, above: arb, below: arb | None = None) -> bool:
    """Whether the curvature is below `above` (at most 0 where that is 0), and at least `below`, on the span."""

    def holds(part: arb) -> bool | None:
        kappa = _curvature(formula, part)
        over = kappa <= 0 if above.is_zero() else kappa < above
        if over and (below is None or kappa >= below):
            return True
        return False if kappa > above or (below is not None and kappa < below) else None

    return _everywhere([span], holds)


def _everywhere(spans: Sequence[arb], holds: Callable[..., bool | None]) -> bool:
    """Whether a condition on a ball of each span is true everywhere, by division of the longest into halves; a
    condition that is neither true nor false there is None."""
    boxes = [[(exact(span.lower()), exact(span.upper())) for span in spans]]
    for _ in range(MOST_PARTS):
        if not boxes:
            return True
        box = boxes.pop()
        verdict = holds(*(interval(*side) for side in box))
        if verdict is False:
            return False
        if verdict is None:
            longest = max(range(len(box)), key=lambda i: float(box[i][1] - box[i][0]))
            low, high = box[longest]
            middle = exact((low + high) / 2)
            if not (low < middle and middle < high):
                return False
            boxes += [[*box[:longest], half, *box[longest + 1 :]] for half in ((low, middle), (middle, high))]
    return False


def _is_graph(track: Pair, span: arb) -> bool:
    """Whether X grows along the whole track."""
    formula = Formula([PARAMETER], [sp.diff(track[0], PARAMETER)])
    return _everywhere([span], lambda part: True if formula(arb_series([part]))[0][0] > 0 else None)


def _apart(scene: Scene, span: arb, reached: arb) -> bool:
    """Whether the disc touches the track at ξ₁ only, for each ξ₁ that the motion reaches."""
    jets = [sp.diff(part, PARAMETER, order) for order in range(3) for part in scene.track]
    formula, r = Formula([PARAMETER], jets), number(scene.disc)

    def holds(at: arb, other: arb) -> bool | None:
        X, Y, Xp, Yp, _, _ = (row[0] for row in formula(arb_series([at])))
        speed = (Xp * Xp + Yp * Yp).sqrt()
        cx, cy = X - r * Yp / speed, Y + r * Xp / speed
        x, y, *_ = (row[0] for row in formula(arb_series([other])))
        if (x - cx) * (x - cx) + (y - cy) * (y - cy) > r * r:
            return True
        # Where the squared distance is convex along the hull of both balls, ξ₁ is its only minimum there.
        x, y, xp, yp, xs, ys = (row[0] for row in formula(arb_series([interval(at, other)])))
        return True if xp * xp + yp * yp + (x - cx) * xs + (y - cy) * ys > 0 else None

    return _everywhere([reached, span], holds)
