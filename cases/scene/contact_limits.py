"""Which cases have several contacts: a plate that touches its track, or its track and supports, in several places."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..contact.nearest import contacts
from ..contact.outline_features import features
from ..curves import Curve
from ..curves.chain import Chain
from ..effects import Flight
from .case_class import Case
from .limits import Scope, as_sentence, limit, without_certificate
from .piece_case import has_pieces
from .start_pose import TOUCHES
from .supports import is_hill

# Contacts are in one place if they are closer than this part of the plate's size.
APART = 1e-6


def limitation(case: Case) -> str:
    """Why a motion of this case with several contacts is not computed by both formulations, in a sentence; "" if it
    is."""
    return as_sentence(limit(case, Scope.SEVERAL_CONTACTS) or without_certificate(case))


def has_features(case: Case) -> bool:
    """Whether the case's contacts, where there are several, are pairs of a support and a feature of the outline."""
    return bool(case.supports) or isinstance(case.plate.outline, Chain)


def is_general_case(case: Case) -> bool:
    """Whether a motion is computed in poses of any number of plates, with pairs of elements of their curves."""
    if case.others:
        return True
    return (case.plate.spins_by_load or has_pieces(case)) and not case.plate.turns


def touches_by_features(case: Case) -> bool:
    """Whether a motion is computed with several contacts from its start on: it has supports, a polygon may fly, or a
    plate with corners begins on a flat side."""
    return bool(case.supports) or (isinstance(case.plate.outline, Chain) and _corners_touch(case))


@lru_cache(maxsize=256)
def _corners_touch(case: Case) -> bool:
    """The same for a plate with corners on a track alone."""
    if (
        limit(case, Scope.SEVERAL_CONTACTS) or limit(case, Scope.SHAPES) or is_hill(case.track)
    ):  # a convex plate touches a hill in one place
        return False
    if case.effect(Flight) is not None and not any(isinstance(piece, Curve) for piece in features(case.plate.outline)):
        return True
    if case.start.gap > 0.0:
        return False
    begin = case.start.motion(case.track, case.plate.outline)
    pose, size = (begin.x, begin.y, begin.theta), abs(begin.x) + abs(begin.y) + case.plate.reach
    some = contacts(case.track, case.plate.outline, *pose)
    places = [case.track.point(one.xi1) for one in some if abs(one.gap) <= TOUCHES * size]
    return any(np.hypot(*(place - places[0])) > APART * case.plate.reach for place in places)
