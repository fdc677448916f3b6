"""Plant the faults of `faults.toml` in a copy of the tree, one at a time, and record which test finds each.

    python -m tests.yardstick.plant            # all faults; writes the column `result` into results.csv
    python -m tests.yardstick.plant --check    # only whether each patch still applies
    python -m tests.yardstick.plant r02 a05    # only these

A fault is found if its test passes on the tree as it is and fails with the fault. Each run is a copy of one process
that has imported the packages: to import them takes longer than most of the tests.
"""

from __future__ import annotations

import csv
import importlib
import os
import shutil
import signal
import sys
import tempfile
import time
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FAULTS, RESULTS = HERE / "faults.toml", HERE / "results.csv"
FOLDERS = ("cases", "reference", "adapters", "reports", "tests", "docs", "starter", "examples")
# Seconds; the dearest test takes a tenth of it. A fault that makes its test hang is found.
LIMIT = 300.0
PACKAGES = ("numpy", "scipy.optimize", "scipy.integrate", "sympy", "mpmath", "pandas")


# Where the test that is to find a fault comes from: named before the fault was planted; another one that was there,
# after that one had missed the fault; written for the fault, after those had missed it too.
CHOICES = ("first", "other", "added")
# What a run of pytest with the fault says of it. "does not run": pytest ended with an error of its own, or without a
# test.
ANSWERS = {"failed": "found", "passed": "not found", "none": "does not run"}


class Fault(NamedTuple):
    """A row of `faults.toml`: `behaviour` states it, `claim` is the row of docs/architecture.md that it breaks; in
    `file` the text `before`, which stands there once, becomes `after`; `test`, with pytest's -k `only`, is to find it.
    `choice` says how that test was chosen: see CHOICES.
    """

    id: str
    room: str
    claim: str
    behaviour: str
    file: str
    before: str
    after: str
    test: str
    only: str = ""
    choice: str = "first"


def faults() -> list[Fault]:
    """All rows, in order."""
    return [Fault(**row) for row in tomllib.loads(FAULTS.read_text(encoding="utf-8"))["fault"]]


def with_patch(fault: Fault, text: str) -> str:
    """The file's text with the fault; raises ValueError if the text before is not there exactly once."""
    if (count := text.count(fault.before)) != 1:
        raise ValueError(f"{fault.id}: {fault.file} has the text to replace {count} times; write `before` again")
    return text.replace(fault.before, fault.after)


def run_tests(tree: Path, nodes: Sequence[str], only: str = "", limit: float = LIMIT) -> str:
    """ "passed", "failed" or "none" (no such test, or pytest does not run) of a tree, in a copy of this process."""
    child = os.fork()
    if child == 0:
        status = 3
        try:
            status = _run_here(tree, nodes, only)
        finally:
            os._exit(status)
    until = time.monotonic() + limit
    while not (answer := os.waitpid(child, os.WNOHANG))[0]:
        if time.monotonic() > until:
            os.killpg(child, signal.SIGKILL)
        time.sleep(0.05)
    # 1: a test fails, 2: its file cannot be imported; less than 0: ended by a signal; else pytest's own faults.
    exitcode = os.waitstatus_to_exitcode(answer[1])
    return "passed" if exitcode == 0 else "failed" if exitcode in (1, 2) or exitcode < 0 else "none"


def _run_here(tree: Path, nodes: Sequence[str], only: str) -> int:
    """pytest's status for tests of a tree, silently."""
    os.setsid()
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1), os.dup2(silent, 2)
    os.chdir(tree)
    sys.path.insert(0, str(tree))
    os.environ["PYTHONPATH"] = str(tree)
    for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
        del sys.modules[name]  # those of this tree
    import pytest

    selection = ["-k", only] if only else []
    return int(
        pytest.main(
            ["-x", "-q", "-p", "no:xdist", "-p", "no:cacheprovider", "--thorough", "-m", "", *selection, *nodes]
        )
    )


def without_faults(tree: Path, selection: Sequence[Fault]) -> dict[str, str]:
    """What the tests say of the tree as it is, by fault: all at once, each alone if one of them does not pass."""
    alike = dict.fromkeys(fault.test for fault in selection if not fault.only)
    together = run_tests(tree, list(alike), limit=LIMIT * len(selection)) if alike else "passed"
    return {
        fault.id: "passed" if together == "passed" and not fault.only else run_tests(tree, [fault.test], fault.only)
        for fault in selection
    }


def with_fault(tree: Path, fault: Fault) -> str:
    """What the fault's test says of it: one of ANSWERS."""
    path = tree / fault.file
    old, times = path.read_text(encoding="utf-8"), path.stat()
    try:
        path.write_text(with_patch(fault, old), encoding="utf-8")
        return ANSWERS[run_tests(tree, [fault.test], fault.only)]
    finally:
        path.write_text(old, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # Python's compiled files go by the time


def read_results() -> dict[str, str]:
    """The last result of each fault."""
    with RESULTS.open(encoding="utf-8", newline="") as file:
        return {row["id"]: row["result"] for row in csv.DictReader(file)}


def write_results(results: Mapping[str, str]) -> None:
    """Write the results, in the order of the faults."""
    with RESULTS.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["id", "result"])
        writer.writerows([fault.id, results[fault.id]] for fault in faults() if fault.id in results)


def main(words: Sequence[str]) -> int:
    """Run the command; status 1 if a fault that was found is found no more, or a patch does not apply."""
    selection = [fault for fault in faults() if fault.id in words or not set(words) - {"--check"}]
    for fault in selection:
        with_patch(fault, (ROOT / fault.file).read_text(encoding="utf-8"))
    if "--check" in words:
        print(f"{len(selection)} faults can be planted")
        return 0
    for package in PACKAGES:
        importlib.import_module(package)
    results = read_results() if RESULTS.exists() else {}
    losses = []
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder)
        for name in FOLDERS:
            shutil.copytree(ROOT / name, tree / name, symlinks=True)
        for path in ROOT.iterdir():
            if path.is_file():
                shutil.copy2(path, tree / path.name)
        plain = without_faults(tree, selection)
        for fault in selection:
            sound = plain[fault.id] == "passed"
            result = with_fault(tree, fault) if sound else f"without the fault: {plain[fault.id]}"
            losses += [fault.id] if results.get(fault.id) == "found" != result else []
            results[fault.id] = result
            print(f"{fault.id} {result}: {fault.behaviour}", flush=True)
            write_results(results)
    count = list(results.values()).count("found")
    print(f"found no more: {', '.join(losses)}" if losses else f"{count} of {len(results)} found")
    return int(bool(losses))


if __name__ == "__main__":
    # So that the copy of the tree is removed; `cases.files.command_line` cannot be imported, the copy's is.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    sys.exit(main(sys.argv[1:]))
