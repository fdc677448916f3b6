"""Knots of curves in pieces: where a motion changes the piece of its track or of its plate's outline."""

from __future__ import annotations

from collections.abc import Sequence

from cases import Case

from .integrators.segment import Segment

# Guards that end a phase at the end of a piece: the row of the state, and the direction along the curve.
ENDS_OF_PIECES = {"track_start": (0, -1), "track_end": (0, 1), "outline_start": (1, -1), "outline_end": (1, 1)}
# Derivatives that must be continuous at a knot for the forces, and the rates of the contact point, to be continuous.
SMOOTH = 2


def passed(case: Case, segment: Segment, y: Sequence[float]) -> tuple[tuple[float, ...], bool] | None:
    """The full state beyond the knot that ended a segment, and whether forces are continuous there; None if the
    segment did not end at a knot."""
    row, step = ENDS_OF_PIECES.get(segment.event.guard or "", (0, 0))
    pieces = (case.track.parts, case.plate.outline.parts)[row]
    number = segment.phase.parts[row]
    if step == 0 or pieces is None or not pieces.has_neighbour(number, step):
        return None
    beyond = pieces.across(number, step, y[row])
    return (*y[:row], beyond, *y[row + 1 :]), pieces.order >= SMOOTH
