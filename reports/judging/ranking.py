"""The level of accuracy that a ladder reaches, and the ranking of routes over the same cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, inf, log10
from typing import NamedTuple

from .score import Score

# Limits of the digits of a score: beyond 4 they depend on the samples; below -1 one case could outweigh all others.
_MOST, _LEAST = 4.0, -1.0
# Routes within a tenth of a digit (26 % of the score) are tied: other constants of the score change it by up to 10 %.
TIE = 0.1


class FirstWithin(NamedTuple):
    """The setting from which on a route stays within a level. `first`: its number in the ladder, None if there is none;
    `settings`: number of settings from it to the finest; a single one is not confirmed by a finer one. `is_known`:
    False if the doubt leaves open whether the level is reached."""

    first: int | None
    settings: int
    is_known: bool


def first_within(ladder: Sequence[tuple[float, float]], level: float) -> FirstWithin:
    """The first setting of a ladder, coarse to fine, at which off and doubt together stay within the level, as they do
    at all finer ones. `ladder`: off and doubt of each setting with a motion."""
    first, settings, possible = None, 0, False
    highest, lowest = 0.0, 0.0
    for number, (off, doubt) in reversed(list(enumerate(ladder))):
        highest = max(highest, off + doubt)
        lowest = max(lowest, off - doubt)
        if highest <= level:
            first, settings = number, settings + 1
        possible = possible or lowest <= level
    return FirstWithin(first, settings, first is not None or not possible)


def digits(off: float) -> float:
    """-log10 of off within its limits: 2 for 1 % off, 0 for ignoring friction's law, less than 0 for a misleading
    motion."""
    return min(max(-log10(off) if off > 0.0 else inf, _LEAST), _MOST)


class Standing(NamedTuple):
    """A route in a ranking: its mean `digits` and their `doubt`, the number of its `motions`, and its
    `rank`: 1 + the number of routes that are better by more than a tie."""

    route: str
    digits: float
    doubt: float
    motions: int
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
    standings = [Standing(route, *mean, 1 + _better(mean, means)) for route, mean in means.items()]
    return sorted(standings, key=lambda standing: (-standing.digits, standing.route))


def _doubt(score: Score) -> float:
    """Half the range of digits that a score's doubt leaves open."""
    return 0.5 * (digits(max(score.off - score.doubt, 0.0)) - digits(score.off + score.doubt))


def _better(mean: tuple[float, float, int], means: Mapping[str, tuple[float, float, int]]) -> int:
    """The number of routes that are better than one with that mean by more than a tie and both doubts. The doubts of
    different cases are independent."""
    return sum(other[0] - mean[0] > max(TIE, hypot(other[1], mean[1])) for other in means.values())
