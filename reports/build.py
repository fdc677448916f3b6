"""The command: `python -m reports.build`. The only writer of files; `plan` checks everything before it touches any.

The report is written into a folder beside its place and moved there when it is whole, so that a partial one is never
taken for it. What is slow to import is imported when it is needed: help and errors answer at once.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from cases import CaseError

from .options import MADE_BY, Plan, listing, parser, plan_of, solvers, strangers

if TYPE_CHECKING:
    from .analysis.work_precision import Measured
    from .running.records import Experiment
    from .running.store import Store
    from .studies import Study

# A report is written in a minute or two: a part of one that is a day old (s) was left by a build that was killed.
_LEFT_BEHIND = 86400.0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status: 0; 2 if what was asked for makes no sense, 1 if the report cannot be
    written, 130 if it was stopped."""
    argv = list(sys.argv[1:] if argv is None else argv)
    try:
        options = parser().parse_args(argv)
        if options.list:
            print(listing(options.case_file))
            return 0
        plan = plan_of(options, argv)
    except CaseError as problem:
        print(f"reports.build: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("reports.build: stopped before anything was run", file=sys.stderr)
        return 130
    from .running.store import Store

    store = Store(plan.store, plan.fresh)
    try:
        _build(plan, store)
    except KeyboardInterrupt:
        # A progress bar may stand on the line.
        print(f"\nreports.build: stopped; {store.kept_words()}", file=sys.stderr)
        return 130
    except OSError as problem:
        print(f"reports.build: cannot write the report: {problem}", file=sys.stderr)
        return 1
    return 0


# --- the report -------------------------------------------------------------------------------------------------------


def _build(plan: Plan, store: Store) -> None:
    from . import studies
    from .running import experiment as xp
    from .running.calls import Recall

    _say(f"{len(plan.cases)} cases, solvers {', '.join(plan.solvers)}, {plan.effort} effort, {plan.jobs} at a time")
    if store.problem():
        _say(f"store: {store.problem()}")
    found = xp.run(plan.cases, plan.solvers, plan.files, plan.thin, plan.jobs, plan.limit, progress, store)
    measured = _measure(plan, found, store)
    studied = studies.run(plan, progress, Recall(store, found.versions).run)
    shown = _with_trajectories(plan, found)
    plan.out.parent.mkdir(parents=True, exist_ok=True)
    _sweep(plan.out)
    partial = Path(tempfile.mkdtemp(prefix=f".{plan.out.name}.", suffix=".partial", dir=plan.out.parent))
    try:
        _write(plan, shown, found, measured, studied, store, partial)
        _move(partial, plan.out)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    store.trim()
    print(_told(plan, shown, store))


def _with_trajectories(plan: Plan, found: Experiment) -> Experiment:
    """What was found here, and what others found."""
    if not plan.trajectories:
        return found
    from .running import external as elsewhere

    return elsewhere.joined(found, plan.trajectories)


def _measure(plan: Plan, found: Experiment, store: Store) -> Measured:
    """The timed pass, after everything else has ended; a quick report goes without."""
    from .analysis import work_precision as precision

    if plan.effort == "quick":
        _say("timings: skipped by --quick; CPU times of the tables were taken beside other runs and rank nothing")
        return precision.Measured()
    return precision.measure(found, plan.files, plan.effort == "full", progress, store)


def progress(step: str, total: int, answers: Iterator) -> Iterator:
    """Hands on the answers, with a bar on the terminal: how many of `total` are there, and the time left."""
    from tqdm import tqdm

    # A terminal sees the bar move; a log file gets a line now and then.
    often = 0.2 if sys.stderr.isatty() else 10.0
    return iter(tqdm(answers, desc=step, total=total, mininterval=often, dynamic_ncols=True))


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _write(
    plan: Plan,
    found: Experiment,
    timed: Experiment,
    measured: Measured,
    studied: Sequence[Study],
    store: Store,
    folder: Path,
) -> None:
    """Tables, figures, page and manifest into the folder; `timed`: what was found here, not elsewhere."""
    from . import studies
    from .analysis import tables
    from .analysis import work_precision as precision
    from .drawing import figures
    from .drawing import style as drawing
    from .drawing import work_precision as precision_figures
    from .page import html as webpage
    from .page.manifest import manifest
    from .running import external as elsewhere

    folder.chmod(0o755)  # mkdtemp's folders are private; a report is for reading
    _say("tables")
    frames = tables.frames(found) | precision.frames(timed, measured)
    tables.write(frames, folder / "tables", _command(plan))
    for study in studied:
        tables.write(study.frames, folder / "tables", study.command)
        frames |= study.frames
    count = 1 + 3 * len(found.cases)
    drawn = list(progress("figures", count, figures.draw(found, folder / "figures", plan.files, plan.jobs)))
    drawn += precision_figures.draw(timed, measured, folder / "figures")
    pictures = studies.drawn(studied, folder / "figures")
    _say("page")
    told = manifest(timed.versions)
    told["solvers"] |= elsewhere.sources(plan.trajectories)
    told |= {
        "made_by": MADE_BY,
        "command": _command(plan),
        "options": _options(plan),
        "settings": f"effort {plan.effort}, {plan.jobs} at a time, {plan.limit:g} s a run; {store.taken_words()}",
        "store": store.told(),
        "limit_seconds": plan.limit,
        "seconds": found.seconds,
        "cases": {case.label: dict(case.parameters) for case in found.cases},
    }
    for figure in drawn:
        drawing.sign(folder / "figures", figure, webpage.command_of(figure.case, told))
    for study in studied:
        for figure in pictures[study.name]:
            drawing.sign(folder / "figures", figure, study.command)
    page = webpage.render(found, measured, frames, drawn, (studied, pictures), folder / "figures", told)
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
    if set(plan.solvers) != set(solvers()):
        words += ["--solver", *plan.solvers]
    return " ".join(words)


def _sweep(out: Path) -> None:
    """Remove what a build that was killed left beside the report."""
    for left in out.parent.glob(f".{out.name}.*.partial"):
        with suppress(OSError):  # another build may be at it, or it is somebody else's: it harms nobody
            if time.time() - left.stat().st_mtime > _LEFT_BEHIND:
                shutil.rmtree(left)


def _move(partial: Path, out: Path) -> None:
    """Put the whole report in its place; an older one is kept aside until it stands."""
    strange = strangers(out)
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


def _told(plan: Plan, found: Experiment, store: Store) -> str:
    """What was written and what came out, for the terminal."""
    from tabulate import tabulate

    from .analysis import tables

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
    lines += ["", f"store: {store.taken_words()}; {store.size_words()}"]
    lines += [f"store: {sentence}" for sentence in store.trouble()]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
