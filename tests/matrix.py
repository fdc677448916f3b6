"""The two commands in environments of their own: every Python, lowest and newest versions, with and without heyoka.

    python3 tests/matrix.py               # each environment: make quick, make test; the table goes to docs/install.md
    python3 tests/matrix.py --only 3.13   # only the environments whose name contains "3.13"
    python3 tests/matrix.py --part        # for .ci/run: make test in the newest other Python, without heyoka

Each environment is a fresh clone of the last commit with an empty home folder. Its row is saved as soon as it ends, and
the next call runs only environments that have no row of the last commit; `--fresh` runs all of them again. Where heyoka
is left out, a constraint makes it impossible to install, as on a machine that it has no wheels for. Exit status: 0; 1
if anything failed in any environment; 2 if nothing can be run. Only the standard library is imported: it begins before
anything is installed.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "install.md"
BEGIN, END = "<!-- written by `make matrix` -->", "<!-- until here -->"
WORK = ROOT / ".cache" / "matrix"
OLDEST = (3, 11)
# A command that hangs is a row, too: a whole test run takes some minutes on a quiet machine.
LIMIT = 7200.0
# What an interpreter says of itself; it fails where it cannot make environments.
ASK = (
    "import ensurepip, json, platform, sys, venv; v = sys.version_info; "
    "print(json.dumps([platform.python_implementation(), sys.prefix == sys.base_prefix, list(v[:3]), v.releaselevel]))"
)
# Variables that would make an environment other than a user's.
LEFT_OUT = (
    "VIRTUAL_ENV", "PYTHONPATH", "PYTHONHOME", "PYTHONDONTWRITEBYTECODE", "MAKEFLAGS", "MFLAGS", "MAKELEVEL",
    "SLIP_TO_ROLL_CACHE",
)  # fmt: skip
HEYOKA = "import importlib.util as u; print(u.find_spec('heyoka') is not None)"


class Python(NamedTuple):
    """An interpreter that environments can be made of."""

    path: Path
    version: tuple[int, int, int]

    @property
    def text(self) -> str:
        return ".".join(map(str, self.version))


class Environment(NamedTuple):
    """What is installed: `versions` is lowest, current (those of constraints/current.txt) or newest."""

    python: Python
    versions: str
    heyoka: bool

    @property
    def name(self) -> str:
        return f"{self.python.text}-{self.versions}-{'with' if self.heyoka else 'without'}-heyoka"


class Command(NamedTuple):
    """A column of the table and the words of its command, run in the clone."""

    column: str
    words: tuple[str, ...]


class Outcome(NamedTuple):
    """How a command ended: whether it succeeded, what the table says of it, and its wall time (s)."""

    passed: bool
    text: str
    seconds: float


class Row(NamedTuple):
    """The outcomes in one environment, by column; the commit that was tried, and the day."""

    environment: Environment
    outcomes: dict[str, Outcome]
    commit: str = ""
    day: str = ""

    @property
    def passed(self) -> bool:
        return all(outcome.passed for outcome in self.outcomes.values())


# --- interpreters -----------------------------------------------------------------------------------------------------


def candidates() -> list[Path]:
    """Where interpreters are looked for: PATH, and the folders of pyenv and uv."""
    folders = [Path(folder) for folder in os.environ.get("PATH", "").split(os.pathsep) if folder]
    found = [file for folder in folders for file in sorted(folder.glob("python3*"))]
    home = Path.home()
    for versions in (Path(os.environ.get("PYENV_ROOT", home / ".pyenv")) / "versions", home / ".local/share/uv/python"):
        found += sorted(versions.glob("*/bin/python3"))
    names = re.compile(r"python3(\.\d+)?")
    return [file for file in found if names.fullmatch(file.name) and os.access(file, os.X_OK)]


def interpreter(path: Path) -> Python | None:
    """The interpreter at that path; None if it is none that environments can be made of, or older than `OLDEST`."""
    try:
        said = subprocess.run([path, "-c", ASK], capture_output=True, text=True, timeout=60.0)
        implementation, outside, version, level = json.loads(said.stdout)
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return None
    if implementation != "CPython" or not outside or level != "final" or tuple(version[:2]) < OLDEST:
        return None
    return Python(path, tuple(version))


def pythons(paths: Iterable[Path]) -> list[Python]:
    """Of each minor version the newest interpreter, in the order of versions."""
    newest: dict[tuple[int, ...], Python] = {}
    for path in dict.fromkeys(paths):
        one = interpreter(path)
        if one and one.version > newest.get(one.version[:2], Python(path, (0, 0, 0))).version:
            newest[one.version[:2]] = one
    return sorted(newest.values(), key=lambda one: one.version)


def whole(found: Sequence[Python]) -> list[Environment]:
    """Every Python with lowest and newest versions, with and without heyoka."""
    return [Environment(one, v, heyoka) for one in found for v in ("lowest", "newest") for heyoka in (True, False)]


def part(found: Sequence[Python], own: tuple[int, ...]) -> list[Environment]:
    """The newest Python other than version `own`, without heyoka; where there is no other, that one."""
    others = [one for one in found if one.version[:2] != own[:2]] or [*found]
    return [Environment(one, "current", False) for one in others[-1:]]


# --- one environment --------------------------------------------------------------------------------------------------


def constraints(environment: Environment) -> str:
    """The text of the constraints file that an environment is installed with."""
    file = ROOT / "constraints" / f"{environment.versions}.txt"
    pins = "" if environment.versions == "newest" else file.read_text(encoding="utf-8")
    if environment.heyoka:
        return pins
    return "".join(f"{pin}\n" for pin in pins.splitlines() if not pin.startswith("heyoka")) + "heyoka<0\n"


def commands(environment: Environment, pinned: Path, partly: bool) -> list[Command]:
    """What is run in an environment whose constraints are in the file `pinned`."""
    make = ("make", f"PYTHON={environment.python.path}", f"CONSTRAINTS={pinned}")
    python = ".venv/bin/python"
    head = [Command("installation", (*make, ".venv/installed")), Command("heyoka", (python, "-c", HEYOKA))]
    if partly:  # .ci/run makes the report, and has something else for the other core
        return [*head, Command("tests", (*make, "JOBS=1", "test"))]
    return [*head, Command("quick report", (*make, "quick")), Command("tests", (*make, "test"))]


def run(command: Command, clone: Path, home: Path, log: Path) -> Outcome:
    """Run a command in the clone with that home folder; what it says goes to the end of `log`."""
    variables = {name: value for name, value in os.environ.items() if name not in LEFT_OUT}
    # What pip has downloaded serves all environments.
    variables |= {"HOME": str(home), "PIP_CACHE_DIR": os.environ.get("PIP_CACHE_DIR", str(Path.home() / ".cache/pip"))}
    began = time.monotonic()
    with log.open("a+", encoding="utf-8") as said:
        said.write(f"$ {' '.join(command.words)}\n")
        said.flush()
        start = said.tell()
        try:
            words = dict(cwd=clone, env=variables, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT)
            status: int | None = subprocess.run(command.words, timeout=LIMIT, **words).returncode  # type: ignore[call-overload]
        except subprocess.TimeoutExpired:
            status = None
        said.seek(start)
        text = said.read()
    return Outcome(status == 0, summary(command.column, status, text), time.monotonic() - began)


def summary(column: str, status: int | None, said: str) -> str:
    """What the table says of a command that ended with that status (None: out of time) and said that."""
    if status is None:
        return f"still running after {LIMIT:.0f} s"
    counts = re.findall(r"^(?:=+ )?((?:\d+ \w+(?:, )?)+) in [\d.]+s", said, flags=re.M)
    if counts:
        failed = ", ".join(f"`{test}`" for test in re.findall(r"^(?:FAILED|ERROR) (\S+)", said, flags=re.M))
        return re.sub(r", \d+ (deselected|warnings?)", "", counts[-1]) + (f": {failed}" if failed else "")
    if status:
        return f"failed (exit status {status})"
    return {"True": "yes", "False": "no"}.get(said.strip(), "passed") if column == "heyoka" else "passed"


def row(environment: Environment, partly: bool, log: Path, commit: str = "") -> Row:
    """Everything in a fresh clone; after a failure only what does not need it is run."""
    outcomes: dict[str, Outcome] = {}
    with tempfile.TemporaryDirectory(prefix=f"{environment.name}-", dir=WORK) as folder:
        clone, home, pinned = Path(folder) / "clone", Path(folder) / "home", Path(folder) / "constraints.txt"
        home.mkdir()
        pinned.write_text(constraints(environment), encoding="utf-8")
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
        for command in commands(environment, pinned, partly):
            outcomes[command.column] = run(command, clone, home, log)
            if command.column == "installation" and not outcomes[command.column].passed:
                break
    return Row(environment, outcomes, commit, time.strftime("%Y-%m-%d"))


# --- saved rows ------------------------------------------------------------------------------------------------------


def save(one: Row) -> None:
    """Write a row next to its log, so that an interrupted matrix goes on where it ended."""
    text = json.dumps({"commit": one.commit, "day": one.day, "outcomes": one.outcomes}, indent=1)
    (WORK / f"{one.environment.name}.json").write_text(text + "\n", encoding="utf-8")


def saved(environment: Environment) -> Row | None:
    """The last row of an environment; None if there is none."""
    try:
        found = json.loads((WORK / f"{environment.name}.json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    outcomes = {column: Outcome(*outcome) for column, outcome in found["outcomes"].items()}
    return Row(environment, outcomes, found["commit"], found["day"])


# --- the table --------------------------------------------------------------------------------------------------------


def table(rows: Sequence[Row]) -> str:
    """The rows as Markdown, what was not run as "–"."""
    columns = list(dict.fromkeys(column for one in rows for column in one.outcomes))
    lines = [("Python", "versions", *columns, "commit", "date"), ("---",) * (len(columns) + 4)]
    for one in rows:
        cells = [_cell(one, column) for column in columns]
        lines.append((one.environment.python.text, one.environment.versions, *cells, one.commit, one.day))
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _cell(one: Row, column: str) -> str:
    outcome = one.outcomes.get(column)
    if outcome is None:
        return "–"
    if column == "heyoka" and outcome.text != ("yes" if one.environment.heyoka else "no"):
        return f"{outcome.text}, though {'asked for' if one.environment.heyoka else 'left out'}"
    return outcome.text if column == "heyoka" else f"{outcome.text}, {outcome.seconds:.0f} s"


def keep(text: str, page: Path = PAGE) -> None:
    """Write the table into its place in a page; raises ValueError if it has none."""
    old = page.read_text(encoding="utf-8")
    new, count = re.subn(f"{BEGIN}.*?{END}", lambda _: f"{BEGIN}\n{text}{END}", old, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"{page} has no part between {BEGIN} and {END}; put both lines where the table belongs")
    page.write_text(new, encoding="utf-8")


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def main(argv: Sequence[str] | None = None, say: Callable[[str], None] = lambda line: print(line, flush=True)) -> int:
    """The command; returns its exit status."""
    parser = argparse.ArgumentParser(prog="make matrix", description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("--part", action="store_true", help="one environment, for .ci/run")
    parser.add_argument("--python", nargs="+", type=Path, metavar="PATH", help="these interpreters and no others")
    parser.add_argument("--only", nargs="+", default=[""], metavar="TEXT", help="environments whose name contains one")
    parser.add_argument("--fresh", action="store_true", help="run environments again that have a row of this commit")
    given = parser.parse_args(argv)
    found = pythons(given.python or [Path(sys.executable), *candidates()])
    if not found:
        say("no Python from 3.11 on was found that can make environments; name one: --python PATH")
        return 2
    say(f"Python {', '.join(one.text for one in found)}")
    if given.part and len(found) == 1:
        say(f"no other Python from 3.11 on was found: tried with {found[0].text} only")
    try:
        commit = _git("rev-parse", "--short", "HEAD")
        changed = _git("status", "--porcelain")
    except (OSError, subprocess.CalledProcessError):
        say(f"{ROOT} is no clone of a repository, of which each environment gets a fresh one; clone it first")
        return 2
    if changed:
        say(f"what is not committed is not part of it: the last commit is {commit}")
    environments = part(found, sys.version_info[:2]) if given.part else whole(found)
    wanted = [one for one in environments if any(text in one.name for text in given.only)]
    if not wanted and environments:
        say(f"no environment's name contains that; they are {', '.join(one.name for one in environments)}")
        return 2
    WORK.mkdir(parents=True, exist_ok=True)
    rows = {} if given.part else {one: old for one in environments if (old := saved(one))}
    for number, environment in enumerate(wanted, start=1):
        log = WORK / f"{environment.name}.log"
        if environment in rows and rows[environment].commit == commit and not given.fresh:
            say(f"{number} of {len(wanted)}, {environment.name} has a row of commit {commit}; --fresh runs it again")
            continue
        log.unlink(missing_ok=True)
        say(f"{number} of {len(wanted)}, {environment.name} begins; what it says: {log}")
        rows[environment] = done = row(environment, given.part, log, commit)
        say("  " + "; ".join(f"{column}: {_cell(done, column)}" for column in done.outcomes))
        if not given.part:
            save(done)
            keep(f"{os.cpu_count()} cores:\n\n{table([rows[one] for one in environments if one in rows])}")
    say(table([rows[one] for one in environments if one in rows]).rstrip())
    return 0 if all(rows[one].passed for one in wanted) else 1


if __name__ == "__main__":
    sys.exit(main())
