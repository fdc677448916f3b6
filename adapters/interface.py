"""What an adapter is. Nothing here knows an engine; `engines` finds the adapters by looking into this folder.

An adapter is one module, or a package, with

    NAME: str                                       the engine's name in every table
    routes: tuple[str, ...]                         "native" (the engine's own shapes and contact), "assisted" (our
                                                    contact point, the engine's contact law and step), "integrator"
                                                    (our contact point and our contact law, the engine's step alone)
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

and, if the parts of its time are to be told,

    bare_run(case, route, setting, without) -> Callable[[], None]
                                                    as many steps as `run` takes, ready to be called, without "notes";
                                                    and with "callback" empty, too; and without the "binding", too
    ENGINE: str                                     or, without that function, the Python package whose compiled code is
                                                    the engine's, for a profile, if it is not called NAME

and, if its rungs are to be compared with what else its knobs allow (`reports.study settings`),

    wide_grid(case, route) -> tuple[Setting, ...]   the same as wide as the ladder is long, in one order for all cases

and, where it can say so,

    KNOWN: str                                      the engine's package and the versions that the adapter was tried
                                                    with, as pip has them: "pymunk>=6.11"; each of them may then be
                                                    asked for, as "pymunk@6.11.1". Read from the code, not imported
    MEANINGS: tuple[Meaning, ...]                   what the engine's parameters make of friction, restitution and
                                                    rolling resistance; for which cases that is another law than theirs

What these return passes `adapters.gate`: plain numbers and words of ordinary size, or the row says what is not. A
`dense` output of a motion is left out.

The first setting of a ladder is the engine as it comes and says so: `Setting.of(rung="defaults", ...)`.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import pkgutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from cases import Case
from cases.errors import BadValue, UnknownName, unknown_name
from cases.user_files import place

GROUP = "slip_to_roll.adapters"

# What every adapter has.
PARTS = ("NAME", "routes", "refuses", "ladder", "build", "run", "read", "version")

# What the first rung of a ladder is called: `Setting.of(rung=DEFAULTS, …)`.
DEFAULTS = "defaults"

# What of an adapter is called, those that not every one has among it.
FUNCTIONS = {"refuses", "ladder", "grid", "wide_grid", "build", "run", "read", "version", "bare_run"}

# What else lies in this folder.
NO_ADAPTERS = {"by_process", "common", "executables", "gate", "interface", "laws"}

# Executables that are engines (`by_process`), by this variable, so that every process of a command knows them.
EXECUTABLES = "SLIP_TO_ROLL_ENGINES"


class EngineFailure(RuntimeError):
    """The engine ran and gave no motion: it stopped with an error, or its numbers are not finite."""


def _never(case: Case) -> bool:
    return False


@dataclass(frozen=True)
class Meaning:
    """What an engine makes of one effect, an effect's class, on the routes named (on all if none is).

    `parameter`: the engine's own word for it and how it combines the two bodies' numbers; `law`: what it does with it,
    a phrase. `differs(case)`: whether that is another law than the case's effect. Such a run is made, not refused, and
    its row tells the law and how far off it is.
    """

    effect: type
    parameter: str
    law: str
    routes: tuple[str, ...] = ()
    differs: Callable[[Case], bool] = _never


def other_laws(adapter, case: Case, route: str) -> tuple[str, ...]:
    """The effects of the case that the route models by another law than theirs, each with that law in a phrase."""
    return tuple(
        f"{meaning.effect.__name__} by another law: {meaning.law}"
        for meaning in getattr(adapter, "MEANINGS", ())
        if (not meaning.routes or route in meaning.routes) and case.effect(meaning.effect) and meaning.differs(case)
    )


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
    return tuple(sorted(_own() | _installed_names().keys() | executables().keys()))


def _own() -> set[str]:
    return {module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)])} - NO_ADAPTERS


def engine(name: str) -> ModuleType:
    """The adapter of that name; raises UnknownName, or ImportError if its engine is not installed."""
    if executable := executables().get(name):
        return _by_process(executable)
    if foreign := _installed_names().get(name):
        return foreign.load()
    if name not in _own():
        raise unknown_name("engine", name, engines())
    return importlib.import_module(f"adapters.{name}")


def find(name: str) -> ModuleType:
    """The adapter of that name, in that Python file, executable or module, whoever wrote it.

    Raises UnknownName if there is none, BadValue for a file that fails or a module that is no adapter, ImportError if
    its engine is not installed.
    """
    path = place("adapter", name)
    if name in engines():
        adapter = engine(name)
    elif name in _bundled_names():
        adapter = _by_process(_bundled_names()[name])
    elif path.suffix == ".py":
        adapter = _from_file(path)
    elif path.is_file():
        adapter = _by_process(path)
    else:
        try:
            adapter = importlib.import_module(name)
        except ModuleNotFoundError as problem:
            if problem.name is None or not f"{name}.".startswith(f"{problem.name}."):
                raise
            raise unknown_name("adapter, Python file or module", name, engines()) from None
    missing = [part for part in PARTS if not hasattr(adapter, part)]
    if missing:
        raise BadValue(f"{name} is no adapter: it has no {', '.join(missing)}; see `adapters.interface`")
    return adapter


class ReturnsOnce:
    """An adapter each of whose functions returns in the process that called it and in no other.

    An engine may fork and let both processes come back. Each would go on as its caller does, and the next call would
    double them again: a copy ends here instead.
    """

    def __init__(self, adapter: Any):
        self._adapter = adapter

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._adapter, name)
        return returns_once(found) if name in FUNCTIONS else found


def returns_once(function: Callable) -> Callable:
    """The function, in whose forked copies nobody comes back from it."""

    def called(*args: Any, **named: Any) -> Any:
        own = os.getpid()
        try:
            return function(*args, **named)
        finally:
            if os.getpid() != own:
                os._exit(0)

    return called


def _from_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise UnknownName(f"there is no adapter file {str(path)!r}")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None, "a path that ends in .py has a loader"
    adapter = importlib.util.module_from_spec(spec)
    # Where it says `from __future__ import annotations`, its dataclasses look their module up by name.
    sys.modules.setdefault(path.stem, adapter)
    try:
        spec.loader.exec_module(adapter)
    except ImportError:
        raise
    except Exception as problem:
        raise BadValue(f"the adapter file {path} fails: {type(problem).__name__}: {problem}") from problem
    return adapter


def executables() -> dict[str, Path]:
    """The executables that `register` has made engines, by name."""
    paths = map(Path, filter(None, os.environ.get(EXECUTABLES, "").split(os.pathsep)))
    return {path.stem: path for path in paths}


def register(file: str | Path) -> str:
    """Make an executable an engine of this process and of those it starts; its name, which is the file's.

    One that comes with the suite (`adapters/executables`) may be given by its short name. Raises BadValue if it cannot
    be run or its name is another engine's, ImportError if it is one of those and its engine is not installed.
    """
    path = place("engine", file)
    if not path.is_file():
        path = _bundled_names().get(str(file), path)
    path = path.resolve()
    name = _by_process(path).NAME
    if executables().get(name) == path:
        return name
    if name in engines() or not name.isidentifier():
        raise BadValue(
            f"the engine {path} cannot be called {name!r}; give its file a name of its own, such as my_engine"
        )
    os.environ[EXECUTABLES] = os.pathsep.join([*map(str, executables().values()), str(path)])
    return name


def _by_process(path: Path) -> Any:
    # It knows what an adapter is, so that it is not known here until it is asked for.
    process = importlib.import_module("adapters.by_process")
    return (process.Shipped if path.resolve().parent == process.FOLDER else process.Engine)(path)


def _bundled_names() -> dict[str, Path]:
    return importlib.import_module("adapters.by_process").bundled_engines()


def _installed_names() -> dict[str, EntryPoint]:
    """Adapters that installed packages bring: `name = "their.module"` in the entry-point group GROUP."""
    return {point.name: point for point in entry_points(group=GROUP)}
