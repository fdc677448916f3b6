"""`slip-to-roll cases show NAME [mu=0.3 …] [--case-file FILE] [--out FILE]`: draw scene and motion, print the facts.

With `--engines` also what the engines make of it: their motions, and their errors against their steps.
It is in `reports` because it needs solvers; `slip-to-roll cases` finds it as an entry point.
"""

from __future__ import annotations

import argparse
import inspect
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import cases
from cases import BadValue, lookup
from cases.files.command_line import status
from cases.files.owned_folder import atomic_path, check_new
from cases.files.user_files import place
from cases.pictures import MADE_BY

from . import options

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cases import Case, Trajectory

_CHANGES = "parameters that differ from the defaults"
KINDS = (".png", ".svg", ".pdf")


class ShowRequest(NamedTuple):
    """The arguments of a command on one case."""

    case: Case
    out: Path | None
    force: bool
    more: argparse.Namespace


def run(words: Sequence[str]) -> None:
    """Draw and print; raises CaseError for invalid arguments."""
    case, out, force, more = case_of(
        "cases show", words, "Draw a case and its motion; print its facts and the solvers that can run it.",
        "out file", "engines", "store",
    )  # fmt: skip
    picture = out or Path(f"{case.name}.png")
    if picture.suffix not in KINDS:
        raise BadValue(f"--out is {str(picture)!r}; give a file that ends in {', '.join(KINDS)}")
    by_name = {name: picture.with_stem(f"{picture.stem}_{name}") for name in ("engines", "errors") if more.engines}
    for path in (picture, *by_name.values()):
        check_free(path, force)
    store = options.check_store(more.store, picture.resolve())
    import reference

    motion = reference.simulate(case)
    picture.parent.mkdir(parents=True, exist_ok=True)
    _write(motion.plot(), picture, force)
    print(facts(case, motion))
    print(f"picture: {picture}")
    for name, figure in engine_figures(case, store).items() if more.engines else ():
        _write(figure, by_name[name], force)
        print(f"{name}: {by_name[name]}")


def _write(figure: Figure, path: Path, force: bool) -> None:
    from cases.pictures.style import apply_style  # imports Matplotlib, which a command's help does not need

    metadata = {"Software" if path.suffix == ".png" else "Creator": MADE_BY}
    with apply_style(), atomic_path(path, replace=force) as partial:
        figure.savefig(partial, metadata=metadata)


def engine_figures(case: Case, store: Path) -> dict[str, Figure]:
    """The figures of the runs that a default report has of the case: the motions of all engines ("engines") and, if one
    has a motion, the errors of all settings against their steps ("errors"). Raises BadValue without a truth."""
    from cases.pictures.style import apply_style

    from .drawing import figures, matplotlib_writer
    from .running.calls import Calls
    from .running.experiment import run_cases
    from .running.ladder_selection import select_rungs
    from .running.progress import Display
    from .running.storage.result_store import Store

    with Display() as display, Calls(store=Store(store), progress=display) as calls:
        calls.begin(options.solvers())
        experiment = run_cases([case], options.solvers(), calls, partial(select_rungs, "default", False))
    failure = experiment.truths[case.label].failure
    if failure:
        raise BadValue(f"there is no truth to compare engines with: {failure}; leave out --engines")
    looks = figures.looks_of(experiment)
    diagrams = {"engines": figures.motion(experiment, case), "errors": figures.against_steps(experiment, case)}
    with apply_style():
        return {name: matplotlib_writer.draw(each, looks) for name, each in diagrams.items() if each}


def case_of(command: str, words: Sequence[str], says: str, *more: str) -> ShowRequest:
    """Parse the command line, with more options of the command: the case, the output path, whether existing files may
    be replaced, and the command's other options. `more`: "out" or "out file", and others."""
    positional = {"CASE": options.A_CASE, "parameter=value*": _CHANGES}
    parser = options.parser(command, says, "case_file", "force", *more, words=positional)
    arguments = parser.parse_args(list(words))
    out = arguments.out and place("folder or file of --out", arguments.out)
    options.load_files(arguments.case_file)
    case = lookup.case_name(arguments.CASE).one(getattr(arguments, "parameter=value"))
    return ShowRequest(case, out, arguments.force, arguments)


def check_free(path: Path, force: bool) -> None:
    """Raises BadValue if a file cannot be written: it exists (allowed with `force`), or its folder is not writable."""
    check_new(path, force)
    options.check_writable("--out", path, path.parent)


def facts(case: Case, motion: Trajectory) -> str:
    """Parameters, docstring, transitions, and the solvers that can run the case, as text."""
    from .running.calls import Calls
    from .running.experiment import offers

    entry = cases.entry(case.name)
    lines = [case.label, "", inspect.getdoc(entry.function) or "", "", "parameters"]
    lines += [f"  {name} = {case.parameters.get(name, value)}" for name, value in entry.parameters.items()]
    of_contacts = [f"{name} {motion.of(name).first_mode}" for name in motion.contact_names]
    lines += ["motion", f"  begins: {', '.join(of_contacts) if len(of_contacts) > 1 else motion.first_mode}"]
    for t in motion.transitions:
        impulse = motion.impulse_at(t)
        how = "; ".join([t.cause, *([impulse.in_words()] if impulse else [])])
        lines.append(f"  {t.time:.9f} s: {t.contact and f'{t.contact} '}{t.after} ({how})")
    lines += [f"  {motion.t[-1]:.9f} s: {motion.status}. {motion.reason}", "solvers", "  reference: runs it"]
    with Calls() as calls:
        for (_, name), of_routes in offers([case], options.solvers()[1:], calls).items():
            for offer in of_routes:
                lines.append(f"  {name}{offer.route and f', {offer.route}'}: {offer.reason or 'runs it'}")
    return "\n".join(lines)


def main(command: Callable[[list[str]], None] = run) -> int:
    """The command `python -m reports.show NAME`, for a suite that is not installed."""
    return status("cases", command, None)


if __name__ == "__main__":
    sys.exit(main())
