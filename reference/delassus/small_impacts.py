"""Small impacts that follow each other ever faster: which are listed, and when they end."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from cases import Transition

# Impacts that close with less than this part of the largest closing speed are small: they are listed only if the motion
# does not come to rest by them (the definition in `cases.Transition`).
SMALL_IMPACT = 7e-4


class SmallImpacts:
    """The changes of mode so far, those of small impacts kept back, and when and at which angle these were."""

    def __init__(self) -> None:
        self.ordinary: list[Transition] = []
        self.kept_back: list[Transition] = []
        self.strikes: list[tuple[float, float]] = []
        self.fastest, self.small, self.at_rest = 0.0, False, False
        self.guess: tuple[float, float] = (inf, inf)
        self.last_guess = inf

    def count(self, t: float, theta: float, closing: float) -> None:
        """Record an impact with that closing speed, m/s, at that angle of the plate."""
        self.small = closing < SMALL_IMPACT * self.fastest
        if closing >= self.fastest:
            self.fastest, self.guess, self.last_guess = closing, (inf, inf), inf
        if not self.small:
            self.ordinary, self.kept_back = [*self.ordinary, *self.kept_back], []
        self.strikes = [*self.strikes[-4:], (t, theta)]
        end = self.aitken(0)
        if end is not None:
            self.guess, self.last_guess = min(self.guess, (abs(end - self.last_guess), end)), end

    def aitken(self, column: int) -> float | None:
        """The limit of the impacts' times (0) or angles (1), from every second of five."""
        if len(self.strikes) < 5:
            return None
        one, two = (self.strikes[i + 2][column] - self.strikes[i][column] for i in (0, 2))
        return self.strikes[4][column] + two * two / (one - two) if abs(two) < abs(one) else None

    def list_changes(self, t: float, changes: list[Transition]) -> None:
        """Keep the changes of small impacts back until it is clear whether the motion comes to rest."""
        changes = sorted(changes, key=lambda change: change.contact)
        if self.at_rest:
            every = [*self.kept_back, *changes]
            before = {change.contact: change.before for change in reversed(every)}
            last = {change.contact: change for change in every}
            changes = [
                replace(change, time=t, before=before[name])
                for name, change in last.items() if before[name] is not change.after
            ]  # fmt: skip
            self.ordinary += sorted(changes, key=lambda change: change.contact)
            self.kept_back, self.at_rest, self.small, self.fastest, self.strikes = [], False, False, 0.0, []
        elif self.small:
            self.kept_back += changes
        else:
            self.ordinary, self.kept_back = [*self.ordinary, *self.kept_back, *changes], []

    def cut(self, t: float) -> None:
        """Forget the changes after a time: the motion goes back to it."""
        self.ordinary = [change for change in self.ordinary if change.time <= t]
        self.kept_back = [change for change in self.kept_back if change.time <= t]
