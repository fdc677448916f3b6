"""Couples of a plate and what it may touch: the track, a support, or another plate, whose outline is a moving track.

A couple is a case of its own with one plate and one track, in the frame of the body that the track belongs to. Its
contacts are those of the elements of both curves (`piece_case`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np

from ..contact.close_pairs import nearest_on
from ..contact.polygon_features import local_centre
from ..curves import Curve
from ..curves.backwards import backwards, forwards
from ..curves.corner import Corner, end_corners
from .case_class import Case
from .case_part import CasePart
from .free_plates import names_of, plates_of
from .start import Start
from .supports import TRACK, effects_at

# An end lies on a curve that is nearer than this part of the plate's reach: a rounding of places that are given.
SAME_PLACE = 1e-9


class PlateBoundary(NamedTuple):
    """What a plate may touch: its name, its curve with the plate on its left, and the number of the plate that it
    belongs to (None: it is fixed)."""

    name: str
    curve: Curve
    body: int | None


class Couple(CasePart):
    """One plate of the case `whole` and one boundary; its track is the boundary's curve in its own frame.

    `number`: which of `couples(whole)` it is; `body`: the number of its plate; `base`: that of the plate with the
    boundary, None if it is fixed; `pair_name`: of its contacts, such as "plate/wall".
    """

    number: int
    body: int
    base: int | None
    pair_name: str

    def __reduce__(self):
        return _couple, (self.whole, self.number)

    def relative_pose(self, poses: np.ndarray) -> tuple[Any, Any, Any]:
        """(x, y, θ) of the plate in the frame of the boundary; `poses` are those of all plates, (3 n,) or (3 n, m)."""
        x, y, theta = poses[3 * self.body : 3 * self.body + 3]
        if self.base is None:
            return x, y, theta
        base = poses[3 * self.base : 3 * self.base + 3]
        return *local_centre(base, x, y), theta - base[2]

    def whole_xi1(self, xi1):
        """A parameter of the track as one of the boundary's own curve: of a plate its outline."""
        if self.base is None:
            return xi1
        return forwards(plates_of(self.whole)[self.base].outline, xi1)


class CurveEnd(Couple):
    """One plate and an end of an open track or support, which is no contact: its track is the corner there.

    `end`: the curve's parameter there; `number`, `body` and `pair_name` are those of the couple with the curve.
    """

    end: float

    def __reduce__(self):
        return _curve_end, (self.whole, self.key)

    @property
    def corner(self) -> Corner:
        """The end."""
        return cast(Corner, self.track)


@lru_cache(maxsize=256)
def couples(case: Case) -> tuple[Couple, ...]:
    """Each plate with the track and each support, then with each plate before it."""
    names, plates, result = names_of(case), plates_of(case), list[Couple]()
    fixed = [PlateBoundary(TRACK, case.track, None)]
    fixed += [PlateBoundary(one.name, one.curve, None) for one in case.supports]
    for body in range(len(plates)):
        for boundary in fixed:
            result.append(_make(case, len(result), body, boundary))
        for other in range(body):
            own, base = (body, other) if plates[body].radius is not None else (other, body)
            outline = PlateBoundary(names[base], backwards(plates[base].outline), base)
            result.append(_make(case, len(result), own, outline))
    return tuple(result)


def _make(whole: Case, number: int, body: int, boundary: PlateBoundary) -> Couple:
    plate, name = plates_of(whole)[body], f"{names_of(whole)[body]}/{boundary.name}"
    start = Start(*(0.5 * sum(curve.span) for curve in (boundary.curve, plate.outline)))
    return Couple.of(
        whole, (number,), track=boundary.curve, plate=plate, effects=effects_at(whole, name), start=start, supports=(),
        others=(), pairs=(), number=number, body=body, base=boundary.body, pair_name=name,
    )  # fmt: skip


@lru_cache(maxsize=256)
def curve_ends(case: Case) -> tuple[CurveEnd, ...]:
    """Each plate with the ends of the track and the supports that are open, but for those that lie on another of these
    curves, which has the contacts there. An open outline encloses nothing that an end could enter."""
    result, fixed = list[CurveEnd](), [case.track, *(support.curve for support in case.supports)]
    for couple in couples(case):
        if couple.base is not None or not couple.plate.outline.period:
            continue
        others = [curve for curve in fixed if curve is not couple.track]
        own = {name: value for name, value in vars(couple).items() if name not in ("whole", "key")}
        for end, corner in end_corners(couple.track):
            if any(_is_inside(corner, curve, couple.plate.reach) for curve in others):
                continue
            result.append(CurveEnd.of(case, (couple.number, len(result)), **own | dict(track=corner, end=end)))
    return tuple(result)


def _is_inside(end: Corner, curve: Curve, reach: float) -> bool:
    """Whether an end lies on another curve, between the ends of that."""
    here, least = np.array([end.x, end.y]), SAME_PLACE * reach
    places = [nearest_on(curve, end.x, end.y), *(curve.ends or ())]
    on_curve, *at_ends = (bool(np.hypot(*(curve.point(s) - here)) <= least) for s in places)
    return on_curve and not any(at_ends)


def _curve_end(whole: Case, key: tuple[int, int]) -> CurveEnd:
    return curve_ends(whole)[key[1]]


def _couple(whole: Case, number: int) -> Couple:
    return couples(whole)[number]
