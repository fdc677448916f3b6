"""Checks whether a process still computes as it did before third-party code ran in it.

An engine that replaces `numpy.hypot`, or anything else used to judge a motion, would influence its own row. Therefore
the functions, what is inside them, limits and tables are compared one by one, and a known run is made and judged
again: its bits must not change. The answers of a changed process are discarded, and it makes no further call.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator, Sequence
from functools import cached_property
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

import cases
import reference
from cases import Trajectory

from ..judging import distances, transitions
from .storage.source_code import adapter_packages, is_adapters

# The case of the known run: its motion is known in closed form, and judging it takes a few
# milliseconds. With so many samples the transition is still read from polynomials of all degrees.
_CASE, _SAMPLES, _RTOL = "disc_on_line[mu=0.1]", 31, 1e-9
# Modules whose functions are compared: all imported modules of the suite except adapters, and libraries it uses.
_OURS = ("cases", "reference", "adapters", "reports")
_LIBRARIES = (
    "builtins", "math", "cmath", "operator", "functools", "itertools", "statistics", "pickle", "time", "numpy",
    "numpy.linalg", "numpy.fft", "scipy.integrate", "scipy.interpolate", "scipy.linalg", "scipy.ndimage",
    "scipy.optimize", "scipy.special", "sympy", "mpmath", "heyoka",
)  # fmt: skip

# Variables of these types have a content that is compared.
_TABLES = (dict, list, set, tuple, np.ndarray)

# A namespace, a name in it, its value, and the full name.
_Attribute = tuple[Any, str, Any, str]


class Canary:
    """The state of the functions of a process and the numbers of a known run, at the time of creation.

    Modules imported later must not contain functions of an adapter, and are compared from then on.
    `known_run`: False omits that run, whose imports and compilations would change the measurement of a cold start.
    """

    def __init__(self, known_run: bool = True) -> None:
        self._packages = adapter_packages()  # read now, because an engine may change the search path
        self._modules: set[str] = set()
        self._contents: list[tuple[Any, Any, str]] = []
        self._bodies: dict[int, tuple[FunctionType, Any, Any, Any, str]] = {}
        self._attributes = self._new_attributes()
        self._numbers = _known_run() if known_run else None

    def change(self) -> str:
        """What has changed, as a phrase; "" if nothing has."""
        for place, name, value, known_as in self._attributes:
            # Compared here first: there are thousands, after each call of an engine.
            if place.get(name) is not value and _is_replaced(place, name, value):
                return f"{known_as} was replaced"
        new_attributes = self._new_attributes()
        for _, _, value, known_as in new_attributes:
            if is_adapters(str(getattr(value, "__module__", "")), self._packages):
                return f"{known_as} was replaced"
        self._attributes += new_attributes
        for function, code, defaults, by_name, known_as in self._bodies.values():
            changes = function.__defaults__ is not defaults or function.__kwdefaults__ is not by_name
            if changes or function.__code__ is not code:
                return f"{known_as} was changed"
        for container, content, _ in self._contents:
            if not _is_same(container, content):
                return f"{_assigned_as([name for one, _, name in self._contents if one is container])} was changed"
        try:
            same = self._numbers is None or _known_run() == self._numbers
        except Exception as problem:
            return f"a known run fails: {type(problem).__name__}"
        return "" if same else "a known run gives other numbers"

    def _new_attributes(self) -> list[_Attribute]:
        """The compared attributes of modules imported since the last call."""
        names = sys.modules.keys() - self._modules
        self._modules |= names
        ours = [name for name in names if name.partition(".")[0] in _OURS and not is_adapters(name, self._packages)]
        attributes = [
            attribute
            for name in (*ours, *names.intersection(_LIBRARIES))
            if (module := sys.modules.get(name)) is not None
            for attribute in _attributes(name, module, methods=name in ours)
        ]
        self._contents += [
            (value, _content(value), known_as)
            for _, name, value, known_as in attributes
            if name.isupper() and isinstance(value, _TABLES)
        ]
        for function, known_as in ((_function(value), known_as) for _, _, value, known_as in attributes):
            if isinstance(function, FunctionType) and id(function) not in self._bodies:
                body = function.__code__, function.__defaults__, function.__kwdefaults__
                self._bodies[id(function)] = function, *body, known_as
        return attributes


def _attributes(known_as: str, module: ModuleType, methods: bool) -> Iterator[_Attribute]:
    """The functions, classes and constants of a module; with `methods` also those of the classes that it defines, and
    limits and tables (names in capitals).

    A name that a module of ours imports at each use is never among its variables, unless somebody puts another there.
    """
    if methods and "__getattr__" in vars(module):
        late = (name for name in getattr(module, "__all__", ()) if name not in vars(module))
        yield from ((vars(module), name, None, f"{known_as}.{name}") for name in late)
    for name, value in list(vars(module).items()):
        if callable(value) or (name.isupper() if methods else isinstance(value, float)):
            yield vars(module), name, value, f"{known_as}.{name}"
        if methods and isinstance(value, type) and value.__module__ == known_as:
            for inner, method in list(vars(value).items()):
                if callable(method) or isinstance(method, property | cached_property):
                    yield vars(value), inner, method, f"{known_as}.{name}.{inner}"


def _assigned_as(names: Sequence[str]) -> str:
    """Of the names of one table, each `module.NAME`, the one of the module that assigns it; others import it."""
    for known_as in names:
        module, _, name = known_as.rpartition(".")
        if re.search(rf"^{name}\b[^=\n]*=", inspect.getsource(sys.modules[module]), re.M):
            return known_as
    return names[0]


def _function(value: Any) -> Any:
    """The function behind a method, a property or a cache."""
    for name in ("fget", "func", "__func__"):
        value = getattr(value, name, None) or value
    return getattr(value, "__wrapped__", value)


def _content(table: Any) -> Any:
    """A copy of a table, of the tables in it and of arrays."""
    if isinstance(table, np.ndarray):
        return table.copy()
    if isinstance(table, dict):
        return {key: _content(value) for key, value in table.items()}
    if isinstance(table, list | tuple):
        return [_content(value) for value in table]
    return set(table) if isinstance(table, set) else table


def _is_same(table: Any, content: Any) -> bool:
    """Whether a table holds the same objects as its copy."""
    if isinstance(table, np.ndarray):
        return table.shape == content.shape and table.tobytes() == content.tobytes()
    if isinstance(table, dict):
        return table.keys() == content.keys() and all(_is_same(table[key], content[key]) for key in content)
    if isinstance(table, list | tuple):
        return len(table) == len(content) and all(map(_is_same, table, content))
    return table == content if isinstance(table, set) else table is content


def _is_replaced(place: Any, name: str, value: Any) -> bool:
    """Whether another object has the name now; a name imported at each use may also have been stored as it is."""
    now = place.get(name)
    if value is None and now is not None:
        return now is not place["__getattr__"](name)
    return now is not value


def _known_run() -> tuple[bytes, ...]:
    """All numbers of a reference run that is shifted a little and judged, as bytes."""
    case = cases.load(_CASE)
    motion = reference.simulate(case, rtol=_RTOL)
    times = np.linspace(0.0, case.duration, _SAMPLES)
    state = motion(times)
    test_motion = Trajectory(t=times, **state._replace(x=np.asarray(state.x) + 1e-3 * times)._asdict())
    reading = transitions.read_motion(case, test_motion)
    off = distances.differences(test_motion, motion, case)
    event_times = [event.time for event in (*motion.transitions, *reading.transitions)]
    numbers = [*event_times, *reading.spreads, *distances.distance(off)]
    return np.array(numbers).tobytes(), *(np.asarray(values).tobytes() for values in state)
