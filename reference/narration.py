"""A motion described in one line: the output of `slip-to-roll cases check` for each case."""

from __future__ import annotations

from cases import BadValue, Case, CaseError, Gravity, Mode, Trajectory, Unilateral
from cases.contact import start_motion
from cases.errors import describe
from cases.scene.limits import without_certificate

from .solve import simulate

# The part of gravity's strength along the track's normal above which it pulls the plate off: a vertical wall has none,
# except for rounding.
_PULLS = 1e-9


def check(case: Case) -> str:
    """Run the case by the best method and describe the motion; raises CaseError with one sentence if it cannot run."""
    try:
        motion = simulate(case)
        return f"{motion.in_words()}{wrong_side(case, motion)}{_without_certificate(case, motion)}"
    except CaseError:
        raise
    except Exception as problem:  # any error of the user's curves and loads
        raise BadValue(f"the motion fails: {describe(problem)}") from problem


def _without_certificate(case: Case, motion: Trajectory) -> str:
    """A note if the motion is one that the second formulation does not compute; "" if it is."""
    has_several = bool(case.others) or len(motion.contact_names) > 1
    reason = without_certificate(case) if has_several else ""
    return f". Note: the motion is checked by its laws only, without a certificate: {reason}" if reason else ""


def wrong_side(case: Case, motion: Trajectory) -> str:
    """A note if the plate probably lies on the wrong side of its track: gravity pulls it off. "" if it does not, or if
    the plate starts in flight."""
    gravity = case.effect(Gravity)
    if gravity is None or not case.start.in_contact:
        return ""
    normal = case.track.normal(start_motion(case).xi1)
    if gravity.vector[0] * normal[0] + gravity.vector[1] * normal[1] <= _PULLS * gravity.g:
        return ""
    below = "the plate lies on the left of increasing s, where gravity pulls it off its track"
    turn = "to put it on the other side let the curve run the other way (-s for s, in xi1 too)"
    if case.effect(Unilateral) is None:
        return f". Note: {below}, and hangs there, because without Unilateral the contact holds it; {turn}"
    leaves = motion.first_mode in (None, Mode.FLIGHT) or motion.t[-1] == 0.0
    return f". Note: {below}; {turn}" if leaves else ""
