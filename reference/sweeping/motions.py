"""What came of many scenarios, as columns: one value a scenario, and the transitions of all in one flat list."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cases import Mode
from cases.mechanics import energy

from ..minimal.hybrid import CAUSES
from ..solve import simulate
from .scenes import Scenes

MODES = tuple(Mode)
PHRASES = tuple(dict.fromkeys(CAUSES.values()))
NUMBER = {mode: number for number, mode in enumerate(MODES)}


class Events(NamedTuple):
    """Transitions: whose, when (s), from which mode to which, where, and why; modes and phrases by their numbers."""

    who: np.ndarray
    time: np.ndarray
    before: np.ndarray
    after: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    cause: np.ndarray

    @classmethod
    def joined(cls, some: list[Events], keep: np.ndarray) -> Events:
        """All of them by scenario, in time's order as they were noted; only of scenarios to `keep`."""
        types = (int, float, int, int, float, float, int)
        columns = [np.concatenate([np.empty(0, t), *(e[i] for e in some)]) for i, t in enumerate(types)]
        order = np.argsort(columns[0], kind="stable")
        order = order[keep[columns[0][order]]]
        return cls(*(column[order] for column in columns))


@dataclass(eq=False)
class Motions:
    """n scenarios: `first` the number of the first mode (-1: none), `status` and `reason` as in Trajectory, `end` (s),
    energies at start and end (J), steps, and whether it was simulated `alone`."""

    first: np.ndarray
    status: np.ndarray
    reason: np.ndarray
    end: np.ndarray
    energy_start: np.ndarray
    energy_end: np.ndarray
    steps: np.ndarray
    alone: np.ndarray
    events: Events

    @classmethod
    def none(cls, n: int) -> Motions:
        """Of n scenarios nothing yet."""
        words = [np.full(n, "", dtype=object) for _ in range(2)]
        numbers = [np.full(n, np.nan) for _ in range(3)]
        events = Events.joined([], np.zeros(n, dtype=bool))
        return cls(np.full(n, -1), *words, *numbers, np.zeros(n, dtype=int), np.zeros(n, dtype=bool), events)


def simulated(scenes: Scenes, who: np.ndarray, rtol: float, moved: Motions) -> None:
    """Scenarios by `simulate`, one after the other, in the place of what is noted of them."""
    keep = np.ones(len(moved.first), dtype=bool)
    keep[who] = False
    noted = [moved.events]
    for i in who.tolist():
        case = scenes.alone(i)
        motion = simulate(case, rtol=rtol)
        moved.first[i] = NUMBER[motion.first_mode] if motion.first_mode else -1
        moved.status[i], moved.reason[i], moved.alone[i] = motion.status, motion.reason, True
        moved.end[i], moved.steps[i] = motion.t[-1], motion.cost.steps
        total = energy(case, motion)
        moved.energy_start[i], moved.energy_end[i] = total[0], total[-1]
        rows = [
            (i, e.time, NUMBER[e.before], NUMBER[e.after], e.xi1, e.xi2, PHRASES.index(e.cause))
            for e in motion.transitions
        ]
        if rows:
            noted.append(Events(*(np.array(column) for column in zip(*rows, strict=True))))
    keep_new = np.ones(len(moved.first), dtype=bool)
    old = Events.joined(noted[:1], keep)
    moved.events = Events.joined([old, *noted[1:]], keep_new)
