"""The question: a plate, its track, the effects that act, how it starts and for how long. Frozen, SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import sqrt
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from . import curves, effects
from .curves import Curve
from .effects import Effect
from .errors import BadCurve, BadValue, positive
from .start import Start

E = TypeVar("E")


@dataclass(frozen=True)
class Plate:
    """A rigid plate: its outline in its own frame, whose origin is the centre of mass; mass in kg, inertia in kg m².

    The outline runs counter-clockwise around the plate (BadCurve if it is closed and runs the other way).
    """

    outline: Curve
    mass: float
    inertia: float

    def __post_init__(self):
        if not isinstance(self.outline, Curve):
            raise BadValue(f"the outline is {self.outline!r}; give a Curve")
        object.__setattr__(self, "mass", positive("mass of the plate", self.mass))
        object.__setattr__(self, "inertia", positive("inertia of the plate", self.inertia))
        if self.outline.period:
            low, high = self.outline.look
            if self.outline.tangent_angle(high) < self.outline.tangent_angle(low):
                raise BadCurve("the outline runs clockwise; reverse its parameter so that the plate is on its left")

    @property
    def gyration(self) -> float:
        """Radius of gyration about the centre of mass, m."""
        return sqrt(self.inertia / self.mass)

    @cached_property
    def inner(self) -> float:
        """The smallest distance of the outline from the centre of mass, m."""
        return float(self._distances.min())

    @cached_property
    def reach(self) -> float:
        """The largest distance of the outline from the centre of mass, m: it turns a spin into a speed."""
        return float(self._distances.max())

    @property
    def _distances(self) -> np.ndarray:
        # Half a degree apart; distances are level at their extremes, so that these are off by 1e-5 or so.
        return np.hypot(*self.outline.point(np.linspace(*self.outline.look, 721)))

    @cached_property
    def radius(self) -> float | None:
        """Radius in metres if the outline is a circle about the centre of mass, else None."""
        s = np.linspace(*self.outline.look, 17)
        r = np.hypot(*self.outline.point(s))
        bend = self.outline.curvature(s)
        # Rounding of a handful of operations; a real outline that round is a disc for every purpose here.
        round_enough = np.ptp(r) <= 1e-13 * r.max() and np.all(np.abs(bend * r - 1.0) <= 1e-12)
        return float(r.mean()) if round_enough and self.outline.period else None


def disc(radius: float, mass: float, inertia: float | None = None) -> Plate:
    """A disc about its centre of mass; inertia ½ m r² (homogeneous) if none is given."""
    radius, mass = positive("radius of the disc", radius), positive("mass of the disc", mass)
    outline = Curve(lambda s: (radius * curves.cos(s), radius * curves.sin(s)))
    return Plate(outline, mass, 0.5 * mass * radius**2 if inertia is None else inertia)


@dataclass(frozen=True)
class Case:
    """One scene. All checks are made here, before any solver runs.

    `name` and `parameters` are filled in by the catalogue; a case made by hand may leave them out.
    Raises BadValue, BadCurve or DoesNotFit with one sentence that says what to change.
    """

    track: Curve
    plate: Plate
    effects: tuple[Effect, ...]
    start: Start
    duration: float
    name: str = "unnamed"
    parameters: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self):
        for what, value, kind in (
            ("track", self.track, Curve),
            ("plate", self.plate, Plate),
            ("start", self.start, Start),
        ):
            if not isinstance(value, kind):
                raise BadValue(f"the {what} of a case is {value!r}; give a {kind.__name__}")
        object.__setattr__(self, "effects", effects.checked(self.effects))
        object.__setattr__(self, "duration", positive("duration of the case", self.duration))
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))
        self.start.check(self.track, self.plate.outline, self.effects)

    def __reduce__(self):
        """A case travels to another process by value, whether a catalogue knows it or not."""
        return _arrived, (vars(self) | {"parameters": dict(self.parameters)},)

    def effect(self, kind: type[E]) -> E | None:
        """The case's effect of that kind, or None if the case does not ask for it."""
        return next((e for e in self.effects if isinstance(e, kind)), None)

    @property
    def label(self) -> str:
        """`name[parameter=value,…]`: the one text that `cases.load` turns back into this case."""
        inside = ",".join(f"{key}={_written(value)}" for key, value in self.parameters.items())
        return f"{self.name}[{inside}]" if inside else self.name


def _arrived(values: dict) -> Case:
    """The case that a process sent. It was checked there, so it is not checked again."""
    case = object.__new__(Case)
    vars(case).update(values, parameters=MappingProxyType(values["parameters"]))
    return case


def _written(value) -> str:
    """A number in as few digits as give it back."""
    return f"{value:g}" if float(f"{value:g}") == value else repr(float(value))
