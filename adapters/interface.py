"""What an adapter is. Nothing here knows an engine; `engines` finds the adapters by looking into this folder.

An adapter is one module, or a package, with

    NAME: str                                       the engine's name in every table
    routes: tuple[str, ...]                         "native" (the engine's own shapes and contact), "assisted" (our
                                                    geometry, the engine's contact law and step)
    refuses(case, route) -> str | None              why this route cannot model the case, in one sentence, or None
    ladder(case, route) -> tuple[Setting, ...]      from coarse to fine, all knobs tightened together
    build(case, route, setting) -> model            untimed
    run(model) -> None                              the only part that is timed
    read(model) -> Trajectory                       untimed; raises EngineFailure for a run that is no motion
    version() -> str                                of the engine

and, if errors are to be taken apart by what causes them (`reports.study error_parts`),

    grid(case, route) -> tuple[Setting, ...]        every combination of a few values of the step `h` and of one or
                                                    more knobs of the model; each knob's values appear from coarse to
                                                    fine, so the first setting is the coarsest, the last the finest

The first setting of a ladder is the engine as it comes and says so: `Setting.of(rung="defaults", ...)`.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType

from cases.errors import unknown

GROUP = "slip_to_roll.adapters"

# What the first rung of a ladder is called: `Setting.of(rung=DEFAULTS, …)`.
DEFAULTS = "defaults"

# What else lies in this folder.
NO_ADAPTERS = {"common", "interface"}


class EngineFailure(RuntimeError):
    """The engine ran and gave no motion: it stopped with an error, or its numbers are not finite."""


@dataclass(frozen=True)
class Setting:
    """One rung of a ladder: the engine's knobs by name, in an order. Its text is for tables, not to be read back.

    `"h" in setting`, `setting["h"]`, `setting.get("h")` ask for a knob, `dict(setting)` gives all of them.
    """

    values: tuple[tuple[str, float | int | str], ...]

    @classmethod
    def of(cls, **values: float | int | str) -> Setting:
        """A setting from keywords, in the order given."""
        return cls(tuple(values.items()))

    def but(self, **values: float | int | str | None) -> Setting:
        """The setting with some knobs changed or added, in its order; None takes a knob out."""
        changed = dict(self.values) | values
        return Setting.of(**{name: value for name, value in changed.items() if value is not None})

    @property
    def is_default(self) -> bool:
        """Whether it is the engine as it comes."""
        return self.get("rung") == DEFAULTS

    def keys(self) -> tuple[str, ...]:
        """The knobs' names."""
        return tuple(name for name, _ in self.values)

    def get(self, name: str, default=None):
        """A knob's value, or the default where the setting has no such knob."""
        return dict(self.values).get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in dict(self.values)

    def __getitem__(self, name: str):
        return dict(self.values)[name]

    def __str__(self) -> str:
        return " ".join(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in self.values)


def engines() -> tuple[str, ...]:
    """The adapters' names, in alphabetical order: this folder's, and those of installed packages."""
    from . import __path__ as folder

    own = {module.name for module in pkgutil.iter_modules(folder)} - NO_ADAPTERS
    return tuple(sorted(own | _installed().keys()))


def engine(name: str) -> ModuleType:
    """The adapter of that name; raises UnknownName, or ImportError if its engine is not installed."""
    if name not in engines():
        raise unknown("engine", name, engines())
    foreign = _installed().get(name)
    return foreign.load() if foreign else importlib.import_module(f"adapters.{name}")


def _installed() -> dict[str, EntryPoint]:
    """Adapters that installed packages bring: `name = "their.module"` in the entry-point group GROUP."""
    return {point.name: point for point in entry_points(group=GROUP)}
