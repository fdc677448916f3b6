"""Proof records: what is stated about a case, its enclosures in decimal digits, and how it was proved."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from decimal import Context, Decimal
from fractions import Fraction
from math import ceil, floor
from typing import Any, NamedTuple

KIND, FORMAT = "proved", 1
# Records have at most some thousand digits, none of which is rounded again.
EXACT = Context(prec=100_000)


class DecimalInterval(NamedTuple):
    """A closed interval whose ends are decimal numbers, as text: every digit counts."""

    low: str
    high: str

    @property
    def width(self) -> float:
        """An upper bound of its width."""
        return float(Fraction(self.high) - Fraction(self.low)) * (1 + 2**-50)

    @property
    def middle(self) -> float:
        return float((Fraction(self.low) + Fraction(self.high)) / 2)

    def __contains__(self, value: object) -> bool:
        return Fraction(self.low) <= Fraction(str(value)) <= Fraction(self.high)

    def inside(self, value: float, bar: float) -> bool:
        """Whether the interval is inside value ± bar, compared exactly."""
        return Fraction(value) - Fraction(bar) <= Fraction(self.low) and Fraction(self.high) <= Fraction(
            value
        ) + Fraction(bar)

    def __str__(self) -> str:
        return f"[{self.low}, {self.high}]"


def outward(ball: Any, digits: int) -> DecimalInterval:
    """A decimal interval that contains a ball of Arb, with ends rounded outward to so many significant digits of its
    middle, give or take one."""
    low, high = fraction(ball.lower()), fraction(ball.upper())
    above, below = max(abs(low), abs(high)).as_integer_ratio()
    places = digits - (len(str(above)) - len(str(below)) + 1) if above else 0
    return DecimalInterval(_decimal(low, places, floor), _decimal(high, places, ceil))


def fraction(exact: Any) -> Fraction:
    """A ball without radius as a number."""
    mantissa, exponent = (int(part) for part in exact.man_exp())
    return Fraction(mantissa) * Fraction(2) ** exponent


def _decimal(number: Fraction, places: int, rounding: Callable[[Fraction], int]) -> str:
    """The number rounded to so many decimal places, as text without an exponent."""
    whole = Decimal(rounding(number * Fraction(10) ** places))
    return f"{whole.scaleb(-places, EXACT).normalize(EXACT):f}"


@dataclass(frozen=True)
class ProvedTransition:
    """A proved change of mode: enclosures of its time (s), place and velocities, and why that mode follows."""

    before: str
    after: str
    time: DecimalInterval
    xi1: DecimalInterval
    state: Mapping[str, DecimalInterval]
    cause: str
    decision: str
    rolling_share: DecimalInterval | None = None  # of the cone, the part that rolling needs where the slip vanishes


@dataclass(frozen=True)
class ProvedPhase:
    """A mode, its beginning and end, and the conditions that were proved on all of it."""

    mode: str
    begin: DecimalInterval
    end: DecimalInterval
    conditions: tuple[str, ...]
    steps: int


@dataclass(frozen=True)
class Proof:
    """A proof record. `status` is that of the motion, or "unproved" or "limited" if the proof ends before it.

    `statement` is the theorem in words, `scene` has the exact numbers that it is about, `assumptions` what it rests on.
    """

    case: str
    status: str
    reason: str
    statement: str
    first_mode: str
    transitions: tuple[ProvedTransition, ...]
    phases: tuple[ProvedPhase, ...]
    end: DecimalInterval
    scene: Mapping[str, Any]
    proved: tuple[str, ...]
    assumptions: tuple[str, ...]
    method: str
    precision: Mapping[str, int]
    versions: Mapping[str, str]
    cpu_s: float
    kind: str = KIND

    @property
    def complete(self) -> bool:
        """Whether the whole motion is proved, up to its duration or its end."""
        return self.status not in ("unproved", "limited")

    def as_data(self) -> dict[str, Any]:
        """The record as dicts, lists, numbers and texts."""
        return {"format": FORMAT, **_plain(asdict(self))}

    def as_json(self) -> str:
        """The record as JSON text."""
        return json.dumps(self.as_data(), indent=1, ensure_ascii=False) + "\n"

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Proof:
        """The record from what `as_data` returns."""
        values = {key: _with_intervals(value) for key, value in data.items() if key not in ("format", "scene")}
        transitions = tuple(ProvedTransition(**row) for row in values.pop("transitions"))
        phases = tuple(ProvedPhase(**row) for row in values.pop("phases"))
        return cls(**values, transitions=transitions, phases=phases, scene=data["scene"])


def _with_intervals(value: Any) -> Any:
    """What `_plain` was made from, with tuples for lists."""
    if isinstance(value, Mapping):
        parts = {key: _with_intervals(part) for key, part in value.items()}
        return DecimalInterval(**parts) if parts.keys() == set(DecimalInterval._fields) else parts
    return tuple(map(_with_intervals, value)) if isinstance(value, list) else value


def _plain(value: Any) -> Any:
    """Dicts, lists, numbers and texts only; an interval is a dict with its ends."""
    if isinstance(value, DecimalInterval):
        return value._asdict()
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    return [_plain(part) for part in value] if isinstance(value, list | tuple) else value


def statement(
    label: str, first_mode: str, transitions: Sequence[ProvedTransition], status: str, end: DecimalInterval
) -> str:
    """The theorem in words."""
    lines = [f"The motion of {label} (exact numbers: see scene) exists, is unique and begins in the mode {first_mode}."]
    for n, t in enumerate(transitions, start=1):
        lines.append(
            f"Transition {n}, {t.before} to {t.after} ({t.cause}), is at a time in {t.time} s, xi1 in {t.xi1}."
        )
        if t.rolling_share and Fraction(t.rolling_share.low) > 1:
            more = float(Fraction(t.rolling_share.low))
            lines.append(f"There rolling would need more than {more:.6g} times the friction of the cone.")
    if status == "completed":
        lines.append(f"There is no other transition before the end of the duration, {end.high} s.")
    elif status in ("unproved", "limited"):
        lines.append(f"There is no other transition before {end.low} s; nothing is stated about later times.")
    else:
        lines.append(f"There is no other transition; the motion ends ({status}) at a time in {end} s.")
    return " ".join(lines)
