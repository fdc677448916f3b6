"""The full report: `python -m reports.build`, or `report([case, …])` from Python.

`options` checks everything before any file is touched. What is slow to import is imported when it is needed: help and
errors answer at once.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cases
from cases import Case, CaseError, compile_cache, lookup
from cases.command_line import status

from . import options
from .options import BuildPlan

if TYPE_CHECKING:
    from .analysis.work_precision import CostMeasurements
    from .running.calls import Calls
    from .running.per_solver import LeftOut
    from .running.records import Experiment
    from .studies import Result

COMMAND = "reports.build"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status: 0; 2 if what was asked for makes no sense, 1 if the report cannot be
    written, 3 if it is written and a case has no truth, or no solver could run one that was named, 130 if it was
    stopped."""
    return status(COMMAND, _work, argv)


def _work(words: list[str]) -> int:
    parser = options.parser(
        COMMAND, "Run cases through solvers and write a report: index.html, tables, figures, manifest.json.", "out",
        "case", "case_file", "solver", "engine", "trajectory", "submissions",
        "quick", "full", "jobs", "dask", "store", "fresh", "paper", "list",
        out="report",
        example=f'python -m {COMMAND} --quick --case "disc_in_circle[mu=0.2]" --solver reference exudyn',
    )  # fmt: skip
    given = parser.parse_args(words)
    if given.list:
        print(listing(given.case_file))
        return 0
    return _build(options.plan_of(given, words))


def report(
    given: Iterable[Case],
    solvers: Iterable[str] | None = None,
    out: str | Path = "report",
    effort: str = "default",
    jobs: int = 2,
    store: str | Path | None = None,
    fresh: bool = False,
) -> Path:
    """A report on cases made by hand, in a script or a notebook; returns the path of its page.

    The arguments are the command's options; each case has a name of its own. Raises CaseError, in one sentence, for
    what makes no sense, and OSError if the report cannot be written.
    """
    plan = options.plan_by_hand(given, solvers, Path(out), effort, jobs, None if store is None else Path(store), fresh)
    _build(plan)
    return plan.out / "index.html"


def listing(files: Sequence[str]) -> str:
    """Cases with variants and summaries, solvers with routes. Imports no engine."""
    from .running.solvers import routes

    options.load_files(files)
    lines = ["cases"]
    for name in cases.names():
        lines.append(f"  {name}: {cases.entry(name).summary}")
        try:
            lines += [f"    {case.label}" for case in lookup.case_name(name).every()]
        except CaseError as problem:
            lines.append(f"    cannot be made: {problem}")
    lines.append("solvers")
    for name in options.solvers():
        try:
            lines.append(f"  {name}: {', '.join(routes(name)) or 'says its routes when it is run'}")
        except ImportError as problem:
            lines.append(f"  {name}: not installed ({problem})")
        except Exception as problem:  # its file may hold anything
            lines.append(f"  {name}: its code cannot be read ({type(problem).__name__}: {problem})")
    return "\n".join(lines)


# --- the report -------------------------------------------------------------------------------------------------------


def _build(plan: BuildPlan) -> int:
    """Make and write the report, and say what came out; the command's status: 3 if a case has no truth, or one that was
    named was run by nobody."""
    from .drawing.figure_files import for_print
    from .page import folder
    from .page.text import lost_text
    from .running import experiment, external_motions, versions
    from .running.calls import Calls
    from .running.processes import cluster
    from .running.processes.progress import Display, usual
    from .running.storage.result_store import Store

    if plan.dask is not None:
        cluster.check(plan.dask)
    store = Store(plan.store, plan.fresh)
    many = f"{len(plan.cases)} case{'s' * (len(plan.cases) != 1)}"
    _say(f"{many}, solvers {', '.join(plan.solvers)}, {plan.effort} effort, {plan.jobs} at a time")
    if store.problem():
        _say(f"store: {store.problem()}")
    versions.make(plan.solvers, _say)
    try:
        shown_by = Display(usual(len(plan.cases), timed=plan.effort != "quick", studied=_requested_studies(plan)))
        with shown_by as display, Calls(plan.jobs, plan.limit, store, display) as calls, _machines(plan, calls):
            calls.begin(plan.solvers)
            ran = experiment.run(plan.cases, plan.solvers, calls, plan.select_rungs)
            measured = _measure(plan, ran, calls)
            studied = _study(plan, calls)
            shown = external_motions.join_external(ran, plan.trajectories)
            with folder.of_report(plan.out).staged(whole=True) as place, for_print(plan.paper):
                verdicts, left_out = _write(plan, shown, ran, measured, studied, calls, place)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(store.kept_words()) from None
    except cluster.NoWorkers as problem:
        raise OSError(f"{problem}; {store.kept_words()}") from None
    except OSError as problem:
        raise OSError(f"cannot write the report: {problem}") from problem
    store.trim()
    print(_summary(plan, shown, verdicts, studied, left_out, calls))
    lacking = _without_truth(shown) + (_run_by_nobody(shown) if plan.named else [])
    for sentence in lacking:
        _say(f"{COMMAND}: {sentence}")
    if calls.lost:
        _say(f"{COMMAND}: {lost_text(calls.lost)}")
    return 3 if lacking else 0


@contextmanager
def _machines(plan: BuildPlan, calls: Calls) -> Iterator[None]:
    """Runs that are not timed are made on the plan's cluster, if it has one, in the block."""
    from .running.processes import cluster_worker
    from .running.processes.cluster import Cluster

    if plan.dask is None:
        yield
        return
    present = calls.present(plan.solvers)
    identity = cluster_worker.identity({name: calls.versions[name] for name in present})
    with closing(Cluster(plan.dask, plan.jobs, identity, present)) as calls.cluster:
        yield


def _without_truth(shown: Experiment) -> list[str]:
    """A sentence for each case that nothing could be judged by."""
    return [f"no truth for {label}: {truth.failure}" for label, truth in shown.truths.items() if truth.failure]


def _run_by_nobody(shown: Experiment) -> list[str]:
    """A sentence for each case of which no run is a motion though it has a truth, with what the first solver says."""
    moved = {run.case for run in shown.runs if run.outcome in ("right", "wrong")}
    moved |= {label for label, truth in shown.truths.items() if truth.failure}
    first = {run.case: run for run in reversed(shown.runs) if run.case not in moved}
    return [f"no solver could run {label}; {run.solver} {run.outcome}: {run.reason}" for label, run in first.items()]


def _measure(plan: BuildPlan, ran: Experiment, calls: Calls) -> CostMeasurements:
    """The timed pass, after everything else has ended; a quick report goes without."""
    from .analysis import baselines, time_to_accuracy, which_engine, work_precision
    from .analysis.work_precision import CostMeasurements
    from .running import per_solver
    from .running.timing import timings

    if plan.effort == "quick":
        _say("timings: skipped by --quick; CPU times of the tables were taken beside other runs and rank nothing")
        return CostMeasurements()
    full = plan.effort == "full"
    timed = timings.measure(ran, full, calls)
    labels = tuple(case.label for case in timed.cases)
    measured = CostMeasurements(labels, timed.timings, baselines.measure(timed.cases, calls), timed.failures)
    points = work_precision.work_precision_rows
    told, _ = per_solver.make_per_solver(
        lambda *some: time_to_accuracy.rows(points(*some)), (ran, measured), per_solver.solvers_of(ran)
    )
    beside = timings.beside(ran, which_engine.cold_start_keys(told), full, calls)
    return measured._replace(cold=beside.cold, parts=beside.parts)


def _requested_studies(plan: BuildPlan) -> bool:
    """A quick report has none, nor one where cases were named, unless it is a full one."""
    return plan.effort == "full" or (plan.effort == "default" and not plan.named)


def _study(plan: BuildPlan, calls: Calls) -> list[Result]:
    """All studies of a report."""
    from . import studies

    if not _requested_studies(plan):
        return []
    full = plan.effort == "full"
    results = []
    for name in studies.names():
        study = studies.study(name)
        if study.IN_REPORT:
            chosen = plan.cases if plan.named and "case" in study.TAKES else ()
            solvers = plan.solvers if "solver" in study.TAKES else ()
            words = [name, *(["--case", *(case.label for case in chosen)] if chosen else [])]
            words += ["--full"] if full else []
            words += ["--case-file", *map(os.path.relpath, plan.files)] if chosen and plan.files else []
            words += ["--solver", *solvers] if solvers and set(solvers) != set(options.solvers()) else []
            request = studies.Request(chosen, solvers, full)
            results.append(studies.run(name, request, calls, options.command("reports.study", words)))
    return results


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _write(
    plan: BuildPlan,
    shown: Experiment,
    ran: Experiment,
    measured: CostMeasurements,
    studied: Sequence[Result],
    calls: Calls,
    place: Path,
) -> tuple[list[dict[str, Any]], list[LeftOut]]:
    """Tables, figures, page and manifest into a folder; returns the rows of the verdict, and what was made without
    a solver's results since with them it fails. `ran`: what was run here, without what is external."""
    from .drawing.figure_files import embed_command
    from .page import folder, html, motions, pictures, tables
    from .page.manifest import manifest
    from .running import external_motions, per_solver
    from .running.solvers import missing_words
    from .running.timing import phase_times

    command = options.command(COMMAND, plan.argv) if plan.argv or not plan.named else "reports.build.report([…])"
    told = manifest(ran.versions) | {
        "command": command,
        "options": _options(plan),
        "settings": f"effort {plan.effort}, {plan.jobs} at a time, {plan.limit:g} s a run; {calls.store.taken_words()}",
        "store": calls.store.told(),
        "compiled": compile_cache.words(),
        "ladders": plan.ladders() or "All settings of all ladders.",
        "limit_seconds": plan.limit,
        "cases": {case.label: dict(case.parameters) for case in shown.cases},
        "lost": calls.lost,
    }
    told["not installed"] = "; ".join(missing_words(ran.versions))
    told["solvers"] |= external_motions.sources(plan.trajectories)
    made = tables.Tables(place / "tables", command, ran.versions, plan.paper)
    rows = tables.write(made, shown, ran, measured, studied)
    calls.spent.book("tables")
    figures = place / "figures"
    drawn, of_studies = pictures.draw(shown, ran, measured, studied, figures, calls)
    for figure in drawn:
        embed_command(figures, figure, html.command_of(figure.case, told))
    for result in studied:
        for figure in of_studies[result.name]:
            embed_command(figures, figure, result.command)
    moving, unmoved = motions.motions(shown)
    made.note([*unmoved, *(one for some in (drawn, *of_studies.values()) for each in some for one in each.left_out)])

    # The page shows the time of the report up to itself; the manifest has the whole.
    told["seconds"] = phase_times.total(calls.spent.phases).wall

    def rendered(
        shown: Experiment, measured: CostMeasurements, frames: dict[str, Any], studied: Sequence[Result]
    ) -> str:
        frames |= {tables.OMISSIONS: made.frames[tables.OMISSIONS]} if made.left_out else {}
        return html.render(shown, measured, frames, made.words, drawn, studied, of_studies, moving, figures, told)

    records = (shown, measured, dict(made.frames), tuple(studied))
    page, left = per_solver.make_per_solver(rendered, records, per_solver.solvers_of(shown), "the page")
    if left:
        made.note(left)
        page = rendered(*(per_solver.without(each, {one.solver for one in left}) for each in records))
    tables.describe(made)
    (place / "index.html").write_text(page, encoding="utf-8", errors="backslashreplace")
    calls.spent.book("page")
    told["phases"], told["seconds"] = (
        phase_times.time_summary(calls.spent.phases),
        phase_times.total(calls.spent.phases).wall,
    )
    told["left_out"] = [one._asdict() for one in made.left_out]
    folder.sign(place, told)
    return rows, made.left_out


def _options(plan: BuildPlan) -> str:
    """The options that matter when one case is to be made again: effort, case files and solvers."""
    words = [] if plan.effort == "default" else [f"--{plan.effort}"]
    if plan.files:
        words += ["--case-file", *(shlex.quote(os.path.relpath(file)) for file in plan.files)]
    if set(plan.solvers) != set(options.solvers()):
        words += ["--solver", *plan.solvers]
    return " ".join(words)


def _summary(
    plan: BuildPlan,
    shown: Experiment,
    verdicts: Sequence[dict[str, Any]],
    studied: Sequence[Result],
    left_out: Sequence[LeftOut],
    calls: Calls,
) -> str:
    """What a terminal is told at the end: the answer, the counts, and last of all the path to open."""
    from .analysis import tables, verdict
    from .running.solvers import missing_words
    from .running.timing import phase_times

    lines = [verdict.in_terminal(verdicts), "", *verdict.notes(verdicts), "", verdict.sentence(verdicts), ""]
    counts = tables.outcome_counts(shown)
    total = {outcome: sum(count[outcome] for count in counts.values()) for outcome in tables.OUTCOMES}
    count = ", ".join(f"{count} {outcome}" for outcome, count in total.items() if count)
    many = len(shown.cases)
    lines += [f"{many} case{'s' * (many != 1)}, {len(shown.runs):,} runs in {shown.seconds:.0f} s: {count}"]
    lines += [f"no truth for {label}: {truth.failure}" for label, truth in shown.truths.items() if truth.failure]
    lines += [f"{result.name} failed: {result.failure}" for result in studied if result.failure]
    lines += [f"{one.item} made without {one.solver}: {one.reason}" for one in left_out]
    lines += missing_words(shown.versions)
    store = calls.store
    lines += [
        f"store: {store.taken_words()}; {store.size_words()}",
        f"cache: {compile_cache.place() or 'off'}; {compile_cache.words()}",
    ]
    lines += [f"store: {sentence}" for sentence in store.trouble()]
    lines += [phase_times.words(calls.spent.phases)]
    return "\n".join([*lines, str(plan.out / "index.html")])


if __name__ == "__main__":
    sys.exit(main())
