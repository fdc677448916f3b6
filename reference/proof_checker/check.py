"""The check of a record: its scene is integrated again, and each claim is compared with the result.

The plate is a disc. State: ξ₁, the velocity V of the disc's centre along the track, and the spin ω. With P = |R_p|, the
curvature κ of the track, the room 1 − κ r, and applied forces f_t, f_n and couple M per mass, (15) gives

    ξ̇₁ = V/(P (1 − κ r)),  N = κ V²/(1 − κ r) − f_n,  V̇ = f_t + T,  (J/m) ω̇ = M + r T,  v = V + r ω,

with T = −μ N sign(v) while it slips, and T from v̇ = V̇ + r ω̇ = 0 while it rolls. A step of Taylor's method is validated
by Taylor's theorem with remainder over a box that contains the step's states in its interior.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import exp, log
from typing import Any, NamedTuple

from mpmath import iv
from mpmath.libmp import mpi_add, mpi_mul, to_float

from .formulas import Formula, derivative, parse
from .graph import ZERO, Graph, Raw, number, raw

MOST_STEPS, MOST_HALVINGS, MOST_PARTS = 3000, 60, 4000
# A remainder grows faster than the step's power, because the box grows with the step; found by trying.
BOX_SHARE = 1.4
# Digits beyond those of the record; the step's order grows with them.
RESERVE = 16
SLIPS = {"slip_forward": 1, "slip_backward": -1}
STATE = ("xi1", "V", "omega")


class NotConfirmed(ValueError):
    """A claim of the record that the checker could not confirm."""


class Zero(NamedTuple):
    """The first zero of a condition in a step, and the condition's name."""

    name: str
    low: Any
    high: Any


class Step(NamedTuple):
    """A validated step: its length, a guess for the next one, and polynomials with their remainders."""

    length: Any
    next_length: Any
    states: tuple[list[Raw], ...]
    conditions: dict[str, list[Raw]]


def check(record: Mapping[str, Any]) -> str:
    """Confirm a record; returns the sentence that says what was confirmed. Raises NotConfirmed, or ValueError for a
    record that the checker does not cover."""
    precision = iv.prec
    digits = int(record["precision"]["digits"]) + RESERVE
    iv.prec = int(digits * 3.33) + 40
    try:
        return _Check(record, digits).confirm()
    finally:
        iv.prec = precision


class _Check:
    def __init__(self, record: Mapping[str, Any], digits: int):
        self.record, self.scene = record, record["scene"]
        self.order, self.tolerance = max(16, round(1.3 * digits)), iv.mpf(10) ** -digits
        scene = self.scene
        if scene["plate"] != "disc" or scene["resistance_arm"] is not None:
            raise ValueError("the checker covers discs without rolling resistance")
        self.mu = None if scene["mu"] is None else Fraction(scene["mu"])
        if self.mu is not None and Fraction(scene["mu_static"]) != self.mu:
            raise ValueError("the checker does not cover static friction")
        if self.mu is not None and not scene["unilateral"]:
            raise ValueError("the checker does not cover bilateral guides with friction")
        self.systems: dict[str, _System] = {}
        self.steps = 0

    def confirm(self) -> str:
        record = self.record
        start = self.scene["start"]
        radius, slip, omega = (Fraction(text) for text in (self.scene["radius"], start["slip"], start["omega"]))
        state = {"xi1": raw(Fraction(start["xi1"])), "V": raw(slip - radius * omega), "omega": raw(omega)}
        mode, time = record["first_mode"], iv.mpf(0)
        self._decide(mode, state, "" if slip else "slip", slip)
        last_zero = "" if slip else "slip"
        for n, claim in enumerate(record["transitions"], start=1):
            if claim["before"] != mode:
                raise NotConfirmed(f"transition {n} begins in {claim['before']}, and the motion is in {mode}")
            zero, time, state = self._phase(mode, state, time, None, last_zero)
            if zero is None:
                raise NotConfirmed(f"transition {n} was not found")
            self._compare(f"time of transition {n}", time, claim["time"])
            turns = self.scene["track_parameter"].partition("s")[2].replace(" ", "")
            shift = _shift(turns)
            self._compare(f"xi1 of transition {n}", number(state["xi1"]) + shift, claim["xi1"])
            last_zero = zero.name
            if zero.name == "slip":
                state["omega"] = (-number(state["V"]) / iv.mpf(radius.numerator) * radius.denominator)._mpi_
            mode = claim["after"]
            if mode == "flight":
                if zero.name != "normal_force":
                    raise NotConfirmed(f"transition {n} is a lift-off, and the normal force does not vanish there")
                break
            self._decide(mode, state, zero.name, None)
        if record["status"] == "completed":
            end = Fraction(self.scene["duration"])
            self._phase(mode, state, time, iv.mpf(end.numerator) / end.denominator, last_zero)
        found = len(record["transitions"])
        return f"confirmed: {record['case']}, {found} transitions, status {record['status']}, {self.steps} steps"

    def _compare(self, what: str, found: Any, claim: Mapping[str, str]) -> None:
        low, high = (number(raw(Fraction(claim[end]))) for end in ("low", "high"))
        if not (low.b <= found.a and found.b <= high.a):
            raise NotConfirmed(f"the {what} is in {found}, not inside the record's [{claim['low']}, {claim['high']}]")

    # --- modes ------------------------------------------------------------------------------------------------------

    def _decide(self, mode: str, state: Mapping[str, Raw], cause: str, slip: Fraction | None) -> None:
        """Confirm that the mode is the only one that is consistent with the state."""
        if self.mu is None:
            expected = "roll" if self.scene["perfectly_rough"] else "slide"
            if mode != expected:
                raise NotConfirmed(f"the mode {mode} is impossible without friction")
            return
        if slip:
            if mode != ("slip_forward" if slip > 0 else "slip_backward"):
                raise NotConfirmed(f"the start slips, and its mode is not {mode}")
            return
        if cause.startswith("cone"):
            if mode != cause.replace("cone", "slip"):
                raise NotConfirmed(f"friction reaches {cause}, and {mode} does not follow")
            return
        verdicts: dict[str, bool | None] = {}
        for candidate in ("roll", *SLIPS):
            values = self._system(candidate).at_start(state)
            names = ("cone_forward", "cone_backward") if candidate == "roll" else ("slip_rate",)
            margins = [values[name] for name in names]
            verdicts[candidate] = True if all(m > 0 for m in margins) else None
            if any(m < 0 for m in margins):
                verdicts[candidate] = False
        if not verdicts[mode] or any(v is not False for other, v in verdicts.items() if other != mode):
            raise NotConfirmed(f"{mode} is not the only consistent mode: {verdicts}")

    def _system(self, mode: str) -> _System:
        if mode not in self.systems:
            self.systems[mode] = _System(self.scene, mode, self.mu)
        return self.systems[mode]

    # --- phases -----------------------------------------------------------------------------------------------------

    def _phase(self, mode: str, state: Mapping[str, Raw], time: Any, end: Any, last_zero: str):
        """Integrate a mode to its first event, or without an event to `end`."""
        system, current, first = self._system(mode), dict(state), True
        guess = iv.mpf(self.scene_length())
        for _ in range(MOST_STEPS):
            now = system.step([current[name] for name in STATE], guess, self.order, self.tolerance, time)
            self.steps += 1
            zeros = self._leading_zeros(now, mode, last_zero) if first else {}
            rows = [(name, row, zeros.get(name, 0)) for name, row in now.conditions.items()]
            events = [zero for row in rows if (zero := first_zero(*row, now.length))]
            first = False
            if end is not None and (time + now.length).a >= end.b:
                if any((time + z.low).a <= end.b for z in events):
                    raise NotConfirmed(f"{events[0].name} may vanish before the end")
                return None, end, current
            if events:
                event = min(events, key=lambda z: z.low.a)
                if any(not event.high.b < other.low.a for other in events if other is not event):
                    raise NotConfirmed("two conditions vanish too close to each other")
                if end is not None:
                    raise NotConfirmed(f"{event.name} vanishes before the end, at {time + event.low}")
                at = iv.mpf([event.low.a, event.high.b])
                place = {name: evaluate(row, at)._mpi_ for name, row in zip(STATE, now.states, strict=True)}
                return event, time + at, place
            current = {name: evaluate(row, now.length)._mpi_ for name, row in zip(STATE, now.states, strict=True)}
            time, guess = time + now.length, iv.mpf(now.next_length.a)
        raise NotConfirmed(f"the phase {mode} takes more than {MOST_STEPS} steps")

    def scene_length(self) -> float:
        """The length of the first step that is tried, s."""
        return float(Fraction(self.scene["duration"])) / 8

    def _leading_zeros(self, now: Step, mode: str, last_zero: str) -> dict[str, int]:
        """How many leading coefficients of a condition are zero at a phase's start, known or computed as exactly 0."""
        known = {"slip": 1} if last_zero == "slip" else {"slip": 2} if last_zero.startswith("cone") else {}
        result = {}
        for name, row in now.conditions.items():
            count = known.get(name, 0)
            while count < len(row) - 1 and row[count] == ZERO:
                count += 1
            result[name] = count
        return result


def _shift(text: str) -> Any:
    """The shift of the track's parameter: +n*pi/2 or nothing."""
    if not text:
        return iv.mpf(0)
    sign, count = (-1 if text[0] == "-" else 1), int(text[1:].partition("*")[0])
    return sign * count * iv.pi / 2


class _System:
    """The equations of one mode as a graph, with the conditions under which it lasts."""

    def __init__(self, scene: Mapping[str, Any], mode: str, mu: Fraction | None):
        g = self.graph = Graph()
        s, V, omega, t = (g.variable(name) for name in (*STATE, "t"))
        self.variables = s, V, omega
        self.time = t
        x, y = (parse(text) for text in scene["track"])
        forms = Formula(g, {"s": s})
        xp, yp = derivative(x), derivative(y)
        X, Y, Xp, Yp, Xs, Ys = (forms.node(tree) for tree in (x, y, xp, yp, derivative(xp), derivative(yp)))
        square = g.sum_of_products(Xp, Xp, Yp, Yp)
        P = g.sqrt(square)
        kappa = g.div(g.sum_of_products(Xp, Ys, g.sub(g.constant(0), Yp), Xs), g.mul(square, P))
        r, G = (g.constant(Fraction(scene[name])) for name in ("radius", "inertia_per_mass"))
        room = g.sub(g.constant(1), g.mul(kappa, r))
        tx, ty = g.div(Xp, P), g.div(Yp, P)
        fx, fy = (Formula(g, {}).node(parse(text)) for text in scene["gravity"])
        M = g.constant(0)
        if scene["load_per_mass"]:
            names = {"t": t, "x": g.sub(X, g.mul(r, ty)), "y": g.add(Y, g.mul(r, tx)), "omega": omega}
            names |= {"vx": g.mul(V, tx), "vy": g.mul(V, ty)}
            lx, ly, M = (Formula(g, names).node(parse(text)) for text in scene["load_per_mass"])
            fx, fy = g.add(fx, lx), g.add(fy, ly)
        ft, fn = g.add(g.mul(fx, tx), g.mul(fy, ty)), g.sub(g.mul(fy, tx), g.mul(fx, ty))
        speed = g.div(V, room)
        N = g.sub(g.mul(g.mul(kappa, speed), V), fn)
        sign = SLIPS.get(mode, 0)
        if mode == "roll":  # v̇ = f_t + T + r (M + r T)/G = 0
            driven, inverse = g.add(ft, g.div(g.mul(r, M), G)), g.add(g.constant(1), g.div(g.mul(r, r), G))
            T = g.sub(g.constant(0), g.div(driven, inverse))
        else:
            T = g.mul(g.constant(-sign * (mu or 0)), N)
        V_dot, omega_dot = g.add(ft, T), g.div(g.add(M, g.mul(r, T)), G)
        self.rates = g.div(speed, P), V_dot, omega_dot
        self.conditions: dict[str, int] = {"fit": room}
        v, v_dot = g.add(V, g.mul(r, omega)), g.add(V_dot, g.mul(r, omega_dot))
        self.slip_rate = g.mul(g.constant(sign), v_dot)
        if sign:
            self.conditions["slip"] = g.mul(g.constant(sign), v)
            self.conditions["normal_force"] = N
        elif mode == "roll" and mu is not None:
            largest = g.mul(g.constant(mu), N)
            self.conditions |= {"cone_forward": g.add(largest, T), "cone_backward": g.sub(largest, T)}
        elif scene["unilateral"]:
            self.conditions["normal_force"] = N
        if scene["track_domain"] is not None:
            low, high = (g.constant(Fraction(text)) for text in scene["track_domain"])
            self.conditions |= {"track_start": g.sub(s, low), "track_end": g.sub(high, s)}

    def at_start(self, state: Mapping[str, Raw]) -> dict[str, Any]:
        """The conditions and the rate of the slip at one instant."""
        self._begin([state[name] for name in STATE], iv.mpf(0))
        self.graph.compute(0)
        values = {name: number(self.graph.c[node][0]) for name, node in self.conditions.items()}
        return values | {"slip_rate": number(self.graph.c[self.slip_rate][0])}

    def _begin(self, state: Sequence[Raw], time: Any) -> None:
        self.graph.clear()
        for node, value in zip((*self.variables, self.time), (*state, time._mpi_), strict=True):
            self.graph.c[node].append(value)

    def expand(self, state: Sequence[Raw], time: Any, order: int):
        """Taylor coefficients 0 … order of the states and the conditions."""
        graph = self.graph
        self._begin(state, time)
        for k in range(order + 1):
            graph.compute(k)
            for node, rate in zip(self.variables, self.rates, strict=True):
                graph.c[node].append((number(graph.c[rate][k]) / (k + 1))._mpi_)
            graph.c[self.time].append(raw(1) if k == 0 else ZERO)
        states = tuple(graph.c[node][: order + 1] for node in self.variables)
        return states, {name: graph.c[node][: order + 1] for name, node in self.conditions.items()}

    def step(self, state: Sequence[Raw], guess: Any, order: int, tolerance: Any, time: Any) -> Step:
        """A validated step of about the length `guess`."""
        states, conditions = self.expand(state, time, order)
        h, change = guess, 0.6
        for _ in range(MOST_HALVINGS):
            change, last = 0.6, self._remainder(states, h, order, time)
            if last is not None:
                size = [max(abs(number(c) * h**k).b for k, c in enumerate(row[:order])) for row in states]
                excess = max((abs(number(c)) * h**order).b / (s or 1) for c, s in zip(last[0], size, strict=True))
                change = 0.9 * exp(max(-2.0, min(0.3, _log(tolerance) - _log(excess)) / (BOX_SHARE * order)))
                if excess <= tolerance.b:
                    rows = {name: [*row[:order], last[1][name]] for name, row in conditions.items()}
                    ends = tuple([*row[:order], c] for row, c in zip(states, last[0], strict=True))
                    return Step(h, h * 1.1, ends, rows)
            h = iv.mpf((h * change).a)
        raise NotConfirmed("a step of the integration could not be validated")

    def _remainder(self, states, h: Any, order: int, time: Any):
        """The coefficients of that order over a box that contains the step's states in its interior, or None."""
        part, precision = iv.mpf([0, h.b]), iv.prec
        iv.prec = 53
        try:
            inner = [evaluate(row[:order], part) for row in states]
            boxes = [_inflated(value) for value in inner]
            try:
                last_states, last_conditions = self.expand([box._mpi_ for box in boxes], time + part, order)
            except ZeroDivisionError:
                return None
            ends = [row[order] for row in last_states]
            power = part**order
            for box, value, c in zip(boxes, inner, ends, strict=True):
                reached = value + number(c) * power
                if not (box.a < reached.a and reached.b < box.b):
                    return None
            return ends, {name: row[order] for name, row in last_conditions.items()}
        finally:
            iv.prec = precision


def _log(value: Any) -> float:
    """The logarithm of an interval's upper end, roughly; that of 0 is far below all others."""
    upper = to_float(value._mpi_[1])
    return log(upper) if upper > 0 else -700.0


def _inflated(value: Any) -> Any:
    """A larger interval around an interval."""
    extra = (value.delta / 8).b + abs(value).b * iv.mpf(2) ** -40 + iv.mpf(2) ** -200
    return iv.mpf([(value - extra).a, (value + extra).b])


def evaluate(row: Sequence[Raw], s: Any) -> Any:
    """A polynomial at an interval, by Horner's rule."""
    total, at, precision = ZERO, s._mpi_, iv.prec
    for c in reversed(row):
        total = mpi_add(mpi_mul(total, at, precision), c, precision)
    return number(total)


def first_zero(name: str, row: Sequence[Raw], zeros: int, length: Any) -> Zero | None:
    """The first zero of a condition in (0, length], unique and from positive to negative; None if it stays positive."""
    value = list(row[zeros:])
    slope = [(number(c) * k)._mpi_ for k, c in enumerate(value)][1:]
    parts = [(iv.mpf(0), length)]
    for _ in range(MOST_PARTS):
        if not parts:
            return None
        low, high = parts.pop()
        part = iv.mpf([low.a, high.b])
        if evaluate(value, part) > 0:
            continue
        rate = evaluate(slope, part)
        if evaluate(value, low) > 0 and (rate > 0 or (rate < 0 and evaluate(value, high) > 0)):
            continue
        if rate < 0 and evaluate(value, low) > 0 and evaluate(value, high) < 0:
            return _narrow(name, value, slope, low, high)
        middle = iv.mpf(((low + high) / 2).mid)
        if not low.b < middle.a or not middle.b < high.a:
            break
        parts += [(middle, high), (low, middle)]
    raise NotConfirmed(f"the sign of {name} could not be confirmed")


def _narrow(name: str, value: Sequence[Raw], slope: Sequence[Raw], low: Any, high: Any) -> Zero:
    """The zero in a small interval, by interval Newton."""
    for _ in range(200):
        part = iv.mpf([low.a, high.b])
        middle = iv.mpf(part.mid)
        newton = middle - evaluate(value, middle) / evaluate(slope, part)
        new_low, new_high = iv.mpf(max(low.a, newton.a)), iv.mpf(min(high.b, newton.b))
        if not (new_high - new_low).b < 0.9 * (high - low).a:
            break
        low, high = new_low, new_high
    return Zero(name, low, high)
