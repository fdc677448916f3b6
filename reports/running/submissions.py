"""Submitted motions: `submissions/ENGINE/VERSION/` with `submission.toml` and a file `CASE.csv` for each case.

No part of a submission is executed, and only the files of its format are read: see `docs/submit.md`.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from adapters.common import motion_table
from cases import BadValue, Case, CaseError, UnknownName, registry
from cases.files import user_files

from . import external_motions
from .external_motions import External
from .records import Run
from .tasks import find_truth

ROUTE = "submission"
HEAD = "submission.toml"
# Required entries of the head, one line each.
WORDS = {
    "engine": "the engine's name, as its folder is called",
    "version": "its version, as its folder is called",
    "who": "the author of the motions: a name, a project",
    "machine": "the machine of the runs: processor, system",
    "settings": "step, shapes, solver: all that is needed to repeat the runs",
}
# Size limit of the head in bytes: a line or two for each entry. Untrusted files must not fill the memory; the limit of
# motions is in `motion_table`.
LARGEST_HEAD = 16_384
LONGEST = 300  # characters of one entry
# Names appear in figures, file names and spreadsheets, where a dollar sign or an equals sign starts a formula.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,59}")


@dataclass(frozen=True)
class Submission:
    """A submission of one version of an engine: entries of its head, declared creep velocity (m/s), files by case."""

    folder: Path
    words: dict[str, str]
    creep: float
    files: dict[str, Path]

    @property
    def name(self) -> str:
        """The solver's name in a report."""
        return f"{self.words['engine']} {self.words['version']}"


def read(folder: Path) -> Submission:
    """Read the submission in a folder; raises CaseError if it does not have the required format."""
    if not folder.is_dir():
        raise UnknownName(f"there is no folder {str(folder)!r}; give submissions/ENGINE/VERSION")
    head = folder / HEAD
    if not os.path.lexists(head):
        raise BadValue(f"{folder} has no {HEAD}; write one with {', '.join(WORDS)}")
    text = user_files.text("head", head, LARGEST_HEAD, follow=False, form="TOML")
    try:
        entries = tomllib.loads(text)
    except (ValueError, RecursionError) as problem:  # also numbers with too many digits, brackets nested too deep
        raise BadValue(f"{head} is not TOML: {problem}") from problem
    words = {name: _word(head, entries, name) for name in WORDS}
    for place, name in ((folder.resolve().parent, "engine"), (folder.resolve(), "version")):
        if not _NAME.fullmatch(words[name]):
            raise BadValue(
                f"{name} in {head} is {words[name]!r}; give letters, digits, '_', '.', '+' and '-', up to 60"
            )
        if place.name != words[name]:
            raise BadValue(
                f"{head} has {name} = {words[name]!r}, but its folder is {place.name!r}; give both the same name"
            )
    creep = entries.get("creep", 0.0)
    if isinstance(creep, bool) or not isinstance(creep, int | float) or abs(creep) > motion_table.LARGEST:
        raise BadValue(f"creep in {head} is {creep!r}; give a speed in m/s, without quotation marks")
    stray = sorted(set(entries) - {*WORDS, "creep"})
    if stray:
        raise BadValue(f"{head} has an unknown entry {stray[0]}; allowed are {', '.join(WORDS)}, creep")
    files = {path.stem: path for path in sorted(folder.iterdir()) if path.suffix == ".csv"}
    if not files:
        raise BadValue(f"{folder} has no CASE.csv; write one for each case, such as disc_in_circle[mu=0.2].csv")
    submission = Submission(folder, words, float(creep), files)
    names: dict[str, str] = {}
    for name in files:
        other = names.setdefault(_label(submission, name), name)
        if other != name:
            raise BadValue(f"{folder} has {other}.csv and {name}.csv, motions of one case; submit one of them")
    return submission


def _word(head: Path, entries: dict, name: str) -> str:
    word = entries.get(name)
    if not isinstance(word, str) or not word.strip():
        raise BadValue(f'{head} has no {name}, {WORDS[name]}; write {name} = "…"')
    if len(word) > LONGEST or not word.isprintable():
        raise BadValue(f"{name} in {head} is not a single line of at most {LONGEST} characters; shorten it")
    return word.strip()


def motion(submission: Submission, label: str) -> External:
    """One motion of a submission; raises CaseError, with the file's name, if it is not a motion of the case."""
    path = submission.files[label]
    try:
        user_files.existing("motion", path, follow=False)
        return external_motions.read(submission.name, registry.load(label), path, ROUTE, submission.creep)
    except CaseError as problem:
        raise type(problem)(f"{path}: {problem}") from problem


def judge_all(folder: Path) -> tuple[Submission, list[Run]]:
    """The submission in a folder and the rows of its motions; raises CaseError for a wrong format."""
    submission = read(folder)
    motions = [motion(submission, label) for label in submission.files]
    return submission, [external_motions.judge_motion(external, 1, find_truth(external.case)) for external in motions]


def submissions_in(folder: Path) -> list[Submission]:
    """All submissions below a folder, by engine and version; raises CaseError for one with a wrong format."""
    if not folder.is_dir():
        raise UnknownName(f"there is no folder {str(folder)!r}; give the one that contains ENGINE/VERSION")
    places = sorted(place for engine in folder.iterdir() if engine.is_dir() for place in engine.iterdir())
    return [read(place) for place in places if place.is_dir()]


def externals(entries: Iterable[Submission], selection: Sequence[Case], solvers: Sequence[str]) -> tuple[External, ...]:
    """The motions of submissions on the cases of a report; raises CaseError for an invalid one."""
    labels = {case.label for case in selection}
    motions = []
    for submission in entries:
        if submission.name in solvers:
            raise BadValue(f"{submission.folder} takes the name of the solver {submission.name}; give another name")
        motions += [motion(submission, label) for label in submission.files if _label(submission, label) in labels]
    return tuple(motions)


def _label(submission: Submission, text: str) -> str:
    try:
        return registry.load(text).label
    except CaseError as problem:
        raise type(problem)(f"{submission.files[text]}: {problem}; name the file by its case") from problem
