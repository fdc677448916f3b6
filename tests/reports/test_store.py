"""The store of finished runs: what a key says, what damage does, what is run again and what is not."""

import io
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
import zipfile
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import cases
from adapters import Setting
from cases import Cost, Mode, Transition
from reports.judging.distances import Distance
from reports.judging.ledger import LedgerRow
from reports.running import experiment, fingerprint, tasks, timings, workers
from reports.running.calls import Calls
from reports.running.clock import Contestant, Timing
from reports.running.records import Run, Truth
from reports.running.store import Store

from .. import fake_adapter

ROOT = Path(__file__).parents[2]
KEY = {"case": "c", "setting": ["h", "0.1"]}
ROW = LedgerRow(1, Mode.SLIP_FORWARD, Mode.ROLL, 1 / 3, 1 / 7, 1 / 3 - 1 / 7, "matched")
RUN = Run(
    "c", "s", "r", Setting.of(h=0.1), 2, "right", "", "completed", "slip_forward", (ROW,), (float("nan"),),
    Distance(1e-300, 2.0, 3.0, 4.0, 5.0, float("inf")), Cost(cpu_s=1 / 9, steps=7),
    {"t": np.linspace(0.0, 1.0, 50), "slip": np.full(50, np.nan)}, {"centre": np.geomspace(1e-17, 1.0, 50)}, "today",
)  # fmt: skip
TRUTH = Truth(
    "taylor", (Transition(1 / 3, Mode.SLIDE, Mode.ROLL),), (1e-17,), Mode.SLIDE, samples={"t": np.arange(3.0)}
)


def same(one, other) -> bool:
    """To the last bit, NaN included."""
    return fingerprint.record_digest(one) == fingerprint.record_digest(other)


# --- what is kept -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind, record", [("run", RUN), ("truth", TRUTH), ("truth", Truth(failure="none"))])
def test_records_come_back_to_the_last_bit(kind, record, tmp_path):
    Store(tmp_path / "s").put(kind, KEY, record)
    assert same(Store(tmp_path / "s").get(kind, KEY, type(record)), record)


def test_nothing_is_taken_under_another_key_or_when_asked_for_fresh(tmp_path):
    Store(tmp_path).put("run", KEY, RUN)
    assert Store(tmp_path).get("run", {**KEY, "case": "d"}, Run) is None
    assert Store(tmp_path).get("truth", KEY, Truth) is None
    assert Store(tmp_path).get("run", None, Run) is None
    assert Store(tmp_path, fresh=True).get("run", KEY, Run) is None


def test_a_store_without_a_folder_keeps_nothing_and_says_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    store = Store(None)
    store.put("run", KEY, RUN)
    assert store.get("run", KEY, Run) is None and store.trouble() == [] and list(tmp_path.iterdir()) == []


def test_the_folder_is_ignored_by_git_and_its_size_told(tmp_path):
    store = Store(tmp_path / "s")
    store.put("run", KEY, replace(RUN, samples={"t": np.random.default_rng(1).random(1_000_000)}))
    assert (tmp_path / "s" / ".gitignore").read_text() == "*\n"
    assert "holds 8 MB and may be deleted" in store.size_words()


def kept_file(folder: Path) -> Path:
    (file,) = folder.glob("run-*.npz")
    return file


def read_record(file: Path) -> dict:
    with zipfile.ZipFile(file) as archive:
        return json.loads(archive.read("record.json"))["record"]


def setting_of(file: Path) -> str:
    """How the fake engine was to run, by the key of what is kept."""
    with zipfile.ZipFile(file) as archive:
        said = json.loads(archive.read("record.json"))["key"]["arguments"]
    ((_, (_, text)),) = said[3][1]["values"]
    return text.strip("'")


def with_object_array(path: Path) -> None:
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    array = io.BytesIO()
    np.save(array, np.array([Trap(path.parent / "sprung")], dtype=object), allow_pickle=True)
    members["value.samples.t.npy"] = array.getvalue()
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)


class Trap:
    """Unpickling it makes a file."""

    def __init__(self, sprung: Path):
        self.sprung = sprung

    def __reduce__(self):
        return Path.touch, (self.sprung,)


def with_record(path: Path, change) -> None:
    with zipfile.ZipFile(path) as archive:
        told = json.loads(archive.read("record.json"))
    change(told)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("record.json", json.dumps(told))


def flipped(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[60] ^= 0xFF  # of the compressed record; what stands between members may change without harm
    path.write_bytes(content)


DAMAGE = {
    "empty": lambda path: path.write_bytes(b""),
    "cut short": lambda path: path.write_bytes(path.read_bytes()[:-400]),
    "garbage": lambda path: path.write_bytes(os.urandom(5000)),
    "one byte": flipped,
    "no arrays": lambda path: with_record(path, lambda told: None),
    "of another key": lambda path: with_record(path, lambda told: told["key"].update(case="d")),
    "another record": lambda path: with_record(path, lambda told: told.update(record={"a": 1})),
    "wrong type": lambda path: with_record(path, lambda told: told["record"].update(outcome=3)),
    "no record": lambda path: with_record(path, lambda told: told.clear()),
    "pickled array": with_object_array,
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_file_is_told_in_one_line_and_mended_by_running_it_again(damage, tmp_path):
    Store(tmp_path).put("run", KEY, RUN)
    damage(kept_file(tmp_path))
    store = Store(tmp_path)
    assert store.get("run", KEY, Run) is None
    (told,) = store.trouble()
    assert told.startswith("could not be read, and made again: 1, such as run-") and "\n" not in told
    store.put("run", KEY, RUN)
    mended = Store(tmp_path)
    assert same(mended.get("run", KEY, Run), RUN) and mended.trouble() == []
    assert not (tmp_path / "sprung").exists()


def test_a_folder_in_a_file_s_place_is_told_and_left(tmp_path):
    Store(tmp_path).put("run", KEY, RUN)
    file = kept_file(tmp_path)
    file.unlink()
    file.mkdir()
    store = Store(tmp_path)
    assert store.get("run", KEY, Run) is None
    store.put("run", KEY, RUN)
    assert [line.partition(":")[0] for line in store.trouble()] == [
        "could not be read, and made again",
        "could not be kept",
    ]
    assert [path for path in tmp_path.iterdir() if path.name.startswith(".unfinished")] == []


def test_files_of_others_are_told_and_left(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    store = Store(tmp_path)
    store.put("run", KEY, RUN)
    store.trim(bound=0)
    assert store.trouble() == ["not its own, and left alone: 1, such as thesis.tex"]
    assert (tmp_path / "thesis.tex").read_text() == "precious"


def test_a_place_that_cannot_be_written_is_told_and_stops_nothing(tmp_path):
    (tmp_path / "file").write_text("precious")
    store = Store(tmp_path / "file" / "store")
    store.put("run", KEY, RUN)
    assert store.get("run", KEY, Run) is None
    (told,) = store.trouble()
    assert told.startswith("could not be kept: 1")
    assert "cannot be kept: NotADirectoryError" in store.problem() and Store(tmp_path / "good").problem() == ""
    assert store.kept_words() == "nothing was finished that could be kept"


def test_who_stops_a_fresh_build_is_told_to_go_on_without_it(tmp_path):
    store = Store(tmp_path, fresh=True)
    store.put("run", KEY, RUN)
    assert store.kept_words() == f"1 run kept in {tmp_path}; the same command without --fresh goes on from there"


def test_what_no_file_can_hold_is_told(tmp_path):
    store = Store(tmp_path)
    store.put("run", KEY, replace(RUN, status=object()))
    assert "could not be kept: 1" in store.trouble()[0]


def test_room_is_made_by_removing_what_was_longest_unused_but_nothing_of_this_build(tmp_path):
    files = []
    for i in range(4):
        Store(tmp_path).put("run", {"i": i}, RUN)
        files += set(tmp_path.glob("run-*")) - set(files)
        os.utime(files[i], (1e9 + i, 1e9 + i))
    half = tmp_path / ".unfinished-killed"
    half.write_bytes(b"half")
    os.utime(half, (1e9, 1e9))
    store = Store(tmp_path)
    assert store.get("run", {"i": 0}, Run) is not None
    store.trim(bound=2 * max(file.stat().st_size for file in files))
    assert [file.exists() for file in files] == [True, False, False, True] and not half.exists()
    store.trim(bound=0)
    assert [file.exists() for file in files] == [True, False, False, False]


def put_often(folder: Path) -> list[str]:
    """Write and read the same few keys again and again, as two builds would."""
    store = Store(folder)
    for i in range(150):
        store.put("run", {"i": i % 3}, RUN)
        found = store.get("run", {"i": i % 3}, Run)
        assert found is not None and same(found, RUN)
    return store.trouble()


def test_two_builds_at_the_same_time_do_each_other_no_harm(tmp_path):
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(put_often, [tmp_path, tmp_path]) == [[], []]


# --- what a key says --------------------------------------------------------------------------------------------------

CASE_FILE = """
from cases import Case, CoulombFriction, Gravity, Start, Unilateral, case, disc
from cases.library import line

@case
def bowled_in_a_file(mu=0.1):
    "{docstring}"
    return Case(
        track=line({slope}), plate=disc(0.1, {mass}), effects=({effects}),
        start=Start(0.0, slip={slip}), duration={duration},
    )
"""
AS_IT_IS = dict(
    docstring="A disc.", slope=0.0, mass=1.0, slip=1.0, duration=1.0,
    effects="Gravity(9.81), CoulombFriction(mu), Unilateral()",
)  # fmt: skip
VERSIONS = {"pymunk": "7.2.0", "reference": "0.1.0"}


def written(tmp_path, monkeypatch, **changes) -> cases.Case:
    cases.names()  # the catalogue is there before it is copied
    monkeypatch.setattr(cases.registry, "_entries", dict(cases.registry._entries))
    file = tmp_path / "own.py"
    file.write_text(CASE_FILE.format(**AS_IT_IS | changes))
    os.utime(file, (1e9, 1e9))  # edits within one second, which a cache of compiled files would not notice
    cases.load_file(file)
    return cases.load("bowled_in_a_file")


def run_key(case, solver="pymunk", route="native", versions=None, truth=TRUTH, rung=1, **knobs):
    call = (case, solver, route, Setting.of(**(knobs or {"h": 0.1})), rung, truth)
    return Calls(versions=VERSIONS if versions is None else versions).key(tasks.perform, call, experiment._KEEP_RUN)


@pytest.mark.parametrize(
    "changes",
    [
        dict(slope=0.001),
        dict(mass=1.0 + 1e-15),
        dict(slip=2.0),
        dict(duration=1.5),
        dict(effects="Gravity(9.81), CoulombFriction(mu, mu_static=0.2), Unilateral()"),
        dict(effects="Gravity(9.81), CoulombFriction(mu)"),
    ],
    ids=str,
)
def test_a_case_file_edited_under_the_same_name_is_another_case(changes, tmp_path, monkeypatch):
    before = run_key(written(tmp_path, monkeypatch))
    after = run_key(written(tmp_path, monkeypatch, **changes))
    assert before["case"] == after["case"] and before != after
    assert [file.name for file in tmp_path.iterdir()] == ["own.py"]  # nothing is left beside a user's file


def test_every_case_of_the_catalogue_can_be_told_from_every_other():
    told = [fingerprint.content(case) for name in cases.names() for case in cases.select(name)]
    assert None not in told and len(set(told)) == len(told)


def test_words_in_a_case_file_decide_nothing(tmp_path, monkeypatch):
    before = run_key(written(tmp_path, monkeypatch))
    assert before == run_key(written(tmp_path, monkeypatch, docstring="A disc, bowled."))


def test_a_key_tells_solver_route_setting_versions_and_truth():
    case = cases.load("disc_on_line")
    keys = [
        run_key(case),
        run_key(case, route="assisted"),
        run_key(case, h=0.1 + 1e-15),
        run_key(case, n=0.1),
        run_key(case, solver="reference"),
        run_key(case, versions={"pymunk": "7.3.0"}),
        run_key(case, truth=Truth(failure="none")),
        run_key(cases.load("disc_on_line", mu=0.2)),
        run_key(cases.load("disc_on_line", mu=0.1)),
    ]
    assert len({fingerprint.digest(key) for key in keys}) == len(keys)
    assert run_key(case) == run_key(cases.load("disc_on_line")) == run_key(case, rung=2)


@pytest.mark.parametrize(
    "name, value",
    [
        ("machine", lambda: "another"),
        ("installed", lambda package: "0"),
        ("sys", type("S", (), {"version": "3.99.0 (main)"})),
    ],
)
def test_a_key_tells_machine_packages_and_python(name, value, monkeypatch):
    case = cases.load("disc_on_line")
    before = run_key(case)
    monkeypatch.setattr(fingerprint, name, value)
    fingerprint._surroundings.cache_clear()
    try:
        assert run_key(case) != before
    finally:
        fingerprint._surroundings.cache_clear()


def test_where_a_version_is_not_known_nothing_is_kept():
    assert run_key(cases.load("disc_on_line"), versions={"pymunk": ""}) is None


def test_an_engine_s_key_tells_its_adapter_and_what_judges_it_and_no_other_engine():
    ours = fingerprint._reached("adapters.pymunk", ()).keys()
    assert {"adapters.pymunk", "adapters.pymunk.native", "adapters.interface", "cases.contact"} <= ours
    assert not any("exudyn" in name or name.startswith("reference") for name in ours)
    judge = fingerprint._reached("reports.running.tasks", tuple(m.__name__ for m in experiment.TRUTHS_OWN)).keys()
    assert {"reports.running.tasks", "reports.judging.slip_phases", "cases.trajectory"} <= judge
    assert not any(name.startswith("reference") for name in judge)
    truth = fingerprint._reached("reports.running.tasks", ()).keys()
    assert {"reference.solve", "reference.certification.certificate", "reference.minimal.eliminated"} <= truth


def test_code_is_told_apart_by_what_it_does_not_by_its_layout(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "an_engine_of_tests"
    package.mkdir()
    (package / "__init__.py").write_text("raise RuntimeError('asking must not wake it')\n")
    (package / "adapter.py").write_text("from ._knobs import h\n")
    (package / "_knobs.py").write_text("h = 0.1\n")
    point = EntryPoint("an_engine_of_tests", "an_engine_of_tests.adapter", fingerprint.GROUP)
    monkeypatch.setattr(fingerprint, "entry_points", lambda group: [point])

    def told() -> str:
        for cached in (fingerprint.adapter_sources, fingerprint._code, fingerprint._tree, fingerprint._imported):
            cached.cache_clear()
        return fingerprint.adapter_sources("an_engine_of_tests")

    before = told()
    (package / "_knobs.py").write_text("# ten centimetres\nh   =   0.1\n")
    assert told() == before
    (package / "_knobs.py").write_text("h = 0.2\n")
    assert told() != before


# --- what is run again ------------------------------------------------------------------------------------------------


@pytest.fixture
def fake(tmp_path, monkeypatch):
    """run(settings, …) -> outcomes by setting, of the fake engine; its folder is `run.folder`."""
    folder = tmp_path / "packages"
    folder.mkdir()
    fake_adapter.install(folder, [])
    monkeypatch.syspath_prepend(folder)
    case = cases.load(fake_adapter.CASE)

    def run(settings, limit=30.0, fresh=False):
        fake_adapter.ladder_is(folder, settings)
        with Calls(1, limit, Store(tmp_path / "s", fresh)) as calls:
            found = experiment.run((case,), ("fake",), calls)
        return {row.setting["how"]: row for row in found.runs}

    run.folder, run.store = folder, tmp_path / "s"
    return run


def test_what_was_run_is_not_run_again_and_a_changed_setting_alone_is(fake):
    first = fake(["wait 1", "wait 2", "nan", "never rolls"])
    again = fake(["wait 1", "wait 2", "nan", "never rolls"])
    assert fake_adapter.runs_in(fake.folder) == ["wait 1", "wait 2", "nan", "never rolls"]
    assert all(same(first[setting], again[setting]) for setting in first)
    assert [run.outcome for run in again.values()] == ["right", "right", "crashed", "wrong"]
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
    first = fake(["until told", "wait 1"], limit=5.0)
    (fake.folder / "told").touch()
    again = fake(["until told", "wait 1"], limit=5.0)
    for runs in (first, again):
        assert [run.outcome for run in runs.values()] == ["timed_out", "timed_out"]
        assert "still running after 5 s" in runs["until told"].reason and "not tried" in runs["wait 1"].reason
    assert fake_adapter.runs_in(fake.folder) == ["wait 2"]
    longer = fake(["until told", "wait 1"], limit=30.0)
    assert [run.outcome for run in longer.values()] == ["right", "right"]


def test_a_crash_is_kept_and_what_the_machine_lacked_is_not(fake):
    settings = ["segfault", "gives up", "no library"]
    told = {setting: (run.outcome, run.reason) for setting, run in fake(settings).items()}
    assert all(outcome == "crashed" for outcome, _ in told.values())
    assert "SIGSEGV" in told["segfault"][1] and "libfake.so" in told["no library"][1]
    kept = [setting_of(path) for path in fake.store.glob("run-*")]
    assert sorted(kept) == ["gives up", "segfault"]


def test_a_worker_killed_from_outside_is_told_and_its_run_made_again():
    killed, own = workers._death(-signal.SIGKILL), workers._death(-signal.SIGSEGV)
    assert "SIGKILL, from outside" in killed.reason and not killed.lasting
    assert own.lasting and workers._death(7).lasting and workers._death(-40).reason.endswith("40, from outside")


@pytest.mark.parametrize("disturbed, times", [(False, 1), (True, 2)])
def test_timings_are_kept_unless_the_machine_was_disturbed(disturbed, times, tmp_path):
    timing = Timing(1 / 3, 0.1, 0.4, 0.2, 0.1, 0.5, 0.1, 5, 0, disturbed)
    who = contestants("a", "b")
    made = []

    class Pool:
        def run(self, function, arguments, *_):
            made.append(arguments)
            yield 0, workers.Answer("done", value=[(timing, ""), (None, "it fell over")])

    calls = Calls(store=Store(tmp_path), versions=VERSIONS)
    calls._pool = Pool()
    for _ in range(2):
        assert timings.time_together(who, 7.0, 10.0, calls) == ([(who[0], timing)], [(who[1], "it fell over")])
    assert len(made) == times


def contestants(*settings: str) -> list[Contestant]:
    return [Contestant(cases.load("disc_on_line"), "pymunk", "native", Setting.of(s=s), 0.1) for s in settings]


def test_timings_made_within_another_budget_or_beside_others_are_not_taken(tmp_path):
    made = []

    class Pool:
        def run(self, function, arguments, *_):
            made.append(arguments)
            yield 0, workers.Answer("done", value=[(None, "it fell over")] * len(arguments[0][0]))

    calls = Calls(store=Store(tmp_path), versions=VERSIONS)
    calls._pool = Pool()
    for who, share, new in (("ab", 10.0, 1), ("ba", 10.0, 1), ("a", 10.0, 2), ("a", 60.0, 3), ("ab", 10.0, 3)):
        timings.time_together(contestants(*who), 7.0, share, calls)
        assert len(made) == new, (who, share)


# --- a build that is stopped ------------------------------------------------------------------------------------------

LADDER = [f"wait {300 + i}" for i in range(8)]
MEASURED = ["cpu_s", "setup_s", "run_at"]


class Builds:
    """The command in processes of its own, on the fake engine."""

    def __init__(self, folder: Path):
        self.folder = folder
        fake_adapter.install(folder, LADDER)

    def start(self, *more: str) -> subprocess.Popen:
        argv = ["--quick", "--case", fake_adapter.CASE, "--solver", "fake", "--jobs", "1", *more]
        path = os.pathsep.join([str(ROOT), str(self.folder)])
        return subprocess.Popen(
            [sys.executable, "-m", "reports.build", *argv],
            cwd=self.folder, env={**os.environ, "PYTHONPATH": path}, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            # What is started in the background of a script inherits Ctrl-C ignored; a user's terminal does not.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )  # fmt: skip

    def stopped(self, how: signal.Signals, kept: int) -> tuple[int, str]:
        """Start a build and stop it when so many runs are in the store; its exit status and its last line."""
        build = self.start()
        deadline = time.monotonic() + 120.0
        while len(self.kept()) < kept:
            assert time.monotonic() < deadline and build.poll() is None, build.communicate()
            time.sleep(0.02)
        build.send_signal(how)
        _, told = build.communicate(timeout=60.0)
        return build.returncode, told.strip().splitlines()[-1]

    def kept(self) -> list[str]:
        """Settings in the store."""
        return [setting_of(path) for path in (self.folder / ".slip-to-roll").glob("run-*.npz")]

    def table(self, out: str, name: str) -> pd.DataFrame:
        return pd.read_csv(self.folder / out / "tables" / f"{name}.csv", dtype=str).drop(
            columns=MEASURED, errors="ignore"
        )


def test_a_build_stopped_by_kill_9_or_ctrl_c_goes_on_where_it_was(tmp_path):
    builds = Builds(tmp_path)
    status, _ = builds.stopped(signal.SIGKILL, kept=1)
    assert status == -signal.SIGKILL
    after_kill = builds.kept()
    status, told = builds.stopped(signal.SIGINT, kept=len(after_kill) + 1)
    assert status == 130
    assert told.startswith("reports.build: stopped; ") and "the same command goes on from there" in told
    after_stop = builds.kept()
    assert set(after_kill) < set(after_stop) and len(after_stop) < 4
    assert not (tmp_path / "report").exists() and list(tmp_path.glob("*.partial")) == []
    damaged = next((tmp_path / ".slip-to-roll").glob("run-*.npz"))
    spoilt = setting_of(damaged)
    damaged.write_bytes(b"garbage")
    (tmp_path / ".slip-to-roll" / "thesis.tex").write_text("precious")

    last = builds.start()
    out, told = last.communicate(timeout=120.0)
    assert last.returncode == 0, told
    assert f"store: {len(after_stop) - 1} run{'s' * (len(after_stop) > 2)} and 1 truth taken from the store" in out
    assert f"store: could not be read, and made again: 1, such as {damaged.name}" in out
    assert "store: not its own, and left alone: 1, such as thesis.tex" in out
    ran = fake_adapter.runs_in(tmp_path)
    counts = {setting: ran.count(setting) for setting in after_stop}
    assert counts == {setting: 2 if setting == spoilt else 1 for setting in after_stop}
    manifest = json.loads((tmp_path / "report" / "manifest.json").read_text())
    assert manifest["store"]["taken"] == {"run": len(after_stop) - 1, "truth": 1}

    whole = builds.start("--fresh", "--out", "uninterrupted")
    assert whole.communicate(timeout=120.0)[0] and whole.returncode == 0
    for name in ("trajectories", "transitions", "truth", "headline", "convergence"):
        pd.testing.assert_frame_equal(builds.table("report", name), builds.table("uninterrupted", name))
