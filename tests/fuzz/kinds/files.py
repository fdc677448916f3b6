"""Files of points, of motions and of cases: what a person, a program or a stranger may have written there."""

import tempfile
from functools import lru_cache
from math import pi
from pathlib import Path

import numpy as np

import cases
from adapters.common import motion_file, motion_table
from cases import Curve, registry
from reports.judging import validation
from tests.fake_adapter import bowled

from ..harness import Kind


@lru_cache(maxsize=1)
def line():
    return cases.load("disc_on_line[mu=0.3]")


def rolling(count: int = 60) -> list[list[str]]:
    """A motion of that case: slipping, then rolling."""
    motion = bowled(line(), np.linspace(0.0, line().duration, count))
    columns = (motion.t, motion.x, motion.y, motion.theta)
    return [[f"{value:.9f}" for value in row] for row in zip(*columns, strict=True)]


CELLS = (
    "",
    "nan",
    "inf",
    "-inf",
    "1e300",
    "1e999",
    "abc",
    "0.0o",
    "=1+1",
    "1;2",
    "0x10",
    "1_0",
    "\0",
    "é",
    '"',
    "1e-320",
    "-0",
)
HEADINGS = (
    "t,x,y,theta", "t,x,y,theta", "t,x,y,theta", "t,x,y", "T,X,Y,THETA", "t,x,y,theta,t", ",t,x,y,theta",
    "t_ms,x,y,theta",
    "t,x [mm],y,theta", "t;x;y;theta", "t,x,y,theta,slip", "t,x,y,theta,vx", "", "# t,x,y,theta", "t, x, y, theta",
)  # fmt: skip
CHANGES = (
    lambda chance, rows: rows,
    lambda chance, rows: rows + rows[-1:],
    lambda chance, rows: rows[::-1],
    lambda chance, rows: rows[:5],
    lambda chance, rows: [[str(1e3 * float(row[0])), *row[1:]] for row in rows],
    lambda chance, rows: [[row[0], str(1e3 * float(row[1])), *row[2:]] for row in rows],
    lambda chance, rows: [[str(0.11 + float(row[0])), *row[1:]] for row in rows],
    lambda chance, rows: [[str(i), *row] for i, row in enumerate(rows)],
    lambda chance, rows: [row + [chance.choice(CELLS)] for row in rows],
)


def text_of_motion(chance) -> str:
    rows = chance.choice(CHANGES)(chance, rolling(chance.choice((60, 60, 200))))
    rows = [list(row) for row in rows]
    for _ in range(chance.choice((0, 0, 1, 2))):
        row = chance.choice(rows)
        row[chance.randrange(len(row))] = chance.choice(CELLS)
    if chance.random() < 0.1:
        chance.choice(rows).append("extra")
    return "\n".join([chance.choice(HEADINGS), *(",".join(row) for row in rows)])


def text_of_points(chance) -> str:
    count = chance.choice((3, 8, 20, 40))
    rows = [[f"{np.cos(2 * pi * i / count):.6f}", f"{np.sin(2 * pi * i / count):.6f}"] for i in range(count)]
    for _ in range(chance.choice((0, 0, 1, 2))):
        chance.choice(rows)[chance.randrange(2)] = chance.choice(CELLS)
    heading = chance.choice((["x,y"], [], ["0.0o,0"], ["x;y"], ["1,2,3"], ["# points"]))
    return "\n".join([*heading, *(",".join(row) for row in rows)])


BYTES = (
    b"", b"\n\n", b"x,y\n", b"1,2\n", b"\x00\x01\xff" * 40, b'"1,2\n' * 20, b"x" * 100_000, b"1e999,0\n" * 20,
    b"PK\x03\x04" + b"\x00" * 200, b"\xff\xfe1\x00,\x002\x00", b"nan,nan\n" * 20, b"1,2\r\n" * 20,
    b"t,x,y,theta\n" * 60,
)  # fmt: skip
STATEMENTS = (
    "", "x = 1", "raise SystemExit", "raise SystemExit(0)", "1/0", "import nothing_like_it", "def f(:", "\0",
    "from cases import *", "from cases import case\n@case\ndef f(): pass",
    "from cases import case\n@case\ndef f(a): pass",
    "from cases import case\n@case(variants=3)\ndef f(): pass",
    "from cases import case\n@case(variants=[3])\ndef f(): pass",
    "from cases import case\n@case(variants=[dict(b=1)])\ndef f(a=1): pass", "from cases import case\ncase(3)",
    "from cases import case\n@case\ndef disc_on_line(): pass", "from cases import case\n@case(hard='x')\ndef f(): pass",
    "from cases import case\n@case\nclass F: pass", "from cases import case\n@case\ndef f(): raise SystemExit(0)",
    "from cases import case\n@case\ndef f(): return __import__('sys').exit()", "class A(BaseException): pass\nraise A",
    "raise ValueError('\\ud800 \\x1b[31m')",
)  # fmt: skip


def written(content: bytes, ending: str, use):
    """The call on a file of that content, in a folder of its own."""

    def call():
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"file{ending}")
            path.write_bytes(content)
            return use(path)

    return call


def points(closed: bool):
    return lambda path: Curve.spline(path, closed=closed)


def motion(path: Path):
    output = motion_file.trajectory_of(line(), motion_table.read(path))
    assert validation.sound(output)
    return output


def case_file(path: Path):
    cases.names()
    before = dict(registry._entries)
    try:
        return [cases.select(name) for name in cases.load_file(path)]
    finally:
        registry._entries.clear()
        registry._entries.update(before)


def draw(chance):
    which = chance.randrange(8)
    if which == 0:
        content = chance.choice(BYTES)
        use, ending = chance.choice(
            ((points(True), ".csv"), (points(False), ".csv"), (motion, ".csv"), (case_file, ".py"))
        )
        return f"{ending} {content[:40]!r}", written(content, ending, use)
    if which == 1:
        text = "\n".join(chance.choice(STATEMENTS) for _ in range(chance.randint(1, 2)))
        return f"case file {text!r}", written(text.encode(), ".py", case_file)
    if which in (2, 3):
        text = text_of_points(chance)
        return f"points {text[:60]!r}", written(text.encode(), ".csv", points(chance.random() < 0.5))
    text = text_of_motion(chance)
    return f"motion {text[:100]!r}", written(text.encode(), ".csv", motion)


FOUND = (
    *((f"case file {text!r}", written(text.encode(), ".py", case_file)) for text in STATEMENTS),
    ("a zip file", written(BYTES[8], ".csv", motion)),
    ("a folder", lambda: motion_table.read("/")),
    ("/proc/self/mem", lambda: motion_table.read("/proc/self/mem")),
)
KIND = Kind("files", draw, 400, 30, FOUND)
