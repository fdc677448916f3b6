"""Scripts of new users, and records of what the terminal printed, in `newcomers/`.

`python -m tests.walk.replay ENVIRONMENT` runs them with the wheel that is installed there and writes the records again.
Read every sentence of a record before you commit it.
"""

from __future__ import annotations

import re
import resource
import shutil
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from .installed import ROOT, Environment

FOLDER = Path(__file__).parent / "newcomers"
STARTER = ROOT / "starter"
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*.sh"))
# What differs from run to run or between machines, and what stands for it in a record.
VOLATILE = (
    (r"^[^:$\n]+: \d+ of \d+(?:, about .* left)?\n", ""),  # progress
    (r"^[^:$\n]+: \S+ (?:s|ms|µs) of CPU time per scenario.*\n", ""),  # the pace of a sweep
    (r"\d+(?:\.\d+)? s, \d+(?:\.\d+)? s of CPU time", "# s, # s of CPU time"),
    (r"\(since [^)]*\)", "(since #)"),
    (r"(passed|skipped|ran) in .*", r"\1 in #"),
    (r"\b\d+ kB", "# kB"),
    (r"\b[\d.]+e-1\d\b", "#"),  # rounding errors
)


def lines_of(name: str, folder: Path = FOLDER) -> list[str]:
    """The commands of a script."""
    lines = (folder / f"{name}.sh").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line[:1] not in ("", "#")]


class Times(NamedTuple):
    """Seconds of CPU and of wall time."""

    cpu: float
    wall: float


def run(name: str, environment: Environment, desk: Path, folder: Path = FOLDER) -> tuple[str, Times, Times]:
    """Run a script of a folder in an empty one that has only the files that it names, of its own and of the starter;
    returns the record, and the times until its first result and of all its commands."""
    text = (folder / f"{name}.sh").read_text(encoding="utf-8")
    for file in (*folder.iterdir(), *STARTER.iterdir()):
        if file.suffix not in (".sh", ".txt") and re.search(rf"\b{re.escape(file.name)}\b", text):
            shutil.copy(file, desk)
    parts, first = [], Times(0.0, 0.0)
    began = _now()
    for line in lines_of(name, folder):
        command, mark, _ = line.partition("  # first result")
        done = environment.run(command, desk, {"COLUMNS": "80"})
        status = f"[exit status {done.returncode}]\n" if done.returncode else ""
        parts.append(f"$ {command}\n{done.stdout}{done.stderr}{status}")
        if mark:
            first = _since(began)
    return _steady("\n".join(parts), desk), first, _since(began)


def _now() -> Times:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return Times(used.ru_utime + used.ru_stime, time.monotonic())


def _since(began: Times) -> Times:
    return Times(*(end - start for end, start in zip(_now(), began, strict=True)))


def _steady(text: str, desk: Path) -> str:
    """The text without what differs from run to run, and without spaces at the ends of lines."""
    text = text.replace(str(desk.resolve()), "DESK").replace(str(desk), "DESK")
    for pattern, instead in VOLATILE:
        text = re.sub(pattern, instead, text, flags=re.M)
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


def main(folder: str, *names: str) -> None:
    """Write the records of the scripts with the installed wheel of an environment."""
    environment = Environment.existing(Path(folder).resolve())
    for name in names or SCRIPTS:
        with TemporaryDirectory() as desk:
            record, *times = run(name, environment, Path(desk))
        (FOLDER / f"{name}.txt").write_text(record, encoding="utf-8")
        first, whole = (f"{each.cpu:.0f} s of CPU time, {each.wall:.0f} s" for each in times)
        print(f"{name}: first result after {first}; all after {whole}; read newcomers/{name}.txt", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
