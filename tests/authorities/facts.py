"""What a fact from outside is: a case, a quantity of its motion, the value, and where the value comes from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from cases import Case, Mode, Trajectory


class Basis(StrEnum):
    """What a value rests on."""

    DERIVED = "derived"  # in the source's own text: laws, then the formula
    LOOKED_UP = "looked up"  # in the place that the text names
    NOT_LOOKED_UP = "known to us, not looked up"


@dataclass(frozen=True)
class Source:
    """Where a value comes from: a derivation, or a place (author, title, year, page or file), and which of the two."""

    basis: Basis
    text: str


def derived(text: str) -> Source:
    """A value that the text derives in two lines."""
    return Source(Basis.DERIVED, text)


Measure = Callable[[Case, Trajectory], float]


@dataclass(frozen=True)
class Fact:
    """`measure` takes the case and its motion; `tolerance` is absolute, in the quantity's unit.

    1e-9 is the default: the reference runs at 1e-12 for a few seconds, and a period read off a zero loses two digits.
    """

    case: str
    quantity: str
    value: float
    source: Source
    measure: Measure
    parameters: dict[str, Any]
    tolerance: float = 1e-9


def row(quantity: str, value: float, measure: Measure, tolerance: float = 1e-9, **parameters: Any) -> tuple:
    """A row of `facts`: a quantity, its exact value, how it is read from the motion, and the case's parameters."""
    return quantity, float(value), measure, parameters, tolerance


def facts(table: dict[tuple[str, Source], list[tuple]]) -> list[Fact]:
    """The facts of a table with the rows of each case and source."""
    return [Fact(case, q, value, source, *more) for (case, source), rows in table.items() for q, value, *more in rows]


def time_of(number: int) -> Callable[[Case, Trajectory], float]:
    """Time of the transition with that index."""
    return lambda case, motion: motion.transitions[number].time


def at_end(name: str) -> Callable[[Case, Trajectory], float]:
    """A quantity of the last state."""
    return lambda case, motion: float(getattr(motion(motion.t[-1]), name))


def at_start(name: str) -> Callable[[Case, Trajectory], float]:
    """A quantity of the first state."""
    return lambda case, motion: float(getattr(motion(0.0), name))


def spread(quantity: Callable[[Case, Any], Any]) -> Callable[[Case, Trajectory], float]:
    """Largest minus smallest value of something that is to stay constant, over the whole motion."""

    def measured(case: Case, motion: Trajectory) -> float:
        import numpy as np

        return float(np.ptp(quantity(case, motion(np.linspace(0.0, motion.t[-1], 200)))))

    return measured


def zero_of(quantity: Callable[[Any], Any], number: int = 0) -> Callable[[Case, Trajectory], float]:
    """Time of a change of sign of something after the start; an exact zero at the start itself is no change."""

    def measured(case: Case, motion: Trajectory) -> float:
        import numpy as np
        from scipy.optimize import brentq

        times = np.linspace(1e-3, motion.t[-1], 400)
        signs = np.sign(quantity(motion(times)))
        i = np.flatnonzero(signs[1:] != signs[:-1])[number]
        return brentq(lambda t: float(quantity(motion(t))), times[i], times[i + 1], xtol=1e-14)

    return measured


def ends_with(status: str) -> Callable[[Case, Trajectory], float]:
    """1 if the motion ends so, else 0."""
    return lambda case, motion: float(motion.status == status)


def first_mode_is(mode: Mode) -> Callable[[Case, Trajectory], float]:
    """1 if the motion begins so, else 0."""
    return lambda case, motion: float(motion.first_mode is mode)
