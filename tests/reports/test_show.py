"""`cases show --engines`: the figures of one case with what every engine makes of it."""

import xml.etree.ElementTree as ET

import pytest

import cases
from reports import options, show

CASE = "disc_on_incline[slope=0.4]"


def test_a_case_is_drawn_with_its_engines(tmp_path, monkeypatch, capsys, in_process):
    monkeypatch.setattr(options, "solvers", lambda: ("reference", "pymunk"))
    words = [CASE, "--engines", "--out", str(tmp_path / "a.svg"), "--store", str(tmp_path / "store")]
    with in_process():
        show.run(words)
    texts = {name: (tmp_path / f"{name}.svg").read_text() for name in ("a", "a_engines", "a_errors")}
    assert all(ET.fromstring(text) is not None for text in texts.values())
    # The routes of engines in both, quantities with units in the first, settings against steps in the second.
    assert f">{CASE}, finest settings<" in texts["a_engines"] and ">pymunk, native<" in texts["a_engines"]
    assert f">Error against steps in {CASE}<" in texts["a_errors"] and ">pymunk native<" in texts["a_errors"]
    assert ">slip velocity v / (m/s)<" in texts["a_engines"] and ">steps<" in texts["a_errors"]
    assert f"engines: {tmp_path / 'a_engines.svg'}" in capsys.readouterr().out
    with pytest.raises(cases.CaseError, match="a_engines"):  # before anything runs
        (tmp_path / "a.svg").unlink()
        show.run(words)


def test_only_engines_need_runs(tmp_path):
    show.run([CASE, "--out", str(tmp_path / "b.png")])
    assert [file.name for file in tmp_path.iterdir()] == ["b.png"]
