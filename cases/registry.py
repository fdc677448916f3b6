"""Cases by name. A function marked `@case` is a case; its name is the case's only name."""

from __future__ import annotations

import ast
import importlib
import importlib.machinery
import importlib.util
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec, overload

from .derivation import LOCK, in_one_thread
from .errors import BadValue, CaseError, boolean, describe, instance, items, number_in, parameter, real, unknown_name
from .files import user_files

if TYPE_CHECKING:
    from .scene.case_class import Case

P = ParamSpec("P")


@dataclass(frozen=True)
class CatalogueEntry:
    """A registered case function with its documented variants.

    `hard`: a sentence on what makes solvers fail there ("" for an ordinary case); `outcome`: the right result; `long`:
    further variants that take a solver minutes.
    """

    name: str
    function: Callable[..., Case]
    variants: tuple[Mapping[str, Any], ...]
    hard: str = ""
    outcome: str = ""
    long: tuple[Mapping[str, Any], ...] = ()

    @cached_property
    def file(self) -> Path | None:
        """The file that defines the function; None for a callable without a file."""
        try:
            file = inspect.getsourcefile(self.function)
        except TypeError:
            return None
        return Path(file) if file else None

    @property
    def folder(self) -> Path:
        """The folder of that file: relative paths in the function start there."""
        return self.file.parent if self.file else Path()

    @property
    def is_own(self) -> bool:
        """Whether it is a case of the suite's own catalogue."""
        return self.function.__module__.startswith(f"{__package__}.catalogue.")

    @cached_property
    def parameters(self) -> dict[str, Any]:
        """Parameter names and defaults, from the function's signature."""
        return parameters_of(self.function)

    @property
    def summary(self) -> str:
        """The first line of the function's docstring."""
        return (inspect.getdoc(self.function) or "").partition("\n")[0]


class CaseSummary(NamedTuple):
    """A line of a list of cases: name, first line of the docstring, and whether it is in the atlas of hard scenes."""

    name: str
    summary: str
    is_hard: bool


_entries: dict[str, CatalogueEntry] = {}


@overload
def case(function: Callable[P, Case], /) -> Callable[P, Case]: ...


@overload
def case(
    *,
    variants: Sequence[Mapping[str, Any]] = ...,
    hard: str = ...,
    outcome: str = ...,
    long: Sequence[Mapping[str, Any]] = ...,
) -> Callable[[Callable[P, Case]], Callable[P, Case]]: ...


def case(
    function=None,
    *,
    variants: Sequence[Mapping[str, Any]] = ({},),
    hard: str = "",
    outcome: str = "",
    long: Sequence[Mapping[str, Any]] = (),
):
    """Mark a function as a case. `variants` names the parameter sets that `--case NAME` runs.

    For a case of the atlas of hard scenes, `hard` says what makes it hard and `outcome` what the right result is;
    `long` are parameter sets that take minutes. A call of the function gives the case with its name and the numbers of
    the call, as `load` does.
    """

    def register(function):
        if not inspect.isfunction(function):
            raise BadValue(f"@case marks {function!r}; give it a function that returns a Case")
        name = function.__name__
        other = _entries.get(name)
        # A notebook compiles each cell under a file name of its own: there a case is defined again as any function is.
        is_again = other and other.function.__module__ == function.__module__ == "__main__"
        if other and not is_again and inspect.getsourcefile(other.function) != inspect.getsourcefile(function):
            raise BadValue(f"there is already a case {name!r}; give this function another name")
        if bool(instance("hard= of @case", hard, str)) != bool(instance("outcome= of @case", outcome, str)):
            raise BadValue(f"the hard case {name!r} has only one of hard= and outcome=; give both")
        short, minutes = (_parameter_sets(name, some) for some in (variants, long))
        _entries[name] = CatalogueEntry(name, function, short, hard, outcome, minutes)
        return _named(function)

    return register if function is None else register(function)


def _named(function: Callable[P, Case]) -> Callable[P, Case]:
    """The same function, whose case has the function's name, and the arguments of the call if all are numbers."""
    signature = inspect.signature(function)

    @wraps(function)
    def call(*arguments: P.args, **keywords: P.kwargs) -> Case:
        from .scene.case_class import Case  # imports NumPy, which lists and help do not need

        scene, values = function(*arguments, **keywords), signature.bind(*arguments, **keywords).arguments
        if not isinstance(scene, Case) or not all(real(value) is not None for value in values.values()):
            return scene
        return scene.with_name(function.__name__, {key: parameter(key, value) for key, value in values.items()})

    return call


def _parameter_sets(name: str, sets: object) -> tuple[dict[str, Any], ...]:
    every = items(f"a list of variants of {name}", sets)
    if not all(isinstance(one, Mapping) for one in every):
        raise BadValue(f"a variant of {name} is no dict; give dict(parameter=number) for each")
    return tuple(dict(one) for one in every)


def entry(name: str) -> CatalogueEntry:
    """The registered case of that name; raises UnknownName with the nearest names."""
    if not isinstance(name, str):
        raise BadValue(f"{name!r} is not a case; give its name, for example disc_in_circle")
    _import_catalogue()
    if name not in _entries:
        _import_packages()
    if name not in _entries:
        raise unknown_name("case", name, _entries)
    return _entries[name]


def names(hard: bool | None = None) -> list[str]:
    """The names of all cases in alphabetical order; with `hard`, only those of the hard atlas or only the others."""
    _import_catalogue()
    _import_packages()
    values = {True, False} if hard is None else {boolean("hard", hard)}
    return sorted(name for name, item in list(_entries.items()) if bool(item.hard) in values)


def parameters_of(function: Callable) -> dict[str, Any]:
    """Names and defaults of a function's parameters. Raises BadValue if they are unknown."""
    try:
        return {name: p.default for name, p in inspect.signature(function).parameters.items()}
    except (TypeError, ValueError):
        raise BadValue(f"the parameters of {function!r} are unknown; give a function that makes a case") from None


def summaries() -> list[CaseSummary]:
    """A line for every case, in alphabetical order, without SymPy: those of the catalogue are read from its source."""
    _import_packages()
    lines = {line.name: line for file in _catalogue_files() for line in _summaries_in(file)}
    lines |= {name: CaseSummary(name, item.summary, bool(item.hard)) for name, item in list(_entries.items())}
    return [lines[name] for name in sorted(lines)]


def _catalogue_files() -> list[Path]:
    from . import catalogue

    return sorted(Path(folder) / f"{module.name}.py" for folder in catalogue.__path__
                  for module in pkgutil.iter_modules([folder]))  # fmt: skip


def _summaries_in(file: Path) -> Iterator[CaseSummary]:
    """The functions marked `@case` in a file of the catalogue."""
    for node in ast.parse(file.read_bytes()).body:
        for mark in getattr(node, "decorator_list", ()):
            call = mark if isinstance(mark, ast.Call) else None
            if isinstance(node, ast.FunctionDef) and ast.unparse(call.func if call else mark) == "case":
                is_hard = call is not None and any(keyword.arg == "hard" for keyword in call.keywords)
                yield CaseSummary(node.name, (ast.get_docstring(node) or "").partition("\n")[0], is_hard)


def load(name: str, **parameters) -> Case:
    """The case `name` with some parameters changed; `name` may carry them: "disc_in_circle[mu=0.2]".

    Raises UnknownName for a name or parameter that does not exist, with the nearest ones; CaseError for values no
    scene can have.
    """
    is_bare = isinstance(name, str) and name in _entries  # nothing to parse
    bare, changes = (name, {}) if is_bare else parse(name)
    item = entry(bare)
    parameters = {**changes, **parameters}
    for key, value in parameters.items():
        if key not in item.parameters:
            raise unknown_name(f"parameter of {bare}", key, item.parameters)
        parameters[key] = parameter(f"{key} of {bare}", value)
    values = tuple(parameters.items())
    make = _catalogue_scene if item.is_own else _scene
    return make(bare, item.function, item.folder, values, repr(values))


def _scene(name: str, function: Callable, folder: Path, values: tuple[tuple[str, float], ...], _: str) -> Case:
    # These import NumPy and SymPy, which lists and help do not need.
    from .curves.point_sources import paths_count_from
    from .scene.case_class import Case

    try:
        with LOCK, paths_count_from(folder):
            scene = function(**dict(values))
    except (CaseError, KeyboardInterrupt):
        raise
    except BaseException as problem:  # sys.exit among them
        text = ", ".join(f"{key}={value!r}" for key, value in values) or "its own parameters"
        raise BadValue(f"{name} cannot be made with {text}: {describe(problem)}") from problem
    if not isinstance(scene, Case):
        raise BadValue(f"the case function {name} returned {type(scene).__name__}; return a Case")
    return scene.with_name(name, dict(values))


# The functions of the suite's own catalogue depend on their parameters only, and a case is immutable. The last argument
# separates 0.0 from -0.0 and 1 from 1.0, which are equal. A user's function may read files: its cases are not cached.
_catalogue_scene = lru_cache(maxsize=1024)(_scene)


def select(text: str, long: bool = False) -> list[Case]:
    """The cases of `--case TEXT`: all variants of a bare name, or the one case of "name[parameter=value]".

    With `long` the variants of a bare name include those that take minutes.
    """
    bare, changes = parse(text)
    if changes or "[" in text:
        return [load(text)]
    item = entry(bare)
    return [load(bare, **variant) for variant in (*item.variants, *(item.long if boolean("long", long) else ()))]


class _UncachedLoader(importlib.machinery.SourceFileLoader):
    """Reads the source each time: Python's bytecode cache misses an edit in the same second that keeps the size."""

    def get_code(self, fullname):
        path = self.get_filename(fullname)
        return self.source_to_code(self.get_data(path), path)


@in_one_thread
def load_file(path: str | Path) -> list[str]:
    """Load the case functions of a Python file into the catalogue; returns their names.

    Raises CaseError, in one sentence, if the file cannot be read, fails, or holds no case.
    """
    path = user_files.existing("case file", path)
    before = dict(_entries)
    if path.suffix != ".py":
        raise BadValue(f"{path} is not a Python file; a case file ends in .py")
    from .curves.point_sources import paths_count_from

    name, place = f"case_file_{path.stem}", path.resolve()  # workers use it from other folders
    spec = importlib.util.spec_from_loader(name, _UncachedLoader(name, str(place)))
    assert spec is not None and spec.loader is not None
    try:
        with paths_count_from(place.parent):
            spec.loader.exec_module(importlib.util.module_from_spec(spec))
    except (CaseError, KeyboardInterrupt):
        raise
    except BaseException as problem:
        raise BadValue(f"the case file {path} fails: {describe(problem)}") from problem
    new = [name for name in _entries if _entries[name] is not before.get(name)]
    if not new:
        raise BadValue(f"the case file {path} holds no case; mark its function with @case")
    return new


@lru_cache(maxsize=1)
def _import_catalogue() -> None:
    from . import catalogue

    for module in pkgutil.iter_modules(catalogue.__path__):
        importlib.import_module(f"{catalogue.__name__}.{module.name}")


@lru_cache(maxsize=1)
def _import_packages() -> None:
    """Cases of installed packages: modules named by entry points of the group "slip_to_roll.cases"."""
    from importlib.metadata import entry_points  # slow to import, and a case of the catalogue needs none

    for item in entry_points(group="slip_to_roll.cases"):
        try:
            item.load()
        except (Exception, SystemExit) as problem:
            raise BadValue(f"the cases of {item.value} fail: {describe(problem)}") from problem


def parse(text: str) -> tuple[str, dict[str, float]]:
    """Split "name[a=1,b=2]" into the name and its numbers; raises BadValue."""
    if not isinstance(text, str):
        raise BadValue(f"{text!r} is not a case; give its name, for example disc_in_circle")
    match = re.fullmatch(r"\s*(\w+)\s*(?:\[(.*)\])?\s*", text)
    if not match:
        raise BadValue(f"{text!r} is not a case; write name or name[parameter=value,…]")
    parameters: dict[str, float] = {}
    for part in filter(None, (piece.strip() for piece in (match[2] or "").split(","))):
        key, equals, value = part.partition("=")
        try:
            parameters[key.strip()] = number_in(key, value if equals else "")
        except BadValue:
            raise BadValue(f"{part!r} in {text!r} is not parameter=number") from None
    return match[1], parameters
