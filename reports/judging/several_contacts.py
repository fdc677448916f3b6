"""A motion compared with the truth, contact by contact: one contact is the case of a single name, "".

Each of several contacts is read and scored as the only one of its motion (`Trajectory.of`); a motion is as good as its
worst contact. Forces are not compared: where they are not unique the law leaves them open. SI units; pure functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, Trajectory, Transition
from cases.motion.trajectory import CONTACT
from cases.scene.supports import base_of, effects_at

from . import ledger
from .distances import differences
from .friction_factor import losses_of_truth
from .ledger import LedgerRow
from .score import Scale, Score, scale_of, score_and_reading
from .slip_phases import RESOLVABLE_GAPS, Reading
from .transitions import LEAST_SHARE, MotionReader, ReadChange, SampleStretch, stick_bound

# Samples next to where a contact closes or opens whose velocities may be means of both sides of an impact.
_EDGE = 2


class Judgement(NamedTuple):
    """A motion compared with a truth. `score`: that of the worst contact, `worst` ("": the only one), with the scale
    `scale`; `scores`: those of all contacts; `ledger`: the transitions of all contacts, paired with the truth's, in
    their order in time; `transitions` and their `spreads` (s): its own, in their order in time."""

    score: Score
    worst: str
    scale: Scale
    first_mode: Mode
    ledger: tuple[LedgerRow, ...]
    transitions: tuple[Transition, ...]
    spreads: tuple[float, ...]
    scores: Mapping[str, Score]


def scales(
    case: Case, truth: Trajectory, events: Sequence[Transition], nulls: Mapping[str, Trajectory]
) -> dict[str, Scale]:
    """The scale of each contact of the truth, by its name, "" for the only one; `events`: the truth's transitions."""
    if len(truth.contact_names) < 2:
        return {"": scale_of(case, truth, events, nulls)}
    losses = losses_of_truth(case, truth)
    return {
        name: scale_of(case, truth.of(name), of_contact(events, name), _matched(truth, nulls, name), losses)
        for name in truth.contact_names
    }


def of_contact(events: Sequence[Transition], name: str) -> tuple[Transition, ...]:
    """The transitions of one contact; "": of the only one."""
    return tuple(event for event in events if name in ("", event.contact))


def judge(
    case: Case, motion: Trajectory, truth: Trajectory, scales: Mapping[str, Scale], events: Sequence[Transition],
    off: Mapping[str, np.ndarray] | None = None,
) -> Judgement:  # fmt: skip
    """The comparison of a sound motion with a truth, contact by contact; `off`: their `differences`, if known."""
    off = differences(motion, truth, case) if off is None else off
    partners = {"": ""} if "" in scales else same_contacts(motion, truth)
    gap = 0.0 if motion.first_mode is not None else float(np.max(np.diff(motion.t), initial=0.0))
    scores, rows, own = dict[str, Score](), list[LedgerRow](), list[tuple[Transition, float]]()
    modes = dict[str, Mode]()
    for name, partner in partners.items():
        one, exact, reader, own_off = motion, truth, None, off
        if name:
            one, exact = only(motion, partner), truth.of(name)
            reader = partial(_read, name, gap_of(motion, partner))
            own_off = differences(one, exact, case, off)
        scores[name], reading = score_and_reading(case, one, exact, scales[name], own_off, reader)
        modes[name] = reading.first_mode
        pairs = ledger.match(of_contact(events, name), reading.transitions, gap)
        rows += _renumbered(pairs, events, name) if name else pairs
        own += zip(reading.transitions, reading.spreads, strict=True)
    worst = max(scores, key=lambda name: scores[name].off)
    rows.sort(key=lambda row: row.reference_time if np.isfinite(row.reference_time) else row.time)
    own.sort(key=lambda pair: pair[0].time)
    return Judgement(
        scores[worst]._replace(doubt=max(score.doubt for score in scores.values())),
        worst,
        scales[worst],
        modes.get(truth.contact_names[0], next(iter(modes.values()))),
        tuple(rows),
        tuple(event for event, _ in own),
        tuple(spread for _, spread in own),
        scores,
    )


def _renumbered(rows: Sequence[LedgerRow], events: Sequence[Transition], name: str) -> tuple[LedgerRow, ...]:
    """The rows of a contact with the numbers that its transitions have among those of all contacts."""
    places = [place for place, event in enumerate(events, start=1) if event.contact == name]
    return tuple(replace(row, contact=name, event=places[row.event - 1] if row.is_true else row.event) for row in rows)


# --- one contact of several -------------------------------------------------------------------------------------------


def same_contacts(motion: Trajectory, truth: Trajectory) -> dict[str, str]:
    """For each contact of the truth, the motion's contact that is it, "" for one that the motion does not have.

    By name where both touch a support, or another plate, in one contact. Further contacts there are numbered in the
    order in which they close, which may differ: a contact is then that of the same support whose place there is
    nearest, on average while both are closed, or while each is if they never are at one time.
    """
    names, others = truth.contact_names, motion.contact_names
    numbered = {_support(name) for each in (names, others) for name in _repeated(each)}
    partners = {name: name if name in others and _support(name) not in numbered else "" for name in names}
    true, own = (
        {n: x for n, x in _places(one, motion.t).items() if _support(n) in numbered} for one in (truth, motion)
    )
    pairs = sorted((_apart(true[a], own[b]), a, b) for a in true for b in own if _support(a) == _support(b))
    for _, a, b in pairs:
        if not partners[a] and b not in partners.values():
            partners[a] = b
    return partners


def _support(name: str) -> str:
    """The name of a contact without its number."""
    return name.split()[0]


def _repeated(names: Sequence[str]) -> list[str]:
    """The names of contacts that share their support with another one."""
    supports = [_support(name) for name in names]
    return [name for name in names if supports.count(_support(name)) > 1]


def _places(motion: Trajectory, times: np.ndarray) -> dict[str, np.ndarray]:
    """The parameter of each contact at these times, NaN while it is open, of those that are closed at one."""
    places = {}
    for name in motion.contact_names:
        columns = motion.contact_columns(name, times) if motion.contact_columns else motion.contacts[name]
        place = np.where(np.isfinite(columns.slip), columns.xi1, np.nan)
        if np.isfinite(place).any():
            places[name] = place
    return places


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    """The mean distance of two contacts' parameters at the times at which both are closed, else of their means."""
    both = np.isfinite(one) & np.isfinite(other)
    return float(np.mean(np.abs(one - other)[both])) if both.any() else abs(float(np.nanmean(one) - np.nanmean(other)))


def only(motion: Trajectory, name: str) -> Trajectory:
    """The motion of one contact, with parameters only while it is closed; "": of a contact that is never closed."""
    if name and motion.first_mode is not None:
        return motion.of(name)
    nothing, none = np.zeros(len(motion.t)), np.full(len(motion.t), np.nan)
    if not name:
        flies = Mode.FLIGHT if motion.first_mode is not None else None
        return replace(
            motion, slip=none, normal_force=nothing, friction_force=nothing, xi1=none, xi2=none, transitions=(),
            first_mode=flies, dense=None, contact_columns=None, contact_names=(CONTACT,),
        )  # fmt: skip
    one = motion.of(name)
    is_open = np.isnan(one.slip)
    return replace(one, first_mode=None, xi1=np.where(is_open, np.nan, one.xi1), xi2=np.where(is_open, np.nan, one.xi2))


def gap_of(motion: Trajectory, name: str) -> Callable[[np.ndarray], np.ndarray]:
    """The gap of one contact, m, at the motion's own times or at others; NaN where it is not known."""

    def gap(times: np.ndarray) -> np.ndarray:
        if not name:
            return np.full(len(times), np.nan)
        if motion.contact_columns is None or np.array_equal(times, motion.t):
            return motion.contacts[name].gap
        return motion.contact_columns(name, times).gap

    return gap


def _matched(truth: Trajectory, nulls: Mapping[str, Trajectory], name: str) -> dict[str, Trajectory]:
    """Each null motion as one of that contact."""
    return {null: only(motion, same_contacts(motion, truth)[name]) for null, motion in nulls.items()}


def _read(contact: str, gap: Callable[[np.ndarray], np.ndarray], case: Case, motion: Trajectory) -> Reading:
    return ContactReader(case, motion, contact, gap(motion.t)).reading()


class ContactReader(MotionReader):
    """One contact of several, with its gap (m) at the samples; it is read by the friction at that contact.

    While it is open the plate may touch its track elsewhere, so that nothing follows from the laws of free flight: a
    contact closes where its gap, extrapolated by a line through the last two samples, vanishes. Slip within two samples
    of where it closes or opens is not read: an impact there has velocities on both sides, of which an engine with a
    fixed step reports the mean.
    """

    def __init__(self, case: Case, motion: Trajectory, contact: str, gap: np.ndarray):
        super().__init__(case, motion)
        self.gap, self.bound = gap, stick_bound(effects_at(case, contact))
        plates = {"plate": case.plate} | {other.name: other.plate for other in case.others}
        # Stuck to what is fixed, a plate that cannot turn rests.
        is_fixed = not plates[contact.partition("/")[0]].turns and base_of(contact) not in plates
        self.turns = self.turns or is_fixed

    def _contact(self, stretch: SampleStretch) -> Reading:
        first = stretch.start + (_EDGE if stretch.start else 0)
        last = stretch.stop - (_EDGE if stretch.stop < len(self.all.t) else 0)
        if first >= last:
            first = (stretch.start + stretch.stop) // 2
            last = first + 1
        return super()._contact(SampleStretch(False, first, last))

    def _rebounds(self, stretch: SampleStretch, landing: ReadChange | None) -> Iterator[ReadChange]:
        """The times within a flight at which the contact closes for too short a time to be more than an impact, if they
        are fast enough to be listed and followed by a long enough flight."""
        t, inside = self.all.t, np.arange(stretch.start, stretch.stop)
        closed = np.isfinite(self.all.xi1[inside])
        begins = inside[1:][closed[1:] & ~closed[:-1]].tolist()
        ends = [float(t[i]) for i in (*begins[1:], stretch.stop - 1)] if begins else []
        shortest = RESOLVABLE_GAPS * float(np.max(np.diff(t[inside]), initial=0.0))
        greatest = 0.0
        for i, end in zip(begins, ends, strict=True):
            change = self._landing(SampleStretch(True, stretch.start, i), SampleStretch(False, i, i + 1), Mode.FLIGHT)
            closing = (self.gap[i - 1] - self.gap[i]) / (t[i] - t[i - 1]) if t[i] > t[i - 1] else 0.0
            greatest = max(greatest, closing)
            is_last = landing is None and i == begins[-1]
            if closing >= LEAST_SHARE * greatest and (is_last or end - change.time >= shortest):
                yield change._replace(cause="impact")

    def _leaving(self, stretch: SampleStretch, before: Mode) -> ReadChange:
        """The opening, which may be up to a sample before the last closed one: where the contact's force fades, its gap
        grows as t³ and is within rounding at first."""
        change, i = super()._leaving(stretch, before), stretch.stop
        t, gap = self.all.t[i - 1 : i + 3], self.gap[i : i + 3]
        usual = 0.5 * float(t[0] + t[1])
        if change.time != usual or len(gap) < 3 or not 0.0 < gap[0] < gap[1] < gap[2]:
            return change
        earliest = float(t[1]) - _time_since_opening(t[1:], gap)
        time = float(np.clip(earliest, 2.0 * t[0] - t[1], t[1]))
        return change._replace(time=time, spread=max(change.spread, abs(time - usual)))

    def _landing(self, flight: SampleStretch, contact: SampleStretch, after: Mode) -> ReadChange:
        i, j = flight.stop - 1, contact.start
        low, high = float(self.all.t[i]), float(self.all.t[j])
        time = 0.5 * (low + high)
        if i > 0 and self.gap[i] < self.gap[i - 1]:
            time = low + self.gap[i] * (low - float(self.all.t[i - 1])) / (self.gap[i - 1] - self.gap[i])
        # A contact counts as closed a little before its gap vanishes, but by no more than one more sample.
        latest = float(self.all.t[min(j + 1, len(self.all.t) - 1)])
        return ReadChange(float(np.clip(time, low, latest)), Mode.FLIGHT, after, 0.5 * (high - low), "landing")


def _time_since_opening(t: np.ndarray, gap: np.ndarray) -> float:
    """The time, s, between the opening of a contact and the first of three samples of its gap, which grows as a power
    of time: the first one after an impact, the second under a force that vanishes at once, the third under one that
    fades. The power is the one that fits the third sample best."""
    fits = []
    for power in (1, 2, 3):
        since = float(t[1] - t[0]) / ((gap[1] / gap[0]) ** (1 / power) - 1.0)
        fits.append((abs(power * np.log1p((t[2] - t[0]) / since) - np.log(gap[2] / gap[0])), since))
    return min(fits)[1]
