"""Transitions of a solver paired with the truth's: which are in both, which only in one of them, and their errors.

Where the truth or the solver has phases too short for a motion's samples, transitions in only one of them are
unresolved: samples cannot have the one, and do not show the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite, nan

from cases import Mode, Transition

from .slip_phases import RESOLVABLE_GAPS


@dataclass(frozen=True)
class LedgerRow:
    """One transition of the truth, of a solver, or of both. `event` counts from 1 in the truth's sequence for paired
    and missed ones, in the solver's own for spurious ones; times in s, NaN where there is none. `pairing`: paired,
    missed, spurious or unresolved, with NaN as the time that it lacks. `contact`: the truth's name of the contact if it
    has several, else ""."""

    event: int
    before: Mode
    after: Mode
    time: float
    reference_time: float
    error: float
    pairing: str
    contact: str = ""

    @property
    def is_true(self) -> bool:
        """Whether the truth has the transition."""
        return isfinite(self.reference_time)


def match(truth: Sequence[Transition], read: Sequence[Transition], gap: float = 0.0) -> tuple[LedgerRow, ...]:
    """Pair transitions by kind (before, after) and order: as many as can be, and of these pairings the one with the
    least sum of time errors. Other transitions of the truth are missed, those of the solver spurious; either is
    unresolved within `RESOLVABLE_GAPS` of a phase that is shorter than that, by samples `gap` seconds apart."""
    pairs = _pairing(truth, read)
    least = RESOLVABLE_GAPS * gap
    short = [*_short_spans(truth, least), *_short_spans(read, least)]

    def name(time: float, pairing: str) -> str:
        return "unresolved" if any(begin <= time <= end for begin, end in short) else pairing

    rows = []
    for i, j in pairs:
        error = read[j].time - truth[i].time
        rows.append(LedgerRow(i + 1, truth[i].before, truth[i].after, read[j].time, truth[i].time, error, "paired"))
    for i in sorted(set(range(len(truth))) - {i for i, _ in pairs}):
        pairing = name(truth[i].time, "missed")
        rows.append(LedgerRow(i + 1, truth[i].before, truth[i].after, nan, truth[i].time, nan, pairing))
    for j in sorted(set(range(len(read))) - {j for _, j in pairs}):
        pairing = name(read[j].time, "spurious")
        rows.append(LedgerRow(j + 1, read[j].before, read[j].after, read[j].time, nan, nan, pairing))
    return tuple(sorted(rows, key=lambda row: row.reference_time if isfinite(row.reference_time) else row.time))


def _short_spans(events: Sequence[Transition], least: float) -> list[tuple[float, float]]:
    """The spans, s, of phases that last less than `least`, with as much on both sides."""
    spans = ((one.time - least, other.time + least) for one, other in pairwise(events))
    return [(begin, end) for begin, end in spans if end - begin < 3.0 * least]


def _pairing(truth: Sequence[Transition], read: Sequence[Transition]) -> list[tuple[int, int]]:
    """Longest common subsequence of kinds, ties broken by the smaller total time error."""
    best: dict[tuple[int, int], tuple[int, float, list[tuple[int, int]]]] = {}

    def score(i: int, j: int):
        return best.get((i, j), (0, 0.0, []))

    for i in reversed(range(len(truth))):
        for j in reversed(range(len(read))):
            choices = [score(i + 1, j), score(i, j + 1)]
            if (truth[i].before, truth[i].after) == (read[j].before, read[j].after):
                count, total, rest = score(i + 1, j + 1)
                choices.append((count + 1, total - abs(read[j].time - truth[i].time), [(i, j), *rest]))
            best[i, j] = max(choices, key=lambda choice: choice[:2])
    return score(0, 0)[2]
