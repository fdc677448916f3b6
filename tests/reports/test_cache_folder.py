"""The user's cache folder is used only if it is private."""

import logging
import os

import pytest

from reports.running import cache_folder


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache folder of the test's own, looked at again in each test."""
    monkeypatch.setenv(cache_folder.VARIABLE, str(tmp_path / "cache"))
    cache_folder._safe_folder.cache_clear()
    yield tmp_path / "cache"
    cache_folder._safe_folder.cache_clear()


def test_it_is_made_for_the_user_alone(folder):
    assert cache_folder.place() == folder
    assert folder.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o750, 0o705, 0o777])
def test_a_folder_that_others_can_open_is_not_used(folder, mode, caplog):
    folder.mkdir()
    folder.chmod(mode)
    assert cache_folder.place() is None
    assert "others have access to it" in caplog.text


def test_a_folder_of_another_user_is_not_used_and_reported_once(folder, monkeypatch, caplog):
    folder.mkdir(mode=0o700)
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    with caplog.at_level(logging.WARNING):
        assert all(cache_folder.place() is None for _ in range(3))
    [record] = caplog.records
    assert "belongs to another user" in record.getMessage() and "\n" not in record.getMessage()


def test_a_link_is_not_followed(folder, caplog):
    (folder.parent / "elsewhere").mkdir(mode=0o700)
    folder.symlink_to(folder.parent / "elsewhere")
    assert cache_folder.place() is None
    assert "not a folder" in caplog.text


@pytest.mark.parametrize("word", ["off", ""])
def test_the_environment_turns_it_off(folder, monkeypatch, word):
    monkeypatch.setenv(cache_folder.VARIABLE, word)
    assert cache_folder.place() is None and not folder.exists()


def test_without_the_variable_it_is_the_users_own_folder(folder, monkeypatch):
    monkeypatch.delenv(cache_folder.VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
    assert cache_folder.place() == folder / "slip-to-roll"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(folder))
    assert cache_folder.place() == folder / ".cache" / "slip-to-roll"
