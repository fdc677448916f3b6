"""The cases that an argument of a command line selects. All commands use this module:

    NAME                    of the catalogue, or of NAME.py in the working folder
    NAME[parameter=value,…] one variant
    FILE.py                 every case of a file
    FILE.py:FUNCTION        one case of a file, also with [parameter=value,…]

A file of cases is Python code that is executed: use this only for input that the user types, else `registry.load`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from . import registry
from .errors import BadValue, CaseError, UnknownName, describe, unknown_name
from .files import user_files

if TYPE_CHECKING:
    from .scene.case_class import Case

T = TypeVar("T")


class CaseName(NamedTuple):
    """The cases that an argument names, the text in its brackets (None: no brackets), and the file of the cases."""

    text: str
    names: tuple[str, ...]
    inside: str | None
    file: Path | None

    def one(self, changes: Sequence[str] = ()) -> Case:
        """The only case, with `changes` such as "mu=0.3"; raises CaseError in one sentence if there are several, or it
        cannot be made."""
        label = self.label(changes)
        return _try(f"the case {label}", self.names[0], partial(registry.load, label))

    def every(self, long: bool = False) -> list[Case]:
        """Every variant of every case, or the one variant; with `long` also those that take minutes.

        Raises CaseError in one sentence.
        """
        if self.inside is not None:
            return [self.one()]
        results: list[Case] = []
        for name in self.names:
            results += _try(f"the case {name}", name, partial(registry.select, name, long))
        return results

    def label(self, changes: Sequence[str] = ()) -> str:
        """The only case, with `changes`, as `name[parameter=value,…]`; raises BadValue if there are several."""
        if len(self.names) > 1:
            cases = f"{len(self.names)} cases, {', '.join(self.names)}"
            raise BadValue(f"{self.text} has {cases}; give one: {self.file}:{self.names[0]}")
        inside = ",".join(filter(None, [self.inside, *changes]))
        return f"{self.names[0]}[{inside}]" if inside or self.inside is not None else self.names[0]


def case_name(text: str, load: Callable[[Path], list[str]] | None = None) -> CaseName:
    """The cases that an argument names, of a file by `load`: by default `load_file`, with its trial run.

    Raises CaseError in one sentence.
    """
    head, bracket, rest = text.strip().partition("[")
    if bracket and not rest.endswith("]"):
        raise BadValue(f"{text!r} is not a case; write name or name[parameter=value,…]")
    inside = rest.removesuffix("]") if bracket else None
    path, colon, function = head.partition(":")
    file = _file(path)
    if file is None:
        if colon:
            raise UnknownName(f"there is no case file {path!r}; write FILE.py:FUNCTION")
        bare, _ = registry.parse(head)
        registry.entry(bare)  # raises UnknownName
        return CaseName(text, (bare,), inside, None)
    names = tuple((load or load_file)(file))
    if colon and function not in names:
        raise unknown_name(f"case in {file}", function, names)
    return CaseName(text, (function,) if colon else names, inside, file)


def load(name: str | Path, **parameters: Any) -> Case:
    """The case `name` with some parameters changed; `name` may carry them: "disc_in_circle[mu=0.2]".

    The name of a Python file, or FILE.py:FUNCTION where it has several cases, executes that file and takes its case.
    Raises UnknownName for a name or parameter that does not exist, with the nearest ones; CaseError for values no
    scene can have.
    """
    return registry.load(catalogue_name(str(name) if isinstance(name, Path) else name), **parameters)


def catalogue_name(name: str) -> str:
    """The name in the catalogue of the only case that `name` gives: the name itself, or a case of a file."""
    is_file = isinstance(name, str) and name.partition("[")[0].partition(":")[0].strip().endswith(".py")
    return case_name(name, registry.load_file).label() if is_file else name


def load_file(file: str | Path) -> list[str]:
    """Load the cases of a file into the catalogue after a trial run in a copy of the process; returns their names.

    Raises CaseError in one sentence with the line of the file.
    """
    path = user_files.existing("case file", file)
    return _make(f"the case file {path}", path, partial(registry.load_file, path))


def _try(what: str, name: str, make: Callable[[], T]) -> T:
    """The result of `make` for the case `name`, with a trial run first if the case is not the suite's own."""
    entry = registry.entry(name)
    return make() if entry.is_own or entry.file is None else _make(what, entry.file, make)


def _make(what: str, file: Path, make: Callable[[], T]) -> T:
    """The result of `make`, with a trial run first; raises BadValue with the line of the author's file."""
    from .files.trial import trial  # of files alone: importing it takes a fifth of what `import cases` does

    trial(what, make, explain=lambda problem: _sentence(file, problem))
    try:
        return make()
    except CaseError as problem:
        raise BadValue(_sentence(file, problem)) from problem


def _sentence(file: Path, problem: BaseException) -> str:
    """The description of a problem, with its place in the author's file."""
    place, text = _place(file, problem), describe(problem)
    return text if text.startswith(place) or (place == _display(file) and place in text) else f"{place}: {text}"


def _file(text: str) -> Path | None:
    """The file that an argument names; None for a name of the catalogue, or if there is no file."""
    if text.endswith(".py"):
        return user_files.existing("case file", text)
    if text in registry.names():
        return None
    path = user_files.place("case", f"{text}.py")
    return path if path.is_file() else None


def _place(file: Path, problem: BaseException) -> str:
    """path:line of the innermost frame of a problem in the author's file, or the path alone."""
    import traceback  # of errors alone

    causes: list[BaseException] = [problem]
    while causes[-1].__cause__:
        causes.append(causes[-1].__cause__)
    lines = [
        frame.lineno
        for cause in causes
        for frame in traceback.extract_tb(cause.__traceback__)
        if Path(frame.filename).resolve() == file.resolve()
    ]
    syntax = [cause.lineno for cause in causes if isinstance(cause, SyntaxError)]
    line = (syntax or lines or [None])[-1]
    return f"{_display(file)}:{line}" if line else _display(file)


def _display(file: Path) -> str:
    """The file's path relative to the working folder, if it is below it."""
    here = Path.cwd()
    return str(file.relative_to(here) if file.is_relative_to(here) else file)
