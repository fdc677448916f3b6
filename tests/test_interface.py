"""Adapters by name, this suite's and other people's."""

from importlib.metadata import EntryPoint

import pytest

import adapters
from adapters import Setting, interface
from cases import UnknownName


def test_an_unknown_engine_is_refused_with_those_there_are():
    with pytest.raises(UnknownName, match="choose from .*exudyn"):
        adapters.engine("exudin")


def test_an_installed_package_brings_its_adapter_by_an_entry_point(monkeypatch):
    point = EntryPoint("theirs", "adapters.pymunk", interface.GROUP)  # any module will do
    monkeypatch.setattr(interface, "entry_points", lambda group: [point] if group == interface.GROUP else [])
    assert "theirs" in adapters.engines()
    assert adapters.engine("theirs").NAME == "pymunk"


def test_a_setting_reads_as_its_knobs():
    setting = Setting.of(rung="defaults", h=1e-3, facets=64)
    assert str(setting) == "rung=defaults h=0.001 facets=64"
    assert setting["facets"] == 64
