"""The options of all commands: one parser, with checks before anything runs. An option has one meaning everywhere.

All functions here are fast; slow modules are imported when they are needed.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import adapters
import cases
from cases import BadValue, lookup
from cases.errors import boolean, choice, instance, items, not_negative, number_in, whole_in
from cases.files.command_line import Parser, program, status
from cases.files.owned_folder import OwnedFolder, TemporaryFolder
from cases.files.user_files import place

from .page import report_folder
from .running import ladder_selection
from .running.names import REFERENCE
from .running.time_limits import RUN_SECONDS

if TYPE_CHECKING:
    from adapters import Setting
    from cases import Case

    from .running.external_motions import External

# The store is in the working folder, like the caches of test runners and linters.
STORE = ".slip-to-roll"
# Largest number of jobs; each is a process that imports every engine, about 200 MB.
MOST_JOBS = 256
# Range of --points: a line has two, and the text of a scene with the most has 25 MB.
FEWEST_POINTS, MOST_POINTS = 2, 100_000
# Help for an argument that is one case.
A_CASE = 'a case: name, "name[parameter=value,…]", FILE.py or FILE.py:FUNCTION'


def _switch(words: str) -> dict[str, Any]:
    return dict(action="store_true", help=words)


def _value(metavar: str, words: str, default: str | None = None) -> dict[str, Any]:
    return dict(metavar=metavar, help=words, default=default)


def _values(metavar: str, words: str, default: list[str] | None = None) -> dict[str, Any]:
    """Several values after one option, which can be repeated."""
    return dict(metavar=metavar, nargs="+", action="extend", help=words, default=default)


def _repeated(metavar: str, words: str) -> dict[str, Any]:
    return dict(metavar=metavar, action="append", help=words, default=[])


# Options by name, with their arguments for argparse. Commands select from these and add no others. After a space: of
# which commands an option is, where it is a file of one and a folder of others.
_OPTIONS: dict[str, dict[str, Any]] = {
    "out": _value("DIR", "folder to write"),
    "out file": _value("FILE", "file to write"),
    "case": _values(
        "NAME", 'cases: a name (all its variants), "name[parameter=value,…]", FILE.py or FILE.py:FUNCTION '
        "(default: all, or those of --case-file)",
    ),
    "case_file": _values("FILE", "Python files with cases of your own, marked with @case", []),
    "solver": _values("NAME", "solvers (default: all); ENGINE@VERSION for one"),
    "engine": _values(
        "FILE", "executables to run as engines (docs/process_protocol.md), in addition to the solvers", []
    ),
    "points": _value("N", "points of track and outline in the scene that executables read and export writes (1001)"),
    "trajectory": _repeated(
        "NAME[@CASE]=FILE", "an exported motion (columns t, x, y, theta, …) as a separate solver; can be repeated"
    ),
    "submissions": _value(
        "DIR", "folder of submitted motions, ENGINE/VERSION/CASE.csv; each version is a separate solver"
    ),
    "engines": _switch("also draw the motions and errors of all engines; they run first, except those in --store"),
    "creep": _value(
        "SPEED", "creep velocity of the solver while it sticks, m/s; the file may also contain it, in a column creep "
        "or a first line such as '# creep = 5e-3'", "0",
    ),
    "quick": _switch("three cases, one variant each, fewer settings"),
    "full": _switch("every setting of every case, with ten times the time limit"),
    "jobs": _value("N", "number of concurrent runs (default: 2)", "2"),
    "store": _value("DIR", f"folder that stores finished runs for reuse (default: {STORE}); it may be deleted"),
    "fresh": _switch("run everything again, without stored results"),
    "paper": _switch("figures also as PDF"),
    "force": _switch("replace existing files"),
    "verbose": _switch("print more: a second table, where the time went, and the store"),
    "list": _switch("print cases and solvers, and stop"),
    "vary": _repeated(
        "PARAMETER=VALUES", "low:high:count, low:high:count:log, or a,b,c; low:high for random samples; several form a "
        "grid",
    ),
    "sample": _value("HOW", "grid, random or sobol (default: grid)", "grid"),
    "number": _value("N", "number of scenarios, for random and sobol"),
    "seed": _value("N", "seed of random and sobol (default: 0)", "0"),
    "rtol": _value("R", "relative tolerance of the reference (default: 1e-10)", "1e-10"),
    "certify": _switch("compute certified error bars (seconds per scenario)"),
    "baseline": _value("DIR", "folder of the report to compare with"),
    "worse_than": _value("SHARE", "growth of an error that is accepted, as 10%% or 0.1"),
    "from_source": _switch(
        "compile versions without a wheel for this Python, by the package's own build; needs a C compiler"
    ),
    "format": _value("NAME", "text, json or junit (default: text)", "text"),
    "json": _switch("print JSON"),
    "refine": _value("WIDTH", "locate the boundaries between outcomes to this width in the first varied parameter"),
    "dask": _value("ADDRESS", 'a Dask scheduler, as tcp://host:port, or "local" for a cluster on this machine'),
}  # fmt: skip


def parser(
    command: str,
    description: str,
    *options: str,
    words: Mapping[str, str] | None = None,
    example: str = "",
    **defaults: Any,
) -> Parser:
    """The parser of a command with the selected options.

    `words`: positional arguments with their help; if there are several, an option takes one value at a time and can be
    repeated. `defaults`: the command's own default values.
    """
    parser = Parser(
        prog=program(command),
        description=description,
        epilog=example and f"Example: {example.replace(f'python -m {command}', program(command))}",
    )
    effort = parser.add_mutually_exclusive_group() if {"quick", "full"} <= {*options} else parser
    for option in options:
        how = dict(_OPTIONS[option])
        if option in defaults:
            how = how | {"default": defaults[option], "help": f"{how['help']} (default: {defaults[option]})"}
        if words and len(words) > 1 and how.get("nargs") == "+":
            how |= {"nargs": None, "action": "append"}
        flag = f"--{option.partition(' ')[0].replace('_', '-')}"
        (effort if option in ("quick", "full") else parser).add_argument(flag, **how)
    for name, text in (words or {}).items():
        parser.add_argument(name.strip("*"), metavar=name.strip("*"), help=text, nargs="*" if "*" in name else None)
    return parser


def runs(
    module: str, says: str, *options: str, words: Mapping[str, str] | None = None, example: str = "", **defaults: Any
) -> Callable[[Callable[[argparse.Namespace, list[str]], int | None]], Callable[..., int]]:
    """A decorator that makes a command of a function of parsed arguments and the words of the command line: its `main`,
    which takes the words (default: those of the process) and returns the exit status. `parser` has the arguments."""

    def as_command(work: Callable[[argparse.Namespace, list[str]], int | None]) -> Callable[..., int]:
        def main(argv: Sequence[str] | None = None) -> int:
            def parse_and_work(given: list[str]) -> int | None:
                arguments = parser(module, says, *options, words=words, example=example, **defaults).parse_args(given)
                return work(arguments, given)

            return status(module, parse_and_work, argv)

        main.__doc__ = work.__doc__
        return main

    return as_command


def command(module: str, words: Sequence[str]) -> str:
    """The command line that repeats a command."""
    return " ".join([program(module), *map(_quoted, words)])


def _quoted(word: str) -> str:
    """A word for the shell; characters that a terminal acts on are spelled out, as bash and zsh read them."""
    if word.isprintable():
        return shlex.quote(word)
    return "$'" + "".join(c if c.isprintable() and c not in "'\\" else f"\\U{ord(c):08x}" for c in word) + "'"


@dataclass(frozen=True)
class BuildPlan:
    """The checked arguments of a report."""

    out: Path
    cases: tuple[Case, ...]
    files: tuple[str, ...]
    solvers: tuple[str, ...]
    effort: str
    jobs: int
    argv: tuple[str, ...]
    is_selection: bool  # whether the user selected cases; else the whole catalogue
    store: Path | None = None  # folder of the store of finished runs
    fresh: bool = False  # whether stored results are ignored
    trajectories: tuple[External, ...] = ()
    paper: bool = False  # whether figures are also written as PDF
    dask: str | None = None  # scheduler of the cluster for untimed runs
    verbose: bool = False  # whether the terminal shows details
    points: int | None = None  # points of each curve in the scenes of `own_engines`
    own_engines: tuple[str, ...] = ()  # the executables of --engine

    @property
    def limit(self) -> float:
        """Time limit of a run, wall seconds."""
        return RUN_SECONDS[self.effort]

    def select_rungs(self, case: str, solver: str, route: str, settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
        """The settings to run (`ladder_selection.select_rungs`)."""
        rungs = ladder_selection.select_rungs(self.effort, self.is_selection, case, solver, route, settings)
        if self.points is None or solver not in self.own_engines:
            return rungs
        return tuple(setting.but(points=self.points) for setting in rungs)

    def ladders(self) -> str:
        """Which settings are run, as a sentence; "" if all are."""
        return ladder_selection.sentence(self.effort, self.is_selection)


def solvers() -> tuple[str, ...]:
    """Names of all solvers: the reference, then the engines in alphabetical order."""
    return (REFERENCE, *adapters.engines())


def plan_of(options: argparse.Namespace, argv: Sequence[str]) -> BuildPlan:
    """Check parsed options and return the plan; raises CaseError for invalid ones."""
    effort = "quick" if options.quick else "full" if options.full else "default"
    own_engines = register_engines(options.engine)
    jobs, solver_names = whole_jobs(options.jobs), choose_solvers([*(options.solver or solvers()), *own_engines])
    files, own = load_files(options.case_file)
    out = check_out(options.out)
    store = check_store(options.store, out)
    names = options.case or own
    case_list, more = choose_cases(
        names or (ladder_selection.QUICK_CASES if effort == "quick" else cases.names(hard=False)), effort
    )
    external = _trajectories(options.trajectory, case_list) + _submissions(options.submissions, case_list)
    is_selection = bool(names)
    points = points_of(options.points)
    if points is not None and not own_engines:
        raise BadValue("--points is for executables; give it with --engine FILE")
    if options.dask is not None and own_engines:
        raise BadValue("--engine files exist on this machine only, and --dask runs on others; give one of the two")
    files = tuple(dict.fromkeys((*files, *more)))
    return BuildPlan(
        out, case_list, files, solver_names, effort, jobs, tuple(argv), is_selection, store, options.fresh, external,
        options.paper, options.dask, options.verbose, points, own_engines,
    )  # fmt: skip


def plan_by_hand(
    own_cases: Iterable[Case],
    solvers: Iterable[str] | None,
    out: str | Path,
    effort: str,
    jobs: int,
    store: str | Path | None,
    fresh: bool,
) -> BuildPlan:
    """The plan of a report on cases made in Python, with the same checks; raises CaseError."""
    from cases import Case  # imports SymPy, which a command's help does not need

    case_list = tuple(instance("item of cases", case, Case) for case in items("cases", own_cases))
    labels = [case.label for case in case_list]
    twice = next((label for label in labels if labels.count(label) > 1), "")
    if not case_list:
        raise BadValue("there is no case; give at least one")
    if twice:
        raise BadValue(f"two cases have the name {twice!r}; give each a different name=")
    choice("effort", effort, RUN_SECONDS)
    solver_names, folder = choose_solvers(solvers), check_out(out)
    return BuildPlan(
        folder,
        case_list,
        (),
        solver_names,
        effort,
        whole_jobs(str(jobs)),
        (),
        True,
        check_store(store, folder),
        boolean("fresh", fresh),
    )


def register_engines(files: Iterable[str]) -> tuple[str, ...]:
    """The names of executables, registered as engines; raises BadValue, also where an engine is not installed."""
    try:
        return tuple(adapters.lookup.register(file) for file in files)
    except ImportError as problem:
        raise BadValue(str(problem)) from problem


def choose_solvers(names: Iterable[str] | None) -> tuple[str, ...]:
    """Each named solver once, or all; raises UnknownName, and BadValue for a version that cannot be used."""
    selection = solvers() if names is None else items("solvers", names)
    solver_names = tuple(dict.fromkeys(instance("name of a solver", name, str) for name in selection))
    if not solver_names:
        raise BadValue("there is no solver; give at least one")
    for name in solver_names:
        engine, mark, _ = name.partition("@")
        choice("solver", engine, solvers())
        if mark:
            from .running import versions

            versions.check(name)
    return solver_names


def load_files(files: Sequence[str]) -> tuple[tuple[str, ...], list[str]]:
    """Load case files into the catalogue; returns their paths and the names of their cases."""
    names = [name for file in files for name in lookup.load_file(file)]
    return tuple(str(Path(file).resolve()) for file in files), names


def _trajectories(texts: Sequence[str], case_list: Sequence[Case]) -> tuple[External, ...]:
    if not texts:
        return ()
    from .running import external_motions

    return external_motions.from_options(texts, case_list, solvers())


def creep_of(text: str) -> float:
    """Parse a speed in m/s; raises BadValue unless it is a number of at least 0."""
    return not_negative("--creep, a speed in m/s,", number_in("--creep", text))


def is_json(arguments: argparse.Namespace) -> bool:
    """Whether the output is JSON, not text; raises BadValue for another format."""
    return choice("--format", arguments.format, ("text", "json")) == "json"


def json_of(content: dict[str, Any]) -> str:
    """The content as JSON, with null for a number that is not known."""
    from adapters.by_process.scene_file import as_json  # imports SymPy, which help does not need

    return as_json(content, indent=1)


def points_of(text: str | None) -> int | None:
    """Parse --points; raises BadValue unless it is a whole number from FEWEST_POINTS to MOST_POINTS."""
    if text is None:
        return None
    return whole_in("--points", text, FEWEST_POINTS, MOST_POINTS)


def _submissions(folder: str | None, case_list: Sequence[Case]) -> tuple[External, ...]:
    if folder is None:
        return ()
    from .running import submissions

    return submissions.externals(
        submissions.submissions_in(place("folder of --submissions", folder)), case_list, solvers()
    )


def whole_jobs(text: str) -> int:
    """Parse the number of concurrent runs; raises BadValue unless it is a whole number from 1 to MOST_JOBS."""
    return whole_in("--jobs", text, 1, MOST_JOBS)


def choose_cases(texts: Sequence[str], effort: str) -> tuple[tuple[Case, ...], tuple[str, ...]]:
    """The cases that the texts select, each once, and the files in the texts; for a quick report only the last variant
    of each case."""
    case_list: dict[tuple, Case] = {}
    case_names = [lookup.case_name(text) for text in texts]
    for one in case_names:
        variants = one.every()
        for case in {case.name: case for case in variants}.values() if effort == "quick" else variants:
            case_list.setdefault((case.name, tuple(case.parameters.items())), case)
    return tuple(case_list.values()), tuple(str(one.file.resolve()) for one in case_names if one.file)


def check_out(out: str | Path, folder_of: Callable[[Path], OwnedFolder] = report_folder.of_report) -> Path:
    """The output folder, resolved; raises BadValue if it contains the working folder, is not writable, or fails
    `OwnedFolder.check`."""
    out = place("folder of --out", out).resolve()
    if out == Path.cwd() or out in Path.cwd().parents:
        raise BadValue(
            f"--out is {out}, which contains the working folder; give a folder inside it, for example report"
        )
    folder_of(out).check()
    check_writable("--out", out, out)
    return out


def check_store(text: str | Path | None, out: Path) -> Path:
    """The folder of the store, resolved; raises BadValue if it is not a separate, writable folder."""
    store = place("folder of --store", STORE if text is None else text).resolve()
    if store == out or store in out.parents or out in store.parents:
        raise BadValue(f"--store is {store} and --out is {out}; give folders that are not inside each other")
    if store == Path.cwd() or store in Path.cwd().parents:
        raise BadValue(f"--store is {store}, which contains the working folder; give a folder inside it")
    if text is not None:  # if the default folder is not writable, the report is made without a store
        if store.exists() and not store.is_dir():
            raise BadValue(f"--store is {store}, which is a file; give a folder")
        check_writable("--store", store, store)
    return store


def check_writable(option: str, path: Path, folder: Path) -> None:
    """Raises BadValue unless the folder is writable or can be created."""
    above = next(some for some in (folder, *folder.parents) if some.exists())
    try:
        TemporaryFolder(above).remove()  # permissions alone do not show whether a file system is writable
    except OSError as problem:
        raise BadValue(
            f"{option} is {path}, and {above} cannot be written to ({problem.strerror}); give another folder"
        ) from None
