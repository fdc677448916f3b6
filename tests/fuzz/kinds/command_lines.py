"""Words of command lines. Commands plan and refuse here; what takes minutes is not begun."""

import os
import tempfile
from contextlib import ExitStack
from unittest import mock

from cases import commands
from reports import animate, build, compare, compare_builds, publish, study, submit, sweep

from ..harness import Kind, run_command

WORDS = (
    "stability", "formulations", "paper", "--fresh", "--case", "--case-file", "--solver", "--quick", "--full",
    "--jobs", "--list", "--out", "--store", "disc_on_line", "mu=0.3", "disc_on_line[mu=0.1]", "disc_on_line[mu=-1]",
    "no_such", "reference", "exudyn", "0", "-1", "2", "nan", "99999999999", "", " ", "--", "-x", "--colour",
    "/dev/null",
    "/nowhere/at/all", ".", "..", "/", "[", "]", "\n", "é" * 300, "*", "new", "check", "show", "export",
    "my case", "--out=",
    "--jobs=two", "--jobs=99999999999", "@file", "numpy", "cases", "random", "cos", "x" * 5000, "a\0b",
    "~nosuchuser", "--force",
    "/proc", "/proc/self/mem", "loop", "--trajectory", "--vary", "mu=0.1:0.3:3", "mu=0:nan:3", "--rtol", "--sample",
    "--engine", "--submissions", "a=b.csv", "<b>=b.csv", "a@disc_on_line=/dev/null",
    "\ud800", "١", "valid_name", "--store=loop", "--out=~nosuchuser/r", "disc_on_line[v0=1e308]",
)  # fmt: skip
COMMANDS = {
    "build": build.main, "compare": compare.main, "cases": commands.main, "study": study.main, "sweep": sweep.main,
    "animate": animate.main, "submit": submit.main, "compare_builds": compare_builds.main, "publish": publish.main,
}  # fmt: skip
# Words that make sense, to which others are added.
SENSE = {
    "build": ["--quick"], "study": ["stability"], "sweep": ["disc_on_line", "--vary", "mu=0.1:0.3:3"],
    "animate": ["disc_on_line[mu=0.1]"], "cases": ["new"], "compare": ["disc_on_line[mu=0.1]"],
}  # fmt: skip


def called(name: str, words: list[str]):
    """The command in an empty folder with a link that leads to itself."""

    def call():
        here = os.getcwd()
        with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
            stack.enter_context(mock.patch.object(build, "_build", lambda *_: 0))
            stack.enter_context(mock.patch.object(build, "listing", lambda *_: "listed"))
            stack.enter_context(mock.patch.object(compare, "compare", lambda *_: "judged"))
            stack.enter_context(mock.patch.object(study, "_make", lambda *_: None))
            stack.enter_context(mock.patch.object(sweep, "_sweep", lambda *_: None))
            stack.enter_context(mock.patch.object(animate, "_film", lambda *_: None))
            stack.enter_context(mock.patch.object(commands, "_of_others", lambda *_: None))
            stack.enter_context(mock.patch.dict(os.environ))
            os.chdir(folder)
            try:
                os.symlink("loop", "loop")
                run_command(COMMANDS[name], words)
            finally:
                os.chdir(here)

    return call


def draw(chance):
    name = chance.choice(sorted(COMMANDS))
    words = list(SENSE.get(name, [])) if chance.random() < 0.5 else []
    words += [chance.choice(WORDS) for _ in range(chance.randint(0, 2 if words else 5))]
    return f"{name} {words!r}", called(name, words)


FOUND = tuple(
    (f"{name} {words!r}", called(name, words))
    for name, words in (
        ("build", ["--jobs", "99999999999"]),
        ("build", ["--out", "~nosuchuser/x"]),
        ("build", ["--out", "x" * 5000]),
        ("build", ["--store", "loop/x"]),
        ("cases", ["new", "numpy"]),
        ("cases", ["new", "cos"]),
        ("cases", ["new", "x" * 5000]),
        ("cases", ["check", "a\0b"]),
        ("compare", ["disc_on_line", "loop"]),
        ("study", ["stability", "--jobs", "nan"]),
        ("build", ["--engine", "loop"]),
        ("build", ["--submissions", "x" * 5000]),
        ("submit", ["~nosuchuser"]),
        ("compare_builds", ["x" * 5000, "loop"]),
        ("sweep", ["disc_on_line", "--vary", "mu=0.1:0.3:3", "--out", "loop/x"]),
    )
)
KIND = Kind("command_lines", draw, 450, 60, FOUND)
