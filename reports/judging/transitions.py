"""First mode and transitions of any case's motion, read from a solver's samples: flights, landings, slip, turning.

Samples without a contact (NaN) are flight. Between them each contact is read for itself by
`slip_phases.read_contact`; where it rolls under rolling resistance, whether it turns is read by the same laws, since
the spin ends and begins as slip does.
In flight a jump of the velocity that gravity and load do not explain is an impact.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from math import inf, nan
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Effect, Mode, PerfectlyRough, State, Trajectory, Transition
from cases.effects import one as one_effect
from cases.motion import mechanics
from cases.scene.contact_limits import touches_by_features
from cases.scene.supports import has_rolling_resistance

from . import slip_phases
from .impacts import normal_speed
from .slip_phases import Reading

# An impact is listed if it closes with at least this part of the greatest closing speed since the plate last lay on its
# track (the reference's rule), and if samples resolve the flight that it begins.
LEAST_SHARE = 7e-4
# A rebound that flies for a whole gap g between samples needs a jump of the velocity by a·g at least, with the
# acceleration a of free flight: half of that is an impact.
_JUMP = 0.5
# Without gravity and load: ten roundings of single precision, of the motion's speed.
_SMALLEST_JUMP = 1e-6
# An impact no farther from the end than this part of its time is at the end: some roundings of where parabolas meet.
_ROUNDING = 1e-14
# Fewest samples of a contact from which slopes are computed.
_FEWEST = 4


class ReadChange(NamedTuple):
    """A change of mode that was read: when, from what to what, how far the time moves, why."""

    time: float
    before: Mode
    after: Mode
    spread: float
    cause: str


class _Impact(NamedTuple):
    """Time and its spread (s), and the closing speed along the track's normal (m/s)."""

    time: float
    spread: float
    closing: float


class SampleStretch(NamedTuple):
    """Samples [start, stop), all in flight or all in contact."""

    aloft: bool
    start: int
    stop: int


def read_motion(case: Case, trajectory: Trajectory) -> Reading:
    """First mode and transitions of a sampled motion of the case, from its samples alone.

    An impact's time is that of a doubled sample, where there is one (its spread is NaN: nothing was extrapolated);
    else where the free motion from before it meets the one from after it, exact under constant forces. Bouncing that
    comes to rest ends where three resolved impacts' geometric series does, if that is between the last sample in flight
    and the first in contact; else, as any landing without a jump, in the middle. The plate leaves where the normal
    force, extrapolated, vanishes. A contact of no more than 2.5 gaps between two flights is an impact.

    Error on exact samples of the catalogue's bounces, and which of them so many samples resolve:
    tests/judging/test_transitions.py.
    """
    if len(trajectory.t) == 1 and trajectory.status == "lift_off":  # it leaves at once: no contact comes before
        return Reading(Mode.FLIGHT, (), ())
    return MotionReader(case, trajectory).reading()


def stick_bound(effects: Sequence[Effect]) -> float | None:
    """The coefficient that bounds stick, as `slip_phases.read_contact` needs it: 0 without friction, None: no bound."""
    friction = one_effect(effects, CoulombFriction)
    return friction.stick if friction else None if one_effect(effects, PerfectlyRough) else 0.0


class MotionReader:
    """A sampled motion and the facts of its case."""

    def __init__(self, case: Case, trajectory: Trajectory):
        self.case, self.all = case, trajectory
        speed = float(np.max(np.hypot(trajectory.vx, trajectory.vy), initial=0.0))
        # A contact may be slower than the whole motion, the rounding of its velocities is not smaller.
        self.resolution = max(trajectory.slip_resolution, slip_phases.ROUNDING * speed / slip_phases.SURELY)
        self.smallest_jump = _SMALLEST_JUMP * speed
        self.bound = stick_bound(case.effects)
        # Whether a contact that does not slip may rest: with rolling resistance, or where its plate cannot turn.
        has_one_contact = not case.others and not touches_by_features(case)
        resists = has_rolling_resistance(case) and not case.others
        self.turns = resists or (not case.plate.turns and has_one_contact)

    def reading(self) -> Reading:
        stretches = self._stretches()
        first, changes = Mode.FLIGHT, list[ReadChange]()
        for number, stretch in enumerate(stretches):
            if stretch.aloft:
                if number + 1 == len(stretches):
                    changes += self._rebounds(stretch, None)
                continue
            inner = self._contact(stretch)
            if number == 0:
                first = inner.first_mode
            else:
                landing = self._landing(stretches[number - 1], stretch, inner.first_mode)
                changes += [*self._rebounds(stretches[number - 1], landing), landing]
            changes += _changes_of(inner)
            if number + 1 < len(stretches):
                changes.append(self._leaving(stretch, changes[-1].after if changes else first))
        return _reading_of(first, changes)

    # --- stretches ----------------------------------------------------------------------------------------------------

    def _stretches(self) -> list[SampleStretch]:
        """Flights and contacts in turn; contacts that are only an impact belong to the flight."""
        aloft, t = np.isnan(self.all.xi1), self.all.t
        edges = [0, *(np.flatnonzero(np.diff(aloft.astype(int))) + 1).tolist(), len(t)]
        stretches: list[SampleStretch] = []
        for start, stop in zip(edges[:-1], edges[1:], strict=True):
            up = bool(aloft[start]) or self._is_impact(start, stop)
            if stretches and stretches[-1].aloft and up:
                start = stretches.pop().start
            stretches.append(SampleStretch(up, start, stop))
        # A motion that ends where it lands is in flight to its end.
        if self.all.status in ("landing", "energy_gain") and len(stretches) > 1 and stretches[-2].aloft:
            stretches.pop()
        return stretches

    def _is_impact(self, start: int, stop: int) -> bool:
        """Whether a contact between two flights is too short for its samples to be more than an impact."""
        t = self.all.t
        if not 0 < start < stop < len(t):
            return False
        around = t[start - 1 : stop + 1]
        return bool(around[-1] - around[0] <= slip_phases.RESOLVABLE_GAPS * np.max(np.diff(around)))

    def _part(self, start: int, stop: int) -> Trajectory:
        last = stop == len(self.all.t)
        return replace(
            self.all,
            t=self.all.t[start:stop],
            **{name: getattr(self.all, name)[start:stop] for name in State._fields},
            slip_resolution=self.resolution,
            status=self.all.status if last else "completed",
            dense=None,
        )

    # --- contact ------------------------------------------------------------------------------------------------------

    def _contact(self, stretch: SampleStretch) -> Reading:
        part = self._part(stretch.start, stretch.stop)
        reading = slip_phases.read_contact(part, self.bound)
        return _with_stick(part, reading, self.case.plate.reach) if self.turns else reading

    def _leaving(self, stretch: SampleStretch, before: Mode) -> ReadChange:
        """The lift-off: the zero of the normal force between the contact's last sample and the first in flight."""
        t, force = self.all.t, self.all.normal_force
        last, next_ = float(t[stretch.stop - 1]), float(t[stretch.stop])
        samples = np.arange(stretch.start, stretch.stop)
        samples = samples[np.isfinite(force[samples]) & (np.diff(t[samples], append=inf) > 0)]
        zero = slip_phases.branch_zero(t[samples], np.abs(force[samples]), next_) if len(samples) >= _FEWEST else None
        if zero is None or not last <= zero[0] <= next_:
            zero = 0.5 * (last + next_), 0.5 * (next_ - last)
        return ReadChange(zero[0], before, Mode.FLIGHT, zero[1], "the normal force vanishes")

    # --- flight -------------------------------------------------------------------------------------------------------

    @cached_property
    def _free(self) -> np.ndarray:
        """Acceleration of free flight at the samples (n, 2), m/s²; NaN in contact."""
        motion, case = self.all, self.case
        free = np.full((len(motion.t), 2), nan)
        aloft = np.isnan(motion.xi1)
        samples = {name: getattr(motion, name)[aloft] for name in ("t", "x", "y", "theta", "vx", "vy", "omega")}
        free[aloft] = (
            mechanics.gravity(case) + mechanics.loads(case, SimpleNamespace(**samples))[:2].T / case.plate.mass
        )
        return free

    @cached_property
    def _places(self) -> np.ndarray:
        return np.column_stack([self.all.x, self.all.y])

    @cached_property
    def _rates(self) -> np.ndarray:
        return np.column_stack([self.all.vx, self.all.vy])

    def _rebounds(self, stretch: SampleStretch, landing: ReadChange | None) -> Iterable[ReadChange]:
        """The impacts of a flight that are fast enough to be listed and followed by a long enough flight."""
        impacts = self._impacts(stretch)
        if not impacts:
            return
        # The flight after the last impact lasts until the final landing, or to the end of the motion.
        last = float(self.all.t[stretch.stop - 1]) if landing is None else landing.time - np.nan_to_num(landing.spread)
        ends = [*(impact.time for impact in impacts[1:]), last]
        shortest = slip_phases.RESOLVABLE_GAPS * float(
            np.max(np.diff(self.all.t[stretch.start : stretch.stop]), initial=0.0)
        )
        greatest = 0.0
        for impact, end in zip(impacts, ends, strict=True):
            greatest = max(greatest, impact.closing)
            # The last flight of a motion counts however short it is.
            goes_on = landing is None and impact is impacts[-1] and end - impact.time > _ROUNDING * end
            whole = end - impact.time >= shortest or goes_on
            if whole and impact.closing >= LEAST_SHARE * greatest:
                yield ReadChange(impact.time, Mode.FLIGHT, Mode.FLIGHT, impact.spread, "impact")

    def _impacts(self, stretch: SampleStretch) -> list[_Impact]:
        """The impacts of a flight, in order."""
        inside = slice(stretch.start, stretch.stop)
        # Solvers with impacts of finite duration report no force in them: such samples are neither contact nor flight.
        free = np.isnan(self.all.xi1[inside]) & ~np.isnan(self.all.normal_force[inside])
        aloft = stretch.start + np.flatnonzero(free)
        impacts = []
        for i, j in zip(aloft[:-1].tolist(), aloft[1:].tolist(), strict=True):
            # Samples omitted between the two are in contact: an impact, with or without a jump.
            if j > i + 1 or self._jumps(i, j):
                time, spread = self._meeting(i, j)
                impacts.append(_Impact(time, spread, -normal_speed(self.case, self.all, i, i, time)))
        return impacts

    def _jumps(self, i: int, j: int) -> bool:
        """Whether the velocity changes from sample i, in flight, to sample j by more than gravity and load do."""
        h = self.all.t[j] - self.all.t[i]
        forces = self._free[i] if np.isnan(self._free[j]).any() else 0.5 * (self._free[i] + self._free[j])
        jump = self._rates[j] - self._rates[i] - h * forces
        return bool(np.hypot(*jump) > _JUMP * h * np.hypot(*forces) + self.smallest_jump)

    def _meeting(self, i: int, j: int) -> tuple[float, float]:
        """Time and spread of the impact between samples i and j: where the motions from both sides meet."""
        t = self.all.t
        h = float(t[j] - t[i])
        between = np.flatnonzero(np.diff(t[i : j + 1]) == 0.0)
        if len(between):
            return float(t[i + between[0]]), nan
        before, after = self._free[i], self._free[j]
        if np.isnan(after).any():
            step = t[j + 1] - t[j] if j + 1 < len(t) else 0.0
            after = (self._rates[j + 1] - self._rates[j]) / step if step > 0.0 else before
        jump = self._rates[j] - self._rates[i] - 0.5 * h * (before + after)
        polynomial = np.array([
            0.5 * (before - after) @ jump,
            (self._rates[i] - self._rates[j] + h * after) @ jump,
            (self._places[i] - self._places[j] + h * self._rates[j] - 0.5 * h * h * after) @ jump,
        ])  # fmt: skip
        roots = np.roots(polynomial) if np.isfinite(polynomial).all() else np.array([])
        inside = roots.real[(np.abs(roots.imag) <= 1e-9 * h) & (roots.real >= 0.0) & (roots.real <= h)]
        if len(inside):
            return float(t[i]) + float(inside[0]), nan
        return float(t[i]) + 0.5 * h, 0.5 * h

    def _landing(self, flight: SampleStretch, contact: SampleStretch, after: Mode) -> ReadChange:
        """Where the last flight of a stretch ends in contact."""
        i, j = flight.stop - 1, contact.start
        if self._jumps(i, j):
            time, spread = self._meeting(i, j)
        else:
            low, high = float(self.all.t[i]), float(self.all.t[j])
            time, spread = 0.5 * (low + high), 0.5 * (high - low)
        limit = self._rest(flight)
        if limit is not None and self.all.t[i] < limit <= self.all.t[j]:
            return ReadChange(limit, Mode.FLIGHT, after, 0.5 * float(self.all.t[j] - self.all.t[i]), "bouncing ends")
        return ReadChange(time, Mode.FLIGHT, after, spread, "landing")

    def _rest(self, flight: SampleStretch) -> float | None:
        """The time at which bouncing comes to rest: the limit of its last three resolved impacts, or None."""
        times = np.array([impact.time for impact in self._impacts(flight)])
        gap = float(np.max(np.diff(self.all.t[flight.start : flight.stop]), initial=0.0))
        # The times of two impacts closer than this would be read from the same samples.
        short = np.flatnonzero(np.diff(times) < slip_phases.RESOLVABLE_GAPS * gap)
        times = times[: short[0] + 1] if len(short) else times
        if len(times) < 3:
            return None
        earlier, later = np.diff(times[-3:]).tolist()
        return float(times[-1] + later**2 / (earlier - later)) if later < earlier else None


def _with_stick(part: Trajectory, reading: Reading, reach: float) -> Reading:
    """The reading of a contact with rolling and rest distinguished, by the same rules as slip and rolling."""
    edges = [-inf, *(event.time for event in reading.transitions), inf]
    modes = [reading.first_mode, *(event.after for event in reading.transitions)]
    first, changes = modes[0], list[ReadChange]()
    for number, mode in enumerate(modes):
        inner = Reading(mode, (), ())
        if mode is Mode.ROLL:
            inside = np.flatnonzero((part.t > edges[number]) & (part.t < edges[number + 1]))
            inner = _turning(part, inside, reach)
        if number == 0:
            first = inner.first_mode
        else:
            event = reading.transitions[number - 1]
            last = changes[-1].after if changes else first
            changes.append(ReadChange(event.time, last, inner.first_mode, reading.spreads[number - 1], event.cause))
        changes += _changes_of(inner)
    return _reading_of(first, changes)


def _changes_of(reading: Reading) -> list[ReadChange]:
    pairs = zip(reading.transitions, reading.spreads, strict=True)
    return [ReadChange(e.time, e.before, e.after, spread, e.cause) for e, spread in pairs]


def _reading_of(first: Mode, changes: Sequence[ReadChange]) -> Reading:
    transitions = tuple(Transition(c.time, c.before, c.after, cause=c.cause) for c in changes)
    return Reading(first, transitions, tuple(c.spread for c in changes))


def _turning(part: Trajectory, inside: np.ndarray, reach: float) -> Reading:
    """Rolls and sticks of a contact that does not slip, samples `inside`."""
    spin = reach * part.omega[inside]
    if len(inside) < _FEWEST:
        still = len(inside) > 0 and np.all(np.abs(spin) <= slip_phases.SURELY * part.slip_resolution)
        return Reading(Mode.REST if still else Mode.ROLL, (), ())
    values = {name: getattr(part, name)[inside] for name in State._fields} | {"slip": spin}
    turning = slip_phases.read_contact(replace(part, t=part.t[inside], **values, status="completed"), None)
    rows = [
        (replace(event, before=_turns(event.before), after=_turns(event.after), cause=cause), spread)
        for event, spread in zip(turning.transitions, turning.spreads, strict=True)
        # A roll that reverses remains a roll.
        if (cause := _TURNING.get((_turns(event.before), _turns(event.after))))
    ]
    return Reading(_turns(turning.first_mode), tuple(event for event, _ in rows), tuple(spread for _, spread in rows))


_TURNING = {(Mode.ROLL, Mode.REST): "turning ends", (Mode.REST, Mode.ROLL): "turning begins"}


def _turns(mode: Mode) -> Mode:
    return Mode.REST if mode is Mode.ROLL else Mode.ROLL
