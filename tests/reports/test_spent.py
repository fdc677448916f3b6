"""Where the time went: every second is some phase's, and the CPU time of what was started counts."""

import subprocess
import sys

import pytest

from reports.running.timing import phase_times
from reports.running.timing.phase_times import PhaseTime, PhaseTimes


def test_every_second_is_booked_once_and_a_phase_that_comes_again_adds_up():
    now = iter([PhaseTime(5.0, 1.0), PhaseTime(7.0, 2.0), PhaseTime(17.0, 22.0), PhaseTime(18.0, 22.5)])
    ledger = PhaseTimes(lambda: next(now))
    for phase in ("survey", "runs", "survey"):
        ledger.book(phase)
    assert ledger.phases == {"survey": PhaseTime(3.0, 1.5), "runs": PhaseTime(10.0, 20.0)}
    assert phase_times.total_words(ledger.phases) == "13 s, 22 s of CPU time"
    assert phase_times.parts_words(ledger.phases) == "runs 10 s, survey 3 s"
    assert phase_times.time_summary(ledger.phases)["runs"] == {"wall_s": 10.0, "cpu_s": 20.0}


@pytest.mark.parametrize("fork", ["", "import os\nif os.fork(): os._exit(os.wait()[1])\n"], ids=["child", "grandchild"])
def test_work_of_a_process_that_was_started_counts_while_it_runs_and_after(fork):
    """A worker is the child of its supervisor."""
    ledger = PhaseTimes()
    work = f"{fork}import time\nwhile time.process_time() < 0.3: pass\nprint(flush=True)\ninput()"
    with subprocess.Popen([sys.executable, "-c", work], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout and process.stdout.readline()
        ledger.book("while it runs")
        process.communicate(b"\n")
    ledger.book("after")
    of_it = ledger.phases["while it runs"].cpu
    if sys.platform == "linux":
        assert of_it >= 0.29  # to a tick of the system's clock
    assert sum(phase.cpu for phase in ledger.phases.values()) >= 0.3


def test_cpu_time_that_a_process_left_hidden_takes_none_from_a_phase():
    now = iter([PhaseTime(0.0, 5.0), PhaseTime(1.0, 3.0), PhaseTime(2.0, 4.5)])
    ledger = PhaseTimes(lambda: next(now))
    ledger.book("one")
    ledger.book("other")
    assert ledger.phases == {"one": PhaseTime(1.0, 0.0), "other": PhaseTime(1.0, 1.5)}
