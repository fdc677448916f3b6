"""All options of all commands: one parser, checked before anything runs. The same word means the same everywhere.

Everything here answers at once; what is slow to import is imported when it is needed.
"""

from __future__ import annotations

import argparse
import os
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import adapters
import cases
from cases import BadValue, Case, compile_cache, lookup
from cases.command_line import Parser
from cases.errors import unknown_name
from cases.owned_folder import OwnedFolder, TemporaryFolder
from cases.user_files import place

from .page import folder
from .running.records import REFERENCE

if TYPE_CHECKING:
    from adapters import Setting

    from .running.external_motions import External

# The families every solver runs; they alone make up a quick report.
SHARED = ("disc_in_circle", "disc_on_incline", "disc_on_line")
# Families whose whole ladders stand in a default report, so that they can be timed: beside what engines are made for a
# lift-off, a plate that is no disc, a track that needs a search for second contacts, a flight with an impact, and an
# outline that was measured.
WHOLE = (
    "disc_in_circle",
    "disc_on_line",
    "disc_rolling_off_hill",
    "ellipse_in_circle",
    "disc_in_cosine",
    "disc_onto_incline",
    "pebble_on_incline",
)
# The reference's route by the paper's own matrix.
LITERAL = "augmented"
# Finished runs are kept where one works, as test runners and linters do: a fresh folder is a fresh start.
STORE = ".slip-to-roll"
# Each is a process that imports every engine: some 200 MB.
MOST_JOBS = 256
# Wall seconds a run may take, by effort: a whole default report takes a few minutes on two cores.
_LIMITS = {"quick": 20.0, "default": 60.0, "full": 600.0}

# The word of a command that is one case.
A_CASE = 'a case: name, "name[parameter=value,…]", FILE.py or FILE.py:FUNCTION'

# Each option: its flag, and what argparse has to know. Commands choose from these and add none.
_OPTIONS: dict[str, dict[str, Any]] = {
    "out": dict(metavar="DIR", help="folder to write"),
    "case": dict(
        metavar="NAME",
        nargs="+",
        action="extend",
        help='cases: a name (all its variants), "name[parameter=value,…]", FILE.py or FILE.py:FUNCTION '
        "(default: all, or those of --case-file)",
    ),
    "case_file": dict(
        metavar="FILE",
        nargs="+",
        action="extend",
        default=[],
        help="Python files with cases of your own, marked with @case",
    ),
    "solver": dict(metavar="NAME", nargs="+", action="extend", help="solvers (default: all); ENGINE@VERSION for one"),
    "engine": dict(
        metavar="FILE",
        nargs="+",
        action="extend",
        default=[],
        help="executables that are engines (docs/process_protocol.md), beside the solvers",
    ),
    "trajectory": dict(
        metavar="NAME[@CASE]=FILE",
        action="append",
        default=[],
        help="an exported motion (columns t, x, y, theta, …) as a solver of its own; may be given again",
    ),
    "submissions": dict(
        metavar="DIR",
        help="folder of motions that others handed in, as ENGINE/VERSION/CASE.csv, each a solver of its own",
    ),
    "creep": dict(
        metavar="SPEED",
        default="0",
        help="how fast the solver creeps while it sticks, m/s; the file may say so itself, in a column creep or in a "
        "first line such as '# creep = 5e-3'",
    ),
    "quick": dict(action="store_true", help="three cases, one variant each, fewer settings"),
    "full": dict(action="store_true", help="every setting of every case, with ten times the patience"),
    "jobs": dict(metavar="N", default="2", help="runs beside each other (default: 2)"),
    "store": dict(
        metavar="DIR",
        help=f"folder where finished runs are kept and taken from (default: {STORE}); delete it to forget them",
    ),
    "fresh": dict(action="store_true", help="run everything anew, whatever is kept"),
    "paper": dict(action="store_true", help="figures also as PDF, tables also as LaTeX"),
    "force": dict(action="store_true", help="write over files that are there"),
    "list": dict(action="store_true", help="print cases and solvers, and stop"),
    "vary": dict(
        metavar="PARAMETER=VALUES",
        action="append",
        default=[],
        help="low:high:count, low:high:count:log, or a,b,c; low:high to draw from; given again they make a grid",
    ),
    "sample": dict(metavar="HOW", default="grid", help="grid, random or sobol (default: grid)"),
    "number": dict(metavar="N", help="scenarios to draw, where they are not a grid"),
    "seed": dict(metavar="N", default="0", help="what random and sobol begin with (default: 0)"),
    "rtol": dict(metavar="R", default="1e-10", help="relative tolerance of the reference (default: 1e-10)"),
    "certify": dict(action="store_true", help="error bars by witnesses, for each scenario (seconds each)"),
    "refine": dict(
        metavar="WIDTH",
        help="find the boundaries between what follows, to this width of the first parameter that varies",
    ),
    "dask": dict(metavar="ADDRESS", help='a Dask scheduler, as tcp://host:port, or "local" for a cluster of its own'),
}


class _NoCache(argparse.Action):
    """Turns off what is kept between processes, for this one and its workers."""

    def __call__(self, parser, namespace, values, option_string=None):
        os.environ[compile_cache.VARIABLE] = compile_cache.OFF


def parser(
    command: str,
    description: str,
    *options: str,
    words: Mapping[str, str] | None = None,
    example: str = "",
    **defaults: Any,
) -> Parser:
    """The parser of a command with some of the options; `defaults` are the command's own.

    `words` are what stands there without an option, and what is said of it: beside several of them an option takes one
    value at a time, and may be given again.
    """
    parser = Parser(
        prog=f"python -m {command}",
        description=description,
        epilog=example and f"Example: {example}",
    )
    effort = parser.add_mutually_exclusive_group() if {"quick", "full"} <= {*options} else parser
    for option in options:
        how = dict(_OPTIONS[option])
        if option in defaults:
            how = how | {"default": defaults[option], "help": f"{how['help']} (default: {defaults[option]})"}
        if words and len(words) > 1 and how.get("nargs") == "+":
            how |= {"nargs": None, "action": "append"}
        (effort if option in ("quick", "full") else parser).add_argument(f"--{option.replace('_', '-')}", **how)
    parser.add_argument(
        "--no-cache",
        action=_NoCache,
        nargs=0,
        help="derive and compile again what earlier processes cached on disk "
        f"({compile_cache.VARIABLE}=off does the same)",
    )
    for name, text in (words or {}).items():
        parser.add_argument(name.strip("*"), metavar=name.strip("*"), help=text, nargs="*" if "*" in name else None)
    return parser


def command(module: str, words: Sequence[str]) -> str:
    """The command as it is typed again."""
    return " ".join([f"python -m {module}", *map(shlex.quote, words)])


@dataclass(frozen=True)
class BuildPlan:
    """What a report is made of, checked."""

    out: Path
    cases: tuple[Case, ...]
    files: tuple[str, ...]
    solvers: tuple[str, ...]
    effort: str
    jobs: int
    argv: tuple[str, ...]
    is_selection: bool  # whether the cases were named, not taken from the whole catalogue
    store: Path | None = None  # where finished runs are kept
    fresh: bool = False  # whether what is kept there is left out of account
    trajectories: tuple[External, ...] = ()
    paper: bool = False  # whether figures are also written as PDF and tables as LaTeX
    dask: str | None = None  # who makes the runs that are not timed, if not this machine

    @property
    def limit(self) -> float:
        """Wall seconds a run may take."""
        return _LIMITS[self.effort]

    def select_rungs(self, case: str, solver: str, route: str, settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
        """The rungs to run: all, or the defaults and three for a quick report, one in the breadth of the catalogue.

        There the reference is run at its finest, for which its equations are compiled anyway: the truth's motion; but
        by the paper's own matrix, which takes fifteen times as long, at its two coarsest."""
        if self.effort == "full" or (self.effort == "default" and (self.is_selection or case in WHOLE)):
            return settings
        if self.effort == "default" and (solver, route) == (REFERENCE, LITERAL):
            return settings[:2]
        ladder = [s for s in settings if not s.is_default]
        third = len(ladder) // 3
        one = len(ladder) - 1 if solver == REFERENCE else 2 * third
        places = sorted({0, third, 2 * third} if self.effort == "quick" else {one}) if ladder else []
        return (*(s for s in settings if s.is_default), *(ladder[i] for i in places))

    def ladders(self) -> str:
        """Which settings are run, in a sentence; "" where all are."""
        if self.effort == "full" or (self.effort == "default" and self.is_selection):
            return ""
        if self.effort == "quick":
            return "Of each ladder three settings and the engine as it comes; --full runs all."
        return (
            f"Whole ladders for {', '.join(WHOLE)}; of other cases the engine as it comes and one fine setting, of the "
            f"reference its finest, and its route {LITERAL!r}, which takes fifteen times as long, at its two coarsest "
            "tolerances only; --full runs all."
        )


def solvers() -> tuple[str, ...]:
    """Every solver's name: the reference first, then the engines in alphabetical order."""
    return (REFERENCE, *adapters.engines())


def plan_of(options: argparse.Namespace, argv: Sequence[str]) -> BuildPlan:
    """The plan of parsed options; raises CaseError, in one sentence, for what makes no sense."""
    effort = "quick" if options.quick else "full" if options.full else "default"
    try:
        own_engines = tuple(adapters.lookup.register(file) for file in options.engine)
    except ImportError as problem:
        raise BadValue(str(problem)) from problem
    jobs, solver_names = whole_jobs(options.jobs), choose_solvers([*(options.solver or solvers()), *own_engines])
    files, own = load_files(options.case_file)
    out = check_out(options.out)
    store = check_store(options.store, out)
    names = options.case or own
    case_list, more = choose_cases(names or (SHARED if effort == "quick" else cases.names(hard=False)), effort)
    external = _trajectories(options.trajectory, case_list) + _submissions(options.submissions, case_list)
    is_selection = bool(names)
    if options.dask is not None and own_engines:
        raise BadValue("--engine names files of this machine, which --dask leaves; give one of the two")
    files = tuple(dict.fromkeys((*files, *more)))
    return BuildPlan(
        out, case_list, files, solver_names, effort, jobs, tuple(argv), is_selection, store, options.fresh, external,
        options.paper, options.dask,
    )  # fmt: skip


def plan_by_hand(
    own_cases: Iterable[Case],
    solvers: Iterable[str] | None,
    out: Path,
    effort: str,
    jobs: int,
    store: Path | None,
    fresh: bool,
) -> BuildPlan:
    """The plan of a report on cases made by hand, checked as one of the command's; raises CaseError."""
    case_list = tuple(own_cases)
    for case in case_list:
        if not isinstance(case, Case):
            raise BadValue(f"{case!r} is no Case; give a list of cases")
    labels = [case.label for case in case_list]
    twice = next((label for label in labels if labels.count(label) > 1), "")
    if twice or not case_list:
        raise BadValue(f"two cases are called {twice!r}; give each a name=" if twice else "no case is given; give one")
    if effort not in _LIMITS:
        raise unknown_name("effort", effort, _LIMITS)
    solver_names, out = choose_solvers(solvers), check_out(out)
    return BuildPlan(
        out, case_list, (), solver_names, effort, whole_jobs(str(jobs)), (), True, check_store(store, out), fresh
    )


def choose_solvers(names: Iterable[str] | None) -> tuple[str, ...]:
    """Each named solver once, or all; raises UnknownName, and BadValue for a version that cannot be asked for."""
    solver_names = tuple(dict.fromkeys(names or solvers()))
    for name in solver_names:
        engine, mark, _ = name.partition("@")
        if engine not in solvers():
            raise unknown_name("solver", engine, solvers())
        if mark:
            from .running import versions

            versions.check(name)
    return solver_names


def load_files(files: Sequence[str]) -> tuple[tuple[str, ...], list[str]]:
    """Bring case files into the catalogue; their paths, and the names of their cases."""
    names = [name for file in files for name in lookup.load_file(file)]
    return tuple(str(Path(file).resolve()) for file in files), names


def _trajectories(texts: Sequence[str], case_list: Sequence[Case]) -> tuple[External, ...]:
    if not texts:
        return ()
    from .running import external_motions

    return external_motions.from_options(texts, case_list, solvers())


def creep_of(text: str) -> float:
    """A speed in m/s; raises BadValue unless it is a number of at least 0."""
    try:
        creep = float(text)
    except ValueError:
        creep = nan
    if not 0.0 <= creep < inf:
        raise BadValue(f"--creep is {text!r}; give a speed in m/s, for example 5e-3")
    return creep


def _submissions(folder: str | None, case_list: Sequence[Case]) -> tuple[External, ...]:
    if folder is None:
        return ()
    from .running import submissions

    return submissions.externals(
        submissions.submissions_in(place("folder of --submissions", folder)), case_list, solvers()
    )


def whole_jobs(text: str) -> int:
    """How many runs beside each other; raises BadValue unless it is a whole number of at least 1."""
    try:
        jobs = int(text)
    except ValueError:
        raise BadValue(f"--jobs is {text!r}; give a whole number, for example 2") from None
    if not 1 <= jobs <= MOST_JOBS:
        raise BadValue(f"--jobs is {text[:40]}; give a whole number from 1 to {MOST_JOBS}")
    return jobs


def choose_cases(texts: Sequence[str], effort: str) -> tuple[tuple[Case, ...], tuple[str, ...]]:
    """The cases of the texts, each once, and the files that the texts name; a quick report takes only the last variant
    of each case."""
    case_list: dict[tuple, Case] = {}
    case_names = [lookup.case_name(text) for text in texts]
    for one in case_names:
        variants = one.every()
        for case in {case.name: case for case in variants}.values() if effort == "quick" else variants:
            case_list.setdefault((case.name, tuple(case.parameters.items())), case)
    return tuple(case_list.values()), tuple(str(one.file.resolve()) for one in case_names if one.file)


def check_out(out: str | Path, folder_of: Callable[[Path], OwnedFolder] = folder.of_report) -> Path:
    """The folder to write, resolved; raises BadValue if it is where the user works, cannot be written to, or is not as
    `OwnedFolder.check` wants it."""
    out = place("folder of --out", out).resolve()
    if out == Path.cwd() or out in Path.cwd().parents:
        raise BadValue(f"--out is {out}, where you are working; give a folder inside it, for example report")
    folder_of(out).check()
    check_writable("--out", out, out)
    return out


def check_store(text: str | Path | None, out: Path) -> Path:
    """The store's folder, resolved; raises BadValue if what was asked for is no folder of its own or not writable."""
    store = place("folder of --store", STORE if text is None else text).resolve()
    if store == out or store in out.parents or out in store.parents:
        raise BadValue(f"--store is {store} and --out is {out}; give folders that are not inside each other")
    if text is not None:  # the usual place may be unfit: the report is made all the same, and says so
        if store.exists() and not store.is_dir():
            raise BadValue(f"--store is {store}, which is a file; give a folder")
        check_writable("--store", store, store)
    return store


def check_writable(option: str, path: Path, folder: Path) -> None:
    """Raises BadValue unless files can be written to the folder, or it can be made."""
    above = next(some for some in (folder, *folder.parents) if some.exists())
    try:
        TemporaryFolder(above).remove()  # the permissions do not say what every file system does
    except OSError as problem:
        raise BadValue(
            f"{option} is {path}, and {above} cannot be written to ({problem.strerror}); give another folder"
        ) from None
