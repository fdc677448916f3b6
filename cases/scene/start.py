"""The start of a motion: position and velocity of the plate at its track, and their checks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..contact import geometry
from ..contact.overlap_search import deepest_overlap, first_overlap
from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner
from ..effects import Effect, Flight, Impact, PerfectlyRough
from ..errors import BadValue, DoesNotFit, finite, instance, items, not_negative
from .plate import is_convex


@dataclass(frozen=True)
class Start:
    """Where and how the plate touches its track at time zero.

    `xi1`, `xi2`: contact parameters on track and outline (xi2=None: such that θ = 0); `slip`: slip velocity along
    the track's unit tangent in m/s; `omega`: angular velocity in rad/s, counter-clockwise. A start off the track
    (Flight): `gap`, the distance in m of the outline's point from the track's along the track's left normal, their
    tangents parallel; `gap_rate`, the velocity in m/s of the outline's point along that normal (negative with gap = 0:
    it begins with an impact).
    """

    xi1: float
    xi2: float | None = None
    slip: float = 0.0
    omega: float = 0.0
    gap: float = 0.0
    gap_rate: float = 0.0

    def __post_init__(self):
        object.__setattr__(self, "xi1", finite("xi1 of Start", self.xi1))
        if self.xi2 is not None:
            object.__setattr__(self, "xi2", finite("xi2 of Start", self.xi2))
        object.__setattr__(self, "slip", finite("slip of Start", self.slip))
        object.__setattr__(self, "omega", finite("omega of Start", self.omega))
        object.__setattr__(self, "gap", not_negative("gap of Start", self.gap))
        object.__setattr__(self, "gap_rate", finite("gap_rate of Start", self.gap_rate))

    @property
    def in_contact(self) -> bool:
        """Whether the plate begins on its track, neither apart from it nor about to hit or leave it."""
        return self.gap == 0.0 and self.gap_rate == 0.0

    def motion(self, track: Curve, outline: Curve) -> geometry.MotionPoint:
        """The start as pose, velocities and contact rates. Raises DoesNotFit for an xi2 that cannot be guessed."""
        return _motion(self, instance("track", track, Curve, Corner), instance("outline", outline, Curve, Corner))

    def check(self, track: Curve, outline: Curve, effects: tuple[Effect, ...]) -> None:
        """Raise DoesNotFit or BadValue for an inadmissible contact, or a start that needs an effect the case lacks."""
        track, outline = instance("track", track, Curve), instance("outline", outline, Curve)
        xi1, ends = self.xi1, track.ends
        if ends and not ends[0] <= xi1 <= ends[1]:
            raise BadValue(f"xi1 = {xi1:g} of Start is outside the track's domain ({ends[0]:g}, {ends[1]:g})")
        self._check_effects(tuple(type(effect) for effect in items("effects", effects)))
        _check_place(self, track, outline)

    def _check_effects(self, kinds: tuple[type, ...]) -> None:
        if (self.gap > 0.0 or self.gap_rate > 0.0) and Flight not in kinds:
            raise BadValue(
                f"the plate begins off the track (gap {self.gap:.3g} m, gap_rate {self.gap_rate:.3g} m/s); "
                "add Flight to the effects or start it on the track"
            )
        if self.gap == 0.0 and self.gap_rate < 0.0 and Impact not in kinds:
            raise BadValue(
                f"gap_rate = {self.gap_rate:g} of Start begins with an impact; "
                "add Impact to the effects or give gap_rate=0"
            )
        if self.in_contact and self.slip != 0.0 and PerfectlyRough in kinds:
            raise BadValue(f"a PerfectlyRough contact does not slip; give slip=0 in Start, not {self.slip:g}")


# Contact speeds are divided by the difference of the curvatures: 1e10 leaves six digits of it.
NARROW = 1e10

# These results depend only on the curves and the start, and scenes are often made again with another friction.


@lru_cache(maxsize=1024)
def _outline_parameter(start: Start, track: Curve, outline: Curve) -> float:
    return geometry.level_parameter(track, outline, start.xi1) if start.xi2 is None else start.xi2


@lru_cache(maxsize=1024)
def _motion(start: Start, track: Curve, outline: Curve) -> geometry.MotionPoint:
    xi2 = _outline_parameter(start, track, outline)
    if start.in_contact:
        return geometry.velocity(track, outline, start.xi1, xi2, start.slip, start.omega)
    moves = start.slip, start.omega, start.gap, start.gap_rate
    return geometry.velocity_apart(track, outline, start.xi1, xi2, *moves)


@lru_cache(maxsize=1024)
def _check_place(start: Start, track: Curve, outline: Curve) -> None:
    """Raise DoesNotFit where the plate has no room (exceptions are not cached)."""
    xi1, xi2 = start.xi1, _outline_parameter(start, track, outline)
    if start.gap == 0.0 and not geometry.clearance(track, outline, xi1, xi2) > 0.0:
        raise DoesNotFit(
            f"the plate does not fit its track at xi1 = {xi1:g}: the track's curvature "
            f"{float(track.curvature(xi1)):.6g} 1/m is not below the outline's "
            f"{float(outline.curvature(xi2)):.6g} 1/m; give a smaller plate or a wider track"
        )
    bends = float(track.curvature(xi1)), float(outline.curvature(xi2))
    if start.gap == 0.0 and bends[1] - bends[0] < max(map(abs, bends)) / NARROW:
        raise DoesNotFit(
            f"the plate fits its track at xi1 = {xi1:g} too closely: curvatures {bends[0]:.9g} and {bends[1]:.9g} 1/m "
            f"differ by less than a {NARROW:g}th, and the contact's speed is a difference divided by theirs; give a "
            "smaller plate or a wider track"
        )
    state = _motion(start, track, outline)  # only if the plate fits: divides by the difference of the curvatures
    x, y, theta, near = (np.array([value]) for value in (state.x, state.y, state.theta, xi1))
    overlap = first_overlap(track, outline, x, y, theta, near)
    if overlap:
        raise DoesNotFit(
            f"the plate overlaps its track at xi1 = {overlap[1]:.6g} while it touches at xi1 = {xi1:g}; "
            "give a smaller plate or another start"
        )
    if track.features is None and not isinstance(track, Chain) and is_convex(outline):
        return  # one point of the outline has the line's direction
    deepest = deepest_overlap(track, outline, state.x, state.y, state.theta, xi1)
    if deepest:
        raise DoesNotFit(
            f"the plate overlaps its track by {-deepest.gap:.6g} m at xi1 = {deepest.xi1:.9g} where it begins; give "
            "another start"
        )
