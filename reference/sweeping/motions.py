"""Results of many scenarios as columns: one value per scenario, and the transitions of all in one flat list."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, Transition
from cases.motion.mechanics import energy

from ..endings import BROKEN_LAW
from ..solve import best_method, initial_value_problem
from .scenario_values import ScenarioGroup

# One of so many scenarios that were simulated together is checked by the laws, and every one that does not end by its
# duration, by leaving its track or at the end of a curve.
CHECKS, USUAL = 1000, ("completed", "lift_off", "track_end", "outline_end")
MODES = tuple(Mode)
NUMBER = {mode: number for number, mode in enumerate(MODES)}


class Events(NamedTuple):
    """Transitions: the scenario, time (s), modes before and after by number, contact parameters, and the contact's name
    if there are several, else ""."""

    scenario: np.ndarray
    time: np.ndarray
    before: np.ndarray
    after: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    contact: np.ndarray

    @classmethod
    def of_one_contact(cls, scenario: np.ndarray, time: np.ndarray, before: int, after: np.ndarray, y: np.ndarray):
        """Transitions of contacts without names, with the contact parameters in the first rows of `y`."""
        names = np.full(len(scenario), "", dtype=object)
        return cls(scenario, time, np.full(len(scenario), before), after, y[0], y[1], names)

    @classmethod
    def join(cls, some: list[Events], keep: np.ndarray) -> Events:
        """All events, ordered by scenario and then as recorded, which is the order in time; only of scenarios to
        `keep`."""
        types = (int, float, int, int, float, float, object)
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
        """Empty results for n scenarios."""

        def words() -> np.ndarray:
            return np.full(n, "", dtype=object)

        def numbers() -> np.ndarray:
            return np.full(n, np.nan)

        events = Events.join([], np.zeros(n, dtype=bool))
        steps, alone = np.zeros(n, dtype=int), np.zeros(n, dtype=bool)
        return cls(np.full(n, -1), words(), words(), numbers(), numbers(), numbers(), steps, alone, events)


def simulate_rows(scenes: ScenarioGroup, indices: np.ndarray, rtol: float, motions: Motions) -> None:
    """Simulate scenarios one after the other, as `simulate` does, and overwrite their rows of `motions`."""
    keep, every_row = (np.ones(len(motions.first), dtype=bool) for _ in range(2))
    keep[indices] = False
    parts = [Events.join([motions.events], keep)]
    for i in indices.tolist():
        transitions = _simulate(scenes.alone(i), rtol, motions, i)
        values = [(i, e.time, NUMBER[e.before], NUMBER[e.after], e.xi1, e.xi2, e.contact) for e in transitions]
        parts += [Events(*(np.array(column) for column in zip(*values, strict=True)))] if values else []
    motions.events = Events.join(parts, every_row)


def check_rows(scenes: ScenarioGroup, indices: np.ndarray, rtol: float, motions: Motions) -> None:
    """Check by the laws some of the scenarios that were simulated together, as CHECKS says, each simulated alone; one
    that breaks a law gets that status."""
    is_usual = np.isin(motions.status[indices].astype(str), USUAL)
    for i in indices[~is_usual | (scenes.rows[indices] % CHECKS == 0)].tolist():
        _, (_, _, ending) = _solve(scenes.alone(i), rtol)
        if ending[0] == BROKEN_LAW:
            motions.status[i], motions.reason[i] = ending


def _solve(case: Case, rtol: float):
    """The problem and the checked motion of one case without samples: segments, transitions and ending."""
    with np.errstate(all="ignore"):  # as in `simulate`
        problem = initial_value_problem(case, rtol, best_method(case))
        return problem, problem.solve()


def _simulate(case: Case, rtol: float, motions: Motions, i: int) -> tuple[Transition, ...]:
    """Simulate one case and write the result into row i; returns the transitions."""
    problem, solution = _solve(case, rtol)
    motion, segments = problem.trajectory(solution), solution[0]
    motions.status[i], motions.reason[i] = motion.status, motion.reason
    motions.alone[i], motions.steps[i] = True, motion.cost.steps
    motions.first[i] = -1 if motion.first_mode is None else NUMBER[motion.first_mode]
    motions.end[i] = segments[-1].event.time if segments else 0.0
    ends = np.array([0.0, motions.end[i]])
    motions.energy_start[i], motions.energy_end[i] = energy(case, motion, ends if segments else None)[[0, -1]]
    return motion.transitions
