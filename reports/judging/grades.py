"""Grades: a score in words, with the reason for it."""

from __future__ import annotations

from enum import StrEnum
from math import isfinite

from .friction_sensitivity import small_share
from .score import Scale, Score


class Grade(StrEnum):
    """How far a motion is from the truth, in words; the limits are in `LIMITS`."""

    EXCELLENT = "excellent"
    VERY_GOOD = "very good"
    GOOD = "good"
    ROUGH = "rough"
    POOR = "poor"
    UNUSABLE = "unusable"
    UNDECIDED = "not decided"


# The largest score of each grade; above the last a motion is about as far off as one that ignores friction's law.
LIMITS = {
    Grade.EXCELLENT: 1e-4,
    Grade.VERY_GOOD: 1e-3,
    Grade.GOOD: 1e-2,
    Grade.ROUGH: 0.1,
    Grade.POOR: 0.5,
}
# The levels of accuracy that tables and rankings ask for, the coarsest first: the limits of the grades from rough on.
LEVELS = tuple(sorted((limit for name, limit in LIMITS.items() if name is not Grade.POOR), reverse=True))
# Sequences that agree only without phases as long as this part of the motion do not agree.
_LONGEST = 0.1
# A friction × within these limits is not a reason for a grade.
USUAL_FRICTION = (0.9, 1.1)


def grade(off: float, doubt: float = 0.0) -> Grade:
    """The grade that `off + doubt` and `off - doubt` share, "not decided" if they have different ones; a score that is
    no number is unusable."""
    best, worst = bounds(off, doubt)
    return best if best is worst else Grade.UNDECIDED


def bounds(off: float, doubt: float) -> tuple[Grade, Grade]:
    """The best and the worst grade that a score's doubt leaves possible."""
    best, worst = (
        next((name for name, limit in LIMITS.items() if end <= limit), Grade.UNUSABLE)
        for end in (off - doubt, off + doubt)
    )
    return best, worst


def is_within(score: Score, level: float) -> bool | None:
    """Whether a motion is right to a level: True if `off + doubt` is within it, False if `off - doubt` is not, None if
    its samples do not decide."""
    if score.off + score.doubt <= level:
        return True
    return None if score.off - score.doubt <= level else False


def sequence_note(score: Score, scale: Scale) -> str:
    """How the sequence of modes of a motion agrees with the truth's."""
    if not score.sequence <= max(_LONGEST * scale.end, score.resolution):
        return "another sequence of modes"
    if score.sequence <= score.resolution:
        return "same sequence"
    if score.missing:
        return f"misses phases of up to {duration(score.sequence)}"
    return f"same sequence down to {duration(score.sequence)}"


def summary(score: Score, friction: float, why: str) -> str:
    """A score in one line: off and its doubt, grade, friction × where it is known, and the reason."""
    friction_text = [f"friction × {_short(friction)}"] if isfinite(friction) else []
    words = grade(score.off, score.doubt)
    return "; ".join([f"off {percent(score.off)} ± {percent(score.doubt)}: {words}", *friction_text, why])


def reason(score: Score, scale: Scale, friction: float) -> str:
    """Why a motion has its grade: which of the scores is the largest, and what explains it. `friction`: its friction ×,
    NaN where that is not known."""
    phrases = [_largest(score, scale)]
    note = sequence_note(score, scale)
    if note != "same sequence":
        phrases.append(note)
    if isfinite(friction) and not USUAL_FRICTION[0] <= friction <= USUAL_FRICTION[1]:
        phrases.append(f"friction and other losses are {_short(friction)} times those of the law")
    if small_share(scale):
        phrases.append(f"not ranked: {small_share(scale)}")
    best, worst = bounds(score.off, score.doubt)
    if best is not worst:
        phrases.append(f"{best} to {worst}: its samples leave {percent(score.doubt)} in doubt; give more of them")
    return "; ".join(phrases)


def _largest(score: Score, scale: Scale) -> str:
    """The largest of the three scores, in words."""
    if score.off == score.pose:
        return f"pose: {percent(score.pose)} of the error of ignoring friction"
    if score.off == score.mode:
        return f"modes: {duration(score.mode * scale.time)} in another mode than the truth"
    return f"slip velocity: {percent(score.slip)} of the error of ignoring friction"


def percent(share: float) -> str:
    """A share as text: 0.0123 is "1.2 %"."""
    if share < 1e-6:
        return "less than 0.0001 %"
    return f"{_short(100.0 * share)} %"


def duration(seconds: float) -> str:
    """A time as text in a fitting unit: 6.2e-6 is "6.2 µs"."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{_short(seconds / size)} {unit}"
    return f"{_short(seconds / 1e-9)} ns" if seconds >= 1e-9 else "less than 1 ns"


def _short(value: float) -> str:
    """A number with two digits, without an exponent where it needs none."""
    return f"{float(f'{value:.2g}'):g}"
