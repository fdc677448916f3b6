"""`python -m reports.sweep CASE --vary mu=0.01:0.5:200 --vary xi1=0:1.5:200`: one row a scenario, and the map."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from cases import BadValue, lookup
from cases.command_line import status
from cases.errors import finite, whole

from . import options

COMMAND = "reports.sweep"


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit status."""
    return status(COMMAND, _work, argv)


def _work(words: list[str]) -> None:
    parser = options.parser(
        COMMAND, "Simulate a case over its parameters: a row for every scenario, in Parquet, and a map.", "vary",
        "sample", "number", "seed", "rtol", "certify", "refine", "solver", "case_file", "out", "jobs", "dask", "fresh",
        words={"CASE": options.A_CASE}, out="sweep",
        example=f"python -m {COMMAND} disc_in_circle --vary mu=0.01:0.5:200 --vary xi1=0:1.5:200",
    )  # fmt: skip
    given = parser.parse_args(words)
    files, _ = options.load_files(given.case_file)
    case = lookup.case_name(given.CASE)
    plan = _plan(given, case.label(), (*files, str(case.file.resolve())) if case.file else files)
    solvers = [name for name in options.choose_solvers(given.solver or ["reference"]) if name != "reference"]
    if versioned := next((name for name in solvers if "@" in name), ""):
        raise BadValue(f"a sweep runs what is installed, not {versioned}; reports.build has versions beside each other")
    jobs = options.whole_jobs(given.jobs)
    width = None if given.refine is None else _width(given.refine, plan)
    _sweep(plan, solvers, jobs, given, width, options.command(COMMAND, words))


def _plan(given, case: str, files: Sequence[str]):
    """The plan of the options; raises CaseError, in one sentence."""
    try:
        from reference.sweeping import plan, table
        from reference.sweeping.plan import MOST
    except ImportError as problem:
        raise BadValue(f"sweeps keep their rows in Parquet ({problem}); install it: pip install pyarrow") from None

    vary = {}
    for text in given.vary:
        name, equals, values = text.partition("=")
        if not equals or not name.strip() or not values.strip():
            raise BadValue(f"--vary {text!r} cannot be read; write --vary parameter=low:high:count")
        if name.strip() in vary:
            raise BadValue(f"--vary {name.strip()} is given twice; give each parameter once")
        vary[name.strip()] = values.strip()
    number = None if given.number is None else whole("--number", _number("--number", given.number), 1, MOST)
    seed, rtol = whole("--seed", _number("--seed", given.seed), 0, MOST), _number("--rtol", given.rtol)
    found = plan(case, vary, given.sample, number, seed, rtol, files)
    table.check_names(found)
    return found


def _number(option: str, text: str) -> float:
    try:
        return finite(option, float(text))
    except ValueError as problem:
        if isinstance(problem, BadValue):
            raise
        raise BadValue(f"{option} is {text!r}; give a number") from None


def _width(text: str, plan) -> float:
    width = _number("--refine", text)
    if not width > 0.0:
        raise BadValue(f"--refine is {width:g}; give a width above zero")
    from .sweeping import boundary_search

    boundary_search.check(plan)
    return width


def _sweep(plan, solvers: Sequence[str], jobs: int, given, width: float | None, command: str) -> None:
    """Make the rows, the boundaries and the maps, and say where they are."""
    from .drawing.figure_files import embed_command
    from .running.processes import cluster
    from .running.processes.progress import Display
    from .sweeping import boundary_search, maps, run
    from .sweeping.folder import Folder

    out = options.check_out(given.out, lambda path: Folder(path, given.fresh))
    if given.dask is not None:
        cluster.check(given.dask)

    ways = {name: run.routes_of(name) for name in solvers}  # raises for an engine that is not there
    folder = Folder(out, given.fresh)
    with folder.exclusive(run.sweep_identity(plan, given.certify)):
        folder.record({"command": command})
        try:
            with Display() as display:
                machines = run.Machines(jobs, given.dask, display)
                made = run.run(plan, folder, given.certify, machines)
                engines: dict[str, str] = {}
                for name in solvers:
                    engines |= run.run_engine(plan, folder, name, ways[name], machines)
            edges = boundary_search.run(plan, folder, width) if width is not None else None
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"what is done is in {out}; give the same command to go on") from None
        counts = maps.counts(folder)
        with folder.staged() as place:
            pictures = [*maps.draw(plan, folder, place, engines, edges)]
            for drawn in pictures:
                embed_command(place, drawn, command)
    for drawn in pictures:
        print(f"{drawn.title}: {out / f'{drawn.name}.svg'}")
    print(f"{len(plan)} scenarios of {plan.name}, {made} of them made now; rows: {out / run.ROWS}")
    for what, count in counts.most_common(12):
        print(f"  {count:>12,}  {what}")
    if edges is not None:
        print(f"boundaries: {out / boundary_search.FILE} ({edges.points} points, {edges.scenarios} more scenarios)")


if __name__ == "__main__":
    sys.exit(main())
