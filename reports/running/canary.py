"""Whether a process still computes as it did before third-party code ran in it.

An engine that replaces `numpy.hypot`, or anything else that a motion is judged with, would decide its own row. So what
is computed with is compared, function by function, and a known run is made and judged again: its bits must not change.
A process that has changed keeps none of its answers and makes no other call.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import numpy as np

import cases
import reference
from cases import Trajectory

from ..judging import distances, transitions
from .storage.source_code import adapter_packages, is_adapters

# The case of the known run: its motion is known in closed form, and judging it takes two milliseconds.
_CASE, _SAMPLES, _RTOL = "disc_on_line[mu=0.1]", 61, 1e-9
# Whose functions are compared: all imported modules of the suite but adapters, and libraries by the names used there.
_OURS = ("cases", "reference", "adapters", "reports")
_LIBRARIES = (
    "builtins", "math", "cmath", "operator", "functools", "itertools", "statistics", "pickle", "time", "numpy",
    "numpy.linalg", "numpy.fft", "scipy.integrate", "scipy.interpolate", "scipy.linalg", "scipy.optimize",
    "scipy.special", "sympy", "mpmath", "heyoka",
)  # fmt: skip

# A namespace, a name in it, its value, and the full name.
_Attribute = tuple[Any, str, Any, str]


class Canary:
    """The functions that a process computes with, and the numbers of a known run, as they are when it is made.

    Modules that are imported later must hold no function of an adapter, and are compared from then on.
    `known_run`: False leaves that run out, which would import and compile what a cold start is to be measured with.
    """

    def __init__(self, known_run: bool = True) -> None:
        self._packages = adapter_packages()  # read now: an engine may change where packages are looked for
        self._modules: set[str] = set()
        self._attributes = self._imported()
        self._numbers = _known_run() if known_run else None

    def change(self) -> str:
        """What is no longer as it was, in a phrase; "" if nothing is."""
        for place, name, value, known_as in self._attributes:
            if place.get(name) is not value:
                return f"{known_as} was replaced"
        imported = self._imported()
        for _, _, value, known_as in imported:
            if is_adapters(str(getattr(value, "__module__", "")), self._packages):
                return f"{known_as} was replaced"
        self._attributes += imported
        try:
            same = self._numbers is None or _known_run() == self._numbers
        except Exception as problem:
            return f"a known run fails: {type(problem).__name__}"
        return "" if same else "a known run gives other numbers"

    def _imported(self) -> list[_Attribute]:
        """What is compared of the modules that were imported since the last call."""
        names = sys.modules.keys() - self._modules
        self._modules |= names
        ours = [name for name in names if name.partition(".")[0] in _OURS and not is_adapters(name, self._packages)]
        return [
            attribute
            for name in (*ours, *names.intersection(_LIBRARIES))
            if (module := sys.modules.get(name)) is not None
            for attribute in _attributes(name, module, methods=name in ours)
        ]


def _attributes(known_as: str, module: ModuleType, methods: bool) -> Iterator[_Attribute]:
    """The functions, classes and constants of a module; with `methods` also those of the classes that it defines."""
    for name, value in list(vars(module).items()):
        if callable(value) or (isinstance(value, float) and not methods):
            yield vars(module), name, value, f"{known_as}.{name}"
        if methods and isinstance(value, type) and value.__module__ == known_as:
            for inner, method in list(vars(value).items()):
                if callable(method) or isinstance(method, property):
                    yield vars(value), inner, method, f"{known_as}.{name}.{inner}"


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
