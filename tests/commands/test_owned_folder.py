"""Folders and files that we write: whole or absent, and nothing of the user's is touched, whatever happens when."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from cases import BadValue
from cases.files import owned_folder
from cases.files.owned_folder import LIST, OwnedFolder, TemporaryFolder
from tests.full_disk import full_disk

QUICK = settings.get_current_profile_name() == "same"


def holds(folder: Path) -> dict[str, str]:
    """The content of every file below a folder but our list, by name."""
    files = [path for path in folder.rglob("*") if path.is_file() and path != folder / LIST]
    return {path.relative_to(folder).as_posix(): path.read_text() for path in files}


def made(folder: Path, names, text: str = "ours") -> OwnedFolder:
    """A report with files of those names."""
    report = OwnedFolder(folder, "report", ("index.html", "tables/*"), ("index.html",))
    with report.staging(whole=True) as place:
        for name in names:
            (place / name).parent.mkdir(exist_ok=True)
            (place / name).write_text(text)
    return report


# --- one file ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("before", [None, "old"])
def test_on_a_full_disk_there_is_the_old_file_or_none(before, tmp_path):
    file = tmp_path / "film.gif"
    if before:
        file.write_text(before)
    with full_disk(free=100), pytest.raises(OSError):
        owned_folder.write(file, "x" * 101)
    assert holds(tmp_path) == ({"film.gif": before} if before else {})
    owned_folder.write(file, "x" * 101)
    assert holds(tmp_path) == {"film.gif": "x" * 101}


def test_a_file_is_not_replaced_unless_that_is_asked_for(tmp_path):
    file = tmp_path / "film.gif"
    file.write_text("precious")
    with pytest.raises(FileExistsError):
        owned_folder.write(file, "new", replace=False)
    with pytest.raises(BadValue, match="film.gif exists already; give another name, or --force to overwrite it"):
        owned_folder.check_new(file)
    owned_folder.check_new(file, force=True)
    for odd in ("link", "folder"):
        os.symlink(file, tmp_path / odd) if odd == "link" else (tmp_path / odd).mkdir()
        for force in (False, True):
            with pytest.raises(BadValue, match="give another name$"):
                owned_folder.check_new(tmp_path / odd, force)
    assert file.read_text() == "precious"


def test_permissions_are_those_that_the_user_wants(tmp_path):
    before = os.umask(0o027)
    try:
        owned_folder.write(tmp_path / "shared", "a")
        owned_folder.write(tmp_path / "own", "a", mode=0o600)
        made(tmp_path / "report", ["index.html"])
    finally:
        os.umask(before)
    modes = {name: (tmp_path / name).stat().st_mode & 0o777 for name in ("shared", "own", "report/index.html")}
    assert modes == {"shared": 0o640, "own": 0o600, "report/index.html": 0o640}


# --- what is left behind ----------------------------------------------------------------------------------------------


def test_what_a_killed_process_left_is_removed_and_nothing_else(tmp_path):
    child = os.fork()
    if not child:
        try:
            (TemporaryFolder(tmp_path).path / "deep").mkdir()
            with owned_folder.atomic_path(tmp_path / "film.gif") as partial:
                partial.write_text("half")
                os.kill(os.getpid(), signal.SIGKILL)
        finally:
            os._exit(1)
    assert os.waitpid(child, 0)[1] == signal.SIGKILL and len(list(tmp_path.iterdir())) == 2
    theirs = [".gitignore", ".slip-to-roll-notes", ".report.mine.partial", ".slip-to-roll-0.partial", ".unfinished-a"]
    for name in theirs:
        (tmp_path / name).write_text("precious")
    link = tmp_path / f".slip-to-roll-{16 * '0'}.partial"
    link.symlink_to(tmp_path)
    in_use = TemporaryFolder(tmp_path)
    owned_folder.remove_leftovers(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*theirs, link.name, in_use.path.name}
    in_use.remove()
    assert not in_use.path.exists()


# --- a folder ---------------------------------------------------------------------------------------------------------


def test_the_list_is_one_that_sha256sum_checks(tmp_path):
    report = made(tmp_path, ["index.html", "tables/µ 1.csv"])
    assert report.names() == ["index.html", "tables/µ 1.csv"]
    output = subprocess.run(["sha256sum", "-c", "--strict", LIST], cwd=tmp_path, capture_output=True, text=True)
    assert output.returncode == 0 and output.stdout.count(": OK") == 2, output.stderr


def test_a_folder_of_the_users_is_not_taken_over(tmp_path):
    (tmp_path / "notes.txt").write_text("precious")
    for text in (None, "", "# slip-to-roll sweep\n", "# slip-to-roll report", "# slip-to-roll report\n\0"):
        if text is not None:
            (tmp_path / LIST).write_text(text)
        if text == "# slip-to-roll report":  # a report with a file of the user's beside ours
            made(tmp_path, ["index.html"]).clear()
            assert holds(tmp_path) == {"notes.txt": "precious"}
            continue
        with pytest.raises(BadValue, match=r"holds (notes.txt|slip-to-roll.sha256) and is no report; give another"):
            OwnedFolder(tmp_path, "report").check()


@pytest.mark.parametrize("name", ["../up", "/etc/passwd", "a/../../up", "a//b", "./a", "", ".", "..", LIST, "a/./b"])
def test_no_name_on_a_list_leads_out_of_its_folder(name, tmp_path):
    outside = tmp_path / "up"
    outside.write_text("precious")
    report = made(tmp_path / "report", ["index.html"])
    with (report.path / LIST).open("a") as file:
        file.write(f"{owned_folder.digest(outside)}  {name}\n")
    assert report.names() == ["index.html"]
    with pytest.raises(BadValue):
        report.write(name, b"mine now")
    report.clear()
    assert outside.read_text() == "precious"


@pytest.fixture
def memory():
    """A folder in memory, where a thousand files are flushed in no time."""
    folder = Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
    yield folder
    shutil.rmtree(folder)


@pytest.mark.parametrize("stride", [3, pytest.param(1, marks=pytest.mark.slow)], ids=["some", "all"])
def test_killed_at_any_step_a_file_is_the_old_or_the_new_one(memory, stride):
    for steps in range(0, 40, stride):
        report = made(memory, ["index.html", "tables/a.csv"])
        ended = killed_after(steps, lambda report=report: report.write("tables/a.csv", b"new"))
        assert holds(memory)["tables/a.csv"] in ("ours", "new")
        report.check()
        assert {*holds(memory)} == {"index.html", "tables/a.csv"}, "a leftover"
    assert ended, "so many steps are enough"


@pytest.mark.parametrize("stride", [3, pytest.param(1, marks=pytest.mark.slow)], ids=["some", "all"])
def test_killed_at_any_step_a_report_is_the_old_or_the_new_one_or_unfinished(memory, stride):
    old, new = {"index.html": "ours", "tables/a.csv": "ours"}, {"index.html": "new", "tables/b.csv": "new"}
    for steps in range(0, 80, stride):
        report = made(memory, old)
        ended = killed_after(steps, lambda: made(memory, new, "new"))
        report.check()
        there = holds(memory)
        if "index.html" in there:
            assert there == old or there.items() >= new.items()
    assert ended and there == new


def test_one_process_at_a_time_writes_a_folder(tmp_path):
    one, other = (OwnedFolder(tmp_path / "sweep", "sweep") for _ in range(2))
    with one.write_lock():
        one.write("a", b"1")
        with pytest.raises(BadValue, match="another command writes to .*sweep; wait for it, or give another --out"):
            other.write_lock(patience=0.1).__enter__()
    with other.write_lock(patience=0.0):
        other.write("b", b"2")
    assert holds(tmp_path / "sweep") == {"a": "1", "b": "2"}


def test_a_full_disk_leaves_the_old_report_and_no_new_folder(tmp_path):
    made(tmp_path / "old", ["index.html", "tables/a.csv"])
    for place in ("old", "new"):
        with full_disk(free=5), pytest.raises(OSError):
            made(tmp_path / place, ["index.html", "tables/b.csv"], "longer")
        with full_disk(free=5), pytest.raises(OSError):  # the files have room, the list has none
            made(tmp_path / place, ["index.html", "tables/b.csv"], "1")
    assert holds(tmp_path / "old") == {"index.html": "ours", "tables/a.csv": "ours"}
    assert not (tmp_path / "new").exists() and OwnedFolder(tmp_path / "old", "report").names()


# --- the user and we, in any order ------------------------------------------------------------------------------------

NAMES = ["index.html", "tables/a.csv", "tables/b.csv", "tables", "notes.txt", "tables/mine.csv", ".slip-to-roll-notes"]
OURS = NAMES[:3]
# All that changes files; a process may be killed before each of them.
CHANGES = ("replace", "link", "unlink", "mkdir", "rmdir", "fsync", "open")


def killed_after(steps: int, work) -> bool:
    """Do the work in another process, which is killed after it has changed files so many times; whether it came to its
    end."""
    child = os.fork()
    if child:
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert status in (0, 9)
        return status == 0
    left = [steps]

    def counting(call):
        def one(*args, **named):
            left[0] -= 1
            if left[0] < 0:
                os._exit(9)  # nothing of what Python does at an end
            return call(*args, **named)

        return one

    try:
        for name in CHANGES:
            setattr(os, name, counting(getattr(os, name)))
        with suppress(BadValue):
            work()
    finally:
        os._exit(0)


def finished(there: dict[str, str]) -> dict[str, str]:
    """Without what a killed process left."""
    return {name: text for name, text in there.items() if ".partial" not in name}


class UserAndWe(RuleBasedStateMachine):
    """A user and our commands work in one folder; some commands are killed."""

    @initialize()
    def begin(self):
        self.root = Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
        self.folder, self.outside = self.root / "report", self.root / "outside"
        self.outside.mkdir()
        (self.outside / "a.csv").write_text("ours 0")  # what we have written there once, by way of a link
        self.theirs: dict[str, str] = {}
        self.number = 0

    def teardown(self):
        if hasattr(self, "root"):
            shutil.rmtree(self.root)

    # What the user does.

    @rule(name=st.sampled_from(NAMES))
    def writes(self, name):
        """A new file of any name, or one of ours in the user's own words."""
        path = self.folder / name
        with suppress(FileExistsError, NotADirectoryError, IsADirectoryError):
            path.parent.mkdir(parents=True, exist_ok=True)
            if not path.parent.is_symlink():
                path.write_text("precious")
                self.theirs[name] = "precious"

    @rule(name=st.sampled_from([*NAMES, LIST]))
    def deletes(self, name):
        if (self.folder / name).parent.is_symlink():
            return
        with suppress(OSError):
            (self.folder / name).unlink()
            self.theirs.pop(name, None)
            if name == LIST:  # then nothing is ours
                self.theirs = finished(holds(self.folder))

    @precondition(lambda self: (self.folder / "tables").is_dir() and not (self.folder / "tables").is_symlink())
    @rule()
    def links(self):
        """The tables move elsewhere, and what they held is the user's."""
        for path in (self.folder / "tables").iterdir():
            self.theirs.pop(f"tables/{path.name}", None)
        shutil.rmtree(self.folder / "tables")
        (self.folder / "tables").symlink_to(self.outside)

    @precondition(lambda self: (self.folder / "tables").is_symlink())
    @rule()
    def unlinks(self):
        (self.folder / "tables").unlink()

    # What we do.

    def report(self) -> OwnedFolder:
        return OwnedFolder(self.folder, "report", ("index.html", "tables/*"), ("index.html",))

    def build(self, names, whole, text):
        with self.report().staging(whole) as place:
            for name in names:
                (place / name).parent.mkdir(exist_ok=True)
                (place / name).write_text(text)

    @rule(names=st.sets(st.sampled_from(OURS)), whole=st.booleans(), old=st.booleans())
    def builds(self, names, whole, old):
        text = self.text(old)
        before = finished(holds(self.folder))
        try:
            self.build(names, whole, text)
        except BadValue:
            assert finished(holds(self.folder)) == before
            return
        after = dict.fromkeys(names, text)
        assert after.items() <= holds(self.folder).items()
        if whole:
            assert self.own(holds(self.folder)) == self.theirs | after
            assert set(self.report().names()) == names
        assert not list(self.folder.glob(".slip-to-roll-*.partial"))

    @rule(name=st.sampled_from(OURS))
    def writes_one(self, name):
        text = self.text(False)
        with suppress(BadValue):
            self.report().write(name, text.encode())
            assert (self.folder / name).read_text() == text

    @rule()
    def clears(self):
        with suppress(BadValue):
            self.report().clear()
            assert self.own(holds(self.folder)) == self.theirs

    @rule(names=st.sets(st.sampled_from(OURS), min_size=1), whole=st.booleans(), steps=st.integers(0, 60))
    def is_killed(self, names, whole, steps):
        text = self.text(False)
        killed_after(steps, lambda: self.build(names, whole, text))

    @rule(name=st.sampled_from(OURS), steps=st.integers(0, 25))
    def is_killed_writing(self, name, steps):
        text = self.text(False)
        killed_after(steps, lambda: self.report().write(name, text.encode()))

    @rule(steps=st.integers(0, 25))
    def is_killed_clearing(self, steps):
        killed_after(steps, lambda: self.report().clear())

    def own(self, there):
        """What is not elsewhere, by way of a link."""
        return {n: t for n, t in there.items() if not (self.folder / n).parent.is_symlink()}

    def text(self, old: bool) -> str:
        """What we write: something new, or what we have written before."""
        self.number += not old
        return f"ours {self.number}"

    @invariant()
    def nothing_of_the_users_is_lost(self):
        if not hasattr(self, "root"):
            return
        there = holds(self.folder)
        assert self.theirs.items() <= there.items()
        assert holds(self.outside) == {"a.csv": "ours 0"}
        # Every file is the user's, or ours and whole.
        assert all(name in self.theirs or text.startswith("ours ") for name, text in finished(there).items())


TestUserAndWe = UserAndWe.TestCase
TestUserAndWe.settings = settings(
    max_examples=15 if QUICK else 300, stateful_step_count=12 if QUICK else 30, deadline=None
)
