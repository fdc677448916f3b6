"""Whether a process still computes as it did before third-party code ran in it.

An engine that replaces `numpy.hypot`, or anything else that a motion is judged with, would decide its own row. So what
is computed with is compared, function by function, and a known run is made and judged again: its bits must not change.
A process that has changed keeps none of its answers and makes no other call.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

import cases
import reference
from cases import Trajectory

from ..judging import distances, transitions

# The case of the known run: its motion is known in closed form, and judging it takes two milliseconds.
_CASE, _SAMPLES, _RTOL = "disc_on_line[mu=0.1]", 61, 1e-9
# Whose functions are compared: everything of ours that is loaded, and the names by which it uses libraries.
_OURS = ("cases", "reference", "adapters", "reports")
_LIBRARIES = (
    "builtins", "math", "cmath", "operator", "functools", "itertools", "statistics", "pickle", "time", "numpy",
    "numpy.linalg", "numpy.fft", "scipy.integrate", "scipy.interpolate", "scipy.linalg", "scipy.optimize",
    "scipy.special", "sympy", "mpmath", "heyoka",
)  # fmt: skip


class Canary:
    """The functions that a process computes with, and the numbers of a known run, as they are when it is made.

    `known_run`: False leaves that run out, which would import and compile what a cold start is to be measured with.
    """

    def __init__(self, known_run: bool = True) -> None:
        self._attributes = list(_attributes())
        self._numbers = _known_run() if known_run else None

    def change(self) -> str:
        """What is no longer as it was, in a phrase; "" if nothing is."""
        for place, name, value, known_as in self._attributes:
            if place.get(name) is not value:
                return f"{known_as} was replaced"
        try:
            same = self._numbers is None or _known_run() == self._numbers
        except Exception as problem:
            return f"a known run fails: {type(problem).__name__}"
        return "" if same else "a known run gives other numbers"


def _attributes() -> Iterator[tuple[Any, str, Any, str]]:
    """Namespace, name, value and full name of the functions, classes, methods and constants that are compared."""
    for module in [each for name, each in list(sys.modules.items()) if name.partition(".")[0] in _OURS]:
        for name, value in list(vars(module).items()):
            if callable(value):
                yield vars(module), name, value, f"{module.__name__}.{name}"
            if isinstance(value, type) and value.__module__ == module.__name__:
                for inner, method in list(vars(value).items()):
                    if callable(method) or isinstance(method, property):
                        yield vars(value), inner, method, f"{module.__name__}.{name}.{inner}"
    for library in _LIBRARIES:
        known = sys.modules.get(library)
        for name, value in list(vars(known).items()) if known else ():
            if callable(value) or isinstance(value, float):
                yield vars(known), name, value, f"{library}.{name}"


def _known_run() -> tuple[bytes, ...]:
    """A run made by the reference, moved a little and judged: every number of it, bit by bit."""
    case = cases.load(_CASE)
    motion = reference.simulate(case, rtol=_RTOL)
    times = np.linspace(0.0, case.duration, _SAMPLES)
    state = motion(times)
    moved = Trajectory(t=times, **state._replace(x=np.asarray(state.x) + 1e-3 * times)._asdict())
    reading = transitions.read_motion(case, moved)
    off = distances.differences(moved, motion, case)
    told = [event.time for event in (*motion.transitions, *reading.transitions)]
    numbers = [*told, *reading.spreads, *distances.distance(off)]
    return np.array(numbers).tobytes(), *(np.asarray(values).tobytes() for values in state)
