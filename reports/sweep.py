"""`slip-to-roll sweep CASE --vary mu=0.01:0.5:200 --vary xi1=0:1.5:200`: a row per scenario, and maps."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Sequence

from cases import BadValue, lookup
from cases.errors import finite, number_in, positive, whole_in

from . import options

COMMAND = "reports.sweep"
# Exit status, as that of a report: no scenario has a motion, or none of the engines asked for an answer.
NOTHING_RAN = 3


@options.runs(
    COMMAND, "Simulate a case for many parameter values: a row per scenario, in Parquet, and a map.", "vary",
    "sample", "number", "seed", "rtol", "certify", "refine", "solver", "case_file", "out", "jobs", "dask", "fresh",
    "paper", "json",
    words={"CASE": options.A_CASE}, out="sweep",
    example=f"python -m {COMMAND} disc_in_circle --vary mu=0.01:0.5:200 --vary xi1=0:1.5:200",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> int:
    """Check the options, make the sweep and print its files; returns the exit status."""
    files, _ = options.load_files(arguments.case_file)
    case = lookup.case_name(arguments.CASE)
    plan = _plan(arguments, case.label(), (*files, str(case.file.resolve())) if case.file else files)
    solvers = [name for name in options.choose_solvers(arguments.solver or ["reference"]) if name != "reference"]
    if with_version := next((name for name in solvers if "@" in name), ""):
        raise BadValue(f"a sweep runs the installed engines, not {with_version}; reports.build compares versions")
    jobs = options.whole_jobs(arguments.jobs)
    width = None if arguments.refine is None else _width(arguments.refine, plan)
    return _sweep(plan, solvers, jobs, arguments, width, options.command(COMMAND, words))


def _plan(arguments, case: str, files: Sequence[str]):
    """The plan of the options; raises CaseError for invalid ones."""
    try:
        from reference.sweeping import plan, table
        from reference.sweeping.plan import MOST
    except ImportError as problem:
        raise BadValue(f"sweeps store their rows in Parquet ({problem}); install it: pip install pyarrow") from None

    vary = {}
    for text in arguments.vary:
        name, equals, values = text.partition("=")
        if not equals or not name.strip() or not values.strip():
            raise BadValue(f"--vary {text!r} cannot be read; write --vary parameter=low:high:count")
        if name.strip() in vary:
            raise BadValue(f"--vary {name.strip()} is given twice; give each parameter once")
        vary[name.strip()] = values.strip()
    number = None if arguments.number is None else whole_in("--number", arguments.number, 1, MOST)
    seed = whole_in("--seed", arguments.seed, 0, MOST)
    rtol = finite("--rtol", number_in("--rtol", arguments.rtol))
    sweep_plan = plan(case, vary, arguments.sample, number, seed, rtol, files)
    table.check_names(sweep_plan)
    return sweep_plan


def _width(text: str, plan) -> float:
    width = positive("--refine", number_in("--refine", text))
    from .sweeping import boundary_search

    boundary_search.check(plan)
    return width


def _sweep(plan, solvers: Sequence[str], jobs: int, arguments, width: float | None, command: str) -> int:
    """Make the rows, the boundaries and the maps, and print their paths and the summary; returns the exit status."""
    from .drawing.figure_files import embed_command
    from .running import cluster
    from .running.progress import Display
    from .sweeping import boundary_search, computation, map_figures, summary
    from .sweeping.sweep_folder import Folder

    out = options.check_out(arguments.out, lambda path: Folder(path, arguments.fresh))
    if arguments.dask is not None:
        cluster.check(arguments.dask)

    ways = {name: computation.routes_of(name) for name in solvers}  # raises for an engine that is not installed
    folder = Folder(out, arguments.fresh)
    with folder.exclusive(computation.sweep_identity(plan, arguments.certify)):
        folder.record({"command": command})
        try:
            with Display() as display:
                machines = computation.Machines(jobs, arguments.dask, display)
                new_count = computation.run_reference(plan, folder, arguments.certify, machines)
                engines: dict[str, str] = {}
                for name in solvers:
                    engines |= computation.run_engine(plan, folder, name, ways[name], machines)
            edges = boundary_search.search_and_write(plan, folder, width) if width is not None else None
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"finished rows are in {out}; give the same command to continue") from None
        result = summary.summary(folder, engines)
        with folder.staging() as place:
            pictures = [*map_figures.draw(plan, folder, place, engines, edges, arguments.paper)]
            for figure in pictures:
                embed_command(place, figure, command)
    files = {figure.title: str(out / f"{figure.name}.svg") for figure in pictures}
    if arguments.json:
        counts = {"case": plan.name, "scenarios": len(plan), "made_now": new_count, "rows": str(out / computation.ROWS)}
        edge = None if edges is None else {"file": str(out / boundary_search.FILE), "points": edges.points}
        print(options.json_of({**counts, **summary.as_dict(result), "boundaries": edge, "figures": files}))
    else:
        print("\n".join(f"{title}: {file}" for title, file in files.items()))
        print(f"{len(plan)} scenarios of {plan.name}, {new_count} of them made now; rows: {out / computation.ROWS}")
        print(summary.as_text(result))
        if edges is not None:
            print(f"boundaries: {out / boundary_search.FILE} ({edges.points} points, {edges.scenarios} more scenarios)")
    return 0 if result.ran else NOTHING_RAN


if __name__ == "__main__":
    sys.exit(main())
