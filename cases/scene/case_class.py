"""A case: plate, track, effects, start and duration. Frozen, SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from math import sin
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import effects
from ..curves import Curve
from ..effects import E, Effect, Gravity
from ..errors import BadValue, instance, parameter, positive, real
from .free_plates import FreePlate, check_parts, check_places
from .limits import check_limits
from .pair_effects import Pair, check_pairs
from .plate import Plate
from .size_limits import check_sizes
from .start import Start
from .start_pose import StartPose, as_start, from_flat_side
from .supports import Support

if TYPE_CHECKING:
    from ..pictures.layout import DrawnScene

# Characters of a case's name, which is part of file names.
LONGEST_NAME = 100


@dataclass(frozen=True, repr=False)
class Case:
    """One scene. All checks are made here, before any solver runs.

    `name` and `parameters` are filled in by the catalogue; a case made by hand may leave them out. `supports` are
    further fixed curves that the plate may touch, `others` further plates that move, `pairs` effects of two bodies
    instead of the case's. A `start` given as `StartPose`, a pose, is stored as a `Start`.
    Raises BadValue, BadCurve or DoesNotFit with one sentence that says what to change.
    """

    track: Curve
    plate: Plate
    effects: tuple[Effect, ...]
    start: Start
    duration: float
    name: str = "unnamed"
    parameters: Mapping[str, float] = field(default_factory=dict, hash=False)
    supports: tuple[Support, ...] = ()
    others: tuple[FreePlate, ...] = ()
    pairs: tuple[Pair, ...] = ()

    if TYPE_CHECKING:  # the fields, but for a start that may be given as a pose

        def __init__(
            self,
            track: Curve,
            plate: Plate,
            effects: tuple[Effect, ...],
            start: Start | StartPose,
            duration: float,
            name: str = "unnamed",
            parameters: Mapping[str, float] = ...,
            supports: tuple[Support, ...] = (),
            others: tuple[FreePlate, ...] = (),
            pairs: tuple[Pair, ...] = (),
        ) -> None: ...

    def __post_init__(self):
        for what, value, kinds in (
            ("track", self.track, (Curve,)),
            ("plate", self.plate, (Plate,)),
            ("start", self.start, (Start, StartPose)),
        ):
            instance(f"{what} of a case", value, *kinds)
        object.__setattr__(self, "effects", effects.check_formula(self.effects))
        object.__setattr__(self, "start", self._checked_start())
        object.__setattr__(self, "duration", positive("duration of the case", self.duration))
        object.__setattr__(self, "parameters", _check_parameters(self.parameters))
        _check_name(self.name)
        with np.errstate(all="ignore"):  # what is not finite does not fit
            check_parts(self)
            check_pairs(self)
            check_limits(self)
            poses = [("Start", self.plate, self.start.omega)]
            poses += [(f"the StartPose of {one.name!r}", one.plate, one.start.omega) for one in self.others]
            for where, plate, omega in poses:
                if not (plate.turns or plate.spins_by_load) and omega != 0.0:
                    raise BadValue(f"a plate of infinite inertia does not turn; give omega=0 in {where}, not {omega:g}")
            check_sizes(self)
            self.start.check(self.track, self.plate.outline, self.effects)
            if self.supports or self.others:
                check_places(self)

    def _checked_start(self) -> Start:
        """The start by contact parameters; of a pose that of its nearest point."""
        if isinstance(self.start, StartPose):
            with np.errstate(all="ignore"):
                return as_start(self.start, self.track, self.plate.outline, self.effects)
        return from_flat_side(self.start, self.track, self.plate.outline, self.effects)

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        # Computed once: caches of derived results use the case as key, and are read at every change of mode.
        return hash(tuple(getattr(self, name) for name in FIELDS if name != "parameters"))

    def __reduce__(self):
        """A case is pickled by value, whether it is in a catalogue or not."""
        return _restore, tuple(self._values().values())

    def with_name(self, name: str, parameters: Mapping[str, float]) -> Case:
        """The same scene as the catalogue's case of that name with those parameters."""
        own = {"name": _check_name(name), "parameters": _check_parameters(parameters)}
        return _restore(*(self._values() | own).values())

    def _values(self) -> dict[str, Any]:
        own = vars(self)
        return {name: own[name] for name in FIELDS} | {"parameters": dict(self.parameters)}

    def effect(self, kind: type[E]) -> E | None:
        """The case's effect of that kind, or None if the case has none."""
        try:
            return self._effects_by_type.get(kind)
        except TypeError:
            raise BadValue(f"{kind!r} is no kind of effect; give a class, such as Gravity") from None

    @cached_property
    def _effects_by_type(self) -> dict[type, Any]:
        # Asked many times in each phase. Of several effects of one base class it has the first.
        return {kind: one for one in reversed(self.effects) for kind in type(one).__mro__}

    @property
    def label(self) -> str:
        """`name[parameter=value,…]`: the text from which `cases.load` makes this case."""
        inside = ",".join(f"{key}={_as_text(value)}" for key, value in self.parameters.items())
        return f"{self.name}[{inside}]" if inside else self.name

    def __repr__(self) -> str:
        acting, start = self.effects_text, self.start_text
        return f"<Case {self.label}: {self.plate} on {self.track}; {acting}; {start}; {self.duration:g} s>"

    def _repr_html_(self) -> str:
        from ..pictures import notebook_html

        return notebook_html.of_case(self)

    @property
    def effects_text(self) -> str:
        """The effects in one line, with the values that differ from the defaults."""
        return ", ".join(map(_text_of, self.effects))

    @property
    def start_text(self) -> str:
        """The start in one line, with the values that differ from the defaults."""
        return _text_of(self.start)

    @property
    def scene(self) -> DrawnScene:
        """The data that a picture of the case needs."""
        from ..pictures.layout import DrawnScene

        gravity = self.effect(Gravity)
        down = gravity is not None and sin(gravity.direction) > 0
        supports = {support.name: support.curve for support in self.supports}
        return DrawnScene(self.track, self.plate.outline, self.label, down, supports, self.plate.drawn)

    @property
    def weight(self) -> float:
        """The plate's weight, N; 0 without gravity."""
        gravity = self.effect(Gravity)
        return self.plate.mass * gravity.g if gravity else 0.0


# The names of its fields.
FIELDS = tuple(f.name for f in fields(Case))


def _check_name(name: object) -> str:
    """The name; raises BadValue for one that cannot be used in file names, tables and `--case`."""
    if not isinstance(name, str) or not name or len(name) > LONGEST_NAME:
        raise BadValue(f"the name of a case is {name!r}; give a text of up to {LONGEST_NAME} characters")
    if not name.isprintable() or name.startswith(".") or set(name) & set("/\\[]<>$\"'`"):
        raise BadValue(f"the name of a case is {name!r}; give one of letters, digits, spaces and hyphens")
    return name


def _check_parameters(parameters: object) -> Mapping[str, float]:
    """The parameters in their stored form; raises BadValue unless they are numbers by name."""
    if not isinstance(parameters, Mapping):
        raise BadValue(f"the parameters of a case are {parameters!r}; give a dict of numbers")
    for key, value in parameters.items():
        if not isinstance(key, str) or real(value) is None and not isinstance(value, bool):
            raise BadValue(f"parameter {key!r} of a case is {value!r}; give numbers by name")
    return MappingProxyType({key: parameter(f"parameter {key}", value) for key, value in parameters.items()})


def _restore(*values: Any) -> Case:
    """A case from the values of one that was checked, in this process or the sending one."""
    case = object.__new__(Case)
    vars(case).update(zip(FIELDS, values, strict=True))
    vars(case).update(parameters=MappingProxyType(case.parameters))
    return case


def _text_of(record: Any) -> str:
    """An effect or a start as text, with the values that differ from the defaults."""
    values = {f.name: (getattr(record, f.name), f.default) for f in fields(record)}
    texts = [f"{name}={_short(value)}" for name, (value, usual) in values.items() if value != usual]
    return f"{type(record).__name__}({', '.join(texts)})"


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _as_text(value) -> str:
    """A number with the fewest digits that reproduce it."""
    return f"{value:g}" if float(f"{value:g}") == value else repr(float(value))
