"""Python code that is read and not run: which modules one reaches, what its syntax says, which routes it names.

To import an adapter is to wake its engine, which takes seconds and may end the process.
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

# The suite's rooms: their modules and those of a module's own package are followed, no others.
SUITE = ("adapters", "cases", "reference", "reports")


def of_adapter(engine: str) -> str:
    """The name of an engine's adapter module. An executable's version is a digest of its file."""
    if engine in executables():
        return "adapters.by_process"
    foreign = [_module(point) for point in entry_points(group=GROUP, name=engine)]
    return foreign[-1] if foreign else f"adapters.{engine}"


def is_adapters(module: str, installed: Container[str] | None = None) -> bool:
    """Whether a module is an engine's adapter, or of the package of one: to import it is to run the engine.
    `installed`: the result of `adapter_packages`, if it is known."""
    here, _, rest = module.partition(".")
    if here == "adapters":
        return bool(rest) and rest.partition(".")[0] not in NO_ADAPTERS
    return here in (adapter_packages() if installed is None else installed)


def adapter_packages() -> frozenset[str]:
    """The installed packages that provide adapters; those of this suite's own folder are not among them."""
    return frozenset(_module(point).partition(".")[0] for point in entry_points(group=GROUP))


def _module(point: EntryPoint) -> str:
    """The module an entry point names, whatever else stands there."""
    return point.value.partition(":")[0].strip()


def routes_of(engine: str) -> tuple[str, ...]:
    """The routes that an engine's adapter names in its code; () if it does not say them in plain words.

    Raises ImportError if a package that the adapter imports first of all is not installed.
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
    """What an engine's adapter gives a name at the top of its code, in plain words; None if it does not.

    Raises LookupError if the adapter has no code to read.
    """
    named = [line.value for line in _lines(engine) if isinstance(line, ast.Assign) and _name(line) == name]
    try:
        return ast.literal_eval(named[0]) if named else None
    except (ValueError, TypeError):
        return None


def _lines(engine: str) -> list[ast.stmt]:
    """What stands at the top of an adapter's modules."""
    module = of_adapter(engine)
    own = [path for name, path in dependency_files(module, SUITE[1:]).items() if f"{name}.".startswith(f"{module}.")]
    return [line for path in own if (tree := tree_of(path)) for line in tree.body]


def _packages(line: ast.stmt) -> list[str]:
    """The packages that a line imports."""
    if isinstance(line, ast.Import):
        return [alias.name.partition(".")[0] for alias in line.names]
    if isinstance(line, ast.ImportFrom) and line.module and not line.level:
        return [line.module.partition(".")[0]]
    return []


def _name(line: ast.Assign) -> str:
    return line.targets[0].id if isinstance(line.targets[0], ast.Name) else ""


def dependency_files(module: str, apart: tuple[str, ...]) -> dict[str, Path]:
    """The files of a module and of what it imports from the suite or its own package, by name, but for those `apart`.

    Raises LookupError if the module has no file.
    """
    if file_of(module) is None:
        raise LookupError(f"there is no file of the module {module}, so that nothing can be said of its code")
    own = {*SUITE, module.partition(".")[0]}
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in found or name.partition(".")[0] not in own or any(f"{name}.".startswith(f"{a}.") for a in apart):
            continue
        path = file_of(name)
        if path is not None:
            found[name] = path
            waiting += [other for other in imports_of(name, path) if not _picture(other) or not _answer(name)]
        parent = name.rpartition(".")[0]
        waiting += [parent] if parent else []
    return found


def _picture(name: str) -> bool:
    return f"{name}.".startswith("cases.pictures.")


def _answer(name: str) -> bool:
    """Whether it is the suite's question or answer: a motion can draw itself, and how it does so decides nothing."""
    return name.startswith("cases.") and not _picture(name)


@lru_cache(maxsize=512)
def imports_of(name: str, path: Path) -> tuple[str, ...]:
    """Every module a module may import, and names that may be one."""
    package = name if path.stem == "__init__" else name.rpartition(".")[0]
    found: list[str] = []
    for level, base, names in _source_facts(path).imports:
        parts = package.split(".")
        above = ".".join(parts[: len(parts) - level + 1]) if level else ""
        whole = ".".join(filter(None, (above, base)))
        found += [whole, *(f"{whole}.{one}" for one in names)]
    return tuple(found)


@lru_cache(maxsize=512)
def of(path: Path) -> str:
    """Digest of a file's code; layout and comments do not count."""
    return _source_facts(path).digest


class _SourceFacts(NamedTuple):
    """What a file's code says: a digest of its syntax; of each import the dots, the module and the names from it."""

    digest: str
    imports: tuple[tuple[int, str, tuple[str, ...]], ...] = ()


def _source_facts(path: Path) -> _SourceFacts:
    content = path.read_bytes()
    if path.suffix != ".py":
        return _SourceFacts(hashlib.sha256(content).hexdigest())
    return _of_suite().get(hashlib.sha256(content).hexdigest()) or _read(content)


@lru_cache(maxsize=1)
def _of_suite() -> dict[str, _SourceFacts]:
    """What the suite's files say, by their contents' digests: kept, since to parse them takes longer than a small
    report's other work."""
    if compile_cache.place() is None:
        return {}
    roots = [root.parent for name in SUITE if (root := file_of(name))]
    contents = [file.read_bytes() for root in roots for file in sorted(root.rglob("*.py"))]
    digests = [hashlib.sha256(content).hexdigest() for content in contents]

    def make() -> dict[str, _SourceFacts]:
        found = {}
        for digest, content in zip(digests, contents, strict=True):
            with suppress(SyntaxError, ValueError):  # who asks for such a file is told when it is read for him
                found[digest] = _read(content)
        return found

    return compile_cache.cached("code", tuple(digests), Path(__file__).parent, make)


def _read(content: bytes) -> _SourceFacts:
    tree = ast.parse(content)
    found: list[tuple[int, str, tuple[str, ...]]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(0, alias.name, ()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found.append((node.level, node.module or "", tuple(alias.name for alias in node.names)))
    return _SourceFacts(hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(found))


@lru_cache(maxsize=512)
def tree_of(path: Path) -> ast.Module | None:
    """The syntax of a module; None if it is compiled."""
    return ast.parse(path.read_bytes()) if path.suffix == ".py" else None


def file_of(name: str) -> Path | None:
    """The file of a module, found without importing it; None if there is no such module."""
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


# Of a package and of a module. Thousands of names are looked for, and most are none: texts, for paths are slow.
_ENDINGS = [end for suffix in importlib.machinery.all_suffixes() for end in (f"{os.sep}__init__{suffix}", suffix)]
