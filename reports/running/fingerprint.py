"""What decides a result, in a form that can be compared: code, versions, machine, the content of a case.

A key says all of it; two results of one key are the same result. What an engine reads from files of its own or from
the environment is not looked at.
"""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import importlib.machinery
import importlib.util
import json
import os
import platform
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, entry_points, version
from pathlib import Path
from types import ModuleType
from typing import Any

import sympy as sp

import adapters
import cases
import reference
import reports
from adapters.interface import GROUP, executables
from cases import Case, Curve
from reference import certification

from . import reference_adapter
from .packing import pack
from .records import REFERENCE

Key = dict[str, Any]

_SUITE = tuple(room.__name__ for room in (adapters, cases, reference, reports))
# Whose versions can change a digit of any result: arithmetic, code generation, compilers of expressions.
_PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "heyoka")


def made_with(versions: Mapping[str, str], solvers: Iterable[str]) -> Key | None:
    """Solvers, their versions and adapters, packages, machine; None if one of the solvers did not tell its version."""
    engines = {name: versions.get(name) for name in solvers}
    if not all(engines.values()):
        return None
    return {"engines": engines, "adapters": {name: adapter_sources(name) for name in engines}, **_surroundings()}


@lru_cache(maxsize=1)
def _surroundings() -> Key:
    """What decides every result."""
    packages = {name: installed(name) for name in _PACKAGES}
    python = f"{platform.python_implementation()} {sys.version.split()[0]}"
    return {"python": python, "packages": packages, "machine": machine()}


def machine() -> str:
    """Processor, cores and system: what times, and the last digits of some functions, depend on."""
    return f"{processor()}, {os.cpu_count()} cores, {platform.machine()}, {platform.system()}"


def processor() -> str:
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def installed(package: str) -> str:
    """The version of an installed package."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def digest(told: Any) -> str:
    """A short name for anything JSON can hold."""
    text = json.dumps(told, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def record_digest(record: Any) -> str:
    """Digest of a plain record, its arrays included."""
    plain, arrays = pack(record)
    return digest([plain, {name: hashlib.sha256(array.tobytes()).hexdigest() for name, array in arrays.items()}])


# --- a case -----------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=256)
def content(case: Case) -> str | None:
    """Digest of all that a case says: curves as expressions, plate, effects, start, duration, parameters.

    None if it has something that cannot be compared, such as a function for a parameter."""
    try:
        return digest(plain(case))
    except TypeError:
        return None


def plain(value: Any) -> Any:
    """Numbers, texts and formulas of a record, whatever its kind; TypeError for what has no content to compare."""
    if isinstance(value, Curve):
        return ["Curve", [sp.srepr(part) for part in value.expression], plain(value.domain)]
    if isinstance(value, sp.Basic):
        return sp.srepr(value)
    if value is None or isinstance(value, bool | int | float | str):
        return [type(value).__name__, repr(value)]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [type(value).__name__, {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}]
    if isinstance(value, Mapping):
        return [[plain(key), plain(v)] for key, v in value.items()]
    if isinstance(value, tuple | list):
        return [plain(v) for v in value]
    raise TypeError(f"{value!r} has no content that can be compared")


# --- code -------------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=64)
def sources(module: ModuleType, apart: tuple[ModuleType, ...] = ()) -> str:
    """Digest of a module's code and of what it imports from the suite or its own package, but for modules `apart`.

    Layout and comments do not count. Imports are read, not made.
    """
    return _digest_of(module.__name__, tuple(m.__name__ for m in apart))


@lru_cache(maxsize=64)
def adapter_sources(solver: str) -> str:
    """The same of the adapter of a solver, found without loading it: an engine is not woken by asking.

    Raises LookupError for a solver without one.
    """
    if solver == REFERENCE:
        return sources(reference_adapter)
    if solver in executables():  # its version is a digest of its file
        return _digest_of(f"{adapters.__name__}.by_process", ())
    foreign = {point.name: point.module for point in entry_points(group=GROUP)}
    return _digest_of(foreign.get(solver, f"{adapters.__name__}.{solver}"), ())


@lru_cache(maxsize=1)
def kept_truth() -> str:
    """Digest of the truths kept with the suite."""
    return hashlib.sha256(certification.TRUTH.read_bytes()).hexdigest()


def _digest_of(module: str, apart: tuple[str, ...]) -> str:
    return digest({name: _code(path) for name, path in sorted(_reached(module, apart).items())})


def _reached(module: str, apart: tuple[str, ...]) -> dict[str, Path]:
    if _file(module) is None:
        raise LookupError(f"there is no file of the module {module}, so that nothing can be said of its code")
    own = {*_SUITE, module.partition(".")[0]}
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in found or name.partition(".")[0] not in own or any(f"{name}.".startswith(f"{a}.") for a in apart):
            continue
        path = _file(name)
        if path is not None:
            found[name] = path
            waiting += _imported(name, path)
        parent = name.rpartition(".")[0]
        waiting += [parent] if parent else []
    return found


@lru_cache(maxsize=512)
def _imported(name: str, path: Path) -> tuple[str, ...]:
    """Every module a module may import, and names that may be one."""
    tree = _tree(path)
    package = name if path.stem == "__init__" else name.rpartition(".")[0]
    found: list[str] = []
    for node in ast.walk(tree) if tree else ():
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")
            base = ".".join(parts[: len(parts) - node.level + 1]) if node.level else ""
            base = ".".join(filter(None, (base, node.module)))
            found += [base, *(f"{base}.{alias.name}" for alias in node.names)]
    return tuple(found)


@lru_cache(maxsize=512)
def _code(path: Path) -> str:
    tree = _tree(path)
    return hashlib.sha256(ast.dump(tree).encode() if tree else path.read_bytes()).hexdigest()


@lru_cache(maxsize=512)
def _tree(path: Path) -> ast.Module | None:
    """The syntax of a module; None if it is compiled."""
    return ast.parse(path.read_bytes()) if path.suffix == ".py" else None


def _file(name: str) -> Path | None:
    """The file of a module, found without importing it; None if there is no such module."""
    top, _, rest = name.partition(".")
    spec = importlib.util.find_spec(top)
    if spec is None:
        return None
    if not spec.submodule_search_locations:
        return Path(spec.origin) if spec.origin and not rest else None
    for location in spec.submodule_search_locations:
        folder = Path(location).joinpath(*rest.split(".")) if rest else Path(location)
        for candidate in _candidates(folder):
            if candidate.is_file():
                return candidate
    return None


def _candidates(folder: Path) -> Iterator[Path]:
    for suffix in importlib.machinery.all_suffixes():
        yield folder / f"__init__{suffix}"
        yield folder.with_name(folder.name + suffix)
