"""A second place in which the plate meets its track, for the second formulation, by its own look at gaps."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, inf

from .flight import Pair, Surroundings, frame

# Points of the outline closer to the contact than this (in plate's sizes) are the contact: far above what Newton's
# method leaves, far below the distance of two samples.
SAME = 1e-6
# Only gaps below this part of the plate's size are worked out; a wider one counts as this.
WIDE = 0.1
# A gap is a difference of places: so many of their roundings are none. (Where a disc nearly fills its circle, the
# lowest point of the gap is anywhere near the contact, and its depth is rounding.)
ROUNDING = 64 * 2.0**-52


def gap_elsewhere(around: Surroundings, body: Sequence[float], xi1: float, xi2: float) -> float:
    """The smallest signed gap between plate and track away from their contact at (xi1, xi2), m, and its rounding, so
    that it falls below zero where they overlap indeed; at most `WIDE` of the plate's size."""
    wide = WIDE * around.size
    near = [pair for pair in around.valleys(*around.gaps(body)) if pair.gap < wide]
    others = [around.refined(body, pair) for pair in near]
    smallest = min((pair.gap for pair in others if not _same(around, body, pair, xi1, xi2)), default=wide)
    return smallest + ROUNDING * (hypot(body[0], body[1]) + around.reach)


def _same(around: Surroundings, body: Sequence[float], pair: Pair, xi1: float, xi2: float) -> bool:
    """Whether a pair of points is the contact."""
    period = around.scene.outline.period or inf
    apart = abs(pair.xi2 - xi2)
    apart = min(apart % period, -apart % period) if period < inf else apart
    return apart * frame(around.scene, body, xi1, xi2).p < SAME * around.size
