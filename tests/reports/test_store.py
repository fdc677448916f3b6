"""The store of finished runs: what comes back from it, and what damage does."""

import json
import multiprocessing
import os
import pickle
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from adapters import Setting
from cases import Cost, Mode
from reports.judging.distances import Distance
from reports.judging.ledger import LedgerRow
from reports.running.records import Run, Truth
from reports.running.storage.result_store import Store

from ..full_disk import full_disk
from .identical import identical

KEY = {"case": "c", "setting": ["h", "0.1"]}
ROW = LedgerRow(1, Mode.SLIP_FORWARD, Mode.ROLL, 1 / 3, 1 / 7, 1 / 3 - 1 / 7, "paired")
RUN = Run(
    "c", "s", "r", Setting.of(h=0.1), 2, "answered", "", "completed", "slip_forward", (ROW,), (float("nan"),),
    Distance(1e-300, 2.0, 3.0, 4.0, 5.0, float("inf")), Cost(cpu_s=1 / 9, steps=7),
    {"t": np.linspace(0.0, 1.0, 50), "slip": np.full(50, np.nan), "centre": np.geomspace(1e-17, 1.0, 50)}, "today",
)  # fmt: skip


# --- what is kept -----------------------------------------------------------------------------------------------------


def test_nothing_is_taken_under_another_key_or_when_asked_for_fresh(tmp_path):
    Store(tmp_path).put("run", KEY, RUN, Run)
    assert Store(tmp_path).get("run", {**KEY, "case": "d"}, Run) is None
    assert Store(tmp_path).get("truth", KEY, Truth) is None
    assert Store(tmp_path).get("run", None, Run) is None
    assert Store(tmp_path, fresh=True).get("run", KEY, Run) is None


def test_a_store_without_a_folder_keeps_nothing_and_says_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    store = Store(None)
    store.put("run", KEY, RUN, Run)
    assert store.get("run", KEY, Run) is None and store.trouble() == [] and list(tmp_path.iterdir()) == []


def test_the_folder_is_ignored_by_git_and_its_size_told(tmp_path):
    store = Store(tmp_path / "s")
    store.put("run", KEY, replace(RUN, off={"t": np.random.default_rng(1).random(1_000_000)}), Run)
    assert (tmp_path / "s" / ".gitignore").read_text() == "*\n"
    assert "holds 8 MB and may be deleted" in store.size_words()


def kept_file(folder: Path) -> Path:
    (file,) = folder.glob("run-*.npz")
    return file


def with_member(path: Path, name: str, content: bytes) -> None:
    """Write the file again with other content in one member."""
    with zipfile.ZipFile(path) as archive:
        members = {other: archive.read(other) for other in archive.namelist()} | {name: content}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, said in members.items():
            archive.writestr(member, said)


def with_object_array(path: Path) -> None:
    array = pickle.dumps([Trap(path.parent / "sprung")])
    with_record(path, lambda output: output["record"].update(off=[["t", [0, "|O", [len(array) // 8]]]]))
    with_member(path, "0", array)


class Trap:
    """Unpickling it makes a file."""

    def __init__(self, sprung: Path):
        self.sprung = sprung

    def __reduce__(self):
        return Path.touch, (self.sprung,)


def with_record(path: Path, change) -> None:
    with zipfile.ZipFile(path) as archive:
        output = json.loads(archive.read("record.json"))
    change(output)
    with_member(path, "record.json", json.dumps(output).encode())


def without_arrays(path: Path) -> None:
    with zipfile.ZipFile(path) as archive:
        output = archive.read("record.json")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("record.json", output)


def flipped(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[60] ^= 0xFF  # of the compressed record; what stands between members may change without harm
    path.write_bytes(content)


DAMAGE = {
    "empty": lambda path: path.write_bytes(b""),
    "cut short": lambda path: path.write_bytes(path.read_bytes()[:-400]),
    "garbage": lambda path: path.write_bytes(os.urandom(5000)),
    "one byte": flipped,
    "no arrays": without_arrays,
    "an array cut short": lambda path: with_member(path, "0", b"12345678"),
    "an array of text": lambda path: with_record(
        path, lambda output: output["record"]["off"][0][1].__setitem__(1, "<U2")
    ),
    "an array of another shape": lambda path: with_record(
        path, lambda output: output["record"]["off"][0][1].__setitem__(2, [10**12])
    ),
    "nested beyond all bounds": lambda path: with_member(path, "record.json", b"[" * 200_000),
    "of another key": lambda path: with_record(path, lambda output: output["key"].update(case="d")),
    "another record": lambda path: with_record(path, lambda output: output.update(record={"a": 1})),
    "a field missing": lambda path: with_record(path, lambda output: output["record"].pop("off")),
    "a field more": lambda path: with_record(path, lambda output: output["record"].update(more=1)),
    "wrong type": lambda path: with_record(path, lambda output: output["record"].update(outcome=3)),
    "no record": lambda path: with_record(path, lambda output: output.clear()),
    "pickled array": with_object_array,
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_file_is_told_in_one_line_and_mended_by_running_it_again(damage, tmp_path):
    Store(tmp_path).put("run", KEY, RUN, Run)
    damage(kept_file(tmp_path))
    store = Store(tmp_path)
    assert store.get("run", KEY, Run) is None
    (output,) = store.trouble()
    assert output.startswith("could not be read, and were made again: 1, such as run-") and "\n" not in output
    store.put("run", KEY, RUN, Run)
    mended = Store(tmp_path)
    assert identical(mended.get("run", KEY, Run), RUN) and mended.trouble() == []
    assert not (tmp_path / "sprung").exists()


def test_a_few_kilobytes_that_unfold_to_more_than_any_record_holds_are_not_unfolded(tmp_path, monkeypatch):
    Store(tmp_path).put("run", KEY, RUN, Run)
    with zipfile.ZipFile(kept_file(tmp_path)) as archive:
        output = archive.read("record.json")
    with_member(kept_file(tmp_path), "record.json", output + b" " * 10_000_000)
    assert kept_file(tmp_path).stat().st_size < 50_000 and Store(tmp_path).get("run", KEY, Run) is not None
    monkeypatch.setattr("reports.running.storage.result_store._MOST_BYTES", 10_000_000)
    store = Store(tmp_path)
    assert store.get("run", KEY, Run) is None
    assert "it claims to hold more than 10 MB" in store.trouble()[0]


def test_files_of_others_are_told_and_left(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    store = Store(tmp_path)
    store.put("run", KEY, RUN, Run)
    store.trim(bound=0)
    assert store.trouble() == ["foreign files, not touched: 1, such as thesis.tex"]
    assert (tmp_path / "thesis.tex").read_text() == "precious"


def test_a_full_disk_is_told_and_leaves_no_file(tmp_path):
    store = Store(tmp_path / "s")
    assert store.problem() == ""
    with full_disk(free=100):
        store.put("run", KEY, RUN, Run)
    assert store.trouble()[0].startswith("could not be stored: 1") and not list((tmp_path / "s").glob("*run*"))


def test_a_place_that_cannot_be_written_is_told_and_stops_nothing(tmp_path):
    (tmp_path / "file").write_text("precious")
    store = Store(tmp_path / "file" / "store")
    store.put("run", KEY, RUN, Run)
    assert store.get("run", KEY, Run) is None
    (output,) = store.trouble()
    assert output.startswith("could not be stored: 1")
    assert "cannot be stored: NotADirectoryError" in store.problem() and Store(tmp_path / "good").problem() == ""
    assert store.kept_words() == "no result was stored"


@pytest.mark.parametrize(
    "change",
    [
        dict(status=object()),
        dict(rung="12"),  # a text in the place of a number
        dict(cost=Cost(steps="12")),
        dict(cost=Cost(steps=100.5)),
        dict(cost=Cost(cpu_s=10**400)),
        dict(setting=Setting((("h", None),))),
        dict(off={"t": np.array(["words"])}),
        dict(off={"t": [0.0, 1.0]}),
        dict(status="a lone \ud800"),
    ],
    ids=lambda change: next(iter(change)),
)
def test_what_could_not_be_read_back_is_not_kept_and_told(change, tmp_path):
    store = Store(tmp_path)
    store.put("run", KEY, replace(RUN, **change), Run)
    (output,) = store.trouble()
    assert output.startswith("could not be stored: 1") and not list(tmp_path.glob("run-*"))


def test_room_is_made_by_removing_what_was_longest_unused_but_nothing_of_this_build(tmp_path):
    files = []
    for i in range(4):
        Store(tmp_path).put("run", {"i": i}, RUN, Run)
        files += set(tmp_path.glob("run-*")) - set(files)
        os.utime(files[i], (1e9 + i, 1e9 + i))
    half = tmp_path / f".slip-to-roll-{16 * '0'}.partial"
    half.write_bytes(b"half")
    store = Store(tmp_path)
    assert store.get("run", {"i": 0}, Run) is not None
    store.trim(bound=2 * max(file.stat().st_size for file in files))
    assert [file.exists() for file in files] == [True, False, False, True] and not half.exists()
    store.trim(bound=0)
    assert [file.exists() for file in files] == [True, False, False, False]


def put_often(folder: Path) -> list[str]:
    """Write and read the same few keys again and again, as two builds would."""
    store = Store(folder)
    for i in range(60):
        store.put("run", {"i": i % 3}, RUN, Run)
        found = store.get("run", {"i": i % 3}, Run)
        assert found is not None and identical(found, RUN)
    return store.trouble()


def test_two_builds_at_the_same_time_do_each_other_no_harm(tmp_path):
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(put_often, [tmp_path, tmp_path]) == [[], []]
