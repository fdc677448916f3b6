"""A setting of an engine: its knobs, and its text."""

import pytest

from adapters import Setting


def test_a_setting_reads_as_its_knobs():
    setting = Setting.of(rung="defaults", h=1e-3, facets=64)
    assert str(setting) == "rung=defaults h=0.001 facets=64"
    assert setting["facets"] == 64


def test_a_setting_is_asked_for_its_knobs_and_not_read_back_from_its_text():
    setting = Setting.of(h=1e-3, facets=64)
    assert "h" in setting and "vertices" not in setting
    assert setting.get("facets") == 64 and setting.get("vertices") is None and setting.get("vertices", 0) == 0
    assert dict(setting) == {"h": 1e-3, "facets": 64}
    with pytest.raises(KeyError):
        setting["vertices"]
    assert not setting.is_default
    assert Setting.of(rung="defaults", h=1e-3).is_default
    assert not Setting.of(rung=1, h=1e-3).is_default
