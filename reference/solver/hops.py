"""Impacts that accumulate: which are listed, and the state in which they end.

A disc that rocks in a valley hits its two flanks in turn, a plate that bounces hits the same support again and again:
each time slower, infinitely often in a finite time. Impacts that close with less than `LISTING_PART` of the largest
closing speed are simulated, but listed only if they do not end so. From one cycle of impacts to the next the closing
speed shrinks, and time, pose and velocities are smooth functions of it (`minimal.bouncing` has the reason): their
polynomials at speed 0 are the end of the series.

Series may themselves follow each other ever faster: a disc comes to rest on a floor, rolls to a wall, bounces off it,
comes to rest on the floor again. The first impacts of such series are a series, too, and end by the same rules.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from cases import Transition
from cases.motion.instants import one_per_instant

from ..minimal.bouncing import APART, LISTING_PART, MOST, extrapolate
from ..scales import EPS

# The name or the number of a contact.
T = TypeVar("T", str, int)

# Impacts are extrapolated to their end where plates move by less than this part of their size until then, or where one
# more of them changes the end by less than the second part of sizes and speeds.
SMALL_HOP, NEGLIGIBLE = 1e-9, 1e-13
# Impacts beyond this many are too old to be of the same series with speeds that are APART.
LONGEST = 1000
# An end is accepted if the last impact changes it by less than this part of the time that remains. Impacts on two
# corners alternately need not have speeds in a fixed ratio, and then have no such end.
AGREES = 1e-2
# Impacts that are each slower than this part of the one before are rounding after three: their end is accepted if the
# line through the first two predicted it to AGREES of the time that remained then.
FAST, FEW = 1e-2, 3
# Velocities at the end of a series below this part of the last closing speed are the extrapolation's error.
STILL = 1e-3
# Two corners take turns within this many impacts.
RECENT = 8


class Strike(NamedTuple):
    """An impact: its time (s), (x, y, θ, vx, vy, ω) after it, the closing speed (m/s), the contacts that touch, and
    those of them that close."""

    time: float
    body: tuple[float, ...]
    closing: float
    contacts: frozenset[str]
    closing_contacts: frozenset[str]


class SeriesEnd(NamedTuple):
    """The end of a series of impacts: its time (s), (x, y, θ, vx, vy, ω), the contacts of its impacts, the error of its
    velocities (m/s), whether series end that follow each other, and by how much the time may be off (s)."""

    time: float
    body: list[float]
    contacts: frozenset[str]
    error: float
    ends_cascade: bool = False
    doubt: float = 0.0

    def landing(self, others: Iterable[tuple[T, float, float]], touches: float) -> set[T] | None:
        """Which of other contacts, each with its gap (m) and lift velocity (m/s) then, close at the end as far as it is
        known; None if one closes before. Gaps below `touches` (m) are rounding."""
        landing = set()
        for contact, gap, lift in others:
            if lift < 0.0 and abs(gap) <= touches - lift * self.doubt:
                landing.add(contact)
            elif gap <= 0.0:
                return None
        return landing


class ImpactSeries:
    """The transitions of a motion in order, those of small impacts kept back, and the impacts."""

    def __init__(self) -> None:
        self.ordinary: list[Transition] = []
        self.kept_back: list[Transition] = []
        self.strikes: list[Strike] = []
        self.fastest, self.is_small = 0.0, False

    @property
    def all(self) -> list[Transition]:
        """All transitions of a motion that is complete."""
        return list(one_per_instant(sorted([*self.ordinary, *self.kept_back], key=lambda change: change.time)))

    def strike(self, now: Strike) -> None:
        """Record an impact."""
        self.is_small = now.closing < LISTING_PART * self.fastest
        self.fastest = max(self.fastest, now.closing)
        self.add([])
        self.strikes = [*self.strikes[-LONGEST:], now]

    def add(self, changes: list[Transition]) -> None:
        """Keep changes back while impacts are small; list them, and those kept back, otherwise."""
        if self.is_small:
            self.kept_back += changes
        else:
            self.ordinary += [*self.kept_back, *changes]
            self.kept_back = []

    def begin_again(self) -> None:
        """Forget the impacts: a series has ended."""
        self.fastest, self.is_small, self.strikes = 0.0, False, []

    def recent(self, t: float) -> frozenset[str]:
        """The contacts of the last impacts, of which the last one is small and at that time; otherwise none."""
        is_now = self.is_small and self.strikes and self.strikes[-1].time == t
        return frozenset().union(*(one.contacts for one in self.strikes[-RECENT:])) if is_now else frozenset()

    def limit(self, t: float, size: float, is_last: bool = False) -> SeriesEnd | None:
        """The end of small impacts of plates of that size (m), the last of them at t, if it is known to rounding or
        the plates hardly move until then; None otherwise. `is_last`: further impacts would not show it better."""
        is_now = self.recent(t) or (is_last and self.strikes)
        some, contacts = self._series() if is_now else ([], frozenset())
        end = self._end_of(some, contacts, t, size, False, is_last) if len(some) > FEW else None
        few = some[-FEW:]
        if end is None and len(few) == FEW and few[2].closing <= FAST * few[1].closing <= FAST**2 * few[0].closing:
            return self._end_of(few, contacts, t, size, True, is_last)
        return end

    def _end_of(
        self, some: Sequence[Strike], contacts: frozenset[str], t: float, size: float, are_few: bool, is_last: bool
    ) -> SeriesEnd | None:
        """The end of those impacts of a series, if it is accepted: with the last impact and without it, or, of the last
        one, by two orders of polynomials."""
        speeds, times = [one.closing for one in some], [one.time for one in some]
        (time, late), (before, _) = extrapolate(speeds, times), extrapolate(speeds[:-1], times[:-1])
        remaining = time - t
        waits = time - times[-2] if are_few else remaining
        off = late if is_last else abs(time - before)
        if not 0.0 <= remaining or off > max(AGREES * waits, np.spacing(t)):
            return None
        limits = [extrapolate(speeds, column) for column in zip(*(one.body for one in some), strict=True)]
        body, plates, fast = [value for value, _ in limits], len(limits) // 6, self.fastest
        scales = [*(size, size, 1.0) * plates, *(fast, fast, fast / size) * plates]
        # An impact's time has the rounding of its place over its speed.
        is_exact = late <= max(NEGLIGIBLE * size / fast, EPS * size / speeds[-1], 4.0 * np.spacing(time)) and all(
            spread <= max(NEGLIGIBLE * scale, 4.0 * np.spacing(abs(value)))
            for (value, spread), scale in zip(limits, scales, strict=True)
        )
        if not is_exact and remaining * speeds[-1] > SMALL_HOP * size:
            return None
        doubt = min(off, AGREES * remaining)  # what the last impact has changed
        return SeriesEnd(time, body, contacts, STILL * speeds[-1], doubt=doubt)

    def lowest(self, touching: frozenset[str]) -> SeriesEnd | None:
        """The end of small impacts whose hops count as touching: on the line through the last two that repeat, as their
        number or their ratio gives no better one. None if there are no two, or one of their contacts does not touch."""
        some, contacts = self._series() if self.strikes else ([], frozenset())
        if len(some) < 2 or not contacts <= touching:
            return None
        speeds = [one.closing for one in some[-2:]]
        time, *body = (
            extrapolate(speeds, column)[0] for column in zip(*((one.time, *one.body) for one in some[-2:]), strict=True)
        )
        return SeriesEnd(time, body, touching, 2.0 * speeds[-1])

    def _series(self) -> tuple[Sequence[Strike], frozenset[str]]:
        """The last impacts of the same contacts after the same cycle of impacts, with speeds that are well apart, and
        all contacts of the cycle."""
        names = [(one.contacts, one.closing_contacts) for one in self.strikes]
        places = [i for i, those in enumerate(names) if those == names[-1]]
        if len(places) < 3:
            return [], frozenset()
        period = places[-1] - places[-2]
        cycle, some = names[-period:], [self.strikes[-1]]
        for last in range(len(names) - 1 - period, -1, -period):
            if names[last] != names[-1] or names[last + 1 : last + 1 + period] != cycle:
                break
            if APART * self.strikes[last].closing >= some[0].closing:
                some.insert(0, self.strikes[last])
        return some[-MOST:], frozenset().union(*(contacts for contacts, _ in cycle))

    def record(
        self, t: float, changes: list[Transition], cause: str = "", bouncing: frozenset[str] = frozenset()
    ) -> None:
        """Record the changes of mode at one instant; `cause` is given if contacts have come to rest, and `bouncing` are
        others whose small impacts have not ended."""
        changes = sorted(changes, key=lambda change: change.contact)
        if not cause:
            self.add(changes)
            return
        every = [*self.kept_back, *changes]
        resting = [change for change in every if change.contact not in bouncing]
        self.ordinary += _net(resting, t, cause) if self.kept_back else resting
        self.kept_back = [change for change in every if change.contact in bouncing]
        if not bouncing:
            self.begin_again()

    def bouncing(self, speeds: dict[str, float]) -> frozenset[str]:
        """The contacts that small impacts have hit lately and go on to hit: of open ones next to their supports, given
        their speeds along the normals (m/s)."""
        hit = frozenset[str]().union(*(one.closing_contacts for one in self.strikes[-RECENT:]))
        small = LISTING_PART * self.fastest
        return frozenset(name for name, speed in speeds.items() if name in hit and abs(speed) < small)


class NestedSeries(ImpactSeries):
    """The same, where the first impacts of successive series are a series of their own, `outer`, which lists the
    transitions."""

    def __init__(self) -> None:
        super().__init__()
        self.outer = ImpactSeries()

    @property
    def all(self) -> list[Transition]:
        changes = [*self.outer.ordinary, *self.outer.kept_back, *self.kept_back]
        return list(one_per_instant(sorted(changes, key=lambda change: change.time)))

    def strike(self, now: Strike) -> None:
        if not self.strikes:
            self.outer.strike(now)
        super().strike(now)
        self._pass_on()

    def limit(self, t: float, size: float, is_last: bool = False) -> SeriesEnd | None:
        end = super().limit(t, size, is_last)
        if end is None:
            end = self.outer.limit(t, size, is_last)
            return end and end._replace(ends_cascade=True)
        return end

    def end_cascade(self) -> None:
        """End the series that follow each other, with the changes of all that are small."""
        self.kept_back = [*self.outer.kept_back, *self.kept_back]
        self.outer.kept_back = []
        self.outer.begin_again()

    def record(
        self, t: float, changes: list[Transition], cause: str = "", bouncing: frozenset[str] = frozenset()
    ) -> None:
        super().record(t, changes, cause, bouncing)
        self._pass_on()

    def _pass_on(self) -> None:
        """Pass the changes that this series lists on to the outer one."""
        self.outer.add(self.ordinary)
        self.ordinary = []


def _net(changes: list[Transition], t: float, cause: str) -> list[Transition]:
    """The changes of mode between the first and the last of some, as changes at one time."""
    first: dict[str, Transition] = {}
    last: dict[str, Transition] = {}
    for change in changes:
        first.setdefault(change.contact, change)
        last[change.contact] = change
    return [
        replace(change, time=t, before=first[name].before, cause=cause)
        for name, change in sorted(last.items())
        if first[name].before is not change.after
    ]
