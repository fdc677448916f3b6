"""The end of a phase: its causes, the statuses and sentences that end a motion, and what follows.

The conditions that end a phase are in `effects` (|T| ≤ µ N of `Coulomb.conditions`) and `assembly` (Painlevé's).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Trajectory
from cases.piece_case import PieceCase

from ..transition_causes import CAUSES as CAUSES  # several formulations read it here
from .integrators.segment import BREAKDOWN, Segment
from .modes import Regime

# This many changes of regime that take no time end a motion.
MANY = 1000

# Limit on the steps of one run: their record, which is made when samples are requested, fills a gigabyte or two. (A
# hundred thousand changes of a limping wheel take 830,000.)
MOST_STEPS = 1_000_000

# Relative error of an event's location, whatever the tolerance of the motion that led there.
LOCATION_ERROR = 1e-12

# Values within this part of a bound are at it where phases of zero length follow each other: a thousand times the
# location's error.
ROUGH = 1e-9

Ending = tuple[str, str]  # status and sentence
COMPLETION: Ending = (Trajectory.status, Trajectory.reason)

# Guards whose zero ends the motion.
ENDS = {
    "painleve": (
        "paradox",
        "The normal equation's coefficient of λ vanished (Painlevé): rigid Coulomb contact has no unique force here.",
    ),
    "fit": ("no_fit", "The curvatures of outline and track became equal: the plate no longer fits its track here."),
    "track_start": ("track_end", "The contact reached the start of the track's domain."),
    "track_end": ("track_end", "The contact reached the end of the track's domain."),
    "outline_start": ("outline_end", "The contact reached the start of the outline's domain."),
    "outline_end": ("outline_end", "The contact reached the end of the outline's domain."),
}
# Guards at the ends of a piece: whether it is the track's, and which way the contact leaves it.
PIECE_ENDS = {
    "track_start": (True, -1),
    "track_end": (True, 1),
    "outline_start": (False, -1),
    "outline_end": (False, 1),
}
CONCAVE = ("second_contact", "The contact reached a corner inside which the plate touches its track in a second place.")
FLAT_LANDING = ("second_contact", "The plate lands on a flat side: it touches its track in two places at once.")
CORNERS_MEET = (
    "landing",
    "A corner of the plate meets a corner of its track: the direction of the impact is not defined there.",
)
FLAT = ("second_contact", "The contact reached a piece along which the plate lies on its track: it touches twice.")
OFF_CORNER = ("lift_off", "The plate's corner passed the track's corner: the plate leaves its track.")
LIFT_OFF = ("lift_off", "The normal force vanished and would pull: the plate leaves its track.")
OFF = (LIFT_OFF, OFF_CORNER)
LANDING_END = ("landing", "The plate meets its track again, and the case names no Impact.")
ENERGY = ("energy_gain", "Newton's law of restitution would create energy in this impact; give law='poisson'.")
NO_MODE = ("paradox", "No mode of rigid Coulomb contact is consistent here (Painlevé).")
NO_SLIP = (
    "paradox",
    "A perfectly rough contact would have to pull here, and the free plate would move into its track: "
    "without slip it can neither stay nor leave.",
)
ACCUMULATION = ("accumulation", "Changes of regime accumulate: they take no time.")
LIFTED = (
    ACCUMULATION[0],
    "An effect that does not act in flight lifts the plate off as soon as it touches: it can neither stay nor fly.",
)


class Step(NamedTuple):
    """The result of a phase: its segments, time, place (ξ₁, ξ₂) and cause of its end, and the full state and regime
    that follow, or the ending."""

    segments: tuple[Segment, ...]
    time: float
    place: tuple[float, float] = (np.nan, np.nan)
    cause: str = ""
    state: tuple[float, ...] = ()
    regime: Regime | None = None
    ending: Ending = COMPLETION
    is_listed: bool = True  # whether an impact between two flights is listed
    pieces: PieceCase | None = None  # those that the contact passes to


def undecidable(t: float) -> Ending:
    """The ending if a decision meets numbers that are not finite."""
    why = "sizes, speeds and forces are too far apart for double precision, or a formula has no value"
    return BREAKDOWN, f"After t = {t:.9g} s {why}."


def singular_ending(t: float) -> Ending:
    """The ending if the equations became singular and no step can continue."""
    return BREAKDOWN, f"The equations became singular at t = {t:.9g} s, and no step was small enough."


def work_limit_ending(t: float, steps: int) -> Ending:
    """The ending if a motion reaches its limit on steps."""
    return "unfinished", (
        f"The motion took {steps} steps until t = {t:.9g} s, the limit of a run; end it there, or use "
        "slower speeds and forces."
    )


def search_limit_ending(t: float) -> Ending:
    """The ending if the search for landings reaches its limit on work."""
    return "unfinished", (
        f"The search for landings reached the limit of a run at t = {t:.9g} s; end it there, or use slower "
        "speeds and spins, or coarser curves."
    )
