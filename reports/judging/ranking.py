"""Which accuracy a route reaches, and how routes compare over the same cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, inf, log10
from typing import NamedTuple

from .score import Score

# Digits of a score: not more than 4, since more are those of the samples; and not less than -1, or one case could
# outweigh all others.
_MOST, _LEAST = 4.0, -1.0
# Routes within a tenth of a digit (26 % of the score) are tied: other constants of the score change it by up to 10 %.
TIE = 0.1


class Reached(NamedTuple):
    """From which setting on a route stays within a level. `first`: its number in the ladder, None where there is none;
    `settings`: how many settings there are from it to the finest; one alone confirms nothing. `known`: False where the
    samples leave open whether the level is reached."""

    first: int | None
    settings: int
    known: bool

    @property
    def confirmed(self) -> bool:
        """Whether finer settings confirm it."""
        return self.settings > 1


def reached(ladder: Sequence[Score | None], level: float) -> Reached:
    """From which setting of a ladder, coarse to fine, score and doubt together stay within the level at it and at all
    finer ones. Settings without a motion (None) say nothing."""
    first, settings, possible = None, 0, False
    highest, lowest = 0.0, 0.0
    for number, score in reversed(list(enumerate(ladder))):
        if score is None:
            continue
        highest = max(highest, score.off + score.doubt)
        lowest = max(lowest, score.off - score.doubt)
        if highest <= level:
            first, settings = number, settings + 1
        possible = possible or lowest <= level
    return Reached(first, settings, first is not None or not possible)


def digits(off: float) -> float:
    """How many digits are right of what friction does: 2 for 1 % off, 0 for ignoring friction's law, less than 0 for a
    misleading motion."""
    return min(max(-log10(off) if off > 0.0 else inf, _LEAST), _MOST)


class Standing(NamedTuple):
    """A route in a ranking: its mean `digits` and their `doubt`, how many of the cases it `answered`, and its `rank`,
    which is 1 + the number of routes that are better by more than a tie."""

    route: str
    digits: float
    doubt: float
    answered: int
    rank: int


def ranking(scores: Mapping[str, Mapping[str, Score]], cases: Sequence[str]) -> list[Standing]:
    """The routes over the same cases, best first; `scores`: of each route, by case. A case without a score (rejected,
    crashed, timed out) counts as ignoring friction's law, 0 digits: better than a misleading motion."""
    if not cases:
        return []
    means = {}
    for route, own in scores.items():
        answers = [own.get(case) for case in cases]
        mean = sum(digits(score.off) for score in answers if score) / len(cases)
        doubt = hypot(*(_doubt(score) for score in answers if score)) / len(cases)
        means[route] = mean, doubt, sum(score is not None for score in answers)
    found = [Standing(route, *mean, 1 + _better(mean, means)) for route, mean in means.items()]
    return sorted(found, key=lambda standing: (-standing.digits, standing.route))


def _doubt(score: Score) -> float:
    """Half the range of digits that a score's doubt leaves open."""
    return 0.5 * (digits(max(score.off - score.doubt, 0.0)) - digits(score.off + score.doubt))


def _better(mean: tuple[float, float, int], means: Mapping[str, tuple[float, float, int]]) -> int:
    """How many routes are better than one with that mean, by more than a tie and both doubts. The doubts of different
    cases are independent."""
    return sum(other[0] - mean[0] > max(TIE, hypot(other[1], mean[1])) for other in means.values())
