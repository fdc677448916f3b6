"""What is run again and what is not: settings, limits, crashes, timings, and builds that were stopped."""

import pytest

import cases
from adapters.processes import pool as pools
from reports.running import experiment
from reports.running.calls import Calls
from reports.running.storage.result_store import Store
from tests.taylor.conftest import default_method  # noqa: F401 - a fixture

from .. import fake_adapter
from .identical import identical


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


def test_fresh_runs_all_again_and_keeps_it(fake):
    before = fake(["wait 1"])["wait 1"]
    anew = fake(["wait 1"], fresh=True)["wait 1"]
    assert fake_adapter.runs_in(fake.folder) == ["wait 1", "wait 1"] and anew.cost.cpu_s != before.cost.cpu_s
    assert fake(["wait 1"])["wait 1"].cost == anew.cost
