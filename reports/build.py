"""The full report: `slip-to-roll report`, or `report([case, …])` from Python.

`options` checks all arguments before any file is written. Slow modules are imported when they are needed, so that help
and errors appear at once.
"""

from __future__ import annotations

import os
import shlex
import sys
from argparse import Namespace
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cases
from cases import CaseError, lookup
from cases.files.command_line import label

from . import options
from .options import BuildPlan

if TYPE_CHECKING:
    from cases import Case

    from .analysis.work_precision import CostMeasurements
    from .running.calls import Calls
    from .running.records import Experiment
    from .studies import Result

COMMAND = "reports.build"


@options.runs(
    COMMAND, "Run cases through solvers and write a report: index.html, tables, figures, manifest.json.", "out",
    "case", "case_file", "solver", "engine", "points", "trajectory", "submissions",
    "quick", "full", "jobs", "dask", "store", "fresh", "paper", "verbose", "list",
    out="report",
    example=f'python -m {COMMAND} --quick --case "disc_in_circle[mu=0.2]" --solver reference exudyn',
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> int:
    """Run the command; returns its exit status.

    0; 1 if the report cannot be written; 2 for invalid arguments; 3 if the report is written but a case has no truth,
    no solver could run a selected case, or nothing ran; 130 if it was interrupted."""
    if arguments.list:
        print(listing(arguments.case_file))
        return 0
    return _build(options.plan_of(arguments, words))


def report(
    cases: Iterable[Case],
    solvers: Iterable[str] | None = None,
    out: str | Path = "report",
    effort: str = "default",
    jobs: int = 2,
    store: str | Path | None = None,
    fresh: bool = False,
) -> Path:
    """Write a report on cases made in a script or notebook; returns the path of its page.

    The arguments are the command's options; each case needs a different name. Raises CaseError for invalid arguments,
    OSError if the report cannot be written.
    """
    plan = options.plan_by_hand(cases, solvers, out, effort, jobs, store, fresh)
    _build(plan)
    return plan.out / "index.html"


def listing(files: Sequence[str]) -> str:
    """Cases with variants and summaries, and solvers with routes, as text. Imports no engine."""
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
            lines.append(f"  {name}: {', '.join(routes(name)) or 'reports its routes when it runs'}")
        except ImportError as problem:
            lines.append(f"  {name}: not installed ({problem})")
        except Exception as problem:  # the source of an adapter can raise anything
            lines.append(f"  {name}: its code cannot be read ({type(problem).__name__}: {problem})")
    return "\n".join(lines)


# --- the report -------------------------------------------------------------------------------------------------------


def _build(plan: BuildPlan) -> int:
    """Make and write the report and print its summary; returns the exit status of `main`."""
    from .running.timing.phase_times import PhaseTimes

    times = PhaseTimes()  # first, so that imports and installations count
    from .page import report_folder
    from .page.text import lost_text
    from .running import cluster, external_motions, versions
    from .running.calls import Calls
    from .running.experiment import run_cases
    from .running.progress import Display, usual
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
        progress = Display(usual(len(plan.cases), timings=plan.effort != "quick", studies=_requested_studies(plan)))
        with (
            progress as display,
            Calls(plan.jobs, plan.limit, store, display, times=times) as calls,
            _machines(plan, calls),
        ):
            calls.begin(plan.solvers)
            local_runs = run_cases(plan.cases, plan.solvers, calls, plan.select_rungs)
            costs = _measure(plan, local_runs, calls)
            study_results = _study(plan, calls)
            experiment = external_motions.join_external(local_runs, plan.trajectories)
            with report_folder.of_report(plan.out).staging(whole=True) as place:
                verdicts, pair_rows = _write(plan, experiment, local_runs, costs, study_results, calls, place)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(store.kept_words()) from None
    except cluster.NoWorkers as problem:
        raise OSError(f"{problem}; {store.kept_words()}") from None
    except OSError as problem:
        raise OSError(f"cannot write the report: {problem}") from problem
    store.trim()
    print(_summary(plan, experiment, verdicts, pair_rows, study_results, calls))
    lacking = _without_truth(experiment) + (_run_by_nobody(experiment) if plan.is_selection else [])
    lacking = lacking or _nothing_ran(experiment)
    for sentence in lacking:
        _say(f"{label(COMMAND)}: {sentence}")
    if calls.interruptions:
        _say(f"{label(COMMAND)}: {lost_text(calls.interruptions)}")
    return 3 if lacking else 0


@contextmanager
def _machines(plan: BuildPlan, calls: Calls) -> Iterator[None]:
    """A context manager in which untimed runs are made on the plan's cluster, if it has one."""
    from .running import cluster_worker
    from .running.cluster import Cluster

    if plan.dask is None:
        yield
        return
    present = calls.present(plan.solvers)
    identity = cluster_worker.identity({name: calls.versions[name] for name in present})
    with closing(Cluster(plan.dask, plan.jobs, identity, present)) as calls.cluster:
        yield


def _without_truth(experiment: Experiment) -> list[str]:
    """A sentence for each case without a truth."""
    return [f"no truth for {label}: {truth.failure}" for label, truth in experiment.truths.items() if truth.failure]


def _run_by_nobody(experiment: Experiment) -> list[str]:
    """A sentence for each case with a truth but without a motion, with the reason of the first solver."""
    done_cases = {run.case for run in experiment.runs if run.outcome == "answered"}
    done_cases |= {label for label, truth in experiment.truths.items() if truth.failure}
    first = {run.case: run for run in reversed(experiment.runs) if run.case not in done_cases}
    return [f"no solver could run {label}; {run.solver} {run.outcome}: {run.reason}" for label, run in first.items()]


def _nothing_ran(experiment: Experiment) -> list[str]:
    """A sentence where no run of the whole report has a motion, with what to install."""
    from .running.solvers import missing_words

    if any(run.outcome == "answered" for run in experiment.runs):
        return []
    return [". ".join(["nothing ran: no solver has a motion", *missing_words(experiment.versions)])]


def _measure(plan: BuildPlan, local_runs: Experiment, calls: Calls) -> CostMeasurements:
    """The timed pass, after all other runs; a quick report has none."""
    from .analysis import null_scores, time_to_accuracy, which_engine
    from .analysis.work_precision import CostMeasurements
    from .running.timing import timed_pass

    if plan.effort == "quick":
        _say("timings: skipped by --quick; CPU times in the tables were measured next to other runs and are not ranked")
        return CostMeasurements()
    full = plan.effort == "full"
    results = timed_pass.measure(local_runs, full, calls)
    labels = tuple(case.label for case in results.cases)
    costs = CostMeasurements(labels, results.timings, null_scores.measure(results.cases, calls), results.failures)
    rows = time_to_accuracy.rows(local_runs, costs)
    # Cold starts and parts of one case only, the first: they take longer than all other timings.
    keys = {key for key in which_engine.cold_start_keys(rows) if full or key[0] == labels[0]}
    extra = timed_pass.measure_extra(local_runs, keys, full, calls)
    return costs._replace(cold=extra.cold, parts=extra.parts)


def _requested_studies(plan: BuildPlan) -> bool:
    """Whether the report has studies: full reports do, default reports only on the whole catalogue."""
    return plan.effort == "full" or (plan.effort == "default" and not plan.is_selection)


def _study(plan: BuildPlan, calls: Calls) -> list[Result]:
    """Run all studies of a report."""
    from . import studies

    if not _requested_studies(plan):
        return []
    full = plan.effort == "full"
    results = []
    for name in studies.names():
        study = studies.study(name)
        if study.IN_REPORT:
            selection = plan.cases if plan.is_selection and "case" in study.TAKES else ()
            solvers = plan.solvers if "solver" in study.TAKES else ()
            words = [name, *(["--case", *(case.label for case in selection)] if selection else [])]
            words += ["--full"] if full else []
            words += ["--case-file", *map(os.path.relpath, plan.files)] if selection and plan.files else []
            words += ["--solver", *solvers] if solvers and set(solvers) != set(options.solvers()) else []
            request = studies.Request(selection, solvers, full)
            results.append(studies.run_study(name, request, calls, options.command("reports.study", words)))
    return results


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _write(
    plan: BuildPlan,
    experiment: Experiment,
    local_runs: Experiment,
    costs: CostMeasurements,
    study_results: Sequence[Result],
    calls: Calls,
    place: Path,
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Write tables, figures, page and manifest into a folder.

    Returns the rows of the verdict and of pairs.
    `local_runs`: the experiment without external motions."""
    from .analysis.table_list import Results
    from .drawing.figure_files import embed_command
    from .page import chapters, html, motions, pictures, report_folder, table_files
    from .page.manifest import manifest
    from .running import external_motions
    from .running.solvers import missing_words
    from .running.timing import phase_times

    command = options.command(COMMAND, plan.argv) if plan.argv or not plan.is_selection else "reports.build.report([…])"
    facts = manifest(local_runs.versions) | {
        "command": command,
        "options": _options(plan),
        "settings": f"effort {plan.effort}, {plan.jobs} at a time, {plan.limit:g} s a run; {calls.store.taken_words()}",
        "store": calls.store.summary(),
        "ladders": plan.ladders() or "All settings of all ladders.",
        "limit_seconds": plan.limit,
        "cases": {case.label: dict(case.parameters) for case in experiment.cases},
        "lost": calls.interruptions,
    }
    facts["not installed"] = "; ".join(missing_words(local_runs.versions))
    facts["solvers"] |= external_motions.sources(plan.trajectories)
    results = Results(local_runs, experiment, costs)
    output = table_files.of_report(results, study_results, local_runs.versions)
    table_files.write(output, place / "tables", command)
    calls.times.book("tables")
    figures = place / "figures"
    entries = pictures.draw(experiment, figures, calls, plan.paper)
    for figure in entries:
        embed_command(figures, figure, html.command_of(figure.case, facts))
    moving = motions.motions(experiment)
    page = html.render(experiment, costs, output.frames, output.words, entries, study_results, moving, place, facts)
    calls.times.book("page")
    # One total for the page, the terminal and the manifest: all phases up to the complete page.
    facts["phases"], facts["seconds"] = (
        phase_times.time_summary(calls.times.phases),
        phase_times.total(calls.times.phases).wall,
    )
    page = page.replace(chapters.TOTAL_TIME, phase_times.total_words(calls.times.phases))
    (place / "index.html").write_text(page, encoding="utf-8", errors="backslashreplace")
    report_folder.sign(place, facts)
    return results.verdicts, results.pairs


def _options(plan: BuildPlan) -> str:
    """The options needed to repeat one case of the report: effort, case files and solvers."""
    words = [] if plan.effort == "default" else [f"--{plan.effort}"]
    if plan.files:
        words += ["--case-file", *(shlex.quote(os.path.relpath(file)) for file in plan.files)]
    if set(plan.solvers) != set(options.solvers()):
        words += ["--solver", *plan.solvers]
    return " ".join(words)


def _summary(
    plan: BuildPlan,
    experiment: Experiment,
    verdicts: Sequence[dict[str, Any]],
    pair_rows: Sequence[dict[str, Any]],
    study_results: Sequence[Result],
    calls: Calls,
) -> str:
    """The text on the terminal at the end: the verdict, the counts, and last the path of the page."""
    from .analysis import tables, verdict_text
    from .running.solvers import missing_words
    from .running.timing import phase_times

    lines = [
        *verdict_text.filled(verdict_text.sentence(verdicts, pair_rows)),
        "",
        verdict_text.in_terminal(verdicts),
        "",
    ]
    lines += [*verdict_text.legend(verdicts), ""]
    many, counts = len(experiment.cases), tables.outcome_counts(experiment)
    lines += [f"{many} case{'s' * (many != 1)}, {len(experiment.runs):,} runs: {counts}"]
    lines += [f"no truth for {label}: {truth.failure}" for label, truth in experiment.truths.items() if truth.failure]
    lines += [f"{result.name} failed: {result.failure}" for result in study_results if result.failure]
    lines += missing_words(experiment.versions)
    store = calls.store
    lines += [f"store: {store.taken_words()}{f'; {store.size_words()}' if plan.verbose else ''}"]
    lines += [f"store: {sentence}" for sentence in store.trouble()]
    total, parts = phase_times.total_words(calls.times.phases), phase_times.parts_words(calls.times.phases)
    lines += [f"the report took {total}{f': {parts}' if plan.verbose else '; --verbose prints more'}"]
    return "\n".join([*lines, str(plan.out / "index.html")])


if __name__ == "__main__":
    sys.exit(main())
