"""Results of many scenarios as columns: one value per scenario, and the transitions of all in one flat list."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, State, Transition, geometry
from cases.contact import belt_speed, start_motion
from cases.mechanics import energy
from cases.piece_case import PieceCase

from ..endings import BROKEN_LAW, CAUSES
from ..minimal.contact_end import slip_and_spin
from ..minimal.modes import FLIGHT, Phase, full_state
from ..solution_check import ending_by_laws
from ..solve import INTEGRATORS, METHODS, at_once, solve_motion
from .scenario_values import ScenarioGroup

# One of so many scenarios is checked by the laws, and every one that does not end by its duration, by leaving its track
# or at the end of a curve.
CHECKS, USUAL = 1000, ("completed", "lift_off", "track_end", "outline_end")
MODES = tuple(Mode)
PHRASES = tuple(dict.fromkeys(CAUSES.values()))
NUMBER = {mode: number for number, mode in enumerate(MODES)}


class Events(NamedTuple):
    """Transitions: the scenario, time (s), modes before and after, contact parameters and cause; modes and causes by
    number."""

    scenario: np.ndarray
    time: np.ndarray
    before: np.ndarray
    after: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    cause: np.ndarray

    @classmethod
    def join(cls, some: list[Events], keep: np.ndarray) -> Events:
        """All events, ordered by scenario and then as recorded, which is the order in time; only of scenarios to
        `keep`."""
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
        with np.errstate(all="ignore"):  # as in `simulate`
            transitions = _simulate(scenes.alone(i), rtol, motions, i, scenes.rows[i] % CHECKS == 0)
        numbers = [
            (i, e.time, NUMBER[e.before], NUMBER[e.after], e.xi1, e.xi2, PHRASES.index(e.cause)) for e in transitions
        ]
        parts += [Events(*(np.array(column) for column in zip(*numbers, strict=True)))] if numbers else []
    motions.events = Events.join(parts, every_row)


def check_rows(scenes: ScenarioGroup, indices: np.ndarray, rtol: float, motions: Motions) -> None:
    """Check by the laws some of the scenarios that were simulated together, as CHECKS says, each simulated alone; one
    that breaks a law gets that status."""
    is_usual = np.isin(motions.status[indices].astype(str), USUAL)
    for i in indices[~is_usual | (scenes.rows[indices] % CHECKS == 0)].tolist():
        case = scenes.alone(i)
        with np.errstate(all="ignore"):  # as in `simulate`
            ending = ending_by_laws(case, _solution(case, rtol), rtol)
        if ending[0] == BROKEN_LAW:
            motions.status[i], motions.reason[i] = ending


def _solution(case: Case, rtol: float):
    """The motion of one case without samples: segments, transitions and ending."""
    return solve_motion(case, rtol, INTEGRATORS[METHODS[0]][1])


def _simulate(case: Case, rtol: float, motions: Motions, i: int, is_sample: bool) -> list[Transition]:
    """Simulate one case without samples and write the result into row i; returns the transitions. It is checked by the
    laws if it is one of the scenarios that CHECKS says."""
    segments, transitions, ending = solution = _solution(case, rtol)
    if is_sample or ending[0] not in USUAL:
        ending = ending_by_laws(case, solution, rtol)
    motions.status[i], motions.reason[i] = ending
    motions.alone[i], motions.steps[i] = True, sum(segment.steps for segment in segments)
    first = segments[0].phase.regime.mode if segments else at_once(ending[0])
    motions.first[i] = -1 if first is None else NUMBER[first]
    motions.energy_start[i] = motions.energy_end[i] = energy(case, start_motion(case))
    motions.end[i] = 0.0
    if segments:
        last = segments[-1]
        motions.end[i], motions.energy_end[i] = (
            last.event.time,
            energy(case, _motion_in(case, last.phase, last.event.time, last.event.state)),
        )
    return transitions


def _motion_in(case: Case, now: Phase, t: float, own) -> geometry.MotionPoint | State:
    """Pose and velocities of a phase's state."""
    if now.regime == FLIGHT:
        nan = float("nan")
        nothing = nan, 0.0, 0.0, nan, nan
        return State(*(float(v) for v in own), *nothing)  # type: ignore[call-arg]
    case = now.case if isinstance(now.case, PieceCase) else case
    y = full_state(case, now, t, own)
    slip, omega = slip_and_spin(case, t, y)
    return geometry.velocity(case.track, case.plate.outline, y[0], y[1], slip + belt_speed(case, t), omega)
