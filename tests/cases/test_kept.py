"""What is kept on disk: found again, made anew where anything that decides it changed, and never read from others."""

import logging
import os
import stat
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import pytest
import sympy as sp

from cases import Curve, compile_cache

from ..full_disk import full_disk

X, Y = sp.symbols("x y")
FORMULA = X**2 + sp.sin(Y) / 3


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """An empty folder to keep things in, and code that decides them."""
    monkeypatch.setenv(compile_cache.VARIABLE, str(tmp_path / "kept"))
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "module.py").write_text("1")
    for cache in (compile_cache._safe_folder, compile_cache._code, compile_cache._surroundings):
        monkeypatch.setattr(compile_cache, cache.__name__, cache.__wrapped__)
    return tmp_path / "kept"


def asked(folder: Path, value="made", decided_by=(FORMULA, 1e-9), kind="number"):
    """The answer, and whether it was made for it."""
    calls = []

    def make():
        calls.append(1)
        return value

    return compile_cache.cached(kind, decided_by, folder.parent / "code", make), bool(calls)


def test_what_was_made_is_found_again(folder):
    assert asked(folder, "first") == ("first", True)
    assert asked(folder, "second") == ("first", False)
    [file] = folder.iterdir()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700 and stat.S_IMODE(file.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "other",
    [
        dict(kind="other"),
        dict(decided_by=(FORMULA, 1e-10)),
        dict(decided_by=(FORMULA.subs(Y, sp.Symbol("y", real=True)), 1e-9)),
        # Equal in value, and added up in another order.
        dict(decided_by=(sp.Add(*reversed(FORMULA.args), evaluate=False), 1e-9)),
    ],
    ids=["kind", "number", "assumption", "order"],
)
def test_anything_else_is_made(folder, other):
    asked(folder)
    assert asked(folder, **other)[1]


def test_another_code_or_version_or_processor_makes_anew(folder, monkeypatch):
    asked(folder)
    (folder.parent / "code" / "module.py").write_text("2")
    assert asked(folder)[1]
    assert not asked(folder)[1]
    with monkeypatch.context() as patch:
        patch.setattr(sp, "__version__", "0.0")
        assert asked(folder)[1]
    with monkeypatch.context() as patch:
        patch.setattr(compile_cache.platform, "machine", lambda: "another")
        assert asked(folder)[1]
    assert not asked(folder)[1]


def test_a_compiled_function_comes_back_whole(folder):
    for library in ("math", "numpy"):
        function = sp.lambdify([X, Y], [FORMULA, sp.pi * X + sp.sqrt(Y)], modules=library, cse=True)
        asked(folder, function, decided_by=library)
        again, made = asked(folder, None, decided_by=library)
        assert not made and again(0.3, 0.7) == function(0.3, 0.7)


@pytest.mark.parametrize("damage", [lambda b: b"", lambda b: b[:-3], lambda b: b[:40] + bytes([b[40] ^ 1]) + b[41:]])
def test_a_file_that_is_not_whole_is_made_anew(folder, caplog, damage):
    asked(folder, "first")
    [file] = folder.iterdir()
    file.write_bytes(damage(file.read_bytes()))
    assert asked(folder, "second") == ("second", True)
    assert "not whole" in caplog.text
    assert asked(folder, "third") == ("second", False)


def test_a_folder_or_file_that_others_can_open_is_left_alone(folder, caplog):
    asked(folder, "first")
    [file] = folder.iterdir()
    file.chmod(0o644)
    assert asked(folder, "second") == ("second", True)
    folder.chmod(0o750)
    assert asked(folder, "third") == ("third", True)
    assert "others have access to it" in caplog.text and len(list(folder.iterdir())) == 1


def test_a_folder_of_somebody_else_is_left_alone_and_said_once(folder, caplog, monkeypatch):
    asked(folder, "first")
    monkeypatch.setattr(compile_cache, "_safe_folder", compile_cache.lru_cache(compile_cache._safe_folder))
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    with caplog.at_level(logging.WARNING):
        assert all(asked(folder, "second") == ("second", True) for _ in range(3))
    [record] = caplog.records
    assert "belongs to somebody else" in record.getMessage() and "\n" not in record.getMessage()


def test_a_link_is_not_followed(folder, caplog):
    asked(folder, "first")
    folder.rename(folder.parent / "elsewhere")
    folder.symlink_to(folder.parent / "elsewhere")
    assert asked(folder, "second") == ("second", True)
    assert "not a folder" in caplog.text
    folder.unlink()
    (folder.parent / "elsewhere").rename(folder)
    [file] = folder.iterdir()
    file.rename(folder.parent / "file")
    file.symlink_to(folder.parent / "file")
    assert asked(folder, "second") == ("second", True)


@pytest.mark.parametrize("word", ["off", ""])
def test_the_environment_turns_it_off(folder, monkeypatch, word):
    monkeypatch.setenv(compile_cache.VARIABLE, word)
    assert asked(folder)[1] and asked(folder)[1]
    assert not folder.exists()


def test_without_the_variable_it_is_the_users_own_folder(folder, monkeypatch):
    monkeypatch.delenv(compile_cache.VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
    assert compile_cache.place() == folder / "slip-to-roll"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(folder))
    assert compile_cache.place() == folder / ".cache" / "slip-to-roll"


@pytest.mark.parametrize("text", [None, "~/kept", "~nobody-of-that-name/kept"])
def test_without_a_home_directory_nothing_is_kept_and_everything_is_made(folder, monkeypatch, caplog, text):
    if text is None:
        monkeypatch.delenv(compile_cache.VARIABLE)
    else:
        monkeypatch.setenv(compile_cache.VARIABLE, text)
    for name in ("HOME", "XDG_CACHE_HOME", "USERPROFILE"):
        monkeypatch.delenv(name, raising=False)

    def nobody(_):
        raise KeyError("no entry for this user")

    monkeypatch.setattr("pwd.getpwuid", nobody)
    monkeypatch.setattr("pwd.getpwnam", nobody)
    assert compile_cache.place() is None
    assert f"give {compile_cache.VARIABLE} a folder of your own" in caplog.text
    assert asked(folder) == ("made", True)
    curve = Curve(lambda s: (s, 0.7123 * s**2), (-1, 1))  # of sizes that nothing else has: it is derived here
    assert curve.point(1.0)[1] == 0.7123


def test_modules_that_cannot_be_read_stop_nothing(folder, monkeypatch, caplog):
    def unreadable(_):
        raise PermissionError("no access")

    monkeypatch.setattr(compile_cache, "_code", unreadable)
    assert asked(folder) == ("made", True)
    assert "nothing is kept: no access" in caplog.text


def test_a_full_disk_stops_nothing(folder, caplog):
    with full_disk():
        assert asked(folder) == ("made", True)
    assert "File too large" in caplog.text and not list(folder.iterdir())


def test_the_oldest_goes_when_there_is_too_much(folder, monkeypatch):
    monkeypatch.setattr(compile_cache, "LARGEST_BYTES", 4000)
    monkeypatch.setattr(compile_cache, "_LOOK_BYTES", 0)
    monkeypatch.setattr(compile_cache, "_bytes_since_trim", -1)
    for i in range(8):
        asked(folder, bytes(1000), decided_by=i)
        for file in folder.iterdir():  # a second between one and the next
            os.utime(file, ns=(file.stat().st_atime_ns, file.stat().st_mtime_ns - 10**9))
        if i:
            assert not asked(folder, decided_by=0)[1], "what is used is not old"
    assert sum(file.stat().st_size for file in folder.iterdir()) <= 4000
    assert asked(folder, decided_by=1)[1]


def test_files_of_the_users_in_the_folder_stay(folder, monkeypatch):
    asked(folder)
    theirs = [folder / name for name in (".gitignore", ".notes", "thesis.kept", "letter.txt")]
    for file in theirs:
        file.write_text("precious")
        os.utime(file, (0, 0))
    monkeypatch.setattr(compile_cache, "LARGEST_BYTES", 0)
    monkeypatch.setattr(compile_cache, "_bytes_since_trim", -1)
    asked(folder, decided_by="another")
    assert sorted(folder.iterdir()) == sorted(theirs)


def _many(folder: Path, count: int) -> list:
    return [asked(folder, i * bytes(1000), decided_by=i)[0] == i * bytes(1000) for i in range(count)]


def test_two_processes_at_once_see_only_what_is_whole(folder):
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert all(all(found) for found in pool.map(partial(_many, folder), [200, 200]))
    assert len(list(folder.iterdir())) == 200


def test_what_was_taken_and_made_is_counted(folder):
    compile_cache.counters()
    asked(folder), asked(folder), asked(folder, decided_by="other", kind="text")
    assert compile_cache.words() == "1 compiled parts taken from the cache, 2 made and kept there"
    assert compile_cache.counters() == ({"number": 1}, {"number": 1, "text": 1})
    assert compile_cache.counters() == ({}, {})


def test_inside_off_all_is_made_and_the_setting_comes_back(folder):
    asked(folder)
    with compile_cache.off():
        assert asked(folder)[1]
        assert "neither kept nor taken" in compile_cache.words()
    assert not asked(folder)[1]
