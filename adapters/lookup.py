"""Finds adapters by name: modules of this folder, installed packages, Python files and executables."""

from __future__ import annotations

import importlib
import importlib.util
import os
import pkgutil
import sys
from collections.abc import Callable, Iterable
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from cases.errors import BadValue, UnknownName, unknown_name
from cases.files.user_files import place

from .interface import PARTS

# The entry-point group of adapters in installed packages: `name = "their.module"`.
GROUP = "slip_to_roll.adapters"

# Modules of this folder that are not adapters.
NO_ADAPTERS = {"by_process", "common", "executables", "gate", "interface", "laws", "lookup", "processes"}

# Environment variable with the paths of the executables registered as engines. Worker processes inherit it.
EXECUTABLES = "SLIP_TO_ROLL_ENGINES"


def engines() -> tuple[str, ...]:
    """Names of all adapters, in alphabetical order: this folder's, installed packages' and registered executables."""
    return tuple(sorted(_bundled_adapters() | _entry_points().keys() | executables().keys()))


def engine(name: str) -> ModuleType:
    """The adapter of that name. Raises UnknownName, or ImportError if its engine is not installed."""
    if executable := executables().get(name):
        return _adapter_of(executable)
    if point := _entry_points().get(name):
        return point.load()
    if name not in _bundled_adapters():
        raise unknown_name("engine", name, engines())
    return importlib.import_module(f"adapters.{name}")


def find(name: str) -> ModuleType:
    """The adapter with that name, or in that Python file, executable or module.

    Raises UnknownName if there is none, BadValue for a file that fails or a module that is not an adapter, ImportError
    if its engine is not installed.
    """
    path = place("adapter", name)
    if name in engines():
        adapter = engine(name)
    elif name in _bundled_executables():
        adapter = _adapter_of(_bundled_executables()[name])
    elif path.suffix == ".py":
        adapter = _from_file(path)
    elif path.is_file():
        adapter = _adapter_of(path)
    else:
        try:
            adapter = importlib.import_module(name)
        except ModuleNotFoundError as problem:
            if problem.name is None or not f"{name}.".startswith(f"{problem.name}."):
                raise
            raise unknown_name("adapter, Python file or module", name, engines()) from None
    missing = [part for part in PARTS if not hasattr(adapter, part)]
    if missing:
        raise BadValue(f"{name} is not an adapter: it lacks {', '.join(missing)}; see `adapters.interface`")
    return adapter


def is_adapters(module: str) -> bool:
    """Whether a module belongs to an engine's adapter, of the suite or of an installed package, so that importing it
    runs the engine."""
    here, _, rest = module.partition(".")
    if here == "adapters":
        return bool(rest) and rest.partition(".")[0] not in NO_ADAPTERS
    return here in {module_of(point).partition(".")[0] for point in entry_points(group=GROUP)}


def module_of(point: EntryPoint) -> str:
    """The module of an entry point, without the object after the colon."""
    return point.value.partition(":")[0].strip()


def executables() -> dict[str, Path]:
    """The executables registered as engines with `register`, by name."""
    paths = map(Path, filter(None, os.environ.get(EXECUTABLES, "").split(os.pathsep)))
    return {path.stem: path for path in paths}


def register(file: str | Path) -> str:
    """Register an executable as an engine, in this process and in those it starts. Returns its name, the file's stem.

    An executable of the suite (`adapters/executables`) may be given by its short name. Raises BadValue if the file
    cannot be run or if another engine has its name, ImportError if it is one of the suite's executables and its engine
    is not installed.
    """
    path = place("engine", file)
    if not path.is_file():
        path = _bundled_executables().get(str(file), path)
    path = path.resolve()
    name = _adapter_of(path).NAME
    if executables().get(name) == path:
        return name
    if name in engines() or not name.isidentifier():
        raise BadValue(
            f"the engine {path} cannot be called {name!r}; give its file a name of its own, such as my_engine"
        )
    os.environ[EXECUTABLES] = os.pathsep.join([*map(str, executables().values()), str(path)])
    return name


@lru_cache(maxsize=1)
def _bundled_adapters() -> frozenset[str]:
    """The adapters in this folder; to read it takes half a millisecond, and each run looks up its adapter."""
    return frozenset(module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)])) - NO_ADAPTERS


def _entry_points() -> dict[str, EntryPoint]:
    return _entry_points_of(entry_points, tuple(sys.path))


@lru_cache(maxsize=1)
def _entry_points_of(search: Callable[..., Iterable[EntryPoint]], path: tuple[str, ...]) -> dict[str, EntryPoint]:
    """The adapters of packages on the search path; a search takes milliseconds, and each run looks up its adapter."""
    return {point.name: point for point in search(group=GROUP)}


def _from_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise UnknownName(f"there is no adapter file {str(path)!r}")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None, "a path that ends in .py has a loader"
    adapter = importlib.util.module_from_spec(spec)
    # With `from __future__ import annotations`, the file's dataclasses look up their module by name.
    sys.modules.setdefault(path.stem, adapter)
    try:
        spec.loader.exec_module(adapter)
    except ImportError:
        raise
    except Exception as problem:
        raise BadValue(f"the adapter file {path} fails: {type(problem).__name__}: {problem}") from problem
    return adapter


def _by_process() -> ModuleType:
    # Imported by name: the keys of stored runs contain the code that an adapter imports, and every adapter imports this
    # package. A change of `by_process` must not invalidate the runs of engines that do not use it.
    return importlib.import_module("adapters.by_process")


def _adapter_of(path: Path) -> Any:
    return _by_process().adapter_of(path)


def _bundled_executables() -> dict[str, Path]:
    return _by_process().bundled_engines()
