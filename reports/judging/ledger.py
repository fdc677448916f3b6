"""Transitions of a solver paired with the truth's: which are in both, which only in one of them, and their errors.

An impact of the truth after which the plate flies for less time than a motion's samples resolve is unresolved: no
solver is expected to have it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan

from cases import Mode, Transition

from .slip_phases import RESOLVABLE_GAPS


@dataclass(frozen=True)
class LedgerRow:
    """One transition of the truth, of a solver, or of both. `event` counts from 1 in the truth's sequence for paired
    and missed ones, in the solver's own for spurious ones; times in s, NaN where there is none. `pairing`: paired,
    missed, unresolved or spurious. `contact`: the truth's name of the contact if
    it has several, else ""."""

    event: int
    before: Mode
    after: Mode
    time: float
    reference_time: float
    error: float
    pairing: str
    contact: str = ""


def match(truth: Sequence[Transition], read: Sequence[Transition], gap: float = 0.0) -> tuple[LedgerRow, ...]:
    """Pair transitions by kind (before, after) and order: as many as can be, and of these pairings the one with the
    least sum of time errors. Other transitions of the truth are missed, or unresolved by samples `gap` seconds apart;
    other transitions of the solver are spurious."""
    pairs = _pairing(truth, read)
    rows = []
    for i, j in pairs:
        error = read[j].time - truth[i].time
        rows.append(LedgerRow(i + 1, truth[i].before, truth[i].after, read[j].time, truth[i].time, error, "paired"))
    for i in sorted(set(range(len(truth))) - {i for i, _ in pairs}):
        pairing = "unresolved" if _short(truth, i, RESOLVABLE_GAPS * gap) else "missed"
        rows.append(LedgerRow(i + 1, truth[i].before, truth[i].after, nan, truth[i].time, nan, pairing))
    for j in sorted(set(range(len(read))) - {j for _, j in pairs}):
        rows.append(LedgerRow(j + 1, read[j].before, read[j].after, read[j].time, nan, nan, "spurious"))
    return tuple(sorted(rows, key=lambda row: row.reference_time if isfinite(row.reference_time) else row.time))


def _short(truth: Sequence[Transition], i: int, least: float) -> bool:
    """Whether the transition is an impact after which the plate flies for less than that."""
    flies_on = truth[i].before is truth[i].after is Mode.FLIGHT
    return flies_on and i + 1 < len(truth) and truth[i + 1].time - truth[i].time < least


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
