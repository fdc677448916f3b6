"""Many scenarios at once, in waves: those of one mode go through a phase together.

What a wave shares is Python's time: parameters, starts of phases, decisions and places are arrays; of each scenario's
own there is one call of the compiled integrator a phase, without a record of its steps. What is not plain there (an
undecided start, a touch, a singularity) goes through that phase alone, by `minimal.hybrid`; what flies, or may meet its
track in a second place, is simulated alone from the beginning.
"""

from __future__ import annotations

from math import ulp
from types import SimpleNamespace
from typing import Any

import numpy as np

from cases import CoulombFriction, Flight, Mode, RollingResistance, Unilateral

from ..minimal import hybrid
from ..minimal.decision import Undecidable
from ..minimal.effects import laws
from ..minimal.integrators import taylor
from ..minimal.integrators.segment import MOST_STEPS
from ..minimal.modes import SLIP_SIGN, able, candidates, phase, start_state, state_in
from ..minimal.series import EPS
from ..minimal.system import contact_system
from ..solve import INTEGRATORS, METHODS, first_regime
from . import geometry
from .decisions import UNDECIDED, Columns, decide
from .first_step import course, leave
from .motions import NUMBER, PHRASES, Events, Motions, simulate_rows
from .scenario_values import ScenarioGroup, structure
from .single_contact import one_contact

# The places of a full state's variables, by name.
_ROWS = {"xi1": 0, "xi2": 1, "u1": 2, "u2": 3, "theta": 4}
# In the place of a regime's number: it has ended, or is to be simulated alone.
_ENDED, _ALONE = -1, -2
# In the place of a guard's number: the end of time, or the integrator does not tell.
_TIME, _UNKNOWN = -1, -2


def move(scenes: ScenarioGroup, rtol: float, optimised: bool = False) -> Motions:
    """The motions of scenarios of one structure; `optimised`: by code that takes a second more to compile."""
    with np.errstate(all="ignore"):  # what is not finite is handed to the solver of one, which says so
        return _advance(scenes, rtol, optimised)


def _advance(scenes: ScenarioGroup, rtol: float, optimised: bool) -> Motions:
    n = len(scenes.rows)
    moved, left = Motions.none(n), np.arange(n)
    if _plain(scenes):
        together = np.flatnonzero(one_contact(scenes))
        if together.size:
            wave = _Wave(scenes.only(together), rtol, optimised)
            wave.run()
            wave.put(moved, together)
            left = np.flatnonzero(moved.status == "")
    simulate_rows(scenes, left, rtol, moved)
    return moved


def _plain(scenes: ScenarioGroup) -> bool:
    """Whether scenarios can go in waves at all: in contact, without bumps that a step could pass over, by heyoka."""
    return taylor.AVAILABLE and scenes.base.start.in_contact and structure(scenes.base).plain


class _Wave:
    """Scenarios on their way: times (n,) and full states (4 or 5, n) at which their phases begin, and the numbers of
    their regimes."""

    def __init__(self, scenes: ScenarioGroup, rtol: float, optimised: bool):
        self.scenes, self.rtol, self.optimised, n = scenes, rtol, optimised, len(scenes.rows)
        known, base = scenes.numbers, scenes.base
        self.base, self.regimes = base, candidates(base)
        self.sizes = scenes.constants("track"), scenes.constants("outline")
        self.everybody = np.arange(n)
        f, h = self._places(self.everybody, known["xi1"], known["xi2"])
        gyration = np.sqrt(known["inertia"] / known["mass"])
        lengths = gyration / f.speed, gyration / h.speed, np.ones(n)
        self.columns = [_columns(scenes, regime, gyration, lengths) for regime in self.regimes]
        u1, u2 = geometry.rates(f, h, known["slip"], known["omega"])
        angle = [known["theta"]] if laws(base).needs_angle else []
        self.y, self.t = np.array([known["xi1"], known["xi2"], u1, u2, *angle]), np.zeros(n)
        self.now, self.first = np.full(n, _ALONE), np.full(n, -1)
        self.phases, self.idle, self.steps = (np.zeros(n, dtype=int) for _ in range(3))
        self.status, self.reason = (np.full(n, "", dtype=object) for _ in range(2))
        self.events: list[Events] = []

    def run(self) -> None:
        """Phase after phase until all have ended or are to be simulated alone."""
        self._begin()
        while (self.now >= 0).any():
            waves = [np.flatnonzero(self.now == number) for number in range(len(self.regimes))]
            for number, who in enumerate(waves):
                if who.size:
                    self._phase(number, who)

    def put(self, moved: Motions, rows: np.ndarray) -> None:
        """Write what has ended into its rows."""
        done = self.now == _ENDED
        there, known = rows[done], self.scenes.numbers
        for name in ("first", "status", "reason", "steps"):
            getattr(moved, name)[there] = getattr(self, name)[done]
        moved.end[there] = self.t[done]
        begun = known["xi1"], known["xi2"], known["slip"], known["omega"]
        moved.energy_start[there] = self._energy(*begun)[done]
        f, h = self._places(self.everybody, self.y[0], self.y[1])
        moved.energy_end[there] = self._energy(self.y[0], self.y[1], *geometry.slip_and_spin(f, h, *self.y[2:4]))[done]
        events = Events.joined(self.events, done)
        moved.events = events._replace(who=rows[events.who])

    def _energy(self, xi1, xi2, slip, omega) -> np.ndarray:
        known = self.scenes.numbers
        f, h = self._places(self.everybody, xi1, xi2)
        pull = known.get("gx", np.zeros(1)), known.get("gy", np.zeros(1))
        return geometry.energy(f, h, slip, omega, pull, known["mass"], known["inertia"])

    def _places(self, who: np.ndarray, xi1, xi2) -> tuple[geometry.CurvePoints, geometry.CurvePoints]:
        track, outline = ([c[who] for c in sizes] for sizes in self.sizes)
        return (
            geometry.places(self.base.track, tuple(track), xi1),
            geometry.places(self.base.plate.outline, tuple(outline), xi2),
        )

    # --- the start ----------------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        """The first regimes, as `solve.first_regime` finds one."""
        known = self.scenes.numbers
        f, h = self._places(self.everybody, known["xi1"], known["xi2"])
        along = np.abs(self.y[2]) * f.speed, np.abs(self.y[3]) * h.speed
        turned = along[0] * np.abs(f.curvature), along[1] * np.abs(h.curvature)
        slips = np.sign(known["slip"]) * (np.abs(known["slip"]) > 8 * EPS * np.maximum(*along))
        turns = np.sign(known["omega"]) * (np.abs(known["omega"]) > 8 * EPS * np.maximum(*turned))
        for slip, turn in set(zip(slips.tolist(), turns.tolist(), strict=True)):
            who = np.flatnonzero((slips == slip) & (turns == turn))
            numbers, found = self._decide(able(self.base, slip, turn), who, self.t[who], self.y[:, who], EPS)
            self.now[who] = np.where(found == UNDECIDED, _ALONE, numbers[found])
            for i in who[found == UNDECIDED].tolist():
                self.now[i] = self._first(i)
        begun = self.now >= 0
        modes = np.array([NUMBER[regime.mode] for regime in self.regimes])
        self.first[begun] = modes[self.now[begun]]

    def _first(self, i: int) -> int:
        """The regime at the start of one scenario, by the decision of one."""
        case = self.scenes.alone(i)
        try:
            regime = first_regime(case, start_state(case))
        except Undecidable:
            return _ALONE
        return self.regimes.index(regime) if regime in self.regimes else _ALONE

    def _decide(self, among, who: np.ndarray, t, y, error: float) -> tuple[np.ndarray, np.ndarray]:
        """The numbers of the regimes `among`, and which of these follows for each."""
        numbers = np.array([self.regimes.index(regime) for regime in among], dtype=int)
        return numbers, decide([self.columns[k].only(who) for k in numbers], t, y, error)

    # --- one phase ----------------------------------------------------------------------------------------------------

    def _phase(self, number: int, who: np.ndarray) -> None:
        """Take some scenarios through their phase and into what follows."""
        columns, end = self.columns[number].only(who), self.scenes.numbers["duration"][who]
        own = self.y[columns.places][:, who]
        left = leave(columns, self.t[who], own, end)
        sound = np.flatnonzero(left.sound)
        guards = np.full(len(who), _UNKNOWN)
        times, states = left.times, left.states
        integrators = taylor.integrators_of(columns.system, taylor.tolerance_of(self.rtol), float, self.optimised)
        guards[sound], self.steps[who[sound]] = integrators.call(
            self._integrated, columns, times, states, end, sound, who
        )
        for i in who[guards == _UNKNOWN].tolist():
            self._one(i)
        for guard in np.unique(guards[guards > _UNKNOWN]).tolist():
            some = guards == guard
            y = self._full(columns, who[some], states[:, some])
            if guard == _TIME:
                self._end(who[some], times[some], y, hybrid.COMPLETED)
            else:
                self._after(number, list(columns.system.guards)[guard], who[some], times[some], y)

    def _integrated(self, integrator, columns: Columns, times, states, end, sound: np.ndarray, who: np.ndarray):
        """Integrate from `times` and `states`, which become those of the events: the guards, and the steps so far."""
        pars, state = integrator.pars, integrator.state
        count, many = len(pars), taylor.CHUNK
        success, limit, all_steps = taylor.SUCCESS, taylor.TIME_LIMIT, taylor.STEP_LIMIT
        events = len(columns.system.guards)
        parameters = np.ascontiguousarray(columns.parameters.T[:, :count])
        guards, steps = [], []
        for i, j in zip(sound.tolist(), who[sound].tolist(), strict=True):
            until, guard, taken = float(end[i]), _TIME, 1
            pars[:] = parameters[i]
            state[:] = states[:, i]
            integrator.time = times[i]
            if events:
                integrator.reset_cooldowns()
            while integrator.time < until:
                outcome, shortest, _, some, _, _ = integrator.propagate_until(until, max_steps=many)
                taken += some
                told = int(outcome)
                if 0 <= -told - 1 < events:
                    guard = -told - 1
                elif told not in (success, limit, all_steps):
                    guard = _UNKNOWN
                if some and shortest <= taylor.SHORTEST * ulp(integrator.time):
                    guard = _UNKNOWN
                if guard == _TIME and taken >= MOST_STEPS and integrator.time < until:
                    guard = _UNKNOWN  # alone it ends as unfinished, and says where
                if guard != _TIME:
                    break
            times[i], states[:, i] = integrator.time, state
            guards.append(guard)
            steps.append(self.steps[j] + taken)
        return np.array(guards, dtype=int), np.array(steps, dtype=int)

    def _full(self, columns: Columns, who: np.ndarray, own: np.ndarray) -> np.ndarray:
        """A regime's own variables as full states."""
        y = np.zeros((len(self.y), len(who)))
        y[columns.places] = own
        if _ROWS["u2"] not in columns.places and _ROWS["u1"] in columns.places:
            self._stop_slip(who, y)
        return y

    def _stop_slip(self, who: np.ndarray, y: np.ndarray) -> None:
        """ξ̇₂ of plates that do not slip: v = 0 in (12)."""
        f, h = self._places(who, y[0], y[1])
        y[3] = y[2] * f.speed / h.speed

    # --- what follows -------------------------------------------------------------------------------------------------

    def _after(self, number: int, guard: str, who: np.ndarray, t: np.ndarray, y: np.ndarray) -> None:
        """What follows where a guard reached zero, as `hybrid` says of one; what is not plain goes there."""
        regime = self.regimes[number]
        if guard in hybrid.ENDS:
            self._end(who, t, y, hybrid.ENDS[guard])
            return
        slip, turn = SLIP_SIGN.get(regime.mode, 0.0), float(regime.turn or 0)
        if guard == "slip":
            slip = 0.0
            self._stop_slip(who, y)
            if regime.turn == 0:
                y[2:4] = 0.0
        elif guard == "turn":
            turn = 0.0
            f, h = self._places(who, y[0], y[1])
            y[2], y[3] = geometry.rates(f, h, geometry.slip_and_spin(f, h, y[2], y[3])[0], 0.0)
        elif guard in hybrid.BEGINS:
            slip, turn = (hybrid.BEGINS[guard], turn) if guard.startswith("cone") else (slip, hybrid.BEGINS[guard])
        else:
            lifts = self._lifts_off(number, who, t, y)  # the one guard that is left: the normal force
            self._leave(number, who[lifts], t[lifts], y[:, lifts], guard)
            for i in who[~lifts].tolist():
                self._one(i)
            return
        among, sure = able(self.base, slip, turn), np.ones(len(who), dtype=bool)
        if guard in hybrid.BEGINS:
            among = tuple(r for r in among if r.side == regime.side and r != regime)
            for other in among:
                sure &= self._unique_force(self.regimes.index(other), who, t, y)
        if guard in hybrid.BEGINS and len(among) == 1:
            numbers, found = np.array([self.regimes.index(among[0])]), np.where(sure, 0, UNDECIDED)
        else:
            numbers, found = self._decide(among, who, t, y, hybrid.LOCATED)
            found[~sure] = UNDECIDED
        for i in who[found == UNDECIDED].tolist():
            self._one(i)
        known = found != UNDECIDED
        cause = PHRASES.index(hybrid.CAUSES[guard])
        self._go_on(number, numbers[found[known]], who[known], t[known], y[:, known], cause)

    def _lifts_off(self, number: int, who: np.ndarray, t, y: np.ndarray) -> np.ndarray:
        """Where a normal force that vanished leaves no doubt: it falls on, or dips a million times as deep as a touch,
        and the plate would not move into its track."""
        if self.base.effect(Unilateral) is None:
            return np.zeros(len(who), dtype=bool)
        columns = self.columns[number].only(who)
        place = list(columns.system.guards).index("normal_force")
        slope, bend, force = course(columns, t, y[columns.places], place)
        deep = slope**2 > 2e6 * max(self.rtol, hybrid.LOCATED) * force * bend
        free = self.columns[-1].only(who)
        m = free.system.record(*free.system.observed_of_arrays(t, y[free.places], free.parameters))
        forces = np.abs(m.normal) + np.abs(m.friction) + np.abs(m.slip_dot)
        own = y[free.places][free.system.positions :]
        fastest = np.max([np.abs(u) / unit for u, unit in zip(own, free.lengths, strict=False)] or [0.0 * t], axis=0)
        scale = forces + free.size * (np.abs(m.omega_dot) + fastest**2)
        return (slope < 0.0) & deep & (m.free_approach <= 1e6 * hybrid.LOCATED * scale)

    def _leave(self, number: int, who: np.ndarray, t, y: np.ndarray, guard: str) -> None:
        """The plate leaves its track: the end, or a flight, which is not for waves."""
        if self.base.effect(Flight) is not None:
            self.now[who] = _ALONE
            return
        mode, nothing = NUMBER[self.regimes[number].mode], np.ones(len(who), dtype=int)
        cause = PHRASES.index(hybrid.CAUSES[guard])
        self.events.append(Events(who, t, mode * nothing, NUMBER[Mode.FLIGHT] * nothing, y[0], y[1], cause * nothing))
        self._end(who, t, y, hybrid.LIFT_OFF)

    def _unique_force(self, number: int, who: np.ndarray, t, y) -> np.ndarray:
        """Where a slip that begins has a force at all."""
        columns = self.columns[number].only(who)
        names = list(columns.system.guards)
        if "painleve" not in names:
            return np.ones(len(who), dtype=bool)
        values = columns.system.guards_of_arrays(t, y[columns.places], columns.parameters)[names.index("painleve")]
        return np.broadcast_to(values, who.shape) > 0.0

    def _one(self, i: int) -> None:
        """One scenario through its phase and into what follows, by the solver of one."""
        case, regime = self.scenes.alone(i), self.regimes[self.now[i]]
        now, number = phase(case, regime), int(self.now[i])
        _, integrate = INTEGRATORS[METHODS[0]]
        try:
            own = state_in(now, tuple(self.y[:, i].tolist()))
            segment = integrate(now, float(self.t[i]), own, case.duration, self.rtol)
            step = hybrid.after_contact(case, segment, max(self.rtol, hybrid.LOCATED))
        except Undecidable:
            self.now[i] = _ALONE
            return
        who, t, last = np.array([i]), np.array([step.time]), step.segments[-1].event.state
        y = np.array(step.state or hybrid.full_state(case, now, last))[:, None]
        self.steps[i] += sum(segment.steps for segment in step.segments)
        if step.ending is hybrid.LIFT_OFF:
            self._leave(number, who, t, y, step.cause)
        elif step.regime is None and step.ending is hybrid.COMPLETED:
            self._end(who, t, y, step.ending)
        elif step.regime in self.regimes:
            after = np.array([self.regimes.index(step.regime)])
            self._go_on(number, after, who, t, y, PHRASES.index(hybrid.CAUSES[step.cause]))
        else:
            self.now[i] = _ALONE  # it flies, or its ending has a sentence of its own

    def _go_on(self, number: int, after: np.ndarray, who: np.ndarray, t, y: np.ndarray, cause: int) -> None:
        """Note transitions and begin the next phases; what gets nowhere is left to the solver of one."""
        modes = np.array([NUMBER[regime.mode] for regime in self.regimes])
        before, new = np.full(len(who), modes[number]), modes[after]
        other = before != new
        columns = who, t, before, new, y[0], y[1], np.full(len(who), cause)
        self.events.append(Events(*(column[other] for column in columns)))
        self.idle[who] = np.where(t == self.t[who], self.idle[who] + 1, 0)
        self.phases[who] += 1
        self.now[who], self.t[who], self.y[:, who] = after, t, y
        stuck = (self.idle[who] > hybrid.IDLE) | (self.phases[who] > hybrid.MANY)
        self.now[who[stuck]] = _ALONE

    def _end(self, who: np.ndarray, t, y: np.ndarray, ending: tuple[str, str]) -> None:
        self.now[who], self.t[who], self.y[:, who] = _ENDED, t, y
        self.status[who], self.reason[who] = ending


def _columns(scenes: ScenarioGroup, regime, gyration: np.ndarray, lengths: tuple[np.ndarray, ...]) -> Columns:
    """A regime's equations with the parameters of all scenarios, as `modes.phase` has them of one."""
    system, law, n = contact_system(scenes.base, regime.kind), laws(scenes.base), len(scenes.rows)
    known = scenes.numbers
    effects = {
        CoulombFriction: SimpleNamespace(mu=known.get("mu"), stick=known.get("mu_stick")),
        RollingResistance: SimpleNamespace(arm=known.get("arm")),
    }
    case: Any = SimpleNamespace(effect=effects.get)  # what the laws ask of a case, with columns for numbers
    values = {**known, "G": known["inertia"] / known["mass"], "m": known["mass"], "nu": float(regime.side)}
    values |= law.friction.values(case, regime.mode, regime.side)
    values |= law.resistance.values(case, regime.turn, regime.side)
    parameters = np.array([np.broadcast_to(values[s.name], n) for s in system.parameters]).reshape(-1, n)
    places = [_ROWS[v.name] for v in system.variables]
    return Columns(regime, system, parameters, gyration, lengths[: system.positions], places)
