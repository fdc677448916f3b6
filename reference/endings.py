"""All statuses with which the first formulation ends a motion, each with its causes and their sentences; and the causes
of its transitions.

The conditions that end a phase are in `effect_laws.friction` (|T| ≤ µ N of `Coulomb.stick_conditions`) and
`minimal.assembly` (Painlevé's).
"""

from __future__ import annotations

from collections.abc import Sequence

from cases import Mode, Trajectory

Ending = tuple[str, str]  # status and sentence

# Guards whose zero changes the mode, with the cause that the transition reports.
CAUSES = {
    "slip": "the slip velocity vanished",
    "turn": "the rotation vanished",
    "cone_forward": "friction reached its cone",
    "cone_backward": "friction reached its cone",
    "couple_forward": "rolling resistance reached its bound",
    "couple_backward": "rolling resistance reached its bound",
    "normal_force": "the normal force vanished",
    "piece": "the contact passed to the next piece of its curve",
    "landing": "impact",
    "rest": "bouncing came to rest",
    **dict.fromkeys(("track_start", "track_end", "outline_start", "outline_end"), "the curvature jumped at a knot"),
}

# --- completed ----------------------------------------------------------------------------------------------------

COMPLETION: Ending = (Trajectory.status, Trajectory.reason)

# --- lift_off: without Flight -------------------------------------------------------------------------------------

LIFT_OFF = ("lift_off", "The normal force vanished and would pull: the plate leaves its track.")
OFF_CORNER = ("lift_off", "The plate's corner passed the track's corner: the plate leaves its track.")
OFF = (LIFT_OFF, OFF_CORNER)

# --- landing: an impact without a law, or without a direction ------------------------------------------------------

LANDING_END = ("landing", "The plate meets its track again, and the case names no Impact.")
CORNERS_MEET = (
    "landing",
    "A corner of the plate meets a corner of its track: the direction of the impact is not defined there.",
)
# --- track_end, outline_end, no_fit: curves end, or no longer fit; paradox where no force is consistent ------------

_LONGER = "make the curve longer, or give it as a Chain with a corner there"
# Guards whose zero ends the motion.
ENDS = {
    "painleve": (
        "paradox",
        "The normal equation's coefficient of λ vanished (Painlevé): rigid Coulomb contact has no unique force here.",
    ),
    "fit": ("no_fit", "The curvatures of outline and track became equal: the plate no longer fits its track here."),
    "track_start": ("track_end", f"The contact reached the start of the track's domain; {_LONGER}."),
    "track_end": ("track_end", f"The contact reached the end of the track's domain; {_LONGER}."),
    "outline_start": ("outline_end", "The contact reached the start of the outline's domain."),
    "outline_end": ("outline_end", "The contact reached the end of the outline's domain."),
}


def end_of_curve(t: float, who: str, which: str, end: float) -> Ending:
    """The ending where a plate meets an end of an open curve; `end`: the curve's parameter there."""
    return ENDS["track_end"][0], (
        f"{who} meets the end of {which} at xi1 = {end:.9g}, at t = {t:.9g} s, where no contact goes on; {_LONGER}."
    )


NO_MODE = ("paradox", "No mode of rigid Coulomb contact is consistent here (Painlevé).")
NO_SLIP = (
    "paradox",
    "A perfectly rough contact would have to pull here, and the free plate would move into its track: "
    "without slip it can neither stay nor leave.",
)

# --- second_contact: more contacts than the case's effects allow --------------------------------------------------

CONCAVE = ("second_contact", "The contact reached a corner inside which the plate touches its track in a second place.")
FLAT = ("second_contact", "The contact reached a piece along which the plate lies on its track: it touches twice.")


def second_place(t: float, xi1: float) -> Ending:
    """The ending where the plate meets its track in a second place."""
    return FLAT[0], f"The plate meets its track in a second place, xi1 = {xi1:.9g}, at t = {t:.9g} s."


def no_impact_law(t: float, who: str, which: str, xi1: float, lands: bool) -> Ending:
    """The ending where a contact closes and the case has no impacts: the plate, and the curve that it meets; `lands`:
    whether there are several plates, or the only one flew."""
    return LANDING_END[0] if lands else FLAT[0], (
        f"{who} meets {which}, xi1 = {xi1:.9g}, at t = {t:.9g} s, and the case names no Impact; add Flight() and "
        "Impact(0.0) to go on."
    )


# --- not_unique, energy_gain: the laws do not decide --------------------------------------------------------------


NOT_UNIQUE = "not_unique"


def several_motions(t: float, names: Sequence[str], motions: Sequence[Sequence[Mode]]) -> Ending:
    """The ending where several motions are consistent, each given by the modes of the contacts with these names."""
    choices = "; ".join(
        ", ".join(f"{name} {mode}" for name, mode in zip(names, modes, strict=True)) for modes in motions
    )
    return NOT_UNIQUE, f"{len(motions)} motions of rigid Coulomb contact are consistent at {t:.9g} s: {choices}."


def several_impacts(t: float, problem: Exception) -> Ending:
    """The ending where the law of impact does not have one result for a group of contacts."""
    return NOT_UNIQUE, f"At t = {t:.9g} s {problem}."


ENERGY = ("energy_gain", "Newton's law of restitution would create energy in this impact; give law='poisson'.")

# --- accumulation: events that take no time -----------------------------------------------------------------------

ACCUMULATION = ("accumulation", "Changes of regime accumulate: they take no time.")
LIFTED = (
    ACCUMULATION[0],
    "An effect that does not act in flight lifts the plate off as soon as it touches: it can neither stay nor fly.",
)


def events_without_time(t: float, count: int, what: str) -> Ending:
    """The ending after that many events at one instant; `what` names them."""
    return ACCUMULATION[0], f"{count} {what} took no time at t = {t:.9g} s."


# --- breakdown: numbers -------------------------------------------------------------------------------------------

BREAKDOWN = "breakdown"  # also used instead of a guard's name if the equations became singular


def undecidable(t: float) -> Ending:
    """The ending if a decision meets numbers that are not finite."""
    return no_numbers(t, "sizes, speeds and forces are too far apart for double precision, or a formula has no value")


def no_numbers(t: float, problem: Exception | str) -> Ending:
    """The ending if a quantity, such as a nearest point, cannot be computed."""
    return BREAKDOWN, f"After t = {t:.9g} s {problem}."


def singular_ending(t: float) -> Ending:
    """The ending if the equations became singular and no step can continue."""
    return BREAKDOWN, f"The equations became singular at t = {t:.9g} s, and no step was small enough."


def forces_not_unique(t: float, names: Sequence[str]) -> Ending:
    """The ending where forces that are not unique change a motion that moves."""
    return BREAKDOWN, (
        f"At t = {t:.9g} s the forces of {', '.join(names)} are not unique while the plates move, and this motion is "
        "not computed."
    )


# --- unfinished: limits on work -----------------------------------------------------------------------------------

WORK_LIMIT = "unfinished"


def work_limit_ending(t: float, steps: int) -> Ending:
    """The ending if a motion reaches its limit on steps."""
    return WORK_LIMIT, (
        f"The motion took {steps} steps until t = {t:.9g} s, the limit of a run; end it there, or use "
        "slower speeds and forces."
    )


def phase_limit_ending(t: float, count: int) -> Ending:
    """The ending if a motion reaches its limit on phases."""
    return WORK_LIMIT, f"The modes changed {count} times until t = {t:.9g} s, the limit of a run; end it there."


def search_limit_ending(t: float) -> Ending:
    """The ending if the search for landings reaches its limit on work."""
    return WORK_LIMIT, (
        f"The search for landings reached the limit of a run at t = {t:.9g} s; end it there, or use slower "
        "speeds and spins, or coarser curves."
    )


def combination_limit_ending(t: float, names: Sequence[str]) -> Ending:
    """The ending if so many contacts touch together that not all of their modes are tried."""
    return WORK_LIMIT, (
        f"{', '.join(names)} touch together at t = {t:.9g} s and have more combinations of modes than are tried; give "
        "fewer plates, or no friction where it matters least."
    )


# --- broken_law: the solver is wrong ------------------------------------------------------------------------------

BROKEN_LAW = "broken_law"


def law_ending(law: object, ending: Ending) -> Ending:
    """The ending of a motion that breaks a law, which otherwise had an ending."""
    status, reason = ending
    return BROKEN_LAW, f"The motion breaks a law, so the solver is wrong: {law}. It ended as {status}: {reason}"


# Every status, and what ends a motion with it. Own effects have statuses of their own.
STATUSES = {
    COMPLETION[0]: "the motion ran to its end",
    LIFT_OFF[0]: "the plate leaves its track, and the case has no Flight",
    LANDING_END[0]: "the plate meets its track, and the case has no Impact or two corners meet",
    "track_end": "the contact, or a plate from the side, reached an end of an open track or support",
    "outline_end": "the contact reached an end of an open outline",
    "no_fit": "the curvatures of outline and track became equal",
    FLAT[0]: "the plate touches in a second place, and the case's effects are for one contact or have no Impact",
    NO_MODE[0]: "no motion of rigid Coulomb contact is consistent",
    "not_unique": "several motions, or results of an impact, are consistent",
    ENERGY[0]: "Newton's law of restitution would create energy",
    ACCUMULATION[0]: "events accumulate at an instant that has no known continuation",
    BREAKDOWN: "a number of the motion is not finite, not unique or cannot be computed",
    WORK_LIMIT: "a limit on work was reached",
    BROKEN_LAW: "the motion breaks a law of mechanics: the solver is wrong",
}
