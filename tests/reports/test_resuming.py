"""What is run again and what is not: settings, limits, crashes, timings, and builds that were stopped."""

import json
import signal
import zipfile
from pathlib import Path

import pytest

import cases
from adapters.processes import pool as pools
from reports.running import experiment
from reports.running.calls import Calls
from reports.running.storage.result_store import Store
from tests.taylor.conftest import default_method  # noqa: F401 - a fixture

from .. import fake_adapter
from .identical import identical


def setting_of(file: Path) -> str:
    """How the fake engine was to run, by the key of what is kept."""
    with zipfile.ZipFile(file) as archive:
        said = json.loads(archive.read("record.json"))["key"]["arguments"]
    ((_, (_, text)),) = said[3][1]["values"]
    return text.strip("'")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The fake engine's folder, and a worker that finds it: one serves all tests, for to start one takes seconds."""
    folder = tmp_path_factory.mktemp("packages")
    fake_adapter.install(folder, [])
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        pool = pools.WorkerPool(1)
        yield folder, pool
        pool.close()


@pytest.fixture
def fake(installed, tmp_path):
    """run(settings, …) -> outcomes by setting, of the fake engine; its folder is `run.folder`."""
    folder, pool = installed
    (folder / "log.txt").unlink(missing_ok=True)
    case = cases.load(fake_adapter.CASE)

    def run(settings, limit=30.0, fresh=False):
        fake_adapter.ladder_is(folder, settings)
        calls = Calls(1, limit, Store(tmp_path / "s", fresh))
        calls._pool = pool
        return {row.setting["how"]: row for row in experiment.run_cases((case,), ("fake",), calls).runs}

    run.folder, run.store = folder, tmp_path / "s"
    return run


def test_what_was_run_is_not_run_again_and_a_changed_setting_alone_is(fake):
    first = fake(["wait 1", "wait 2", "nan", "never rolls"])
    again = fake(["wait 1", "wait 2", "nan", "never rolls"])
    assert fake_adapter.runs_in(fake.folder) == ["wait 1", "wait 2", "nan", "never rolls"]
    assert all(identical(first[setting], again[setting]) for setting in first)
    assert [run.outcome for run in again.values()] == ["answered", "answered", "crashed", "answered"]
    changed = fake(["wait 3", "wait 1", "nan"])
    assert fake_adapter.runs_in(fake.folder)[4:] == ["wait 3"]
    assert [run.rung for run in changed.values()] == [1, 2, 3]


def test_times_of_a_kept_run_stay_those_measured_and_say_when(fake):
    first, again = fake(["wait 1"])["wait 1"], fake(["wait 1"])["wait 1"]
    assert first.cost == again.cost and first.when == again.when and first.when.startswith("20")


def test_fresh_runs_all_again_and_keeps_it(fake):
    before = fake(["wait 1"])["wait 1"]
    anew = fake(["wait 1"], fresh=True)["wait 1"]
    assert fake_adapter.runs_in(fake.folder) == ["wait 1", "wait 1"] and anew.cost.cpu_s != before.cost.cpu_s
    assert fake(["wait 1"])["wait 1"].cost == anew.cost


def test_what_ran_out_of_time_is_run_again_only_when_it_has_more(fake):
    fake(["wait 2"])  # truth has the same limit: here it has time, and is kept
    first = fake(["until touched", "wait 1"], limit=4.0)
    (fake.folder / "touched").touch()
    again = fake(["until touched", "wait 1"], limit=4.0)
    for runs in (first, again):
        assert [run.outcome for run in runs.values()] == ["timed_out", "timed_out"]
        assert "still running after 4 s" in runs["until touched"].reason and "not tried" in runs["wait 1"].reason
    assert fake_adapter.runs_in(fake.folder) == ["wait 2"]
    longer = fake(["until touched", "wait 1"], limit=30.0)
    assert [run.outcome for run in longer.values()] == ["answered", "answered"]


def test_a_crash_is_kept_and_what_the_machine_lacked_is_not(fake):
    settings = ["segfault", "gives up", "no library"]
    output = {setting: (run.outcome, run.reason) for setting, run in fake(settings).items()}
    assert all(outcome == "crashed" for outcome, _ in output.values())
    assert "SIGSEGV" in output["segfault"][1] and "libfake.so" in output["no library"][1]
    kept = [setting_of(path) for path in fake.store.glob("run-*")]
    assert sorted(kept) == ["gives up", "segfault"]


def test_a_worker_killed_from_outside_is_told_and_its_run_made_again():
    killed, own = pools._death(-signal.SIGKILL), pools._death(-signal.SIGSEGV)
    assert "SIGKILL, from outside" in killed.reason and not killed.lasting
    assert own.lasting and pools._death(7).lasting and pools._death(-40).reason.endswith("40, from outside")
