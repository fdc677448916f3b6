"""Analysis of Python source without running it: files that a result depends on, digests of syntax, routes of adapters.

Importing an adapter loads its engine, which takes seconds and may end the process.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.machinery
import importlib.util
import os
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from adapters.lookup import GROUP, executables, module_of

# The suite's packages.
SUITE = ("adapters", "cases", "reference", "reports")
# The folders of `reports` whose code makes results: each may import those before it (tests/style/test_architecture.py).
LAYERS = ("judging", "running", "analysis", "drawing", "sweeping", "studies", "page")
# The modules of `adapters` that all adapters may import.
SHARED = ("", "common", "gate", "interface", "lookup", "processes")
# The first layers whose results depend on these folders of `cases`.
FIRST_WITH = {"pictures": "drawing", "catalogue": "studies"}


def of_adapter(engine: str) -> str:
    """The name of an engine's adapter module; `adapters.by_process` for executables, whose version is a digest."""
    if engine in executables():
        return "adapters.by_process"
    foreign = [module_of(point) for point in entry_points(group=GROUP, name=engine)]
    return foreign[-1] if foreign else f"adapters.{engine}"


def routes_of(engine: str) -> tuple[str, ...]:
    """The routes in the source of an engine's adapter; () if they are not a literal.

    Raises ImportError if a package that the adapter imports at the top level is not installed.
    """
    for line in _lines(engine):
        for package in _packages(line):
            if importlib.util.find_spec(package) is None:
                raise ImportError(f"No module named {package!r}")
    routes = literal_of(engine, "routes")
    return tuple(map(str, routes)) if isinstance(routes, tuple | list) else ()


def literal_of(engine: str, name: str) -> Any:
    """The literal that the source of an engine's adapter assigns to a top-level name; None if there is none.

    Raises LookupError if the adapter has no source file.
    """
    values = [line.value for line in _lines(engine) if isinstance(line, ast.Assign) and _name(line) == name]
    try:
        return ast.literal_eval(values[0]) if values else None
    except (ValueError, TypeError):
        return None


def _lines(engine: str) -> list[ast.stmt]:
    """The top-level statements of an adapter's modules."""
    module = of_adapter(engine)
    files = dependency_files(module, SUITE[1:])
    own = [path for name, path in files.items() if f"{name}.".startswith(f"{module}.")]
    return [line for path in own if path.suffix == ".py" for line in tree_of(path).body]


def _packages(line: ast.stmt) -> list[str]:
    """The packages that a statement imports."""
    if isinstance(line, ast.Import):
        return [alias.name.partition(".")[0] for alias in line.names]
    if isinstance(line, ast.ImportFrom) and line.module and not line.level:
        return [line.module.partition(".")[0]]
    return []


def _name(line: ast.Assign) -> str:
    return line.targets[0].id if isinstance(line.targets[0], ast.Name) else ""


def dependency_files(module: str, apart: tuple[str, ...]) -> dict[str, Path]:
    """Files that a module's results may depend on, by module name, except those of the packages in `apart`.

    These are whole folders: its own, and those that it may import by docs/architecture.md. An import added within them
    needs no change here, and code that is found by name at run time is included. Raises LookupError if the module has
    no file.
    """
    if file_of(module) is None:
        raise LookupError(f"the module {module} has no file, so its code cannot be read")
    own = module.rpartition(".")[0] or module
    files = {} if module.partition(".")[0] in SUITE else _files_in(own) or _files_in(module)
    for room in SUITE:
        files |= {name: path for name, path in _files_in(room).items() if _may_depend(module, name)}
    return {name: path for name, path in files.items() if not any(f"{name}.".startswith(f"{a}.") for a in apart)}


def _may_depend(module: str, other: str) -> bool:
    """Whether a module's results may depend on another module, of the suite."""
    room, layer, name, *_ = (*module.split("."), "", "")
    other_room, other_layer, other_name, *_ = (*other.split("."), "", "")
    level = LAYERS.index(layer) if room == "reports" and layer in LAYERS else -1
    if other_room == "cases":
        # Calls get their cases as arguments, which have keys of their own; only studies load cases by name.
        return other_layer not in ("catalogue", "pictures") or level >= LAYERS.index(FIRST_WITH[other_layer])
    if other_room == "adapters":
        return other_layer in SHARED or (room, layer) == (other_room, other_layer)
    if other_room == "reference":
        return room in ("reference", "reports")
    if room != "reports" or other_layer not in LAYERS:
        return False
    is_other_study = layer == other_layer == "studies" and other_name not in ("", name)
    return LAYERS.index(other_layer) <= level and not is_other_study


@lru_cache(maxsize=16)
def _files_in(package: str) -> dict[str, Path]:
    """The files of a package's modules by their names, or of a module that is no package."""
    file = file_of(package)
    if file is None or not file.name.startswith("__init__."):
        return {} if file is None else {package: file}
    result = {}
    for path in sorted(file.parent.rglob("*")):
        stem = path.name.partition(".")[0]
        if path.name[len(stem) :] in _SUFFIXES:
            parts = path.relative_to(file.parent).parts[:-1]
            result[".".join((package, *parts, *(() if stem == "__init__" else (stem,))))] = path
    return result


@lru_cache(maxsize=512)
def of(path: Path) -> str:
    """Digest of a file's syntax; layout and comments do not count."""
    content = path.read_bytes()
    return _syntax_digest(content) if path.suffix == ".py" else hashlib.sha256(content).hexdigest()


def _syntax_digest(content: bytes) -> str:
    return hashlib.sha256(ast.dump(ast.parse(content)).encode()).hexdigest()


@lru_cache(maxsize=512)
def tree_of(path: Path) -> ast.Module:
    """The syntax of a module."""
    return ast.parse(path.read_bytes())


def file_of(name: str) -> Path | None:
    """The file of a module, without importing it; None if there is no such module."""
    top, _, rest = name.partition(".")
    spec = importlib.util.find_spec(top)
    if spec is None:
        return None
    if not spec.submodule_search_locations:
        return Path(spec.origin) if spec.origin and not rest else None
    for location in spec.submodule_search_locations:
        stem = os.path.join(location, *rest.split(".")) if rest else location
        for ending in _ENDINGS:
            if os.path.isfile(stem + ending):
                return Path(stem + ending)
    return None


# File endings of modules, and of packages and modules as strings.
_SUFFIXES = (*importlib.machinery.SOURCE_SUFFIXES, *importlib.machinery.EXTENSION_SUFFIXES)
_ENDINGS = [end for suffix in importlib.machinery.all_suffixes() for end in (f"{os.sep}__init__{suffix}", suffix)]
