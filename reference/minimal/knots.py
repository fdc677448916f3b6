"""Knots of curves in pieces: where a motion changes the piece of its track or of its plate's outline."""

from __future__ import annotations

from collections.abc import Sequence

from cases import Case

from .integrators.segment import Segment
from .phase_end import PIECE_ENDS

# Derivatives that must be continuous at a knot for the forces, and the rates of the contact point, to be continuous.
SMOOTH = 2


def passed(case: Case, segment: Segment, y: Sequence[float]) -> tuple[tuple[float, ...], bool] | None:
    """The full state beyond the knot that ended a segment, and whether forces are continuous there; None if the
    segment did not end at a knot."""
    of_track, step = PIECE_ENDS.get(segment.event.guard or "", (True, 0))
    row = 0 if of_track else 1
    pieces = (case.track.parts, case.plate.outline.parts)[row]
    number = segment.phase.parts[row]
    if step == 0 or pieces is None or not pieces.has_neighbour(number, step):
        return None
    beyond = pieces.across(number, step, y[row])
    return (*y[:row], beyond, *y[row + 1 :]), pieces.order >= SMOOTH
