"""A motion, phase after phase: each one is proved, or the motion ends with the condition that was not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from flint import arb, arb_series

from cases import Mode
from cases.effects import MOTION

from .decision import Following, cone_margins, first_regime, following
from .equations import ContactRegime, Dynamics, number
from .steps import NotCovered, NotProved, StateExpansion, ValidStep, Zero, exact, first_zero, interval, step

# Steps of one motion, and phases: beyond them the rest of the motion is not proved.
MOST_STEPS, MOST_PHASES = 2_000, 500
# Lengths of a step that are tried, each a quarter of the one before, until all signs are proved.
MOST_SHORTER = 5

ENDINGS = {
    "painleve": "paradox",
    "fit": "no_fit",
    "track_start": "track_end",
    "track_end": "track_end",
    "outline_start": "outline_end",
    "outline_end": "outline_end",
}
State = dict[str, arb]
Report = Callable[[str], None]


class ModeChange(NamedTuple):
    """A proved change of mode: `time` and the state's entries are enclosures."""

    before: Mode
    after: Mode
    time: arb
    state: Mapping[str, arb]
    cause: str
    reason: str  # why the mode that follows is the only one that is consistent
    share: arb | None  # of the cone, the part that rolling needs where the slip vanishes


class PhaseProof(NamedTuple):
    """What was proved about one phase: guards positive in its interior, over that many steps."""

    regime: ContactRegime
    begin: arb
    end: arb
    guards: tuple[str, ...]
    steps: int


@dataclass
class MotionProof:
    """The proved part of a motion. `status` is "unproved" if it ends before the motion's end; `reason` says why."""

    first_mode: Mode | None = None
    transitions: list[ModeChange] = field(default_factory=list)
    phases: list[PhaseProof] = field(default_factory=list)
    status: str = "unproved"
    reason: str = ""
    end: arb = field(default_factory=arb)
    xi1_range: arb | None = None
    covered: bool = True  # whether more digits may prove more


def follow(equations: Dynamics, order: int, tolerance: arb, most: int, report: Report | None = None) -> MotionProof:
    """Prove the motion up to its duration, its end, or its first `most` transitions."""
    scene, result = equations.scene, MotionProof()
    t, end = arb(0), number(scene.duration)
    steps = 0
    try:
        regime, state, orders = first_regime(equations)
        result.first_mode = regime.mode
        for _ in range(MOST_PHASES):
            if regime.mode is Mode.REST:
                return _at_rest(equations, result, state, t, end)
            phase = _RegimeProof(equations, regime, state, orders, t, order, tolerance)
            steps += phase.integrate(end, MOST_STEPS - steps)
            t = phase.time
            result.xi1_range = phase.covered(result.xi1_range)
            result.phases.append(PhaseProof(regime, phase.begin, t, phase.guards, phase.steps))
            result.end = t
            if phase.event is None:
                result.status, result.reason = "completed", "The motion was proved up to its duration."
                return result
            then = _after(equations, regime, phase.event, phase.state, t)
            if then.regime is None or then.regime.mode is not regime.mode:
                after = then.regime.mode if then.regime else Mode.FLIGHT
                if then.regime is not None or then.status == "lift_off":
                    at = ModeChange(regime.mode, after, t, phase.state, phase.event, then.reason, then.share)
                    result.transitions.append(at)
                    if report is not None:
                        report(f"{regime.mode} -> {after} at {t.str(12, radius=False)} s")
            if then.regime is None:
                if then.status == "lift_off" and scene.flies:
                    raise NotCovered("the plate flies, and proofs do not follow flights")
                result.status, result.reason = then.status, then.reason
                return result
            if len(result.transitions) >= most:
                result.status, result.reason = "limited", f"The first {most} transitions were asked for."
                return result
            regime, state, orders = then.regime, then.state, then.known
        result.reason = f"The motion has more than {MOST_PHASES} phases."
    except NotProved as problem:
        result.covered = not isinstance(problem, NotCovered)
        result.reason = f"After {t.str(9, radius=False)} s: {problem}."
    return result


def _at_rest(equations: Dynamics, result: MotionProof, state: State, t: arb, end: arb) -> MotionProof:
    """The motion of a plate that came to rest: it stays there if no load depends on time."""
    load = equations.scene.load
    if load is not None and any(part.has(MOTION[0]) for part in load):
        raise NotCovered("the plate rests under a load that depends on time")
    result.phases.append(PhaseProof(ContactRegime(Mode.REST), t, end, ("rest",), 0))
    result.status, result.reason, result.end = "completed", "The motion was proved up to its duration.", end
    return result


def _after(equations: Dynamics, regime: ContactRegime, guard: str, state: State, t: arb) -> Following:
    if guard in ENDINGS:
        return Following(None, {}, {}, f"{guard} vanished", ENDINGS[guard])
    return following(equations, regime, guard, state, t)


class _RegimeProof:
    """One regime from its beginning to its first event or the motion's end."""

    def __init__(self, equations: Dynamics, regime: ContactRegime, state: State, orders: Mapping[str, int], begin: arb,
                 order: int, tolerance: arb):  # fmt: skip
        self.equations, self.regime, self.begin, self.orders = equations, regime, begin, orders
        self.order, self.tolerance = order, tolerance
        self.names = equations.names(regime)
        self.state: State = state
        self.time, self.steps = begin, 0
        self.guards: tuple[str, ...] = ()
        self._range: arb | None = None
        self._guess = 0.0
        self.event: str | None = None

    def covered(self, before: arb | None) -> arb | None:
        """All values of ξ₁ of this phase, and those before."""
        return before.union(self._range) if before is not None and self._range is not None else self._range

    def integrate(self, end: arb, most: int) -> int:
        """Validate steps until an event or the motion's end; returns their number."""
        for n in range(most):
            remaining = exact((end - self.time).upper())
            if not remaining > 0:
                return n
            now, guards, event = self._step(remaining, first=n == 0)
            self.guards = tuple(guards)
            self.steps += 1
            length = event.high if event else now.length
            part = now.states[0](interval(arb(0), length))
            self._range = part if self._range is None else self._range.union(part)
            if event is None:
                self._advance(now, now.length)
                if (now.length == remaining) and not self.time < end:
                    self.time = end
                    return n + 1
                continue
            if self.time + event.low > end:
                self.time = end
                return n + 1
            self._advance(now, event.enclosure)
            if not self.time < end:
                raise NotProved("an event lies within the error of the motion's end")
            self.event = event.name
            return n + 1
        raise NotCovered(f"the motion takes more than {MOST_STEPS} steps")

    def _step(self, longest: arb, first: bool) -> tuple[ValidStep, dict[str, StateExpansion], Zero | None]:
        """A validated step with all signs proved; a shorter one where the remainder of a guard hides its sign."""
        for n in range(MOST_SHORTER):
            now = step(self._field, self._values(), longest, self._guess, self.order, self.tolerance)
            self._guess = now.next_length
            try:
                guards = self._with_zeros(now, first)
                return now, guards, self._first_event(guards, now.length)
            except NotProved:
                if n == MOST_SHORTER - 1:
                    raise
            longest = exact(now.length / 4)
        raise AssertionError  # the loop returns or raises

    def _values(self) -> list[arb]:
        return [self.state[name] for name in self.names]

    def _advance(self, now: ValidStep, s: arb) -> None:
        self.state = dict(zip(self.names, now.state(s), strict=True))
        self.time = self.time + s

    def _field(self, series: Sequence[arb_series]) -> tuple[list[arb_series], dict[str, arb_series]]:
        state = dict(zip(self.names, series, strict=True))
        point = self.equations.at(self.regime, state, self.time)
        return [point.rates[name] for name in self.names], guards(self.equations, self.regime, state, point)

    def _with_zeros(self, now: ValidStep, first: bool) -> dict[str, StateExpansion]:
        """The guards, with the number of leading coefficients that are exactly zero in the phase's first step."""
        if not first:
            return now.guards
        result = {}
        for name, guard in now.guards.items():
            orders, zeros = self.orders.get(name, 0), 0
            for coefficient in guard.coefficients[:-1]:
                if zeros >= orders and not coefficient.is_zero():
                    break
                zeros += 1
            rest = guard.coefficients[zeros:]
            if rest[0] < 0:
                raise NotProved(f"{name} would become negative at the start of {self.regime.mode}")
            result[name] = StateExpansion((arb(0),) * zeros + rest, zeros)
        return result

    def _first_event(self, guards: Mapping[str, StateExpansion], length: arb) -> Zero | None:
        """The first zero of any guard, before which all others are positive."""
        zeros = [zero for name, guard in guards.items() if (zero := first_zero(guard, length, name)) is not None]
        first = min(zeros, key=lambda zero: zero.low, default=None)
        for other in zeros:
            if first is not None and other is not first and not first.high < other.low:
                raise NotProved(f"{first.name} and {other.name} vanish too close to each other")
        return first


def guards(equations: Dynamics, regime: ContactRegime, state: Mapping[str, arb_series], point) -> dict[str, arb_series]:
    """What is positive as long as the regime lasts, by name."""
    scene, result = equations.scene, {}
    if regime.sign:
        result["slip"] = regime.sign * state["v"]
        result["normal_force"] = regime.side * point.normal
        result["painleve"] = point.den
    elif regime.slips:
        result |= {"normal_force": point.normal} if scene.unilateral else {}
    elif scene.rough:
        result |= {"normal_force": point.normal} if scene.unilateral else {}
    else:
        result["cone_forward"], result["cone_backward"] = cone_margins(equations, regime, point)
    if regime.turn:
        result["turn"] = regime.turn * point.omega
    result["fit"] = point.fit
    for name, domain in (("track", scene.track_domain), ("outline", scene.outline_domain)):
        if domain is not None:
            place = state["xi1" if name == "track" else "xi2"]
            result[f"{name}_start"], result[f"{name}_end"] = place - number(domain[0]), number(domain[1]) - place
    return result
