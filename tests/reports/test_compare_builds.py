"""Two reports compared: what changed is listed; what varies from day to day is not."""

import shutil

import pandas as pd
import pytest

from reports import build, compare, compare_builds


def changed(report, tmp_path, table, column, value, where=lambda frame: frame.index == 0):
    """A copy of the report with one column of some rows changed."""
    other = tmp_path / "other"
    shutil.copytree(report, other)
    file = other / "tables" / f"{table}.csv"
    frame = pd.read_csv(file, dtype=str, keep_default_na=False)
    frame.loc[where(frame), column] = value
    frame.to_csv(file, index=False)
    return other


CASE = "disc_on_line[mu=0.1]"
WHO = {"case": CASE, "solver": "reference", "route": "taylor"}
RUN = WHO | {"setting": "rtol=1e-13"}
TABLES = {
    "headline": [WHO | {"finest_off": 1e-12}],
    "verdict": [{"solver": "a", "route": "native", "finest_off": 0.01}],
    "trajectories": [RUN | {"outcome": "answered", "centre_max": 1e-15, "cpu_s": 1e-3, "run_at": "now"}],
    "transitions": [
        RUN | {"event": 1, "before": "slip_forward", "after": "roll", "pairing": "paired", "error": e}
        for e in (0.0, 1.0)
    ],
    "truth": [{"case": CASE, "event": 1, "time": 0.34}],
}


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The tables of a small report, and those of times as a longer one has them."""
    out = tmp_path_factory.mktemp("builds") / "one"
    (out / "tables").mkdir(parents=True)
    (out / "manifest.json").write_text('{"format": 2}')
    times = WHO | {"level": 1e-2, "reached": "reached"}
    a = times | {"solver": "a", "ratio": 1.0, "ratio_low": 1.0, "ratio_high": 1.0, "rank": 1.0}
    b = times | {"solver": "b", "ratio": 3.0, "ratio_low": 2.5, "ratio_high": 3.5, "rank": 2.0}
    for name, rows in {**TABLES, "time_to_accuracy": [a, b]}.items():
        pd.DataFrame(rows).to_csv(out / "tables" / f"{name}.csv", index=False)
    return out


def test_a_report_does_not_differ_from_itself(report, capsys):
    assert compare.main([str(report), str(report)]) == compare_builds.main([str(report), str(report)]) == 0
    assert "results that changed: none" in capsys.readouterr().out


def test_reports_of_two_formats_are_not_compared(report, tmp_path, capsys):
    other = changed(report, tmp_path, "truth", "time", "0.34")
    (other / "manifest.json").write_text("{}")
    assert compare_builds.main([str(report), str(other)]) == 2
    assert "has the format 2 and" in capsys.readouterr().err


@pytest.mark.parametrize(
    "table, column",
    [
        ("transitions", "error"),
        ("trajectories", "outcome"),
        ("truth", "time"),
        ("headline", "finest_off"),
        ("verdict", "finest_off"),
    ],
)
def test_an_accuracy_that_changed_is_told_with_its_row(table, column, report, tmp_path, capsys):
    other = changed(report, tmp_path, table, column, "0.125")
    assert compare_builds.main([str(report), str(other)]) == 3
    (difference,) = compare_builds.compare(report, other).results
    assert (difference.table, difference.column, difference.other) == (table, column, "0.125")
    assert difference.row == "a, native" if table == "verdict" else CASE in difference.row
    assert difference.row in capsys.readouterr().out


def test_a_row_that_is_missing_is_told(report, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(report, other)
    file = other / "tables" / "trajectories.csv"
    pd.read_csv(file).iloc[1:].to_csv(file, index=False)
    (difference,) = compare_builds.compare(report, other).results
    assert (difference.one, difference.other) == ("there", "missing")


@pytest.mark.slow
def test_two_builds_of_the_same_commit_give_the_same_accuracies_and_alike_times(tmp_path):
    """Nothing is taken from a store. A test of the machine as well: it must be quiet for its times."""
    for name in ("one", "two"):
        argv = ["--case", CASE, "--solver", "reference", "pymunk", "--fresh"]
        argv += ["--out", str(tmp_path / name), "--store", str(tmp_path / f"store of {name}")]
        assert build.main(argv) == 0
    output = compare_builds.compare(tmp_path / "one", tmp_path / "two")
    assert output.results == [] and output.levels == []
    if output.ratio_count < 10:
        pytest.skip("the machine was disturbed")
    # Of two processes 99.9 % of the ratios agree on a quiet machine, in the worst two 97 %.
    assert len(output.ratios) <= 0.05 * output.ratio_count


def test_two_solvers_of_a_report_are_compared_as_one(report, tmp_path, capsys):
    def both(table, column):
        frame = pd.read_csv(report / "tables" / f"{table}.csv")
        twins = pd.concat([frame.assign(solver="a@1", version="1"), frame.assign(solver="a@2", version="2")])
        twins.loc[twins["solver"] == "a@2", column] = 0.125
        return twins

    other = tmp_path / "twins"
    shutil.copytree(report, other)
    both("trajectories", "cpu_s").to_csv(other / "tables" / "trajectories.csv", index=False)
    words = [str(other), str(other), "--solver", "a@1", "--solver", "a@2"]
    assert compare_builds.main(words) == 0
    both("trajectories", "centre_max").to_csv(other / "tables" / "trajectories.csv", index=False)
    assert compare_builds.main(words) == 3
    assert "centre_max 1e-15 | 0.125" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("file", "content", "sentence"),
    [
        ("tables/truth.csv", "", "cannot be read as comma-separated values"),
        ("tables/truth.csv", "time\n1\n", "has no column case"),
        ("tables/time_to_accuracy.csv", None, "rank in "),
        ("manifest.json", "nonsense", "is not JSON"),
        ("manifest.json", "[1]", "is not the manifest of a report"),
    ],
)
def test_a_report_that_is_none_is_one_sentence_and_status_2(file, content, sentence, report, tmp_path, capsys):
    other = changed(report, tmp_path, "time_to_accuracy", "rank", "first" if content is None else "1")
    if content is not None:
        (other / file).write_text(content)
    assert compare_builds.main([str(report), str(other)]) == 2
    output = capsys.readouterr()
    assert sentence in output.err and output.err.count("\n") == 1 and not output.out
