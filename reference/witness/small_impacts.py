"""Small impacts that follow each other ever faster: which are listed, and when they end."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases import Transition
from cases.motion.instants import one_per_instant

# Impacts that close with less than this part of the largest closing speed are small: they are listed only if they do
# not come to an end (the definition in `cases.Transition`).
SMALL_IMPACT = 7e-4
# A cubic in the closing speed is fitted through four impacts, each at least so many times slower than the one before; a
# parabola where there have been only four, as they are then much slower each time.
POINTS, SLOWER = 4, 2.0
# Impacts of one kind are a series from this number on: two may differ by anything.
SERIES = 3
# Two contacts take turns within so many impacts.
TURNS = 8
# Three impacts are enough if each is at most this part as fast as the one before.
SHORT = 1e-2
# Its end is accepted if it differs from that of the cubic before by less than this part of the time that remains: where
# successive impacts have no fixed ratio, they differ by more.
AGREES = 1e-2


class ImpactRecord(NamedTuple):
    """The time (s) and closing speed (m/s) of an impact, its contacts and those that close, and (x, y, θ, vx, vy, ω)
    after it."""

    time: float
    closing: float
    names: frozenset[str]
    closers: frozenset[str]
    after: np.ndarray


class SmallImpacts:
    """The changes of mode so far, those of small impacts kept back, and the impacts."""

    def __init__(self) -> None:
        self.ordinary: list[Transition] = []
        self.kept_back: list[Transition] = []
        self.strikes: list[ImpactRecord] = []
        self.fastest, self.small, self.at_rest = 0.0, False, False

    @property
    def all(self) -> tuple[Transition, ...]:
        """All transitions of a motion that is complete."""
        return one_per_instant(sorted([*self.ordinary, *self.kept_back], key=lambda change: change.time))

    def count(self, record: ImpactRecord) -> None:
        """Record an impact."""
        self.small = record.closing < SMALL_IMPACT * self.fastest
        self.fastest = max(self.fastest, record.closing)
        self.list_or_keep([])
        self.strikes.append(record)

    def list_or_keep(self, changes: list[Transition]) -> None:
        """List changes and those kept back, unless impacts are small."""
        if self.small:
            self.kept_back += changes
        else:
            self.ordinary, self.kept_back = [*self.ordinary, *self.kept_back, *changes], []

    def forget(self) -> None:
        """Forget the impacts: they are over."""
        self.small, self.fastest, self.strikes = False, 0.0, []

    def end(self, t: float, size: float) -> tuple[float, np.ndarray, frozenset[str], float] | None:
        """Time (s) and (x, y, θ, vx, vy, ω) at which small impacts end, the last of them at t, the contacts that then
        touch, and by how much the time may be off (s), if those that bounce move by less than `size` (m) until then;
        None otherwise."""
        is_now = self.small and self.strikes and self.strikes[-1].time == t
        some, names = self.points() if is_now else ([], frozenset())
        # Three impacts do if hops after them are rounding; then the line through the first two is compared.
        is_short = len(some) == 3 and some[2].closing <= SHORT * some[1].closing <= SHORT**2 * some[0].closing
        points = min(POINTS, len(some) - 1)
        if points < POINTS - 1 and not is_short:
            return None
        speeds = np.array([one.closing for one in some]) / some[-1].closing
        values = np.array([[one.time - t, *(one.after - some[-1].after)] for one in some])
        before, now = (
            np.linalg.solve(np.vander(speeds[those]), values[those])[-1]
            for those in (slice(points), slice(0 if is_short else 1, None))
        )
        wait = float(now[0])
        wait_then = t + wait - some[-2].time if is_short else wait
        if not 0.0 <= wait * some[-1].closing <= size or abs(wait - before[0]) > max(AGREES * wait_then, np.spacing(t)):
            return None
        doubt = min(abs(wait - float(before[0])), AGREES * wait)
        return t + wait, some[-1].after + now[1:], names, doubt

    def is_driven(self) -> bool:
        """Whether small impacts do not shrink. Closing a gap that counts as none changes the energy by its height,
        which may drive hops of that height for ever."""
        same = [one.closing for one in self.strikes[-3 * TURNS :] if one.closers == self.strikes[-1].closers]
        return self.small and len(same) > TURNS and same[-1] >= same[-1 - TURNS]

    def low_end(self, t: float, body: np.ndarray, low: frozenset[str]) -> tuple[float, np.ndarray]:
        """Time (s) and (x, y, θ, vx, vy, ω) at the end of hops so low that nothing is known of their ratio, at contacts
        `low`: on the straight line through the last two impacts that repeat; t and the body if there are no three of
        them."""
        some, names = self.points()
        last_kind = [(one.names, one.closers) for one in self.strikes[-1:]]
        repeats = sum((one.names, one.closers) in last_kind for one in self.strikes)
        if repeats < SERIES or len(some) < 2 or not names <= low:
            return t, body.copy()
        before, last = some[-2:]
        part = last.closing / (before.closing - last.closing)
        return last.time + part * (last.time - before.time), last.after + part * (last.after - before.after)

    def points(self) -> tuple[list[ImpactRecord], frozenset[str]]:
        """The last impacts that repeat with the same contacts, each well slower than the one before, and all contacts
        of the impacts between two of them."""
        last, period = self.strikes[-1], 0
        some, sequence = [last], [(one.names, one.closers) for one in self.strikes]
        for i in range(len(self.strikes) - 2, -1, -1):
            if not period and sequence[i] == sequence[-1]:
                period = len(self.strikes) - 1 - i
            if not period or (len(self.strikes) - 1 - i) % period:
                continue
            if sequence[i + 1 : i + 1 + period] != sequence[-period:]:
                break
            if self.strikes[i].closing >= SLOWER * some[0].closing:
                some.insert(0, self.strikes[i])
            if len(some) == POINTS + 1:
                break
        return some, frozenset().union(*(one.names for one in self.strikes[-period:] if period))

    def list_changes(self, t: float, changes: list[Transition], goes_on: frozenset[str] = frozenset()) -> None:
        """Keep the changes of small impacts back until it is clear whether the motion comes to rest. `goes_on`: where
        some contacts do, the others that have small impacts still to come."""
        changes = sorted(changes, key=lambda change: change.contact)
        if self.at_rest:
            every = [change for change in [*self.kept_back, *changes] if change.contact not in goes_on]
            before = {change.contact: change.before for change in reversed(every)}
            last = {change.contact: change for change in every}
            still = [change for change in [*self.kept_back, *changes] if change.contact in goes_on]
            changes = [
                replace(change, time=t, before=before[name])
                for name, change in last.items() if before[name] is not change.after
            ]  # fmt: skip
            self.ordinary += sorted(changes, key=lambda change: change.contact)
            self.kept_back, self.at_rest = still, False
            if not goes_on:
                self.forget()
        else:
            self.list_or_keep(changes)


class ImpactsOnTwoLevels(SmallImpacts):
    """The same where a plate comes to rest, and hits something else from there, ever faster: the first impacts after
    each rest, `firsts`, come to an end by the same rules."""

    def __init__(self) -> None:
        super().__init__()
        self.firsts = SmallImpacts()

    @property
    def all(self) -> tuple[Transition, ...]:
        changes = [*self.firsts.ordinary, *self.firsts.kept_back, *self.kept_back]
        return one_per_instant(sorted(changes, key=lambda change: change.time))

    def count(self, record: ImpactRecord) -> None:
        if not self.strikes:
            self.firsts.count(record)
        super().count(record)
        self.hand_over()

    def is_first(self) -> bool:
        """Whether the last impact is the first after a rest, and small among those."""
        return len(self.strikes) == 1 and self.firsts.small

    def end_all(self) -> None:
        """The first impacts have come to an end: keep only what all small changes amount to."""
        self.kept_back, self.firsts.kept_back = [*self.firsts.kept_back, *self.kept_back], []
        self.firsts.forget()

    def list_changes(self, t: float, changes: list[Transition], goes_on: frozenset[str] = frozenset()) -> None:
        super().list_changes(t, changes, goes_on)
        self.hand_over()

    def hand_over(self) -> None:
        """Hand the listed changes over to those of the first impacts."""
        self.firsts.list_or_keep(self.ordinary)
        self.ordinary = []
