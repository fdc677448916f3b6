"""What was asked for: the command's options, checked before anything runs, and the ladders they thin.

Everything here answers at once; what is slow to import is imported when it is needed.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import adapters
import cases
from cases import BadValue, Case, CaseError
from cases.errors import unknown

if TYPE_CHECKING:
    from adapters import Setting

    from .running.external import Elsewhere

MADE_BY = "slip-to-roll report"
REFERENCE = "reference"
# The families every solver runs; they alone make up a quick report.
SHARED = ("disc_in_circle", "disc_on_incline", "disc_on_line")
# Families whose whole ladders stand in a default report, so that they can be timed: with the shared ones a lift-off and
# a plate that is no disc, whose curvature changes.
WHOLE = (*SHARED, "disc_rolling_off_hill", "ellipse_in_circle")
# Finished runs are kept where one works, as test runners and linters do: a fresh folder is a fresh start.
STORE = ".slip-to-roll"
# Wall seconds a run may take, by effort: a whole default report takes a few minutes on two cores.
_LIMITS = {"quick": 20.0, "default": 60.0, "full": 600.0}


@dataclass(frozen=True)
class Plan:
    """What was asked for, checked."""

    out: Path
    cases: tuple[Case, ...]
    files: tuple[str, ...]
    solvers: tuple[str, ...]
    effort: str
    jobs: int
    argv: tuple[str, ...]
    asked: bool  # whether the cases were named, not taken from the whole catalogue
    store: Path | None = None  # where finished runs are kept
    fresh: bool = False  # whether what is kept there is left out of account
    trajectories: tuple[Elsewhere, ...] = ()

    @property
    def limit(self) -> float:
        """Wall seconds a run may take."""
        return _LIMITS[self.effort]

    def thin(self, case: str, solver: str, settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
        """The rungs to run: all, or the defaults and three for a quick report, one in the breadth of the catalogue.

        There the reference is run at its finest, for which its equations are compiled anyway: the truth's motion."""
        if self.effort == "full" or (self.effort == "default" and (self.asked or case in WHOLE)):
            return settings
        from .running.records import is_default_setting

        ladder = [s for s in settings if not is_default_setting(s)]
        third = len(ladder) // 3
        one = len(ladder) - 1 if solver == REFERENCE else 2 * third
        places = sorted({0, third, 2 * third} if self.effort == "quick" else {one}) if ladder else []
        return (*(s for s in settings if is_default_setting(s)), *(ladder[i] for i in places))


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence, by the suite's own error."""

    def error(self, message: str) -> NoReturn:
        stray = message.removeprefix("unrecognized arguments: ")
        if stray != message:
            options = [o for action in self._actions for o in action.option_strings if o.startswith("--")]
            raise unknown("option", (stray.split() or [""])[0], options)
        raise BadValue(f"{message}; see {self.prog} --help")


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    parser = Parser(
        prog="python -m reports.build",
        description="Run cases through solvers and write a report: index.html, tables, figures, manifest.json.",
        epilog='Example: python -m reports.build --quick --case "disc_in_circle[mu=0.2]" --solver reference exudyn',
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--out", metavar="DIR", default="report", help="folder of the report (default: report)")
    add(
        "--case",
        metavar="NAME",
        nargs="+",
        action="extend",
        help='cases: a name (all its variants) or "name[parameter=value,…]" (default: all, or those of --case-file)',
    )
    add(
        "--case-file",
        metavar="FILE",
        nargs="+",
        action="extend",
        default=[],
        help="Python files with cases of your own, marked with @case",
    )
    add(
        "--solver",
        metavar="NAME",
        nargs="+",
        action="extend",
        help=f"solvers: {', '.join(solvers())} (default: all)",
    )
    add(
        "--trajectory",
        metavar="NAME[@CASE]=FILE",
        action="append",
        default=[],
        help="an exported motion (columns t, x, y, theta, …) as a solver of its own; may be given again",
    )
    effort = parser.add_mutually_exclusive_group()
    add = effort.add_argument
    add("--quick", action="store_true", help="three cases, one variant each, fewer settings")
    add("--full", action="store_true", help="every setting of every case, with ten times the patience")
    parser.add_argument("--jobs", metavar="N", default="2", help="runs beside each other (default: 2)")
    parser.add_argument(
        "--store",
        metavar="DIR",
        help=f"folder where finished runs are kept and taken from (default: {STORE}); delete it to forget them",
    )
    parser.add_argument("--fresh", action="store_true", help="run everything anew, whatever is kept")
    parser.add_argument("--list", action="store_true", help="print cases and solvers, and stop")
    return parser


def solvers() -> tuple[str, ...]:
    """Every solver's name: the reference first, then the engines in alphabetical order."""
    return (REFERENCE, *adapters.engines())


def plan_of(options: argparse.Namespace, argv: Sequence[str]) -> Plan:
    """The plan of parsed options; raises CaseError, in one sentence, for what makes no sense."""
    effort = "quick" if options.quick else "full" if options.full else "default"
    jobs = whole_jobs(options.jobs)
    chosen = tuple(dict.fromkeys(options.solver or solvers()))
    for name in chosen:
        if name not in solvers():
            raise unknown("solver", name, solvers())
    files = tuple(str(Path(file).resolve()) for file in options.case_file)
    own = [name for file in files for name in _guarded(file, lambda file=file: cases.load_file(file))]
    out = _checked_out(Path(options.out))
    store = _checked_store(options.store, out)
    asked = options.case or own
    found = _cases(asked or (SHARED if effort == "quick" else cases.names(hard=False)), effort)
    given = _trajectories(options.trajectory, found)
    return Plan(out, found, files, chosen, effort, jobs, tuple(argv), bool(asked), store, options.fresh, given)


def _trajectories(texts: Sequence[str], found: Sequence[Case]) -> tuple[Elsewhere, ...]:
    if not texts:
        return ()
    from .running import external as elsewhere

    return elsewhere.asked(texts, found, solvers())


def whole_jobs(text: str) -> int:
    """How many runs beside each other; raises BadValue unless it is a whole number of at least 1."""
    try:
        jobs = int(text)
    except ValueError:
        raise BadValue(f"--jobs is {text!r}; give a whole number, for example 2") from None
    if jobs < 1:
        raise BadValue(f"--jobs is {jobs}; give at least 1")
    return jobs


def _cases(texts: Sequence[str], effort: str) -> tuple[Case, ...]:
    """The cases of the texts, each once; a quick report takes only the last variant of a bare name."""
    found: dict[tuple, Case] = {}
    for text in texts:
        variants = _guarded(f"the case {text}", lambda text=text: cases.select(text))
        for case in variants[-1:] if effort == "quick" else variants:
            found.setdefault((case.name, tuple(case.parameters.items())), case)
    return tuple(found.values())


def _guarded(what: str, make):
    """A case's own code may fail in any way; it is told in one sentence."""
    try:
        return make()
    except CaseError:
        raise
    except Exception as problem:
        text = " ".join(str(problem).split())
        raise BadValue(f"{what} fails: {type(problem).__name__}: {text}") from problem


def _checked_out(out: Path) -> Path:
    """The folder to write, resolved; raises BadValue unless it is new, empty, or a report of ours and nothing else."""
    out = out.expanduser().resolve()
    if out == Path.cwd() or out in Path.cwd().parents:
        raise BadValue(f"--out is {out}, where you are working; give a folder inside it, for example report")
    if out.exists() and not out.is_dir():
        raise BadValue(f"--out is {out}, which is a file; give a folder")
    _check_writable("--out", out, out.parent)
    strange = strangers(out)
    if strange:
        raise BadValue(f"--out is {out}, which holds {strange}, no part of a report; give another folder")
    return out


def _checked_store(text: str | None, out: Path) -> Path:
    """The store's folder, resolved; raises BadValue if what was asked for is no folder of its own or not writable."""
    store = Path(STORE if text is None else text).expanduser().resolve()
    if store == out or store in out.parents or out in store.parents:
        raise BadValue(f"--store is {store} and --out is {out}; give folders that are not inside each other")
    if text is not None:  # the place nobody asked for may be unfit: the report is made all the same, and says so
        if store.exists() and not store.is_dir():
            raise BadValue(f"--store is {store}, which is a file; give a folder")
        _check_writable("--store", store, store)
    return store


def _check_writable(option: str, path: Path, folder: Path) -> None:
    above = next(place for place in (folder, *folder.parents) if place.exists())
    if not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise BadValue(f"{option} is {path}, and {above} cannot be written to; give another folder")


def strangers(out: Path) -> str:
    """A file in the folder that no report of ours wrote, or ""."""
    files = [p for p in out.rglob("*") if not p.is_dir() or p.is_symlink()] if out.is_dir() else []
    known: set[str] = set()
    try:
        manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
        if manifest.get("made_by") == MADE_BY:
            known = set(manifest["files"])
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        pass  # no manifest, or not one of ours: everything in the folder is somebody's
    return next((str(p.relative_to(out)) for p in sorted(files) if p.relative_to(out).as_posix() not in known), "")


def listing(files: Sequence[str]) -> str:
    """Cases with variants and summaries, solvers with routes."""
    for file in files:
        _guarded(file, lambda file=file: cases.load_file(file))
    lines = ["cases"]
    for name in cases.names():
        lines.append(f"  {name}: {cases.entry(name).summary}")
        try:
            lines += [f"    {case.label}" for case in _guarded("it", lambda name=name: cases.select(name))]
        except CaseError as problem:
            lines.append(f"    cannot be made: {problem}")
    lines.append("solvers")
    from .running.tasks import solver

    for name in solvers():
        try:
            lines.append(f"  {name}: {', '.join(solver(name).routes)}")
        except ImportError as problem:
            lines.append(f"  {name}: not installed ({problem})")
    return "\n".join(lines)
