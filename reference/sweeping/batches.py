"""Batch simulation of many scenarios: all scenarios in the same mode go through a phase together, as one wave.

A wave shares Python's overhead: parameters, starts of phases, decisions and places are arrays. Each scenario needs one
call of the compiled integrator per phase, without a record of its steps. A scenario that needs special treatment in a
phase (an undecided start, a touch, a singularity) goes through that phase alone, as in `solver.contact_chart`. A
scenario that flies or may meet its track in a second place is simulated alone from the beginning.
"""

from __future__ import annotations

from math import ulp
from types import SimpleNamespace
from typing import Any

import numpy as np

from cases import CoulombFriction, Flight, Mode, RollingResistance, Unilateral

from .. import endings, scales
from ..effect_laws import laws
from ..minimal import contact_end
from ..minimal.assembly import contact_system
from ..minimal.decision import Undecidable, close
from ..minimal.integrators import taylor
from ..minimal.integrators.segment import MOST_STEPS
from ..minimal.modes import able, candidates, full_state, phase, start_state, state_in
from ..scales import EPS, slip_error
from ..solve import INTEGRATORS, METHODS, first_regime
from . import geometry
from .decisions import NO_DECISION, Columns, decide
from .first_step import course, leave
from .motions import NUMBER, Events, Motions, check_rows, simulate_rows
from .scenario_values import ScenarioGroup, structure
from .single_contact import one_contact

# Row of each variable in a full state.
_ROWS = {"xi1": 0, "xi2": 1, "u1": 2, "u2": 3, "theta": 4}
# Used instead of a regime's number: the motion has ended, or the scenario must be simulated alone.
_OVER, _ALONE = -1, -2
# Used instead of a guard's number: the end of the time span, or the integrator gave no clear outcome.
_TIME, _UNCLEAR = -1, -2


def move(scenes: ScenarioGroup, rtol: float, optimised: bool = False) -> Motions:
    """Simulate scenarios of one structure; `optimised`: with code that takes a second longer to compile."""
    with np.errstate(all="ignore"):  # non-finite values are passed to the single-scenario solver, which reports them
        return _advance(scenes, rtol, optimised)


def _advance(scenes: ScenarioGroup, rtol: float, optimised: bool) -> Motions:
    n = len(scenes.rows)
    motions, remaining = Motions.none(n), np.arange(n)
    if _plain(scenes):
        together = np.flatnonzero(one_contact(scenes))
        if together.size:
            wave = _Wave(scenes.only(together), rtol, optimised)
            wave.integrate_phases()
            wave.put(motions, together)
            remaining = np.flatnonzero(motions.status == "")
            check_rows(scenes, np.setdiff1d(together, remaining), rtol, motions)
    simulate_rows(scenes, remaining, rtol, motions)
    return motions


def _plain(scenes: ScenarioGroup) -> bool:
    """Whether scenarios can go in waves: heyoka is installed, they start in contact, and no feature is so short that a
    step could pass over it."""
    return taylor.AVAILABLE and scenes.base.start.in_contact and structure(scenes.base).plain


class _Wave:
    """A batch of scenarios: times (n,) and full states (4 or 5, n) at which their phases begin, and the numbers of
    their regimes."""

    def __init__(self, scenes: ScenarioGroup, rtol: float, optimised: bool):
        self.scenes, self.rtol, self.optimised, n = scenes, rtol, optimised, len(scenes.rows)
        inputs, base = scenes.numbers, scenes.base
        self.base, self.regimes = base, candidates(base)
        self.sizes = scenes.constants("track"), scenes.constants("outline")
        self.all_indices = np.arange(n)
        f, h = self._places(self.all_indices, inputs["xi1"], inputs["xi2"])
        gyration = np.sqrt(inputs["inertia"] / inputs["mass"])
        lengths = gyration / f.speed, gyration / h.speed, np.ones(n)
        self.columns = [_columns(scenes, regime, gyration, lengths) for regime in self.regimes]
        u1, u2 = geometry.rates(f, h, inputs["slip"], inputs["omega"])
        angle = [inputs["theta"]] if laws(base).needs_angle else []
        self.y, self.t = np.array([inputs["xi1"], inputs["xi2"], u1, u2, *angle]), np.zeros(n)
        self.now, self.first = np.full(n, _ALONE), np.full(n, -1)
        self.phases, self.idle, self.steps = (np.zeros(n, dtype=int) for _ in range(3))
        self.status, self.reason = (np.full(n, "", dtype=object) for _ in range(2))
        self.events: list[Events] = []

    def integrate_phases(self) -> None:
        """Integrate phase after phase until every scenario has ended or must be simulated alone."""
        self._begin()
        while (self.now >= 0).any():
            waves = [np.flatnonzero(self.now == number) for number in range(len(self.regimes))]
            for number, indices in enumerate(waves):
                if indices.size:
                    self._phase(number, indices)

    def put(self, motions: Motions, rows: np.ndarray) -> None:
        """Write the finished scenarios into their rows of `motions`."""
        is_over = self.now == _OVER
        there, inputs = rows[is_over], self.scenes.numbers
        for name in ("first", "status", "reason", "steps"):
            getattr(motions, name)[there] = getattr(self, name)[is_over]
        motions.end[there] = self.t[is_over]
        initial = inputs["xi1"], inputs["xi2"], inputs["slip"], inputs["omega"]
        motions.energy_start[there] = self._energy(*initial)[is_over]
        f, h = self._places(self.all_indices, self.y[0], self.y[1])
        motions.energy_end[there] = self._energy(self.y[0], self.y[1], *geometry.slip_and_spin(f, h, *self.y[2:4]))[
            is_over
        ]
        events = Events.join(self.events, is_over)
        motions.events = events._replace(scenario=rows[events.scenario])

    def _energy(self, xi1, xi2, slip, omega) -> np.ndarray:
        inputs = self.scenes.numbers
        f, h = self._places(self.all_indices, xi1, xi2)
        pull = inputs.get("gx", np.zeros(1)), inputs.get("gy", np.zeros(1))
        return geometry.energy(f, h, slip, omega, pull, inputs["mass"], inputs["inertia"])

    def _places(self, indices: np.ndarray, xi1, xi2) -> tuple[geometry.CurvePoints, geometry.CurvePoints]:
        track, outline = ([c[indices] for c in sizes] for sizes in self.sizes)
        return (
            geometry.places(self.base.track, tuple(track), xi1),
            geometry.places(self.base.plate.outline, tuple(outline), xi2),
        )

    # --- the start ----------------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        """Decide the first regimes, as `solve.first_regime` does for one scenario."""
        inputs = self.scenes.numbers
        f, h = self._places(self.all_indices, inputs["xi1"], inputs["xi2"])
        along = np.abs(self.y[2]) * f.speed, np.abs(self.y[3]) * h.speed
        rotation = along[0] * np.abs(f.curvature), along[1] * np.abs(h.curvature)
        slips = np.sign(inputs["slip"]) * (np.abs(inputs["slip"]) > slip_error(EPS) * np.maximum(*along))
        turns = np.sign(inputs["omega"]) * (np.abs(inputs["omega"]) > slip_error(EPS) * np.maximum(*rotation))
        for slip, turn in set(zip(slips.tolist(), turns.tolist(), strict=True)):
            indices = np.flatnonzero((slips == slip) & (turns == turn))
            numbers, choice = self._decide(
                able(self.base, slip, turn), indices, self.t[indices], self.y[:, indices], EPS
            )
            self.now[indices] = np.where(choice == NO_DECISION, _ALONE, numbers[choice])
            for i in indices[choice == NO_DECISION].tolist():
                self.now[i] = self._first(i)
        running = self.now >= 0
        modes = np.array([NUMBER[regime.mode] for regime in self.regimes])
        self.first[running] = modes[self.now[running]]

    def _first(self, i: int) -> int:
        """The number of the regime at the start of one scenario, decided as for a single motion; _ALONE if there is
        none."""
        case = self.scenes.alone(i)
        try:
            regime = first_regime(case, start_state(case))
        except Undecidable:
            return _ALONE
        return self.regimes.index(regime) if regime in self.regimes else _ALONE

    def _decide(self, among, indices: np.ndarray, t, y, error: float) -> tuple[np.ndarray, np.ndarray]:
        """The numbers of the regimes `among`, and for each scenario the index of the regime that follows."""
        numbers = np.array([self.regimes.index(regime) for regime in among], dtype=int)
        return numbers, decide([self.columns[k].only(indices) for k in numbers], t, y, error)

    # --- one phase ----------------------------------------------------------------------------------------------------

    def _phase(self, number: int, indices: np.ndarray) -> None:
        """Integrate some scenarios to the end of their phase and start the next one."""
        columns, end = self.columns[number].only(indices), self.scenes.numbers["duration"][indices]
        own = self.y[columns.places][:, indices]
        first_steps = leave(columns, self.t[indices], own, end)
        sound = np.flatnonzero(first_steps.sound)
        guards = np.full(len(indices), _UNCLEAR)
        times, states = first_steps.times, first_steps.states
        integrators = taylor.integrators_of(columns.system, taylor.tolerance_of(self.rtol), float, self.optimised)
        guards[sound], self.steps[indices[sound]] = integrators.call(
            self._integrate, columns, times, states, end, sound, indices
        )
        for i in indices[guards == _UNCLEAR].tolist():
            self._one(i)
        for guard in np.unique(guards[guards > _UNCLEAR]).tolist():
            some = guards == guard
            y = self._full(columns, indices[some], states[:, some])
            if guard == _TIME:
                self._end(indices[some], times[some], y, endings.COMPLETION)
            else:
                self._after(number, list(columns.system.guards)[guard], indices[some], times[some], y)

    def _integrate(
        self, workspace: taylor.Workspace, columns: Columns, times, states, end, sound: np.ndarray, indices: np.ndarray
    ):
        """Integrate from `times` and `states`, which are overwritten by those of the events; returns the guards and the
        steps so far."""
        integrator, pars, state = workspace.integrator, workspace.pars, workspace.state
        workspace.parameters = ()
        count, many = len(pars), taylor.CHUNK
        success, limit, all_steps = taylor.SUCCESS, taylor.TIME_LIMIT, taylor.STEP_LIMIT
        events = len(columns.system.guards)
        parameters = np.ascontiguousarray(columns.parameters.T[:, :count])
        guards, steps = [], []
        for i, j in zip(sound.tolist(), indices[sound].tolist(), strict=True):
            until, guard, total = float(end[i]), _TIME, 1
            pars[:] = parameters[i]
            state[:] = states[:, i]
            integrator.time = times[i]
            if events:
                integrator.reset_cooldowns()
            while integrator.time < until:
                outcome, shortest, _, some, _, _ = integrator.propagate_until(until, max_steps=many)
                total += some
                code = int(outcome)
                if 0 <= -code - 1 < events:
                    guard = -code - 1
                elif code not in (success, limit, all_steps):
                    guard = _UNCLEAR
                if some and shortest <= taylor.SHORTEST * ulp(integrator.time):
                    guard = _UNCLEAR
                if guard == _TIME and total >= MOST_STEPS and integrator.time < until:
                    guard = _UNCLEAR  # simulated alone it ends as unfinished and reports where
                if guard != _TIME:
                    break
            times[i], states[:, i] = integrator.time, state
            guards.append(guard)
            steps.append(self.steps[j] + total)
        return np.array(guards, dtype=int), np.array(steps, dtype=int)

    def _full(self, columns: Columns, indices: np.ndarray, own: np.ndarray) -> np.ndarray:
        """A regime's own variables as full states."""
        y = np.zeros((len(self.y), len(indices)))
        y[columns.places] = own
        if _ROWS["u2"] not in columns.places and _ROWS["u1"] in columns.places:
            self._stop_slip(indices, y)
        return y

    def _stop_slip(self, indices: np.ndarray, y: np.ndarray) -> None:
        """ξ̇₂ of plates that do not slip: v = 0 in (12)."""
        f, h = self._places(indices, y[0], y[1])
        y[3] = y[2] * f.speed / h.speed

    # --- what follows -------------------------------------------------------------------------------------------------

    def _after(self, number: int, guard: str, indices: np.ndarray, t: np.ndarray, y: np.ndarray) -> None:
        """Decide what follows a guard's zero, as `contact_chart` does; special cases are passed to it one by one."""
        regime = self.regimes[number]
        if guard in endings.ENDS:
            self._end(indices, t, y, endings.ENDS[guard])
            return
        if guard == "slip":
            self._stop_slip(indices, y)
            if regime.turn == 0:
                y[2:4] = 0.0
        elif guard == "turn":
            f, h = self._places(indices, y[0], y[1])
            y[2], y[3] = geometry.rates(f, h, geometry.slip_and_spin(f, h, y[2], y[3])[0], 0.0)
        elif guard not in contact_end.BEGINS:
            lifts = self._lifts_off(number, indices, t, y)  # the only other guard: the normal force
            self._leave(number, indices[lifts], t[lifts], y[:, lifts])
            for i in indices[~lifts].tolist():
                self._one(i)
            return
        among, sure = contact_end.regimes_beyond(self.base, regime, guard), np.ones(len(indices), dtype=bool)
        for other in among if guard in contact_end.BEGINS else ():
            sure &= self._unique_force(self.regimes.index(other), indices, t, y)
        if guard in contact_end.BEGINS and len(among) == 1:
            numbers, choice = np.array([self.regimes.index(among[0])]), np.where(sure, 0, NO_DECISION)
        else:
            numbers, choice = self._decide(among, indices, t, y, scales.LOCATION_ERROR)
            choice[~sure] = NO_DECISION
        for i in indices[choice == NO_DECISION].tolist():
            self._one(i)
        is_decided = choice != NO_DECISION
        self._go_on(number, numbers[choice[is_decided]], indices[is_decided], t[is_decided], y[:, is_decided])

    def _lifts_off(self, number: int, indices: np.ndarray, t, y: np.ndarray) -> np.ndarray:
        """Where a vanishing normal force is certainly a lift-off: it keeps falling, or dips a million times as deep as
        a touch, and the plate would not move into its track."""
        if self.base.effect(Unilateral) is None:
            return np.zeros(len(indices), dtype=bool)
        columns = self.columns[number].only(indices)
        place = list(columns.system.guards).index("normal_force")
        slope, bend, force = course(columns, t, y[columns.places], place)
        deep = slope**2 > 2.0 * close(max(self.rtol, scales.LOCATION_ERROR)) * force * bend
        free = self.columns[-1].only(indices)
        m = free.system.record(*free.system.outputs_of_arrays(t, y[free.places], free.parameters))
        forces = np.abs(m.normal) + np.abs(m.friction) + np.abs(m.slip_dot)
        scale = forces + free.size * (np.abs(m.omega_dot) + free.fastest(y[free.places]) ** 2)
        return (slope < 0.0) & deep & (m.free_approach <= close(scales.LOCATION_ERROR) * scale)

    def _leave(self, number: int, indices: np.ndarray, t, y: np.ndarray) -> None:
        """The plate leaves its track: the motion ends, or flies and is then simulated alone."""
        if self.base.effect(Flight) is not None:
            self.now[indices] = _ALONE
            return
        before, after = NUMBER[self.regimes[number].mode], NUMBER[Mode.FLIGHT]
        self.events.append(Events.of_one_contact(indices, t, before, np.full(len(indices), after), y))
        self._end(indices, t, y, endings.LIFT_OFF)

    def _unique_force(self, number: int, indices: np.ndarray, t, y) -> np.ndarray:
        """Where the contact force of a slip that begins is unique (Painlevé)."""
        columns = self.columns[number].only(indices)
        names = list(columns.system.guards)
        if "painleve" not in names:
            return np.ones(len(indices), dtype=bool)
        values = columns.system.guards_of_arrays(t, y[columns.places], columns.parameters)[names.index("painleve")]
        return np.broadcast_to(values, indices.shape) > 0.0

    def _one(self, i: int) -> None:
        """Integrate one scenario to the end of its phase and start the next one, by the single-scenario solver."""
        case, regime = self.scenes.alone(i), self.regimes[self.now[i]]
        now, number = phase(case, regime), int(self.now[i])
        _, integrate = INTEGRATORS[METHODS[0]]
        try:
            own = state_in(now, tuple(self.y[:, i].tolist()))
            segment = integrate(now, float(self.t[i]), own, case.duration, self.rtol)
            step = contact_end.after_contact(case, segment, own, max(self.rtol, scales.LOCATION_ERROR))
        except Undecidable:
            self.now[i] = _ALONE
            return
        indices, t, last = np.array([i]), np.array([step.time]), step.segments[-1].event.state
        y = np.array(step.state or full_state(case, now, step.time, last))[:, None]
        self.steps[i] += sum(segment.steps for segment in step.segments)
        if step.ending is endings.LIFT_OFF:
            self._leave(number, indices, t, y)
        elif step.regime is None and step.ending is endings.COMPLETION:
            self._end(indices, t, y, step.ending)
        elif step.regime in self.regimes:
            after = np.array([self.regimes.index(step.regime)])
            self._go_on(number, after, indices, t, y)
        else:
            self.now[i] = _ALONE  # it flies, or the sentence of its ending contains numbers

    def _go_on(self, number: int, after: np.ndarray, indices: np.ndarray, t, y: np.ndarray) -> None:
        """Record transitions and begin the next phases; scenarios without progress are left to the single-scenario
        solver."""
        modes = np.array([NUMBER[regime.mode] for regime in self.regimes])
        other = modes[after] != modes[number]
        self.events.append(
            Events.of_one_contact(indices[other], t[other], modes[number], modes[after[other]], y[:, other])
        )
        self.idle[indices] = np.where(t == self.t[indices], self.idle[indices] + 1, 0)
        self.phases[indices] += 1
        self.now[indices], self.t[indices], self.y[:, indices] = after, t, y
        stuck = (self.idle[indices] > scales.IDLE) | (self.phases[indices] > scales.MANY)
        self.now[indices[stuck]] = _ALONE

    def _end(self, indices: np.ndarray, t, y: np.ndarray, ending: tuple[str, str]) -> None:
        self.now[indices], self.t[indices], self.y[:, indices] = _OVER, t, y
        self.status[indices], self.reason[indices] = ending


def _columns(scenes: ScenarioGroup, regime, gyration: np.ndarray, lengths: tuple[np.ndarray, ...]) -> Columns:
    """A regime's equations with the parameters of all scenarios, as `modes.phase` gives them for one."""
    base, law, n = scenes.base, laws(scenes.base), len(scenes.rows)
    system = contact_system(law, regime.kind, base.track, base.plate.outline)
    inputs = scenes.numbers
    effects = {
        CoulombFriction: SimpleNamespace(mu=inputs.get("mu"), stick=inputs.get("mu_stick")),
        RollingResistance: SimpleNamespace(arm=inputs.get("arm")),
    }
    case: Any = SimpleNamespace(effect=effects.get)  # the part of a case that the laws use, with columns for numbers
    values = {**inputs, "G": inputs["inertia"] / inputs["mass"], "m": inputs["mass"], "nu": float(regime.side)}
    values |= law.friction.values(case, regime.mode, regime.side)
    values |= law.resistance.values(case, regime.turn, regime.side)
    given = np.array([np.broadcast_to(values[name], n) for name in system.names]).reshape(-1, n)
    constants = [np.broadcast_to(row, n) for row in system.constants_of_arrays(given)]
    parameters = np.array([*given, *constants]).reshape(-1, n)
    places = [_ROWS[v.name] for v in system.variables]
    return Columns(regime, system, parameters, gyration, lengths[: system.positions], places)
