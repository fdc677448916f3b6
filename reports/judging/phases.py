"""Phases of a motion, one for each mode, and the difference between two sequences of phases."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np

from cases import Mode, Transition


class ModePhase(NamedTuple):
    """A mode, its begin and its end, s."""

    mode: Mode
    begin: float
    end: float

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.end - self.begin


def phases_of(first: Mode | None, transitions: Sequence[Transition], end: float) -> tuple[ModePhase, ...]:
    """The phases of a motion up to the time `end`; flights between impacts are one phase.

    Phases without duration are omitted, unless there is no other. If the first mode is unknown, it is the mode before
    the first transition.
    """
    if first is None:
        if not transitions:
            return ()
        first = transitions[0].before
    times = np.maximum.accumulate([0.0, *(min(t.time, end) for t in transitions), end]).tolist()
    modes = [first, *(t.after for t in transitions)]
    whole = [ModePhase(mode, a, b) for mode, a, b in zip(modes, times[:-1], times[1:], strict=True)]
    return _join(phase for phase in whole if phase.duration > 0.0) or tuple(whole[-1:])


def _join(phases: Iterable[ModePhase]) -> tuple[ModePhase, ...]:
    """The phases with adjacent ones of the same mode joined."""
    result: list[ModePhase] = []
    for phase in phases:
        if result and result[-1].mode == phase.mode:
            result[-1] = result[-1]._replace(end=phase.end)
        else:
            result.append(phase)
    return tuple(result)


def flights(phases: Sequence[ModePhase]) -> tuple[ModePhase, ...]:
    """The phases with all modes of contact replaced by rolling: flights and rolls only."""
    return _join(p if p.mode is Mode.FLIGHT else p._replace(mode=Mode.ROLL) for p in phases)


def rolling_within(phases: Sequence[ModePhase], spans: Sequence[tuple[float, float]]) -> tuple[ModePhase, ...]:
    """The phases with slip replaced by rolling within the time spans."""
    slips = (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD)
    return _join(p._replace(mode=Mode.ROLL) if is_in and p.mode in slips else p for p, is_in in _pieces(phases, spans))


def outside(phases: Sequence[ModePhase], spans: Sequence[tuple[float, float]]) -> tuple[ModePhase, ...]:
    """The parts of the phases that are in none of the time spans."""
    return tuple(piece for piece, is_in in _pieces(phases, spans) if not is_in)


def _pieces(phases: Sequence[ModePhase], spans: Sequence[tuple[float, float]]) -> Iterator[tuple[ModePhase, bool]]:
    """The phases cut at the ends of the spans, and whether each piece is within a span."""
    for phase in phases:
        cuts = sorted({time for span in spans for time in span if phase.begin < time < phase.end})
        for begin, end in pairwise([phase.begin, *cuts, phase.end]):
            middle = 0.5 * (begin + end)
            yield phase._replace(begin=begin, end=end), any(low <= middle <= high for low, high in spans)


def time_by_mode(phases: Sequence[ModePhase]) -> dict[Mode, float]:
    """Seconds in each mode."""
    times: dict[Mode, float] = {}
    for phase in phases:
        times[phase.mode] = times.get(phase.mode, 0.0) + phase.duration
    return times


def time_in_another_mode(phases: Sequence[ModePhase], truth: Sequence[ModePhase], end: float) -> float:
    """Seconds up to `end` in which the two sequences are not in the same mode; time without a phase counts."""
    edges = np.unique([0.0, end, *(t for p in (*phases, *truth) for t in (p.begin, p.end))])
    edges = edges[(edges >= 0.0) & (edges <= end)]
    middle = 0.5 * (edges[1:] + edges[:-1])
    return float(np.sum(np.diff(edges)[_modes_at(phases, middle) != _modes_at(truth, middle)]))


def _modes_at(phases: Sequence[ModePhase], times: np.ndarray) -> np.ndarray:
    """The modes at the times; "" where there is no phase."""
    if not phases:
        return np.full(times.shape, "", dtype=object)
    begins, ends = np.array([(p.begin, p.end) for p in phases]).T
    latest = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, None)
    modes = np.array([str(p.mode) for p in phases], dtype=object)[latest]
    modes[(times < begins[0]) | (times > ends[latest])] = ""
    return modes


class _Merging:
    """A sequence of phases from which the shortest are removed one by one, and their neighbours joined."""

    def __init__(self, phases: Sequence[ModePhase]):
        self.phases = list(phases)
        self.durations = np.array([p.duration for p in phases])

    def shortest(self) -> float:
        """The duration of the phase that is removed next; infinite if only one is left."""
        return float(self.durations.min()) if len(self.phases) > 1 else inf

    def remove_up_to(self, longest: float) -> None:
        """Remove all phases of up to `longest` seconds, the shortest first, but never the last remaining one."""
        while self.shortest() <= longest:
            self._remove(int(self.durations.argmin()))

    def _remove(self, i: int) -> None:
        shortest = self.phases.pop(i)
        if i == 0:
            self.phases[0] = self.phases[0]._replace(begin=shortest.begin)
        elif i == len(self.phases):
            self.phases[-1] = self.phases[-1]._replace(end=shortest.end)
        elif self.phases[i - 1].mode == self.phases[i].mode:
            self.phases[i - 1 : i + 1] = [self.phases[i - 1]._replace(end=self.phases[i].end)]
        else:
            middle = 0.5 * (shortest.begin + shortest.end)
            self.phases[i - 1] = self.phases[i - 1]._replace(end=middle)
            self.phases[i] = self.phases[i]._replace(begin=middle)
        self.durations = np.array([p.duration for p in self.phases])

    def modes(self) -> list[Mode]:
        """The modes in order."""
        return [p.mode for p in self.phases]


def agreement(phases: Sequence[ModePhase], truth: Sequence[ModePhase]) -> tuple[float, bool]:
    """The least duration x, s, such that both sequences of modes agree once phases of no more than x are removed, and
    whether phases of the truth are among those removed. Infinite where they agree for no x."""
    if not phases or not truth:
        return inf, False
    ours, true = _Merging(phases), _Merging(truth)
    longest = 0.0
    for _ in range(len(phases) + len(truth)):  # each round removes a phase
        if ours.modes() == true.modes():
            return longest, len(true.phases) < len(truth)
        longest = max(longest, min(ours.shortest(), true.shortest()))
        if longest == inf:
            break
        ours.remove_up_to(longest)
        true.remove_up_to(longest)
    return inf, False
