"""The check of a record: its scene is integrated again, and each claim is compared with the result."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import product
from math import log
from typing import Any

from .balls import ZERO, Ball, FixedPoint, add, hull, negative, positive, sub
from .steps import NotConfirmed, Step, Zero, first_zero, take
from .system import SLIPS, Regime, State, System

MOST_STEPS = 3000
# Digits beyond those of the record: the sets of states grow along the motion. Where the first are not enough, the check
# begins again with the next.
RESERVES = (16, 28, 44)
# Order of a step's series per digit; near the least time in trials.
ORDER_PER_DIGIT = 1.1
# Bits beyond those of the digits: fixed-point numbers need them where quantities are small, down to 1e-9 of the others.
SPARE_BITS = 140
REST = Regime("rest")
# The condition that a motion's end is a zero of, by the record's status.
ENDINGS = {
    "paradox": ("painleve",),
    "no_fit": ("fit",),
    "track_end": ("track_start", "track_end"),
    "outline_end": ("outline_start", "outline_end"),
}


def check(record: Mapping[str, Any]) -> str:
    """Confirm a record; returns the sentence that says what was confirmed. Raises NotConfirmed, or ValueError for a
    record that the checker does not cover."""
    if record["first_mode"] == "none":
        return f"nothing to confirm: {record['case']} has no proved part ({record['reason']})"
    for reserve in RESERVES:
        try:
            return _Check(record, int(record["precision"]["digits"]) + reserve).confirm()
        except NotConfirmed:
            if reserve == RESERVES[-1]:
                raise
    raise AssertionError  # the loop returns or raises


class _Check:
    def __init__(self, record: Mapping[str, Any], digits: int):
        self.record, self.scene = record, record["scene"]
        self.f = FixedPoint(int(digits * 3.33) + SPARE_BITS)
        self.order, self.tolerance = max(16, round(ORDER_PER_DIGIT * digits)), -digits * log(10.0)
        self.systems: dict[Regime, System] = {}
        self.steps = 0
        self.state: State = {}
        self.time: Ball = ZERO
        self.still: frozenset[str] = frozenset()  # the velocities that are exactly 0: "slip", "turn"

    def confirm(self) -> str:
        record, cause = self.record, ""
        regime = self._start()
        self._is(record["first_mode"], regime, "the motion begins in")
        for n, claim in enumerate(record["transitions"], start=1):
            self._is(claim["before"], regime, f"transition {n} begins in")
            regime, cause, before = self._to_change(regime, cause)
            if before is None:
                raise NotConfirmed(f"transition {n} was not found: the plate rests")
            shift = self._shift(self.scene["track_parameter"])
            self._compare(f"time of transition {n}", self.time, claim["time"])
            self._compare(f"xi1 of transition {n}", add(before["xi1"], shift), claim["xi1"])
            self._is(claim["after"], regime, f"transition {n} leads to")
        status, end = record["status"], Fraction(record["end"]["low"])
        if status in ENDINGS:
            name = self._phase(regime, cause, None)
            if name not in ENDINGS[status]:
                raise NotConfirmed(f"the status is {status}, and {name} vanishes first")
            self._compare("end", self.time, record["end"])
        elif status == "completed" or (regime.mode != "flight" and self.f.high(self.time) < end):
            self._to_end(regime, cause, Fraction(self.scene["duration"]) if status == "completed" else end)
        elif status not in ("lift_off", "unproved", "limited"):
            raise ValueError(f"a record has the status {status}, which the checker does not cover")
        elif status == "lift_off" and regime.mode != "flight":
            raise NotConfirmed("the status is lift_off, and the motion does not lift off")
        count = len(record["transitions"])
        return f"confirmed: {record['case']}, {count} transitions, status {status}, {self.steps} steps"

    def _is(self, claim: str, regime: Regime, what: str) -> None:
        if claim != regime.mode:
            raise NotConfirmed(f"{what} {regime.mode}, not {claim}")

    def _compare(self, what: str, value: Ball, claim: Mapping[str, str]) -> None:
        low, high = Fraction(claim["low"]), Fraction(claim["high"])
        if not (low <= self.f.low(value) and self.f.high(value) <= high):
            text = self.f.text(value)
            raise NotConfirmed(f"the {what} is in {text}, not inside the record's [{claim['low']}, {claim['high']}]")

    def _shift(self, parameter: str) -> Ball:
        """The shift of the track's parameter: a number of quarter turns."""
        text = parameter.partition("s")[2].replace(" ", "")
        if not text:
            return ZERO
        turns = (-1 if text[0] == "-" else 1) * int(text[1:].partition("*")[0])
        m, r = self.f.pi()
        return self.f.times_power((turns * m, abs(turns) * r), -1)

    # --- modes ------------------------------------------------------------------------------------------------------

    def _start(self) -> Regime:
        """The state at the start, and its regime."""
        start = {name: Fraction(text) for name, text in self.scene["start"].items()}
        self.still = frozenset(n for n, key in (("slip", "slip"), ("turn", "omega")) if not start[key])
        self.state = {name: self.f.of(start[name]) for name in ("xi1", "xi2", "omega")}
        self.state["V"] = ZERO
        stick = self._values(Regime("slip_forward"))["without_slip"]
        if self.scene["plate"] == "disc":
            stick = self.f.of(-Fraction(self.scene["radius"]) * start["omega"])
        self.state["V"] = add(self.f.of(start["slip"]), stick)
        return self._decide()

    def _system(self, regime: Regime) -> System:
        if regime not in self.systems:
            self.systems[regime] = System(self.scene, regime, self.f)
        return self.systems[regime]

    def _values(self, regime: Regime) -> dict[str, Ball]:
        return self._system(regime).values(self.state, self.time)

    def _candidates(self) -> list[Regime]:
        scene = self.scene
        if scene["mu"] is None:
            modes = ["roll" if scene["perfectly_rough"] else "slide"]
        elif "slip" in self.still:
            modes = ["roll", *SLIPS]
        else:
            slip = self._values(Regime("slip_forward"))["slip"]
            modes = [mode for mode, sign in SLIPS.items() if positive((sign * slip[0], slip[1]))]
        sides = (1,) if scene["unilateral"] or scene["mu"] is None else (1, -1)
        turns: tuple[int, ...] = (0,)
        if scene["resistance_arm"] is not None:
            omega = self.state["omega"]
            turns = (1, -1) if "turn" in self.still else (1 if positive(omega) else -1 if negative(omega) else 0,)
        rest = [REST] if len(turns) == 2 and "roll" in modes else []
        return [Regime(*values) for values in product(modes, sides, turns)] + rest

    def _decide(self) -> Regime:
        """The only regime that is consistent with the state, by strict inequalities."""
        verdicts = {regime: self._is_consistent(regime) for regime in self._candidates()}
        able = [regime for regime, verdict in verdicts.items() if verdict]
        if len(able) == 1 and all(verdict is not None for verdict in verdicts.values()):
            return able[0]
        raise NotConfirmed(f"strict inequalities do not decide the mode: {verdicts}")

    def _is_consistent(self, regime: Regime) -> bool | None:
        """Whether the conditions of a regime hold just after the state; None if balls that contain 0 leave it open. A
        normal force that is exactly 0 is left to the first step of the phase."""
        margins = self._margins_of_rest() if regime is REST else self._margins(regime)
        if any(negative(margin) for margin in margins):
            return False
        return True if all(positive(margin) for margin in margins) else None

    def _margins(self, regime: Regime) -> list[Ball]:
        values, sign = self._values(regime), SLIPS.get(regime.mode, 0)
        names = ["fit", "painleve", "normal_force", "cone_forward", "cone_backward"]
        margins = [values[name] for name in names if name in values and not (name == "normal_force" == _zero(values))]
        if sign and "slip" in self.still:
            margins.append(_times(sign, values["slip_rate"]))
        if regime.turn and "turn" in self.still:
            margins.append(_times(regime.turn, values["spin_rate"]))
        return margins

    def _margins_of_rest(self) -> list[Ball]:
        f, values = self.f, self._system(Regime("slide")).values(self.state | {"V": ZERO, "omega": ZERO}, self.time)
        N, T = _times(-1, values["across"]), _times(-1, values["along"])
        couple = sub(add(values["couple"], f.mul(values["arm_t"], N)), f.mul(values["arm_n"], T))
        sticks = f.mul(f.of(Fraction(self.scene["mu_static"])), N)
        largest = f.mul(f.of(Fraction(self.scene["resistance_arm"])), N)
        return [sub(sticks, T), add(sticks, T), sub(largest, couple), add(largest, couple)]

    # --- phases -----------------------------------------------------------------------------------------------------

    def _to_change(self, regime: Regime, cause: str, end: Fraction | None = None) -> tuple[Regime, str, State | None]:
        """Integrate to the next change of mode: the regime after it, its cause, and the state. None for the state if
        the plate rests, or if there is no change until `end`."""
        while regime is not REST:
            event = self._phase(regime, cause, end)
            if event is None:
                break
            before, after = dict(self.state), self._after(regime, event)
            if after.mode != regime.mode:
                return after, event, before
            regime, cause = after, event
        return regime, cause, None

    def _to_end(self, regime: Regime, cause: str, end: Fraction) -> None:
        """Confirm that the motion changes its mode no more."""
        regime, cause, change = self._to_change(regime, cause, end)
        if change is not None:
            raise NotConfirmed(f"{cause} vanishes before the end, at {self.f.text(self.time)}")
        if regime is REST and any(
            "t" in text.replace("sqrt", "").replace("tan", "") for text in self.scene["load_per_mass"] or ()
        ):
            raise ValueError("the checker does not cover a plate that rests under a load that depends on time")

    def _after(self, regime: Regime, cause: str) -> Regime:
        """The regime after a condition's zero; the state is set to the velocities that are then exactly 0."""
        self.still = frozenset()
        if cause == "normal_force":
            return Regime("flight") if self.scene["unilateral"] else regime._replace(side=-regime.side)
        still = set()
        if regime.mode == "roll" and self.scene["mu"] is not None or cause == "slip":
            still.add("slip")
            self.state["V"] = self._values(Regime("slip_forward") if cause == "slip" else regime)["without_slip"]
        if cause == "turn":
            still.add("turn")
            self.state |= {"omega": ZERO} | ({"V": ZERO} if "slip" in still else {})
        self.still = frozenset(still)
        if cause.startswith("cone"):
            begins = regime._replace(mode=cause.replace("cone", "slip"))
            other = next(mode for mode in SLIPS if mode != begins.mode)
            if self._is_consistent(regime._replace(mode=other)) is not False:
                raise NotConfirmed(f"friction reaches {cause}, and {other} is not excluded")
            return begins
        if cause not in ("slip", "turn"):
            raise NotConfirmed(f"{cause} vanishes, where the motion would end")
        return self._decide()

    def _phase(self, regime: Regime, cause: str, end: Fraction | None) -> str | None:
        """Integrate a regime to its first event, whose condition's name is returned, or without an event to `end`."""
        system, f = self._system(regime), self.f
        guess = float(Fraction(self.scene["duration"])) / 8
        for n in range(MOST_STEPS - self.steps):
            now = take(
                system, [self.state[name] for name in system.names], self.time, guess, self.order, self.tolerance
            )
            self.steps += 1
            zeros = self._leading_zeros(now, cause) if n == 0 else {}
            roots = (first_zero(f, name, row, zeros.get(name, 0), now.length) for name, row in now.conditions.items())
            event = _first([zero for zero in roots if zero])
            if end is not None:
                until = f.low(self._later(now, (event.low, 0) if event else (now.length, 0)))
                if until > end:
                    return None
            at = hull(event.low, event.high) if event else (now.length, 0)
            self.time = self._later(now, at)
            self.state |= {name: f.polynomial(row, at) for name, row in zip(system.names, now.states, strict=True)}
            if event:
                if end is not None and not f.high(self.time) < end:
                    raise NotConfirmed(f"{event.name} may vanish before the end")
                return event.name
            guess = 1.1 * now.seconds(f)
        raise NotConfirmed(f"the motion takes more than {MOST_STEPS} steps")

    def _later(self, now: Step, part: Ball) -> Ball:
        return add(self.time, self.f.times_power(part, now.exponent))

    def _leading_zeros(self, now: Step, cause: str) -> dict[str, int]:
        """How many leading coefficients of a condition are zero at a phase's start, known or computed as exactly 0."""
        same = self.scene["mu"] == self.scene["mu_static"]
        known = {}
        if "slip" in self.still:
            known["slip"] = 2 if same and "cone" in cause else 1
        if "turn" in self.still:
            known["turn"] = 1
        if cause == "normal_force":
            known["normal_force"] = 1
        result = {}
        for name, row in now.conditions.items():
            count = known.get(name, 0)
            while count < len(row) - 1 and row[count] == ZERO:
                count += 1
            result[name] = count
        return result


def _zero(values: Mapping[str, Ball]) -> str:
    """The name of the normal force's condition if it is exactly 0."""
    return "normal_force" if values.get("normal_force") == ZERO else ""


def _times(sign: int, a: Ball) -> Ball:
    return sign * a[0], a[1]


def _first(zeros: list[Zero]) -> Zero | None:
    """The first of the conditions' zeros, which must be separate from the others."""
    if not zeros:
        return None
    first = min(zeros, key=lambda zero: zero.low)
    if any(not first.high < other.low for other in zeros if other is not first):
        raise NotConfirmed("two conditions vanish too close to each other")
    return first
