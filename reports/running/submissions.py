"""Motions that others hand in: `submissions/ENGINE/VERSION/` with `submission.toml` and `CASE.csv`, a file a case.

Nothing of a submission is run, and no more of it is read than its form allows: `docs/submit.md` says what that is.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cases
from adapters.common import motion_file
from cases import BadValue, Case, CaseError, UnknownName

from . import external_motions
from .external_motions import External

ROUTE = "submission"
HEAD = "submission.toml"
# What the head has to say, each in a line.
WORDS = {
    "engine": "the engine's name, as its folder is called",
    "version": "its version, as its folder is called",
    "who": "who made the motions: a name, a project",
    "machine": "what they were made on: processor, system",
    "settings": "step, shapes, solver: what someone needs to make them again",
}
# Bytes: a line or two for each word. A stranger's file is not to fill the memory; a motion's own bound is
# `exported.LARGEST_FILE`.
LARGEST_HEAD = 16_384
LONGEST = 300  # characters of one word
# Names stand in figures, file names and spreadsheets, where a dollar sign or an equals sign begins a formula.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,59}")


@dataclass(frozen=True)
class Submission:
    """One version of one engine, its words by name, the creep that it declares (m/s) and its files by case."""

    folder: Path
    words: dict[str, str]
    creep: float
    files: dict[str, Path]

    @property
    def name(self) -> str:
        """The solver's name in a report."""
        return f"{self.words['engine']} {self.words['version']}"


def read(folder: Path) -> Submission:
    """The submission of a folder; raises CaseError, with one sentence, for whatever is not in the form."""
    if not folder.is_dir():
        raise UnknownName(f"there is no folder {str(folder)!r}; give submissions/ENGINE/VERSION")
    head = folder / HEAD
    if not head.is_file():
        raise BadValue(f"{folder} has no {HEAD}; write one with {', '.join(WORDS)}")
    _check_own(head)
    _check_size(head, LARGEST_HEAD)
    try:
        given = tomllib.loads(head.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as problem:  # a number of too many digits, brackets of too many kinds
        raise BadValue(f"{head} is no TOML: {problem}") from problem
    words = {name: _word(head, given, name) for name in WORDS}
    for place, name in ((folder.resolve().parent, "engine"), (folder.resolve(), "version")):
        if not _NAME.fullmatch(words[name]):
            raise BadValue(
                f"{name} in {head} is {words[name]!r}; give letters, digits, '_', '.', '+' and '-', up to 60"
            )
        if place.name != words[name]:
            raise BadValue(
                f"{head} says {name} = {words[name]!r}, and lies in a folder {place.name!r}; call both alike"
            )
    creep = given.get("creep", 0.0)
    if isinstance(creep, bool) or not isinstance(creep, int | float) or abs(creep) > motion_file.LARGEST:
        raise BadValue(f"creep in {head} is {creep!r}; give a speed in m/s, without quotation marks")
    stray = sorted(set(given) - {*WORDS, "creep"})
    if stray:
        raise BadValue(f"{head} says {stray[0]}, which means nothing here; it may say {', '.join(WORDS)}, creep")
    files = {path.stem: path for path in sorted(folder.iterdir()) if path.suffix == ".csv"}
    if not files:
        raise BadValue(f"{folder} has no CASE.csv; write one for each case, such as disc_in_circle[mu=0.2].csv")
    return Submission(folder, words, float(creep), files)


def _word(head: Path, given: dict, name: str) -> str:
    word = given.get(name)
    if not isinstance(word, str) or not word.strip():
        raise BadValue(f'{head} does not say {name}, {WORDS[name]}; write {name} = "…"')
    if len(word) > LONGEST or not word.isprintable():
        raise BadValue(f"{name} in {head} is no single line of at most {LONGEST} characters; shorten it")
    return word.strip()


def _check_own(path: Path) -> None:
    """A refusal quotes a line of what is read: it is to be the stranger's own."""
    if path.is_symlink():
        raise BadValue(f"{path} is a link; hand in the file itself")


def _check_size(path: Path, most: int) -> None:
    size = path.stat().st_size
    if size > most:
        raise BadValue(f"{path} has {size} bytes; give at most {most}")


def motion(submission: Submission, label: str) -> External:
    """One motion of it; raises CaseError, with one sentence that names the file, if it is none of the case's."""
    path = submission.files[label]
    _check_own(path)
    try:
        return external_motions.read(submission.name, cases.load(label), path, ROUTE, submission.creep)
    except CaseError as problem:
        raise type(problem)(f"{path}: {problem}") from problem


def submissions_in(folder: Path) -> list[Submission]:
    """All submissions below a folder, by engine and version; raises CaseError for one that is not in the form."""
    if not folder.is_dir():
        raise UnknownName(f"there is no folder {str(folder)!r}; give the one that holds ENGINE/VERSION")
    places = sorted(place for engine in folder.iterdir() if engine.is_dir() for place in engine.iterdir())
    return [read(place) for place in places if place.is_dir()]


def externals(given: Iterable[Submission], chosen: Sequence[Case], solvers: Sequence[str]) -> tuple[External, ...]:
    """The motions of submissions on the cases of a report; raises CaseError for one that is none."""
    labels = {case.label for case in chosen}
    found = []
    for submission in given:
        if submission.name in solvers:
            raise BadValue(f"{submission.folder} takes the name of the solver {submission.name}; give another name")
        found += [motion(submission, label) for label in submission.files if _label(submission, label) in labels]
    return tuple(found)


def _label(submission: Submission, text: str) -> str:
    try:
        return cases.load(text).label
    except CaseError as problem:
        raise type(problem)(f"{submission.files[text]}: {problem}; call the file by its case") from problem
