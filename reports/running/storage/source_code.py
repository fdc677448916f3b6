"""Analysis of Python source without running it: imported modules, digests of the syntax, routes of adapters.

Importing an adapter loads its engine, which takes seconds and may end the process.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.machinery
import importlib.util
import os
from collections.abc import Container
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, NamedTuple

from adapters.lookup import GROUP, NO_ADAPTERS, executables
from cases import compile_cache

# The suite's packages. Only imports from these and from a module's own package are followed.
SUITE = ("adapters", "cases", "reference", "reports")


def of_adapter(engine: str) -> str:
    """The name of an engine's adapter module; `adapters.by_process` for executables, whose version is a digest."""
    if engine in executables():
        return "adapters.by_process"
    foreign = [_module(point) for point in entry_points(group=GROUP, name=engine)]
    return foreign[-1] if foreign else f"adapters.{engine}"


def is_adapters(module: str, packages: Container[str] | None = None) -> bool:
    """Whether a module belongs to an engine's adapter, so that importing it runs the engine.

    `packages`: the result of `adapter_packages`, if it is known."""
    here, _, rest = module.partition(".")
    if here == "adapters":
        return bool(rest) and rest.partition(".")[0] not in NO_ADAPTERS
    return here in (adapter_packages() if packages is None else packages)


def adapter_packages() -> frozenset[str]:
    """The installed packages that provide adapters; those of this suite's own folder are not among them."""
    return frozenset(_module(point).partition(".")[0] for point in entry_points(group=GROUP))


def _module(point: EntryPoint) -> str:
    """The module of an entry point, without the object after the colon."""
    return point.value.partition(":")[0].strip()


def routes_of(engine: str) -> tuple[str, ...]:
    """The routes in the source of an engine's adapter; () if they are not a literal.

    Raises ImportError if a package that the adapter imports at the top level is not installed.
    """
    for line in _lines(engine):
        for package in _packages(line):
            if importlib.util.find_spec(package) is None:
                raise ImportError(f"No module named {package!r}")
    try:
        return tuple(map(str, literal_of(engine, "routes") or ()))
    except TypeError:
        return ()


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
    own = [path for name, path in dependency_files(module, SUITE[1:]).items() if f"{name}.".startswith(f"{module}.")]
    return [line for path in own if (tree := tree_of(path)) for line in tree.body]


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
    """Files of a module and its imports from the suite or its own package, by module name, except those in `apart`.

    Raises LookupError if the module has no file.
    """
    if file_of(module) is None:
        raise LookupError(f"the module {module} has no file, so its code cannot be read")
    own = {*SUITE, module.partition(".")[0]}
    result: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in result or name.partition(".")[0] not in own or any(f"{name}.".startswith(f"{a}.") for a in apart):
            continue
        path = file_of(name)
        if path is not None:
            result[name] = path
            waiting += [other for other in imports_of(name, path) if not _picture(other) or not _answer(name)]
        parent = name.rpartition(".")[0]
        waiting += [parent] if parent else []
    return result


def _picture(name: str) -> bool:
    return f"{name}.".startswith("cases.pictures.")


def _answer(name: str) -> bool:
    """Whether a module of `cases` affects results; its imports of pictures do not."""
    return name.startswith("cases.") and not _picture(name)


@lru_cache(maxsize=512)
def imports_of(name: str, path: Path) -> tuple[str, ...]:
    """Every module that a module may import, and imported names that may be modules."""
    package = name if path.stem == "__init__" else name.rpartition(".")[0]
    result: list[str] = []
    for level, base, names in _source_facts(path).imports:
        parts = package.split(".")
        above = ".".join(parts[: len(parts) - level + 1]) if level else ""
        whole = ".".join(filter(None, (above, base)))
        result += [whole, *(f"{whole}.{one}" for one in names)]
    return tuple(result)


@lru_cache(maxsize=512)
def of(path: Path) -> str:
    """Digest of a file's syntax; layout and comments do not count."""
    return _source_facts(path).digest


class _SourceFacts(NamedTuple):
    """Digest of a file's syntax, and its imports: number of dots, module and names."""

    digest: str
    imports: tuple[tuple[int, str, tuple[str, ...]], ...] = ()


def _source_facts(path: Path) -> _SourceFacts:
    content = path.read_bytes()
    if path.suffix != ".py":
        return _SourceFacts(hashlib.sha256(content).hexdigest())
    return _of_suite().get(hashlib.sha256(content).hexdigest()) or _read(content)


@lru_cache(maxsize=1)
def _of_suite() -> dict[str, _SourceFacts]:
    """Facts of the suite's files by the digests of their contents; cached, because parsing takes longer than a small
    report's other work."""
    if compile_cache.place() is None:
        return {}
    roots = [root.parent for name in SUITE if (root := file_of(name))]
    contents = [file.read_bytes() for root in roots for file in sorted(root.rglob("*.py"))]
    digests = [hashlib.sha256(content).hexdigest() for content in contents]

    def make() -> dict[str, _SourceFacts]:
        result = {}
        for digest, content in zip(digests, contents, strict=True):
            with suppress(SyntaxError, ValueError):  # the error is raised when the file is requested
                result[digest] = _read(content)
        return result

    return compile_cache.cached("code", tuple(digests), Path(__file__).parent, make)


def _read(content: bytes) -> _SourceFacts:
    tree = ast.parse(content)
    result: list[tuple[int, str, tuple[str, ...]]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            result += [(0, alias.name, ()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            result.append((node.level, node.module or "", tuple(alias.name for alias in node.names)))
    return _SourceFacts(hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(result))


@lru_cache(maxsize=512)
def tree_of(path: Path) -> ast.Module | None:
    """The syntax of a module; None if it is compiled."""
    return ast.parse(path.read_bytes()) if path.suffix == ".py" else None


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


# File endings of a package and of a module, as strings: thousands of names are checked, and `Path` is slow.
_ENDINGS = [end for suffix in importlib.machinery.all_suffixes() for end in (f"{os.sep}__init__{suffix}", suffix)]
