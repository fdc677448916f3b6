"""The plan of a sweep: a case, its fixed parameters, and which parameters vary and how.

Scenarios are numbered. Any range of numbers can be computed by itself, on any machine, from the plan alone.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, fields
from functools import cached_property
from inspect import Parameter
from math import prod
from typing import Any

import numpy as np

import cases
from cases import BadValue, Case
from cases.errors import between, choice, finite, number_in, real, unknown_name, whole
from cases.lookup import catalogue_name
from cases.registry import parameters_of, parse

from ..solve import TOLERANCES

# How parameters vary: every combination of their values, or points drawn from all ranges together.
SAMPLES = ("grid", "random", "sobol")
# A billion motions take half a day; for many more, even the list of chunks would fill the memory.
MOST = 10**9
# Points of SciPy's Sobol sequence.
MOST_SOBOL = 2**30
# Philox generates four numbers per step.
_WORDS = 4


@dataclass(frozen=True)
class Axis:
    """The values of one parameter, or a range to draw from; `count` is None for a range.

    With `log`, values are spaced or drawn evenly in their logarithm.
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    count: int | None = None
    log: bool = False
    values: tuple[float, ...] = ()

    @cached_property
    def all(self) -> np.ndarray:
        """All values, shape (count,)."""
        if self.values:
            return np.array(self.values)
        spacing = np.geomspace if self.log else np.linspace
        return spacing(self.low, self.high, self.count or 0)

    def __len__(self) -> int:
        return len(self.values) or self.count or 0

    def __getstate__(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def at_parts(self, part: np.ndarray) -> np.ndarray:
        """The values at fractions of the range between 0 and 1."""
        if self.log:
            return self.low * (self.high / self.low) ** part
        return self.low + (self.high - self.low) * part

    @classmethod
    def of(cls, name: str, source: Any) -> Axis:
        """An axis from text ("0.01:0.5:200", "0.01:0.5:200:log", "0.1,0.2"), numbers, or a pair for a range."""
        if isinstance(source, Axis):
            return source
        if isinstance(source, str):
            return _from_text(name, source)
        if real(source) is not None:
            return cls(name, values=(finite(name, source),))
        try:
            if isinstance(source, bytes | bytearray | memoryview | Mapping | Set):
                raise TypeError  # bytes would be read as numbers, keys as values; a set has no order
            values = [finite(name, value) for value in (source.tolist() if isinstance(source, np.ndarray) else source)]
        except TypeError:
            raise BadValue(
                f"{name} is {source!r}; give a number, a list of numbers or text such as 0.01:0.5:200"
            ) from None
        if not values:
            raise BadValue(f"{name} has no value; give at least one")
        return cls(name, values=tuple(values))

    def as_range(self) -> Axis:
        """The axis as a range to draw from: two values are the ends of the range."""
        if len(self.values) == 1:
            return Axis(self.name, self.values[0], self.values[0])
        if self.values and len(self.values) != 2:
            raise BadValue(f"{self.name} has {len(self.values)} values; to be drawn from, give low:high")
        if self.values:
            return _range(self.name, self.values[0], self.values[1], log=False)
        return Axis(self.name, self.low, self.high, None, self.log)


def _from_text(name: str, text: str) -> Axis:
    how = f"{name}={text!r} cannot be read; write {name}=low:high:count, {name}=low:high:count:log, or {name}=a,b,c"
    parts = text.split(":")
    log = parts[-1] == "log"
    parts = parts[:-1] if log else parts
    try:
        if len(parts) == 1 and not log:
            return Axis.of(name, [number_in(name, part) for part in parts[0].split(",") if part.strip()])
        numbers = [number_in(name, part) for part in parts]
    except BadValue as problem:
        raise BadValue(f"{problem}; {how}") from None
    if len(numbers) not in (2, 3):
        raise BadValue(how)
    limits = _range(name, numbers[0], numbers[1], log=log)
    if len(numbers) == 2:
        return limits
    count = whole(f"the count of {name}", numbers[2], 1, MOST)
    return Axis(name, limits.low, limits.high, count, log)


def _range(name: str, low: float, high: float, log: bool) -> Axis:
    low, high = finite(f"the start of {name}", low), finite(f"the end of {name}", high)
    if not low < high:
        raise BadValue(f"{name} runs from {low:g} to {high:g}, which is empty; give the smaller number first")
    if log and low <= 0.0:
        raise BadValue(f"{name} runs from {low:g} by powers; give a start above zero")
    return Axis(name, low, high, None, log)


@dataclass(frozen=True)
class Plan:
    """A sweep: a case by name (or its function), fixed parameters, axes, the sampling, and the tolerance.

    `files` are case files to load first. Raises CaseError with one sentence for invalid arguments.
    """

    case: str | Callable[..., Case]
    axes: tuple[Axis, ...]
    fixed: Mapping[str, Any] = field(default_factory=dict)
    sample: str = "grid"
    number: int | None = None
    seed: int = 0
    rtol: float = 1e-10
    files: tuple[str, ...] = ()

    def __post_init__(self):
        choice("sampling", self.sample, SAMPLES)
        parameters = self.parameters
        names = [axis.name for axis in self.axes]
        for name in (*names, *self.fixed):
            if name not in parameters:
                raise unknown_name(f"parameter of {self.name}", name, parameters)
        for name in names:
            if names.count(name) > 1 or name in self.fixed:
                raise BadValue(f"{name} is given twice; give each parameter once")
            if parameters[name] is not Parameter.empty and real(parameters[name]) is None:
                raise BadValue(f"{name} of {self.name} is {parameters[name]!r}, no number; only numbers can vary")
        for name in parameters.keys() - {*names, *self.fixed}:
            if parameters[name] is Parameter.empty:
                raise BadValue(f"{name} of {self.name} has no default; give it a value")
        if not names:
            raise BadValue(f"nothing varies; give at least one parameter of {self.name}: {', '.join(parameters)}")
        object.__setattr__(self, "rtol", between("rtol", self.rtol, *TOLERANCES))
        self._check_sample()

    def _check_sample(self) -> None:
        if self.sample == "grid":
            if self.number is not None:
                raise BadValue(
                    "a grid has as many scenarios as its axes say; leave the number out, or sample at random"
                )
            for axis in self.axes:
                if not len(axis):
                    raise BadValue(f"{axis.name} has no count; write {axis.name}={axis.low:g}:{axis.high:g}:count")
        else:
            if self.number is None:
                raise BadValue(f"sampling {self.sample} needs the number of scenarios; give one")
            object.__setattr__(self, "axes", tuple(axis.as_range() for axis in self.axes))
            whole("the number of scenarios", self.number, 1, MOST_SOBOL if self.sample == "sobol" else MOST)
            whole("seed", self.seed, 0, 2**63)
        if len(self) > MOST:
            raise BadValue(f"the grid has {len(self):.3g} scenarios; give fewer")

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the fields only, without cached properties."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def name(self) -> str:
        """The case's name."""
        return self.case if isinstance(self.case, str) else getattr(self.case, "__name__", "the case")

    @cached_property
    def _entry(self):
        for file in self.files:
            if isinstance(self.case, str) and self.case not in cases.names():
                cases.load_file(file)
        return cases.entry(self.case) if isinstance(self.case, str) else None

    @cached_property
    def parameters(self) -> dict[str, Any]:
        """The case's parameters and their defaults."""
        if self._entry is not None:
            return self._entry.parameters
        return parameters_of(self.function)

    def __len__(self) -> int:
        return prod(map(len, self.axes)) if self.sample == "grid" else int(self.number or 0)

    @property
    def shape(self) -> tuple[int, ...]:
        """The lengths of a grid's axes; the last one varies fastest."""
        return tuple(map(len, self.axes))

    def make(self, **parameters: float) -> Case:
        """One scenario as a case; raises CaseError."""
        if self._entry is not None:
            return cases.load(self.name, **{**self.fixed, **parameters})
        return self.case(**{**self.fixed, **parameters})  # type: ignore[operator]

    @property
    def function(self) -> Callable[..., Case]:
        """The case's own function."""
        return self._entry.function if self._entry is not None else self.case  # type: ignore[return-value]

    def columns(self, start: int, stop: int) -> dict[str, np.ndarray]:
        """The parameters of scenarios start … stop − 1, each of shape (stop − start,)."""
        if self.sample == "grid":
            places = np.unravel_index(np.arange(start, stop), self.shape)
            return {axis.name: axis.all[place] for axis, place in zip(self.axes, places, strict=True)}
        parts = _random(self, start, stop) if self.sample == "random" else _sobol(self, start, stop)
        return {axis.name: axis.at_parts(part) for axis, part in zip(self.axes, parts.T, strict=True)}

    def as_text(self) -> dict[str, Any]:
        """Everything that determines the rows, as text that can be stored and compared."""
        axes = [[a.name, *map(repr, (a.low, a.high, a.count, a.log)), list(map(repr, a.values))] for a in self.axes]
        fixed = {name: repr(value) for name, value in sorted(self.fixed.items())}
        sampling = {"sample": self.sample, "number": self.number, "seed": self.seed if self.sample != "grid" else None}
        return {"case": self.name, "fixed": fixed, "axes": axes, **sampling, "rtol": repr(self.rtol)}


def plan(
    case: str | Case | Callable[..., Case],
    vary: Mapping[str, Any],
    sample: str = "grid",
    number: int | None = None,
    seed: int = 0,
    rtol: float = 1e-10,
    files: Sequence[str] = (),
) -> Plan:
    """The plan for a user's arguments; a single number fixes a parameter. Raises CaseError."""
    name, fixed = _axis_of(case)
    axes = [Axis.of(key, value) for key, value in vary.items()]
    single = {axis.name: axis.values[0] for axis in axes if len(axis.values) == 1}
    varying = tuple(axis for axis in axes if axis.name not in single)
    fixed = {key: value for key, value in fixed.items() if key not in vary} | single
    return Plan(name, varying, fixed, sample, number, seed, rtol, tuple(files))


def _axis_of(case) -> tuple[str | Callable[..., Case], dict[str, Any]]:
    if isinstance(case, str):
        bare, fixed = parse(catalogue_name(case))
        cases.entry(bare)  # raises UnknownName
        return bare, dict(fixed)
    if isinstance(case, Case):
        if case.name not in cases.names() or cases.load(case.name, **case.parameters) != case:
            raise BadValue(f"the case {case.label} was made by hand; give the function that makes it, and what varies")
        return case.name, dict(case.parameters)
    if callable(case):
        return case, {}
    raise BadValue(f"{case!r} is no case; give its name, for example 'disc_in_circle', or a function that makes it")


def _random(plan: Plan, start: int, stop: int) -> np.ndarray:
    """Numbers in [0, 1) by Philox, which can jump to any step directly: shape (stop − start, axes)."""
    blocks = -(-len(plan.axes) // _WORDS)  # each scenario begins a step of the generator
    generator = np.random.Philox(key=plan.seed).advance(start * blocks)
    points = np.random.Generator(generator).random((stop - start, blocks * _WORDS))
    return points[:, : len(plan.axes)]


def _sobol(plan: Plan, start: int, stop: int) -> np.ndarray:
    """Owen-scrambled points of Sobol's sequence, by SciPy."""
    from scipy.stats import qmc  # slow to import

    sequence = qmc.Sobol(len(plan.axes), scramble=True, rng=np.random.default_rng(plan.seed))
    if start:
        sequence.fast_forward(start)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # about lengths that are no power of two: the whole may be one
        return sequence.random(stop - start)
