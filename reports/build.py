"""The command: `python -m reports.build`. The only writer of files; it checks everything before it touches any.

The report is written into a folder beside its place and moved there when it is whole, so that a partial one is never
taken for it. What is slow to import is imported when it is needed: help and errors answer at once.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import adapters
import cases
from cases import BadValue, Case, CaseError
from cases.errors import unknown

if TYPE_CHECKING:
    from adapters import Setting

    from .elsewhere import Elsewhere
    from .precision import Measured
    from .records import Experiment

MADE_BY = "slip-to-roll report"
REFERENCE = "reference"
# The families every solver runs, whose whole ladders stand in every report; they alone make up a quick one.
SHARED = ("disc_in_circle", "disc_on_incline", "disc_on_line")
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
    trajectories: tuple[Elsewhere, ...] = ()

    @property
    def limit(self) -> float:
        """Wall seconds a run may take."""
        return _LIMITS[self.effort]

    def thin(self, case: str, settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
        """The rungs to run: all, or for a quick report and in the breadth of the catalogue the defaults and three."""
        if self.effort == "full" or (self.effort == "default" and (self.asked or case in SHARED)):
            return settings
        from .records import is_default_setting

        ladder = [s for s in settings if not is_default_setting(s)]
        places = sorted({0, len(ladder) // 3, 2 * len(ladder) // 3}) if ladder else []
        return (*(s for s in settings if is_default_setting(s)), *(ladder[i] for i in places))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status: 0, or 2 if what was asked for makes no sense."""
    argv = list(sys.argv[1:] if argv is None else argv)
    try:
        options = _parser().parse_args(argv)
        if options.list:
            print(_listing(options.case_file))
            return 0
        plan = _plan(options, argv)
    except CaseError as problem:
        print(f"reports.build: {problem}", file=sys.stderr)
        return 2
    try:
        return _build(plan)
    except KeyboardInterrupt:
        print("reports.build: stopped; nothing was written", file=sys.stderr)
        return 130
    except OSError as problem:
        print(f"reports.build: cannot write the report: {problem}", file=sys.stderr)
        return 1


# --- what was asked for -----------------------------------------------------------------------------------------------


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence, by the suite's own error."""

    def error(self, message: str) -> NoReturn:
        stray = message.removeprefix("unrecognized arguments: ")
        if stray != message:
            options = [o for action in self._actions for o in action.option_strings if o.startswith("--")]
            raise unknown("option", stray.split()[0], options)
        raise BadValue(f"{message}; see python -m reports.build --help")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
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
        help=f"solvers: {', '.join(_solvers())} (default: all)",
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
    parser.add_argument("--list", action="store_true", help="print cases and solvers, and stop")
    return parser


def _solvers() -> tuple[str, ...]:
    return (REFERENCE, *adapters.engines())


def _plan(options: argparse.Namespace, argv: Sequence[str]) -> Plan:
    effort = "quick" if options.quick else "full" if options.full else "default"
    jobs = _jobs(options.jobs)
    chosen = tuple(dict.fromkeys(options.solver or _solvers()))
    for name in chosen:
        if name not in _solvers():
            raise unknown("solver", name, _solvers())
    files = tuple(str(Path(file).resolve()) for file in options.case_file)
    own = [name for file in files for name in _guarded(file, lambda file=file: cases.load_file(file))]
    out = _checked_out(Path(options.out))
    asked = options.case or own
    found = _cases(asked or (SHARED if effort == "quick" else cases.names()), effort)
    given = _trajectories(options.trajectory, found)
    return Plan(out, found, files, chosen, effort, jobs, tuple(argv), bool(asked), trajectories=given)


def _trajectories(texts: Sequence[str], found: Sequence[Case]) -> tuple[Elsewhere, ...]:
    if not texts:
        return ()
    from . import elsewhere

    return elsewhere.asked(texts, found, _solvers())


def _jobs(text: str) -> int:
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
    above = next(folder for folder in out.parents if folder.exists())
    if not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise BadValue(f"--out is {out}, and {above} cannot be written to; give another folder")
    strange = _strangers(out)
    if strange:
        raise BadValue(f"--out is {out}, which holds {strange}, no part of a report; give another folder")
    return out


def _strangers(out: Path) -> str:
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


def _listing(files: Sequence[str]) -> str:
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
    from .trial import solver

    for name in _solvers():
        try:
            lines.append(f"  {name}: {', '.join(solver(name).routes)}")
        except ImportError as problem:
            lines.append(f"  {name}: not installed ({problem})")
    return "\n".join(lines)


# --- the report -------------------------------------------------------------------------------------------------------


def _build(plan: Plan) -> int:
    from . import experiment as xp

    _say(f"{len(plan.cases)} cases, solvers {', '.join(plan.solvers)}, {plan.effort} effort, {plan.jobs} at a time")
    found = xp.run(plan.cases, plan.solvers, plan.files, plan.thin, plan.jobs, plan.limit, _progress)
    measured = _measure(plan, found)
    shown = _with_trajectories(plan, found)
    plan.out.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{plan.out.name}.", suffix=".partial", dir=plan.out.parent))
    try:
        _write(plan, shown, found, measured, partial)
        _move(partial, plan.out)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    print(_told(plan, shown))
    return 0


def _with_trajectories(plan: Plan, found: Experiment) -> Experiment:
    """What was found here, and what others found."""
    if not plan.trajectories:
        return found
    from . import elsewhere

    return elsewhere.joined(found, plan.trajectories)


def _measure(plan: Plan, found: Experiment) -> Measured:
    """The timed pass, after everything else has ended; a quick report goes without."""
    from . import precision

    if plan.effort == "quick":
        _say("timings: skipped by --quick; CPU times of the tables were taken beside other runs and rank nothing")
        return precision.Measured()
    return precision.measure(found, plan.files, plan.effort == "full", _progress)


def _progress(step: str, total: int, answers: Iterator) -> Iterator:
    from tqdm import tqdm

    # A terminal sees the bar move; a log file gets a line now and then.
    often = 0.2 if sys.stderr.isatty() else 10.0
    return iter(tqdm(answers, desc=step, total=total, mininterval=often, dynamic_ncols=True))


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _write(plan: Plan, found: Experiment, timed: Experiment, measured: Measured, folder: Path) -> None:
    """Tables, figures, page and manifest into the folder; `timed`: what was found here, not elsewhere."""
    from . import elsewhere, figures, precision, precision_figures, tables, webpage
    from .manifest import manifest

    folder.chmod(0o755)  # mkdtemp's folders are private; a report is for reading
    _say("tables")
    frames = tables.frames(found) | precision.frames(timed, measured)
    tables.write(frames, folder / "tables")
    count = 1 + 3 * len(found.cases)
    drawn = list(_progress("figures", count, figures.draw(found, folder / "figures")))
    drawn += precision_figures.draw(timed, measured, folder / "figures")
    _say("page")
    told = manifest(plan.solvers, plan.jobs, plan.limit)
    told["solvers"] |= elsewhere.sources(plan.trajectories)
    told |= {
        "made_by": MADE_BY,
        "command": _command(plan),
        "options": _options(plan),
        "settings": f"effort {plan.effort}, {plan.jobs} at a time, {plan.limit:g} s a run",
        "limit_seconds": plan.limit,
        "seconds": found.seconds,
        "cases": {case.label: dict(case.parameters) for case in found.cases},
    }
    page = webpage.render(found, measured, frames, drawn, folder / "figures", told)
    (folder / "index.html").write_text(page, encoding="utf-8")
    files = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    told["files"] = [*files, "manifest.json"]
    (folder / "manifest.json").write_text(json.dumps(told, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def _command(plan: Plan) -> str:
    return " ".join(["python -m reports.build", *(shlex.quote(a) for a in plan.argv)])


def _options(plan: Plan) -> str:
    """The options that matter when one case is to be made again: effort, case files and solvers."""
    words = [] if plan.effort == "default" else [f"--{plan.effort}"]
    if plan.files:
        words += ["--case-file", *(shlex.quote(os.path.relpath(file)) for file in plan.files)]
    if set(plan.solvers) != set(_solvers()):
        words += ["--solver", *plan.solvers]
    return " ".join(words)


def _move(partial: Path, out: Path) -> None:
    """Put the whole report in its place; an older one is kept aside until it stands."""
    strange = _strangers(out)
    if strange:
        raise OSError(f"{out} has come to hold {strange} meanwhile, which is no part of a report")
    if not out.exists():
        partial.rename(out)
        return
    aside = Path(tempfile.mkdtemp(prefix=f".{out.name}.", suffix=".old", dir=out.parent))
    out.rename(aside / "report")
    try:
        partial.rename(out)
    except OSError:
        (aside / "report").rename(out)
        raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _told(plan: Plan, found: Experiment) -> str:
    """What was written and what came out, for the terminal."""
    from tabulate import tabulate

    from . import tables

    lines = [f"report: {plan.out / 'index.html'} ({found.seconds:.0f} s of runs)", ""]
    counts = tables.outcome_counts(found)
    rows = [[name, *(count[o] for o in tables.OUTCOMES)] for name, count in counts.items()]
    lines += [tabulate(rows, headers=["solver", *tables.OUTCOMES], tablefmt="plain"), ""]
    rows = [
        [
            row["case"],
            row["solver"],
            row["route"],
            *(tables.error_text(row, key) for key in ("default_error", "finest_error")),
        ]
        for row in tables.headline_rows(found)
    ]
    headers = ["first transition", "solver", "route", "as it comes / s", "finest / s"]
    lines.append(tabulate(rows, headers=headers, tablefmt="plain", disable_numparse=True))
    lines += [f"no truth for {label}: {truth.failure}" for label, truth in found.truths.items() if truth.failure]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
