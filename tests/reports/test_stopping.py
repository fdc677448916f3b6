"""Commands that are stopped: Ctrl-C is one sentence, and a kill leaves nothing that the next run does not mend."""

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from fnmatch import fnmatch
from pathlib import Path

import pandas as pd
import pytest

from cases.files.owned_folder import LIST
from reports import build, options
from reports.page.report_folder import of_report
from tests.sampling import quick_every

from .. import fake_adapter

ROOT = Path(__file__).parents[2]
CASE = fake_adapter.CASE
COMMANDS = {
    "build": ["reports.build", "--quick", "--case", CASE, "--solver", "fake"],
    "study": ["reports.study", "stability", "--case", CASE, "--solver", "fake"],
    "compare": ["reports.compare", CASE, "motion.csv"],
    "cases": ["cases"],
    "show": ["cases", "show", CASE],
    "check": ["cases", "check", "none.py"],
    "export": ["cases", "export", CASE],
    "laws": ["adapters.laws", "fake"],
    "sweep": ["reports.sweep", "disc_in_circle", "--vary", "mu=0.01:0.5:2000", "--vary", "xi1=0:1.5:2000"],
    "animate": ["reports.animate", CASE],
    "compare_builds": ["reports.compare_builds", "one", "other"],
    "truth": ["truth_elsewhere"],
    "console": ["slip-to-roll", "cases"],
}
NAMES = {command: words[0] for command, words in COMMANDS.items()} | {"truth": "reference"}
# `python -m reference` without options, a package as well, but that it leaves the suite's own truth alone.
TRUTH_ELSEWHERE = {
    "__init__": "import reference",
    "__main__": """
import sys
from pathlib import Path
from reference.__main__ import main

if __name__ == "__main__":
    sys.exit(main([], Path("truth.json")))
""",
}
MEASURED = ["cpu_s", "setup_s", "run_at"]


def started(folder: Path, words: list[str]) -> subprocess.Popen:
    """A command in a process group of its own, as a terminal starts one."""
    path = os.pathsep.join([str(ROOT), str(folder)])
    console = Path(sys.executable).with_name(words[0])
    program = [console, *words[1:]] if console.exists() else [sys.executable, "-m", *words]
    return subprocess.Popen(
        program, cwd=folder, text=True, start_new_session=True,
        env={**os.environ, "PYTHONPATH": path, "TMPDIR": str(folder / "tmp")},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip


def imports(command: subprocess.Popen) -> None:
    """Wait till it loads NumPy, however busy the machine is: our own first import is over, most others are to come."""
    maps, deadline = Path(f"/proc/{command.pid}/maps"), time.monotonic() + 60.0
    while command.poll() is None and "numpy" not in maps.read_text():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def interrupted(folder: Path, words: list[str], after: float, begun=lambda command: None) -> tuple[int, str]:
    """Status and what was said, after Ctrl-C reached every process of the terminal's group so long after it began."""
    command = started(folder, words)
    begun(command)
    time.sleep(after)
    if command.poll() is None:
        os.killpg(command.pid, signal.SIGINT)
    _, output = command.communicate(timeout=120.0)
    return command.returncode, output


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "tmp").mkdir()
    (tmp_path / "truth_elsewhere").mkdir()
    for name, text in TRUTH_ELSEWHERE.items():
        (tmp_path / "truth_elsewhere" / f"{name}.py").write_text(text)
    fake_adapter.install(tmp_path, ["wait 300", "wait 301"])
    return tmp_path


def check_interrupt(folder: Path, command: str, after: float, **begun) -> None:
    status, output = interrupted(folder, COMMANDS[command], after, **begun)
    assert "Traceback" not in output, output
    if status in (130, -signal.SIGINT):
        # It may have come to an end of its own just before.
        assert output.strip().splitlines()[-1].startswith((f"{NAMES[command]}: ", "cases: ", "truth_elsewhere: ")), (
            output
        )


@quick_every(2)
@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="the system does not report what a process has loaded")
@pytest.mark.parametrize(("command", "after"), [("cases", 0.0), ("build", 0.1), ("console", 0.2), ("truth", 0.3)])
def test_an_interrupt_is_one_sentence_already_while_modules_are_imported(command, after, folder):
    check_interrupt(folder, command, after, begun=imports)


@pytest.mark.slow
@pytest.mark.parametrize("after", [0.4, 0.8, 1.6, 3.0, 5.0])
@pytest.mark.parametrize("command", COMMANDS)
def test_an_interrupt_is_one_sentence_in_every_command_at_any_time(command, after, folder):
    check_interrupt(folder, command, after)


@pytest.mark.parametrize("command", ["build", "laws"])
def test_a_command_that_is_terminated_leaves_nothing(command, folder):
    program = started(folder, COMMANDS[command])
    deadline = time.monotonic() + 60.0
    # Not at the first file: Python tries its folder for temporary files with one of its own.
    while not unfinished(folder) and time.monotonic() < deadline:
        time.sleep(0.01)
    program.terminate()
    _, output = program.communicate(timeout=120.0)
    assert program.returncode == 143 and f"{NAMES[command]}: stopped" in output and left(folder) == []


# --- kills ------------------------------------------------------------------------------------------------------------

# Builds that are killed, one in each part of equal CPU time from the first import to the page. A trial costs about 10 s
# of CPU time: half a build without stored results, and the build that goes on.
KILLS = 12
# No build takes so long, however busy the machine is.
MOST_SECONDS = 900.0


def children(process: int) -> list[int]:
    """The processes that a process and its children have started and that still run (Linux)."""
    try:
        found = [int(word) for word in Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    except OSError:
        return []
    return [*found, *(below for child in found for below in children(child))]


def cpu_seconds(process: int) -> float:
    """CPU time of a process, its children and those of them that have ended (Linux)."""
    ticks = 0
    for one in (process, *children(process)):
        try:
            fields = Path(f"/proc/{one}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        ticks += sum(int(field) for field in fields[11:15])
    return ticks / os.sysconf("SC_CLK_TCK")


def wait_for_cpu(command: subprocess.Popen, seconds: float) -> None:
    """Wait until a command has taken so much CPU time, or has ended."""
    deadline = time.monotonic() + MOST_SECONDS
    while command.poll() is None and cpu_seconds(command.pid) < seconds:
        assert time.monotonic() < deadline
        time.sleep(0.01)


def tables(folder: Path) -> dict[str, pd.DataFrame]:
    """The tables of runs, without what differs from run to run."""
    found = {}
    for name in ("trajectories", "transitions", "headline", "convergence", "truth"):
        frame = pd.read_csv(folder / "report" / "tables" / f"{name}.csv", dtype=str)
        found[name] = frame.drop(columns=MEASURED, errors="ignore")
    return found


def is_whole(report: Path) -> bool:
    """Whether all files of a report are there as they were written, and no others but what the next build removes."""
    there = {p.relative_to(report).as_posix() for p in report.rglob("*") if p.is_file()}
    return {name for name in there if not name.startswith(".")} == {*of_report(report).names(), LIST}


def unfinished(folder: Path) -> list[str]:
    """The suite's own files that are not finished."""
    # os.walk passes over a folder that ends meanwhile; rglob raises.
    return [
        name for _, folders, files in os.walk(folder) for name in (*folders, *files) if fnmatch(name, ".slip-to-roll-*")
    ]


def left(folder: Path) -> list[str]:
    """What no report and no store is."""
    return [*unfinished(folder), *(path.name for path in (folder / "tmp").iterdir())]


def stopped(folder: Path, words: list[str], how: signal.Signals, kept: int) -> tuple[int, str]:
    """Stop a build when so many runs are in its store; returns its status and its last line."""
    command, deadline = started(folder, words), time.monotonic() + MOST_SECONDS
    while len(runs_kept(folder)) < kept:
        assert time.monotonic() < deadline and command.poll() is None, command.communicate()
        time.sleep(0.02)
    command.send_signal(how)
    _, output = command.communicate(timeout=MOST_SECONDS)
    return command.returncode, (output.strip().splitlines() or [""])[-1]


def runs_kept(folder: Path) -> list[Path]:
    return sorted((folder / ".slip-to-roll").glob("run-*.npz"))


def test_a_build_stopped_by_kill_9_or_ctrl_c_goes_on_where_it_was(
    folder, monkeypatch, capsys, without_figures, in_process
):
    """A run waits for the file of its name, so that a build is stopped at the same run on every machine."""
    fake_adapter.ladder_is(folder, ["wait 0", "until second", "until third"])
    words = ["--quick", "--case", CASE, "--solver", "fake", "--jobs", "1"]
    assert stopped(folder, ["reports.build", *words], signal.SIGKILL, kept=1)[0] == -signal.SIGKILL
    (damaged,) = runs_kept(folder)
    (folder / "second").touch()
    status, output = stopped(folder, ["reports.build", *words], signal.SIGINT, kept=2)
    assert status == 130
    assert output.startswith("reports.build: stopped; ") and "the same command continues from there" in output
    assert not (folder / "report").exists() and list(folder.glob("*.partial")) == []
    damaged.write_bytes(b"garbage")
    (folder / ".slip-to-roll" / "thesis.tex").write_text("precious")

    (folder / "third").touch()
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setattr(options, "STORE", ".slip-to-roll")
    with without_figures(), in_process():
        assert build.main(words) == 0
        out = capsys.readouterr().out
        ran, resumed = fake_adapter.runs_in(folder), tables(folder)
    assert "store: 1 run and 1 truth taken from the store" in out
    assert f"store: could not be read, and were made again: 1, such as {damaged.name}" in out
    assert "store: foreign files, not touched: 1, such as thesis.tex" in out
    assert (ran.count("wait 0"), ran.count("until second")) == (2, 1)  # the damaged one again
    whole_build(folder, ["reports.build", *words, "--fresh"])  # a process as those that were stopped
    for name, frame in tables(folder).items():
        pd.testing.assert_frame_equal(resumed[name], frame, obj=name)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="it asks the system for children")
@pytest.mark.parametrize("effort", ["--quick", "--default"])
def test_killed_anywhere_a_build_goes_on_to_identical_tables_and_leaves_nothing(effort, folder):
    rng = random.Random(20)
    words = ["reports.build", *(["--quick"] if effort == "--quick" else []), "--case", CASE, "--solver", "fake"]
    words += ["--store", str(folder / ".slip-to-roll")]
    took, expected, killed = whole_build(folder, words), tables(folder), 0
    for part in range(KILLS):
        for path in (folder / ".slip-to-roll").glob("*.npz"):
            path.unlink()
        command = started(folder, words)
        wait_for_cpu(command, took * (part + rng.random()) / KILLS)
        victim = rng.choice([command.pid, *children(command.pid)])
        if command.poll() is None:
            with suppress(ProcessLookupError):  # a worker may have ended meanwhile
                os.kill(victim, signal.SIGKILL)
                killed += 1
        _, output = command.communicate(timeout=MOST_SECONDS)
        if command.returncode == -signal.SIGKILL:
            # The old report stands or the new one, as a whole; for an instant, while one takes the other's place, none.
            assert not (folder / "report" / "index.html").exists() or is_whole(folder / "report")
        else:
            assert command.returncode == 0, output
        whole_build(folder, words)
        for name, frame in tables(folder).items():
            pd.testing.assert_frame_equal(frame, expected[name], obj=name)
        assert left(folder) == []
    assert killed >= KILLS // 2


def whole_build(folder: Path, words: list[str]) -> float:
    """Run a build to its end; returns its CPU time, s."""
    before = os.times()
    command = started(folder, words)
    _, output = command.communicate(timeout=MOST_SECONDS)
    assert command.returncode == 0, output
    now = os.times()
    return now.children_user + now.children_system - before.children_user - before.children_system


# The handler is set because a process that a shell starts in the background ignores the signal.
IN_A_CALLBACK = """
import signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from cases.files.keyboard_interrupt import say_so
say_so("a command")
class Ends:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
Ends()  # Python ignores an exception of __del__, and of callbacks in the middle of an import
for _ in range(400):
    time.sleep(0.05)
print("went on")
"""


def test_an_interrupt_that_python_ignores_in_a_callback_stops_the_command():
    output = subprocess.run([sys.executable, "-c", IN_A_CALLBACK], capture_output=True, text=True, timeout=60)
    assert (output.stdout, output.stderr) == ("", "\na command: stopped\n")
