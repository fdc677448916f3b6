"""An adapter for tests of what happens to a run: a disc bowled on a line, exactly, but for the ways to fail it offers.

A test copies this file to a folder of its own and installs it there (`install`); `ladder.json` beside the copy says
what its settings are, `log.txt` what it ran. `break_down` makes a copy fail in one of its parts; `callers.txt` names
the processes in which any part of any copy ran.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import dataclasses
import itertools
import json
import os
import shutil
import signal
import stat
import sys
import time
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np

from adapters import EngineFailure, Setting
from cases import Cost, CoulombFriction, State, Trajectory

NAME = "fake"
routes = ("native",)
HERE = Path(__file__).parent
CASE = "disc_on_line[mu=0.1]"


class Own(float):
    """A number that only this module knows."""


class Fails(float):
    """A number that fails when it is asked for its value."""

    def __float__(self):
        raise RuntimeError("no value")

    __repr__ = __str__ = __format__ = __float__


# Steps that are no count, by the way in which `read` goes wrong.
ODD_STEPS = {
    "text": "12", "huge": 10**400, "array": np.array([1, 2]), "nan": float("nan"), "fails": Fails(1.0), "minus": -1,
}  # fmt: skip


def part(name: str) -> str:
    """What happens wherever a part of the adapter is called: it is noted by whom, and fails if it was made to; the way
    is returned, for those parts that only answer strangely."""
    with open(HERE / "callers.txt", "a") as callers:
        callers.write(f"{os.getpid()}\n")
    habits = HERE / f"{Path(__file__).stem}.json"
    way = json.loads(habits.read_text()).get(name, "") if habits.exists() else ""
    if way == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif way == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    elif way == "hang":
        while True:
            time.sleep(1.0)
    elif way == "raises":
        raise ValueError("no \ud800, no \x00 and no <b>end</b>")
    elif way == "exits":
        sys.exit("had enough")
    elif way == "vanishes":
        os._exit(0)
    elif way == "forks":
        os.fork()
    elif way == "rounds":
        ctypes.CDLL(ctypes.util.find_library("m")).fesetround(0x800)  # upwards, on x86
    elif way == "sulks":
        np.seterr(all="raise")
        warnings.simplefilter("error")
        os.chdir("/")
        sys.stdout.close()
    elif way == "floods":
        for _ in range(1000):
            os.write(1, b"x" * 100_000)
    elif way == "garbles":
        for stream in range(3, 64):
            with suppress(OSError):
                if stat.S_ISSOCK(os.fstat(stream).st_mode):
                    os.write(stream, b"x" * 100)
    elif way == "prints":
        os.write(1, b"all is well\n")
        print("all is well", file=sys.stderr)
    return way


def refuses(case, route):
    return Own(1.0) if part("refuses") == "strange" else None


def ladder(case, route):
    way = part("ladder")
    if way == "strange":
        return (Setting.of(h=Own(0.1)),)
    if way == "many":
        return (Setting.of(h=1.0 / (1 + i)) for i in itertools.count())
    if way == "unwritable":
        return (Setting.of(how="wait 0", name="\ud800"),)
    return tuple(Setting.of(how=how) for how in json.loads((HERE / "ladder.json").read_text()))


def grid(case, route):
    part("grid")
    return tuple(Setting.of(h=h, k=k, how="wait 0") for h in (0.02, 0.01) for k in (1, 2))


def build(case, route, setting):
    part("build")
    return case, setting["how"]


def run(model):
    part("run")
    how = model[1]
    if how.startswith("wait"):  # for so many milliseconds
        time.sleep(int(how.partition(" ")[2]) / 1000)
    elif how == "hang":
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGINT})
        while True:
            time.sleep(1.0)
    elif how == "until killed":
        (HERE / "pid").write_text(str(os.getpid()))
        time.sleep(60.0)
    elif how.startswith("until"):  # there is a file of that name
        while not (HERE / how.partition(" ")[2]).exists():
            time.sleep(0.01)
    elif how == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif how == "no library":
        raise ImportError("libfake.so is missing")


def read(model):
    way = part("read")
    if way == "strange":
        return None
    case, how = model
    if how == "gives up":
        raise EngineFailure("Newton gave up")
    motion = bowled(case, np.linspace(0.0, case.duration, 301))
    if how == "nan" or way == "far":
        fifth = np.arange(len(motion.x)) == 5
        motion = dataclasses.replace(motion, x=np.where(fifth, np.nan if how == "nan" else 1e300, motion.x))
    if how == "never rolls":
        motion = dataclasses.replace(motion, slip=motion.slip + 1.0)  # as fast as it begins: no creep
    if way in ODD_STEPS:
        motion = dataclasses.replace(motion, cost=Cost(steps=ODD_STEPS[way]))
    if way == "own":
        motion = dataclasses.replace(motion, status=Own(2.0), reason="\ud800")
    with open(HERE / "log.txt", "a") as log:
        log.write(f"{how}\n")
    return motion


def version():
    return "\ud800" * 10**6 if part("version") == "strange" else "1.0"


def bowled(case, t, delay=0.0) -> Trajectory:
    """The exact motion of `disc_on_line`: it slips until v0/(3 mu g) and rolls from there; `delay` (s) later, if so."""
    v0, mu, g, r = case.start.slip, case.effect(CoulombFriction).mu, 9.81, case.plate.radius
    turn = v0 / (3 * mu * g) + delay
    slipping, rolling = np.minimum(t, turn), np.maximum(t - turn, 0.0)
    vx = v0 - mu * g * slipping
    slip = np.where(t < turn, v0 - 3 * mu * g * (t - delay), 0.0)
    x = v0 * slipping - mu * g * slipping**2 / 2 + (v0 - mu * g * turn) * rolling
    theta = -mu * g * slipping**2 / r - (v0 - mu * g * turn) / r * rolling
    friction = np.where(t < turn, -mu * g, 0.0)
    zero = np.zeros(len(t))
    state = State(x, zero + r, theta, vx, zero, (slip - vx) / r, slip, zero + g, friction, x, x)
    return Trajectory(t=t, **state._asdict())


if __name__ != "tests.fake_adapter":  # a copy, which is an adapter
    part("import")


# --- for the tests ----------------------------------------------------------------------------------------------------


def install(folder: Path, settings: list[str], name: str = NAME, works: bool = True) -> None:
    """Put a copy into the folder, as an installed package would bring it; the folder still has to be on sys.path."""
    module = f"{name}_adapter_of_tests"
    shutil.copy(__file__, folder / f"{module}.py")
    if not works:
        (folder / f"{module}.py").write_text("import no_such_engine\n")
    output = folder / f"{module}-1.0.dist-info"
    output.mkdir()
    (output / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    (output / "entry_points.txt").write_text(f"[slip_to_roll.adapters]\n{name} = {module}\n")
    ladder_is(folder, settings)


def break_down(folder: Path, name: str, where: str, way: str) -> None:
    """Make an installed copy fail where one of its parts is called, in one of the ways of `part`, or its file."""
    file = folder / f"{name}_adapter_of_tests.py"
    if where == "file":
        file.unlink()
        if way == "syntax":
            file.write_bytes(b"routes = ('native',\x00\n")
    else:
        file.with_suffix(".json").write_text(json.dumps({where: way}))


def ladder_is(folder: Path, settings: list[str]) -> None:
    """What it offers from now on."""
    (folder / "ladder.json").write_text(json.dumps(settings))


def runs_in(folder: Path) -> list[str]:
    """The settings it ran to the end so far, in order."""
    log = folder / "log.txt"
    return log.read_text().splitlines() if log.exists() else []
