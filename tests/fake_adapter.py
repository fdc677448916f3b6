"""An adapter for tests of what happens to a run: a disc bowled on a line, exactly, but for the ways to fail it offers.

A test copies this file to a folder of its own and installs it there (`install`); `ladder.json` beside the copy says
what its settings are, `log.txt` what it ran. `break_down` makes a copy fail in one of its parts; `callers.txt` names
the processes in which any part of any copy ran.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path

import numpy as np

from adapters import EngineFailure, Setting
from cases import State, Trajectory

NAME = "fake"
routes = ("native",)
HERE = Path(__file__).parent
CASE = "disc_on_line[mu=0.1]"


def part(name: str) -> None:
    """What happens wherever a part of the adapter is called: it is noted by whom, and fails if it was made to."""
    with open(HERE / "callers.txt", "a") as callers:
        callers.write(f"{os.getpid()}\n")
    habits = HERE / f"{Path(__file__).stem}.json"
    way = json.loads(habits.read_text()).get(name) if habits.exists() else None
    if way == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif way == "hang":
        while True:
            time.sleep(1.0)
    elif way == "prints":
        os.write(1, b"all is well\n")
        print("all is well", file=sys.stderr)


def refuses(case, route):
    part("refuses")
    return None


def ladder(case, route):
    part("ladder")
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
    elif how == "until told":
        while not (HERE / "told").exists():
            time.sleep(0.01)
    elif how == "until killed":
        (HERE / "pid").write_text(str(os.getpid()))
        time.sleep(60.0)
    elif how == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif how == "no library":
        raise ImportError("libfake.so is missing")


def read(model):
    part("read")
    case, how = model
    if how == "gives up":
        raise EngineFailure("Newton gave up")
    motion = bowled(case, np.linspace(0.0, case.duration, 301))
    if how == "nan":
        motion.x[5] = np.nan
    if how == "never rolls":
        motion.slip[:] += 0.5
    with open(HERE / "log.txt", "a") as log:
        log.write(f"{how}\n")
    return motion


def version():
    part("version")
    return "1.0"


def bowled(case, t) -> Trajectory:
    """The exact motion of `disc_on_line` with mu = 0.1: it slips until v0/(3 mu g) and rolls from there."""
    v0, mu, g, r = 1.0, 0.1, 9.81, case.plate.radius
    turn = v0 / (3 * mu * g)
    slipping, rolling = np.minimum(t, turn), np.maximum(t - turn, 0.0)
    vx = v0 - mu * g * slipping
    slip = np.where(t < turn, v0 - 3 * mu * g * t, 0.0)
    x = v0 * slipping - mu * g * slipping**2 / 2 + (v0 - mu * g * turn) * rolling
    theta = -mu * g * slipping**2 / r - (v0 - mu * g * turn) / r * rolling
    friction = np.where(t < turn, -mu * g, 0.0)
    zero = np.zeros(len(t))
    state = State(x, zero + r, theta, vx, zero, (slip - vx) / r, slip, zero + g, friction, x, x)
    return Trajectory(t=t, **state._asdict())


part("import")


# --- for the tests ----------------------------------------------------------------------------------------------------


def install(folder: Path, settings: list[str], name: str = NAME, works: bool = True) -> None:
    """Put a copy into the folder, as an installed package would bring it; the folder still has to be on sys.path."""
    module = f"{name}_adapter_of_tests"
    shutil.copy(__file__, folder / f"{module}.py")
    if not works:
        (folder / f"{module}.py").write_text("import no_such_engine\n")
    told = folder / f"{module}-1.0.dist-info"
    told.mkdir()
    (told / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    (told / "entry_points.txt").write_text(f"[slip_to_roll.adapters]\n{name} = {module}\n")
    ladder_is(folder, settings)


def break_down(folder: Path, name: str, where: str, way: str) -> None:
    """Make an installed copy "segfault", "hang" or say something ("prints") where one of its parts is called."""
    (folder / f"{name}_adapter_of_tests.json").write_text(json.dumps({where: way}))


def ladder_is(folder: Path, settings: list[str]) -> None:
    """What it offers from now on."""
    (folder / "ladder.json").write_text(json.dumps(settings))


def runs_in(folder: Path) -> list[str]:
    """The settings it ran to the end so far, in order."""
    log = folder / "log.txt"
    return log.read_text().splitlines() if log.exists() else []
