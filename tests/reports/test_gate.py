"""`reports.compare --worse-than`: which changes of a report make it fail, in every format."""

import json
from xml.etree import ElementTree

import pandas as pd
import pytest

from reports import compare, gate

KEY = {"case": "disc_on_line[mu=0.1]", "solver": "exudyn", "route": "native", "setting": "h=0.001"}
RUN = KEY | {"outcome": "answered", "off": 0.02, "off_doubt": 1e-5}


def report(folder, *rows):
    (folder / "tables").mkdir(parents=True)
    pd.DataFrame(rows).to_csv(folder / "tables" / "trajectories.csv", index=False)
    return str(folder)


@pytest.mark.parametrize(
    ("now", "change", "status"),
    [
        ({}, "", 0),
        ({"off": 0.0219}, "", 0),  # 9.5 %
        ({"off": 0.0221}, "worse", 1),  # 10.5 %
        ({"off": 0.0221, "off_doubt": 0.01}, "not decided", 3),
        ({"off_doubt": 0.01}, "not decided", 3),  # the same error, with so few samples that it may be twice as large
        ({"off": 0.001}, "better", 0),
        ({"outcome": "crashed", "off": ""}, "worse", 1),
        ({"solver": "exudyn@1.13.6", "off": 0.03}, "worse", 1),
    ],
)
def test_a_run_is_worse_by_more_than_the_share_and_the_doubt(now, change, status, tmp_path, capsys):
    old, new = report(tmp_path / "old", RUN), report(tmp_path / "new", RUN | now)
    assert compare.main([old, new, "--worse-than", "10%"]) == status
    text = capsys.readouterr().out
    assert gate.main(["--baseline", old, new]) == status  # the older name
    assert capsys.readouterr().out == text
    assert text.startswith(
        f"{change}: disc_on_line[mu=0.1], exudyn native, h=0.001: " if change else "0 worse, 0 better"
    )


def test_a_worse_run_decides_the_status_and_one_that_is_not_decided_is_skipped(tmp_path, capsys):
    rows = [RUN | {"case": label} for label in ("a", "b", "c")]
    unsure, worse = {"off": 0.0221, "off_doubt": 0.01}, {"off": 0.03}
    old = report(tmp_path / "old", *rows)
    new = report(tmp_path / "new", rows[0] | unsure, rows[1] | worse, rows[2])
    assert gate.main(["--baseline", old, new, "--worse-than", "10%", "--format", "junit"]) == 1
    suite = ElementTree.fromstring(capsys.readouterr().out)
    assert [suite.get(name) for name in ("tests", "failures", "skipped")] == ["3", "1", "1"]
    assert [[inner.tag for inner in case] for case in suite] == [["skipped"], ["failure"], []]


def test_a_missing_run_is_worse_and_a_new_one_is_not(tmp_path, capsys):
    other = RUN | {"case": "disc_on_incline"}
    both, one = report(tmp_path / "both", RUN, other), report(tmp_path / "one", RUN)
    assert gate.main(["--baseline", both, one]) == 1
    assert "the run is missing" in capsys.readouterr().out
    assert gate.main(["--baseline", one, both]) == 0
    assert "1 new" in capsys.readouterr().out


def test_errors_below_four_digits_do_not_count(tmp_path):
    old = report(tmp_path / "old", RUN | {"off": 1e-6, "off_doubt": 0.0})
    assert gate.main(["--baseline", old, report(tmp_path / "a", RUN | {"off": 9e-5, "off_doubt": 0.0})]) == 0
    assert gate.main(["--baseline", old, report(tmp_path / "b", RUN | {"off": 2e-4, "off_doubt": 0.0})]) == 1


def test_formats_for_programs(tmp_path, capsys):
    other = RUN | {"case": "disc_on_incline"}
    old = report(tmp_path / "old", RUN, other)
    new = report(tmp_path / "new", RUN, other | {"outcome": "crashed", "off": "", "off_doubt": ""})
    assert gate.main(["--baseline", old, new, "--format", "json"]) == 1
    output = json.loads(capsys.readouterr().out)
    assert output["counts"] == {"same": 1, "worse": 1} and output["runs"][1]["now"] is None
    assert gate.main(["--baseline", old, new, "--format", "junit"]) == 1
    suite = ElementTree.fromstring(capsys.readouterr().out)
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    (failure,) = suite.iter("failure")
    assert failure.get("message") == "answered, now crashed"
