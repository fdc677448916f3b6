"""`python -m cases show NAME [mu=0.3 …] [--case-file FILE] [--out FILE]`: draw scene and motion, and print the facts.

It is in `reports` because it needs solvers; `python -m cases` finds it as an entry point.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Sequence
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
    from cases import Case, Trajectory

_CHANGES = "parameters that differ from the defaults"
KINDS = (".png", ".svg", ".pdf")


class ShowRequest(NamedTuple):
    """The arguments of a command on one case."""

    case: Case
    out: Path | None
    force: bool
    points: int | None


def run(words: Sequence[str]) -> None:
    """Draw and print; raises CaseError for invalid arguments."""
    case, out, force, _ = case_of(
        "cases show", words, "Draw a case and its motion; print its facts and the solvers that can run it.", "out file"
    )
    picture = out or Path(f"{case.name}.png")
    if picture.suffix not in KINDS:
        raise BadValue(f"--out is {str(picture)!r}; give a file that ends in {', '.join(KINDS)}")
    check_free(picture, force)
    import reference

    motion = reference.simulate(case)
    picture.parent.mkdir(parents=True, exist_ok=True)
    metadata = {"Software" if picture.suffix == ".png" else "Creator": MADE_BY}
    with atomic_path(picture, replace=force) as partial:
        motion.plot().savefig(partial, metadata=metadata)
    print(facts(case, motion))
    print(f"picture: {picture}")


def case_of(command: str, words: Sequence[str], says: str, *more: str) -> ShowRequest:
    """Parse the command line, with more options of the command: the case, the output path, whether existing files may
    be replaced, and the points of a curve if the command has --points. `more`: "out" or "out file", and others."""
    positional = {"CASE": options.A_CASE, "parameter=value*": _CHANGES}
    parser = options.parser(command, says, "case_file", "force", *more, words=positional)
    arguments = parser.parse_args(list(words))
    out = arguments.out and place("folder or file of --out", arguments.out)
    points = options.points_of(getattr(arguments, "points", None))
    options.load_files(arguments.case_file)
    case = lookup.case_name(arguments.CASE).one(getattr(arguments, "parameter=value"))
    return ShowRequest(case, out, arguments.force, points)


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
    lines += [f"  {t.time:.9f} s: {t.contact and f'{t.contact} '}{t.after} ({t.cause})" for t in motion.transitions]
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
