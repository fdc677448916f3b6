"""The pytest plugin in an empty folder, as an engine project uses it: a right engine, wrong ones, and wrong options."""

import os
import re
import subprocess
import sys
from importlib.metadata import entry_points
from math import nan
from pathlib import Path

import pytest

from cases import Mode
from cases.commands import TEMPLATE
from reports.engine_tests import _times, apart
from reports.judging.ledger import LedgerRow

ROOT = Path(__file__).parents[2]
ENGINE = ROOT / "starter" / "engine.py"
# An installation that is older than the entry point does not have it: the plugin is then named.
PLUGIN = [] if [*entry_points(group="pytest11", name="slip_to_roll")] else ["-p", "pytest_slip_to_roll"]


@pytest.fixture
def project(tmp_path):
    """An empty folder with the starter engine, and a function that runs pytest there."""

    def run(*words: str, change: tuple[str, str] | None = ("", "")):
        if change:
            text = ENGINE.read_text()
            assert change[0] in text
            (tmp_path / "my_engine").write_text(text.replace(*change) if change[0] else text)
        (tmp_path / "my_engine").chmod(0o755)
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-ra", "-q", *PLUGIN, *words]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, env=environment)
        return done.returncode, done.stdout + done.stderr

    run.folder = tmp_path
    return run


OURS = ("--slip-to-roll-engine", "./my_engine")


def test_a_right_engine_passes_and_what_it_does_not_support_is_skipped(project):
    status, out = project(*OURS)
    assert status == 0 and "5 passed, 2 skipped" in out, out
    assert "unsupported: Only discs in contact with a line or a circle" in out


def test_friction_that_is_a_fifth_too_large_fails_with_the_reason(project):
    status, out = project(
        *OURS,
        "-k",
        "slide_to_roll",
        "--junitxml=out.xml",
        change=('{"mu": 0.0})["mu"]\n    bend', '{"mu": 0.0})["mu"] * 1.2\n    bend'),
    )
    assert status == 1 and "1 failed, 6 deselected" in out, out
    assert "of the error of ignoring friction" in out and "slip_forward -> roll" in out and "Traceback" not in out
    assert 'classname="slip-to-roll"' in (project.folder / "out.xml").read_text()  # dashboards group by it
    assert re.search(r"off is \d+ %, and good is at most 1 % of", out), out


@pytest.mark.parametrize(
    ("grade", "says"), [("good", "1 failed"), pytest.param("rough", "1 passed", marks=pytest.mark.slow)]
)
def test_friction_that_is_a_twentieth_too_small_is_rough_and_not_good(grade, says, project):
    # Good is at most 1 % of the error of ignoring friction, rough 10 %.
    change = ('{"mu": 0.0})["mu"]\n    bend', '{"mu": 0.0})["mu"] * 0.95\n    bend')
    _, out = project(*OURS, "-k", "slide_to_roll", "--slip-to-roll-grade", grade, change=change)
    assert says in out, out


def test_an_engine_that_supports_no_case_is_not_green(project):
    (project.folder / "my_engine").write_text("#!/bin/sh\nexit 3\n")
    status, out = project(*OURS, change=None)
    assert status == 1 and "7 skipped" in out and "my_engine supports none of the cases that were run" in out, out


def test_what_an_adapter_refuses_is_skipped(project):
    """It was run all the same, and failed or crashed."""
    status, out = project("--slip-to-roll-engine", "pymunk", "-k", "cone_holds or rolling_resistance")
    assert status == 0 and "2 passed, 2 skipped" in out and "unsupported: " in out, out


def test_a_case_file_without_an_engine_says_what_is_missing(project):
    status, out = project("--case-file=my_slopes.py")
    assert status == 4 and "add --slip-to-roll-engine ENGINE" in out, out


# The truth of these tests' process is taken away: what is then said of an engine that answers, and of one that refuses.
NO_TRUTH = """
import pytest
from reports import engine_tests
from reports.running.records import Truth
engine_tests.find_truth = lambda case: Truth(failure="a reason")
"""


def test_a_missing_truth_is_an_error_of_the_suite_and_unsupported_comes_first(project):
    (project.folder / "conftest.py").write_text(NO_TRUTH)
    status, out = project(*OURS, "-k", "cone_holds or rolling_resistance")
    assert status == 1 and "1 skipped, 5 deselected, 1 error" in out, out
    assert "slip-to-roll has no truth of this case, which is no fault of the engine: a reason" in out, out


@pytest.mark.slow
def test_a_contact_that_creeps_fails(project):
    # A regularised contact never holds: it brakes a part of the slip that rolling would need to stop.
    status, out = project(
        *OURS, "-k", "creep", change=("stop = -((u + r * omega) / h", "stop = -(0.02 * (u + r * omega) / h")
    )
    assert status == 0, out  # a small lag is no creep
    status, out = project(
        *OURS, "-k", "creep", change=("stop = -((u + r * omega) / h + along)", "stop = -(5.0 * (u + r * omega))")
    )
    assert status == 1 and "the contact creeps at" in out, out


@pytest.mark.slow
def test_an_engine_that_crashes_fails_with_its_message(project):
    status, out = project(
        *OURS,
        "-k",
        "cone_holds",
        change=("def main() -> int:\n", "def main() -> int:\n    raise OSError('no licence')\n"),
    )
    assert status == 1 and "crashed" in out and "no licence" in out


@pytest.mark.slow
def test_the_cases_of_a_file_replace_the_phenomena(project):
    text = TEMPLATE.format(name="my_valley").replace("(s, -depth * cos(2 * s))", "(s, -0.5 * depth * s)")
    (project.folder / "my_slopes.py").write_text(text)
    status, out = project(*OURS, "--case-file=my_slopes.py", "-rA")
    assert status == 0 and "PASSED slip-to-roll::my_engine-my_valley" in out and "1 passed" in out, out


def slowly(*values):
    """A parameter of the slow tests: each starts a process."""
    return pytest.param(*values, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--slip-to-roll-engine", "./none"), "none is no executable file"),
        (("--slip-to-roll-engine", "pymunkk"), "pymunk; did you mean pymunk?"),
        slowly((*OURS, "--slip-to-roll-step", "fast"), "--slip-to-roll-step is 'fast'; give a step in s, for example"),
        slowly((*OURS, "--slip-to-roll-grade", "goood"), "there is no grade 'goood'; choose from excellent, good"),
        slowly((*OURS, "--case-file=none.py"), "none.py"),
    ],
)
def test_wrong_options_give_one_line(words, says, project):
    status, out = project(*words)
    assert status == 4 and says in out and "Traceback" not in out, out


def test_without_its_options_the_plugin_imports_nothing_and_adds_nothing(project):
    (project.folder / "test_mine.py").write_text(
        "import sys\n\ndef test_mine():\n    assert not {'numpy', 'sympy', 'reference'} & sys.modules.keys()\n"
    )
    status, out = project()
    assert status == 0 and "1 passed" in out, out


def test_messages_have_the_digits_that_decide_and_no_nan():
    """ "1 % off; good is at most 1 %" was 1.04 %."""
    assert apart(1.04, 1.0) == ("1.04", "1")
    assert apart(170.0, 1.0) == ("170", "1") and apart(1.0000004, 1.0) == ("1.0000004", "1")
    missed = LedgerRow(1, Mode.ROLL, Mode.REST, nan, 2.038741, nan, "missed")
    spurious = LedgerRow(1, Mode.FLIGHT, Mode.ROLL, 0.3185, nan, nan, "spurious")
    assert _times(missed) == "missing, truth 2.03874 s" and _times(spurious) == "at 0.3185 s, truth missing"
