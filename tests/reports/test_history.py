"""`reports.history`: which release changed an answer, the page, and the versions of a package."""

import csv
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from adapters import Setting
from cases import Mode
from reports import history
from reports.analysis import version_history
from reports.judging.ledger import LedgerRow
from reports.judging.score import Score
from reports.page import history_text
from reports.running import versions
from reports.running.records import Run
from reports.running.storage import source_code

CASE, H = "disc_on_line[mu=0.1]", Setting.of(h=1e-3)
DOCS = Path(__file__).parents[2] / "docs"
EVENT = LedgerRow(1, Mode.SLIP_FORWARD, Mode.ROLL, 0.34, 0.34, 1e-5, "paired")


def run(version, off=0.02, setting=H, outcome="answered", ledger=(EVENT,)):
    score = Score(off, 1e-6, off, 0.0, 0.0, 0.0, 0.0, 0.0, False)
    return Run(CASE, f"pymunk@{version}", "native", setting, 2, outcome, score=score, ledger=ledger, grade="good")


def kinds(*runs):
    (line,) = version_history.lines(runs)
    return line.changes


def test_a_release_is_named_that_changes_the_error_by_more_than_one_percent_of_it():
    found = kinds(run("6.9"), run("6.10", 0.0201), run("6.11", 0.0206), run("7.0", 0.0206))
    assert found == {"6.9": "first", "6.10": "digits", "6.11": "changed", "7.0": "same"}


def test_another_sequence_or_outcome_is_a_change_whatever_the_error():
    other = replace(EVENT, after=Mode.SLIP_BACKWARD, pairing="spurious")
    assert kinds(run("6.9"), run("7.0", ledger=(EVENT, other)))["7.0"] == "changed"
    assert kinds(run("6.9"), run("7.0", outcome="crashed"))["7.0"] == "changed"
    assert kinds(run("6.9", outcome="crashed"), run("7.0", 0.5, outcome="crashed"))["7.0"] == "same"


def test_a_route_that_a_version_lacks_is_its_answer_at_every_setting():
    lacking = replace(run("6.9", setting=Setting.of(), outcome="unsupported"), score=None)
    (line,) = version_history.lines([lacking, run("7.0")])
    assert version_history.in_words(line.answers["6.9"]) == "unsupported" and line.changes["7.0"] == "changed"


def test_releases_count_what_became_better_and_worse_and_versions_that_were_not_run():
    fine = Setting.of(h=1e-4)
    lines = version_history.lines(
        [
            run("6.9"),
            run("7.0", 0.01),
            run("6.9", 0.001, fine),
            run("7.0", 0.002, fine),
            run("7.1"),
            run("7.1", 0.002, fine),
        ]
    )
    rows = version_history.release_rows(lines, {"pymunk@6.0": "no wheel"})
    assert [row["version"] for row in rows] == ["6.0", "6.9", "7.0", "7.1"]
    assert (rows[2]["changed"], rows[2]["better"], rows[2]["worse"]) == (2, 1, 1)
    assert rows[0]["note"] == "no wheel" and rows[0]["runs"] == 0 and rows[3]["worse"] == 1
    output = history.summary(rows)
    assert "pymunk: 3 versions run, 6.9 to 7.1" in output and "6.0: not run: no wheel" in output
    assert "7.0: 2 answers changed, 1 better, 1 worse" in output


def test_the_page_in_the_documentation_is_that_of_its_tables():
    tables = [
        list(csv.DictReader((DOCS / "engine_history" / f"{name}.csv").read_text().splitlines()))
        for name in ("history_lines", "history_releases")
    ]
    page = (DOCS / "engine_history.md").read_text()
    origin = page.partition("The runs are of ")[2].partition(". With")[0]
    command = page.partition("```sh\n")[2].partition("\n")[0]
    assert history_text.render(*tables, " ".join(origin.split()), command) == page
    for key in history_text.CAUSES:
        assert key in {(row["engine"], row["version"]) for row in tables[1] if int(row["changed"])}


@pytest.fixture
def index(monkeypatch):
    """A package index with some versions of pymunk."""

    def answer(words, **_):
        assert words[-1] == "pymunk"
        return subprocess.CompletedProcess(
            words, 0, "pymunk (7.0)\nAvailable versions: 7.0, 6.10, 6.9, 6.0.1, 5.7\n", ""
        )

    monkeypatch.setattr(source_code, "literal_of", lambda engine, _: {"pymunk": "pymunk>=6.0"}.get(engine))
    monkeypatch.setattr(versions.subprocess, "run", answer)


def test_released_versions_are_those_that_the_adapter_supports_oldest_first(index):
    assert versions.releases("pymunk") == ("6.0.1", "6.9", "6.10", "7.0")


@pytest.mark.slow
def test_the_history_of_two_versions_as_a_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(versions, "releases", lambda engine: ("7.2.0", "7.3.1"))
    assert history.main(["pymunk", "--case", CASE, "--out", "h"]) == 0
    assert "pymunk: 2 versions run, 7.2.0 to 7.3.1\n  no release changed an answer" in capsys.readouterr().out
    assert (tmp_path / "h" / "tables" / "history_lines.csv").is_file()
    assert "2 versions were run: 7.2.0, 7.3.1." in (tmp_path / "h" / "history.md").read_text()
