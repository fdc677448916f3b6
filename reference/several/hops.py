"""Impacts that accumulate: which are listed, and when they come to rest.

A disc that rocks in a valley hits its two flanks in turn, each time slower, infinitely often in a finite time. Impacts
that close with less than `LISTING_PART` of the largest closing speed are simulated, but listed only if the motion does
not come to rest by them; the end of the rest of the series is extrapolated (Aitken).
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

from cases import Transition

from ..minimal.bouncing import LISTING_PART

# Impacts alternate between two contacts, whose intervals may differ: intervals are compared with those two before.
PERIOD = 2


class ImpactSeries:
    """The transitions of a motion in order, those of small impacts kept back, and the times of these."""

    def __init__(self) -> None:
        self.ordinary: list[Transition] = []
        self.kept_back: list[Transition] = []
        self.strikes: list[tuple[float, float]] = []  # time (s) and angle of the plate
        self.fastest, self.is_small = 0.0, False
        self.best: tuple[float, float] = (inf, inf)  # change of the extrapolated end, and that end, s
        self.last = inf

    @property
    def all(self) -> list[Transition]:
        """All transitions of a motion that is complete."""
        return [*self.ordinary, *self.kept_back]

    def strike(self, t: float, theta: float, closing: float) -> None:
        """Record an impact with that closing speed, m/s, at that angle of the plate."""
        self.is_small = closing < LISTING_PART * self.fastest
        if closing >= self.fastest:
            self.fastest, self.best, self.last = closing, (inf, inf), inf
        if not self.is_small:
            self.ordinary, self.kept_back = self.all, []
        self.strikes = [*self.strikes[-2 * PERIOD :], (t, theta)]
        end = self._limit(0)
        if end is not None:
            self.best = min(self.best, (abs(end - self.last), end))
            self.last = end

    def _limit(self, column: int) -> float | None:
        """The limit of times (0) or angles (1), extrapolated; None if they do not approach one."""
        if len(self.strikes) <= 2 * PERIOD:
            return None
        before, between, now = (self.strikes[i][column] for i in (0, PERIOD, 2 * PERIOD))
        first, second = between - before, now - between
        return now + second * second / (first - second) if abs(second) < abs(first) else None

    def limit(self, t: float, speed: float, size: float) -> tuple[float, float] | None:
        """Time and angle at which small impacts end, if the plate moves by less than `size` (m) until then at that
        speed."""
        theta = self._limit(1)
        if not self.is_small or self.best[1] == inf or theta is None or self.strikes[-1][0] != t:
            return None
        return (max(self.best[1], t), theta) if speed * abs(self.last - t) <= size else None

    def record(self, t: float, changes: list[Transition], cause: str = "") -> None:
        """Record the changes of mode at one instant; `cause` is given if bouncing has come to rest."""
        rests, changes = bool(cause), sorted(changes, key=lambda change: change.contact)
        if rests and self.kept_back:
            changes = _net([*self.kept_back, *changes], t, cause)
            self.kept_back = []
        if rests:
            self.fastest, self.is_small, self.strikes = 0.0, False, []
        if self.is_small:
            self.kept_back += changes
        else:
            self.ordinary, self.kept_back = [*self.all, *changes], []


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
