"""The command `slip-to-roll cases`.

    slip-to-roll cases [list]                     lists every case, hard ones with a star
    slip-to-roll cases new NAME [--force]         writes NAME.py, a commented case to start from
    slip-to-roll cases check CASE [mu=0.3 …]      says what is wrong in a case or a file of cases, and where; else what
                                                  happens
    slip-to-roll cases show CASE [mu=0.3 …]       a picture of scene and motion, facts, and which solvers can run it
    slip-to-roll cases film CASE [mu=0.3 …]       an animation of the motion, GIF or MP4
    slip-to-roll cases export CASE [mu=0.3 …]     the scene and its true motion as JSON and CSV

CASE is NAME, "NAME[parameter=value,…]", FILE.py or FILE.py:FUNCTION, in every command of the suite.

`show` and `export` need solvers, which this package does not import: packages declare them as entry points of the
group "slip_to_roll.commands" (the suite's are `reports.show` and `reports.export`). The entry point `check` is a
function that runs a case and describes its motion in one line (the suite's is in `reference.narration`).
"""

from __future__ import annotations

import ast
import builtins
import importlib.util
import keyword
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import entry_points
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill

from . import lookup, registry
from .errors import BadValue, CaseError, unknown_name
from .files import owned_folder
from .files.command_line import program, status

OWN = ("list", "new", "check")

CENTRE_OUTSIDE = (
    "the centre of mass, the origin of the outline, lies outside the outline; if that is not meant, use "
    "Plate.homogeneous(outline, mass)"
)
BY_OTHERS = ("show", "export")
# Narrowest column of summaries in a listing, in characters.
_NARROWEST = 20
# Of a file, with room for an ending.
LONGEST_NAME = 100
NO_SOLVER = "no solver is installed that could run it (pip install -e .)"

TEMPLATE = '''"""One case of your own. Edit the expression, then: slip-to-roll cases check {name}.py"""

from cases import Case, CoulombFriction, Curve, Gravity, Start, Unilateral, case, disc
from cases.curves import cos


@case  # @case(variants=[dict(mu=0.1), dict(mu=0.3)]) runs several
def {name}(depth=0.3, mu=0.1, xi1=-1.0):
    """Say in one sentence what happens here.

    Why: what makes it interesting. Source: who posed it, or yourself.
    """
    return Case(
        # The track, in metres: the plate lies on the left of increasing s. Use the functions of cases.curves,
        # a ready-made curve of cases.library, pieces of cases.constructions, or measured points:
        # Curve.spline("points.csv", closed=False), a path that counts from this file.
        track=Curve(lambda s: (s, -depth * cos(2 * s)), domain=(-3, 3)),
        # The plate: a disc, a block(width, height, mass) that slides and does not turn, or Plate(outline, mass,
        # inertia) with an outline about the centre of mass.
        plate=disc(radius=0.1, mass=1.0),
        # Leave out CoulombFriction for no friction, Unilateral for a bilateral guide.
        effects=(Gravity(9.81), CoulombFriction(mu), Unilateral()),
        # At the track's parameter xi1, at rest unless slip= (m/s) and omega= (rad/s) say otherwise; xi2= for outlines
        # that are no circle.
        start=Start(xi1=xi1),
        duration=2.0,  # seconds
    )
'''


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status: 0, or 2 with one line if what was asked for makes no sense."""
    return status("cases", _work, argv)


def _work(words: list[str]) -> None:
    if {"-h", "--help"} & {*words[:1]} or ({*OWN} & {*words[:1]} and {"-h", "--help"} & {*words}):
        print((__doc__ or "").strip())
    else:
        run_command(words[0] if words else "list", words[1:])


def run_command(command: str, words: Sequence[str]) -> None:
    """One of the commands; raises CaseError if it cannot."""
    if command not in OWN + BY_OTHERS:
        raise unknown_name("command", command, OWN + BY_OTHERS)
    if command in BY_OTHERS:
        function = _of_others(command)
        if function is None:
            raise BadValue(
                f"{command} needs the installed suite: pip install -e . first, or python -m reports.{command}"
            )
        function(words)
        return
    if command == "list":
        print(listing())
        return
    if command == "check":
        if not words:
            raise BadValue(f"check takes a case or a FILE: {program('cases check')} FILE")
        print(check(words[0], words[1:]))
        return
    force = "--force" in words
    words = [word for word in words if word != "--force"]
    if len(words) != 1:
        raise BadValue(f"new takes one NAME: {program('cases new')} NAME")
    print(new(words[0], force))


def _of_others(command: str) -> Callable | None:
    """What an installed package declares for that command."""
    points = list(entry_points(group="slip_to_roll.commands", name=command))
    return points[0].load() if points else None


def listing(width: int | None = None) -> str:
    """Every case with its summary, in lines of at most `width` characters (default: the terminal's width); a star marks
    the hard ones."""
    cases = registry.summaries()
    indent = max(len(case.name) for case in cases) + 3
    width = max(width or get_terminal_size().columns, indent + _NARROWEST)
    lines = []
    for case in cases:
        first = f"{case.name:{indent - 3}} {'*' if case.is_hard else ' '} "
        lines.append(fill(case.summary, width, initial_indent=first, subsequent_indent=" " * indent))
    return "\n".join(lines)


def new(name: str, force: bool = False) -> str:
    """Write NAME.py into the working folder; raises BadValue for a name no case can have, or a file that exists unless
    `force`."""
    name = name.removesuffix(".py")
    if not name.isidentifier() or keyword.iskeyword(name) or len(name) > LONGEST_NAME:
        raise BadValue(
            f"{name!r} cannot name a case; use up to {LONGEST_NAME} letters, digits and underscores, for example "
            "my_valley"
        )
    if name in registry.names():
        raise BadValue(f"there is already a case {name!r}; give another name")
    path = Path(f"{name}.py")
    owned_folder.check_new(path, force)
    if not path.exists() and _shadows(name):
        raise BadValue(f"{name!r} is the name of a Python module, or of something that a case uses, which {name}.py "
                       "would replace; give another name")  # fmt: skip
    owned_folder.write(path, TEMPLATE.format(name=name), replace=force)
    return f"written: {path}; edit its curve, then {program('cases check')} {path}"


def _shadows(name: str) -> bool:
    """Whether a file NAME.py, or a function of that name in it, would hide something that a case uses."""
    used = {node.id for node in ast.walk(ast.parse(TEMPLATE.format(name="_"))) if isinstance(node, ast.Name)}
    if name in used or hasattr(builtins, name) or name in sys.stdlib_module_names:
        return True
    try:
        return importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):  # a module without a specification is one all the same
        return True


def check(text: str, changes: Sequence[str] = ()) -> str:
    """Make every variant of the cases that a word names (or the one with `changes`) and run it, where there is a
    solver; raises CaseError with file and line of what is wrong."""
    selection, run_command = lookup.case_name(text), _of_others("check")
    lines = []
    for case in [selection.one(changes)] if changes else selection.every():
        try:
            does = run_command(case) if run_command else NO_SOLVER
        except CaseError as problem:
            raise BadValue(f"{case.label}: {problem}") from problem
        lines.append(f"{case.label}: fits; {does}")
        if not case.plate.encloses_centre:
            lines.append(f"{case.label}: {CENTRE_OUTSIDE}")
    lines += [
        f"{name}: its docstring names no source yet (Source: …); the acceptance tests ask for one"
        for name in selection.names
        if "Source:" not in (registry.entry(name).function.__doc__ or "")
    ]
    return "\n".join(lines)
