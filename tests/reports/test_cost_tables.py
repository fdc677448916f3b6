"""The tables of a report that took timings: awards, answers, the first sentence, the dictionary of columns."""

import csv
import io
import json
import re
from contextlib import redirect_stdout
from dataclasses import replace
from html import unescape
from math import nan

import pandas as pd
import pytest

from reports import build, options
from reports.analysis import columns, cost_conclusions, number_format, time_to_accuracy, verdict, which_engine
from reports.page import dictionary, text
from reports.running import solvers
from reports.running.timing import timings

CASE = "disc_in_circle[mu=0.2]"


@pytest.fixture(scope="module")
def report(tmp_path_factory, without_figures):
    """A report of one case with little time for timings, made by the command. Calls from cold are those made for the
    imports, one each, and parts end by their own count of repeats: on a busy machine as on a quiet one."""
    out = tmp_path_factory.mktemp("made") / "report"
    together = timings.time_together

    def undisturbed(*given):
        """What is tested is the tables: that something else runs on the machine is none of their business here."""
        found, failed = together(*given)
        return [(one, replace(timing, disturbed=False)) for one, timing in found], failed

    def coarse(plan, case, solver, route, ladder):
        """As many settings as a curve has at least: the finest of an engine take as long as all others together."""
        return ladder[: timings.LEAST_SETTINGS] if solver == "pymunk" else ladder

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timings, "time_together", undisturbed)
        patch.setattr(options.BuildPlan, "select_rungs", coarse)
        for name, seconds in (("BUDGET", 1.0), ("COLD_BUDGET", 0.0), ("PARTS_BUDGET", 60.0)):
            patch.setattr(timings, name, seconds)
        patch.setattr(which_engine, "LEVELS", (1e-4,))
        with redirect_stdout(io.StringIO()) as told, without_figures():
            assert build.main(["--case", CASE, "--solver", "reference", "pymunk", "--out", str(out)]) == 0
    (out.parent / "terminal.txt").write_text(told.getvalue())
    return out


def read(report, name: str) -> pd.DataFrame:
    return pd.read_csv(report / "tables" / f"{name}.csv", keep_default_na=False, na_values=[""])


# --- what is awarded --------------------------------------------------------------------------------------------------


def test_no_accuracy_is_awarded_that_a_finer_rung_or_the_doubt_contradicts(report):
    """By the order of the runs themselves, and the errors and doubts of work_precision."""
    points, told, runs = (read(report, name) for name in ("work_precision", "time_to_accuracy", "trajectories"))
    awarded = told[told.award.isin(["reached", "not timed", "disturbed"])]
    assert len(awarded) >= 50
    for row in awarded.itertuples():
        ladder = runs[(runs.case == row.case) & (runs.solver == row.solver) & (runs.route == row.route)]
        mine = points[(points.solver == row.solver) & (points.route == row.route) & (points.quantity == row.quantity)]
        worth = dict(zip(mine.setting, mine.absolute_error + mine.doubt, strict=True))
        from_here = list(ladder.setting)
        if row.award == "reached":
            from_here = from_here[from_here.index(row.setting) :]
            assert set(ladder[ladder.setting.isin(from_here)].outcome) == {"right"}
            assert all(worth[setting] <= row.accuracy for setting in from_here), row
        else:
            assert worth[from_here[-1]] <= row.accuracy, row


def test_what_a_rung_met_by_chance_is_called_so_and_has_no_time(report):
    points, told = read(report, "work_precision"), read(report, "time_to_accuracy")
    rest = told[told.award.isin(["by chance", "never"])]
    assert all(rest.cpu_s.isna()) and all(rest.setting.isna())
    for row in rest.itertuples():
        mine = points[(points.solver == row.solver) & (points.route == row.route) & (points.quantity == row.quantity)]
        assert (mine.absolute_error.min() <= row.accuracy) == (row.award == "by chance"), row


def test_a_setting_that_a_finer_one_contradicts_reaches_by_chance():
    errors = {"coarse": 5e-3, "lucky": 1e-6, "fine": 1e-3}
    contradicted = {"coarse": 5e-3, "lucky": 1e-3, "fine": 1e-3}  # no better than any finer setting
    group = [
        {"absolute_error": error, "standing_error": contradicted[name], "floor_error": 1e-15}
        | {"cpu_s": 1.0, "disturbed": False}
        for name, error in errors.items()
    ]
    levels = {1e-2: "reached", 1e-4: "by chance", 1e-7: "never", 1e-16: "not known"}
    assert {level: time_to_accuracy.award(group, level)[0] for level in levels} == levels


def test_a_case_is_led_by_all_its_transitions_where_there_are_several(report):
    told, truth = read(report, "time_to_accuracy"), read(report, "truth")
    assert len(truth) >= 2 and set(told[told.lead].quantity) == {"all_transitions"}
    assert set(read(report, "headline").lead_quantity) == {"all_transitions"}


# --- what is answered -------------------------------------------------------------------------------------------------


def spent(row, runs: int) -> float:
    return row.first_call_s + (runs - 1) * row.call_s


def test_answers_are_the_cheapest_of_each_side(report):
    told, answers = read(report, "time_to_accuracy"), read(report, "which_engine")
    assert [(row.accuracy, row.runs) for row in answers.itertuples()] == [(1e-4, 1), (1e-4, 1000)]
    for answer in answers.itertuples():
        level = told[told.lead & (told.accuracy == answer.accuracy) & told.first_call_s.notna()]
        for name, seconds, ours in (
            (answer.engine, answer.engine_total_s, False),
            (answer.reference, answer.reference_total_s, True),
        ):
            side = {
                f"{row.solver} {row.route}": spent(row, answer.runs)
                for row in level.itertuples()
                if (row.solver == "reference") == ours
            }
            if not side:
                assert pd.isna(seconds) and answer.reason
                continue
            assert (name, seconds) == (min(side, key=side.get), pytest.approx(min(side.values())))
        if isinstance(answer.cheaper, str) and answer.cheaper:
            pair = {answer.engine: answer.engine_total_s, answer.reference: answer.reference_total_s}
            assert answer.factor == pytest.approx(max(pair.values()) / min(pair.values()))
            assert answer.cheaper == ("alike" if answer.factor < 1.1 else min(pair, key=pair.get))


def test_terminal_page_and_file_give_the_same_verdict(report):
    lines = (report.parent / "terminal.txt").read_text().splitlines()
    page = (report / "index.html").read_text()
    table = page.partition('<table class="answer')[2].partition("</table>")[0]
    shown = re.findall(r'<span class="of">(.*?)</span></th>(.*?)</tr>', table, re.DOTALL)
    rows = read(report, "verdict").to_dict("records")
    assert len(rows) == len(shown) == len(solvers.solver("pymunk").routes)
    for row, (who, cells), line in zip(rows, shown, lines[1:], strict=False):
        texts = re.findall(r"<td.*?>(.*?)(?: <small>.*?)?</td>", cells, re.DOTALL)
        expected = [main for main, _ in verdict.cells(row).values()]
        assert re.split(r" {2,}", line.strip()) == [who, *map(unescape, texts)] == [who, *expected]
        assert who.endswith(f"{row['solver']} {row['route']}") and who[0].isdigit() == pd.notna(row["digits_rank"])
    (sentence,) = re.findall(r'<p class="verdict"[^>]*>(.*?)</p>', page)
    assert unescape(sentence) in lines and lines[-1] == str(report / "index.html")
    assert unescape(sentence) == verdict.sentence(rows)


def test_first_sentence_is_true_by_the_tables_beside_it(report):
    page = (report / "index.html").read_text()
    section = page[page.index('<section class="chapter" id="precision">') :]
    sentence = unescape(re.search(r"<p><strong>(.*?)</strong></p>", section)[1])
    told = read(report, "time_to_accuracy")
    level = told[told.lead & (told.accuracy == cost_conclusions.LEVEL) & told.first_call_s.notna()]
    sides = [level[(level.solver == "reference") == ours] for ours in (True, False)]
    assert all(len(side) for side in sides)
    assert sentence.startswith(f"As used from Python, to reach 1e-4 s in the times of all transitions of {CASE}, ")
    for runs in (1, 1000):
        best = {}
        for side in sides:
            row = min(side.itertuples(), key=lambda row: spent(row, runs))
            best[f"{row.solver} {row.route}"] = spent(row, runs)
        cheap, dear = sorted(best, key=best.get)
        takes = (
            f"{number_format.seconds(best[cheap])} with {cheap} and {number_format.seconds(best[dear])} with {dear}: "
        )
        factor = best[dear] / best[cheap]
        who = f"{cheap} is cheaper, by {number_format.times(factor)}" if factor >= 1.1 else "they are alike"
        assert takes + who in sentence


def test_the_parts_of_an_engines_runs_are_in_the_table(report):
    told = read(report, "time_to_accuracy")
    rows = told[told.lead & told.engine_s.notna() & (told.solver == "pymunk")]
    assert len(rows)
    parts = rows[["engine_s", "binding_s", "callback_s", "notes_s"]]
    # That they add up to the whole is measured in `test_parts`.
    assert (parts >= 0.0).all(axis=None)


# --- what the columns mean --------------------------------------------------------------------------------------------


def tables(report) -> dict[str, list[list[str]]]:
    found = {}
    for file in sorted((report / "tables").glob("*.csv")):
        with open(file, newline="") as lines:
            found[file.stem] = list(csv.reader(lines))
    return found


def test_every_column_of_every_table_is_in_both_dictionaries_and_nothing_else(report):
    package = json.loads((report / "tables" / "datapackage.json").read_text())
    resources = {resource["name"]: resource for resource in package["resources"]}
    assert resources.keys() == tables(report).keys()
    people = (report / "tables" / "columns.md").read_text()
    for name, (head, *_) in tables(report).items():
        fields = resources[name]["schema"]["fields"]
        assert [field["name"] for field in fields] == head and resources[name]["path"] == f"{name}.csv"
        assert all(field["description"] for field in fields)
        section = people[people.index(f"## {name}.csv") :].split("\n## ")[0]
        assert re.findall(r"^- `(\w+)`: \S", section, re.M) == head


def test_cells_are_of_the_type_the_dictionary_says(report):
    package = json.loads((report / "tables" / "datapackage.json").read_text())
    kinds = {"number": float, "integer": int, "boolean": {"True": 1, "False": 0}.__getitem__, "string": str}
    for resource in package["resources"]:
        _, *rows = tables(report)[resource["name"]]
        for place, field in enumerate(resource["schema"]["fields"]):
            for row in rows:
                if row[place]:
                    kinds[field["type"]](row[place])
        units = {field["name"]: field.get("unit", "") for field in resource["schema"]["fields"]}
        # A time, a ratio or an error is nowhere without its unit.
        assert all(unit for name, unit in units.items() if name.endswith(("_s", "ratio", "error", "_max", "_rms")))


def test_numbers_and_words_stand_in_columns_of_their_own_and_nothing_is_infinite(report):
    for name, (head, *rows) in tables(report).items():
        for place, column in enumerate(head):
            cells = {row[place] for row in rows} - {""}
            assert not cells & {"inf", "-inf", "nan"}, (name, column)
            numbers = {cell for cell in cells if re.fullmatch(r"-?[0-9]+(\.[0-9]*)?(e[-+]?[0-9]+)?", cell)}
            assert not numbers or numbers == cells, (name, column, cells - numbers)


def test_an_infinite_result_is_not_written(tmp_path):
    frame = pd.DataFrame([{"case": "c", "error": float("inf")}])
    with pytest.raises(ValueError, match="infinite result in error"):
        text.write({"t": frame}, {"t": columns.describe_column("t", frame.columns)}, tmp_path, "make it")


def test_a_column_without_words_is_not_written(tmp_path):
    frame = pd.DataFrame([{"case": "c", "secret": 1.0}])
    with pytest.raises(ValueError, match="no description of secret in the table t"):
        dictionary.write({"t": frame}, {"t": columns.Table("t", {"case": "the case"})}, tmp_path, "make it")


def test_tables_for_reading_are_short(report):
    for file in (report / "tables").glob("*.md"):
        told = file.read_text()
        rows = [line for line in told.splitlines() if line.startswith("|")]
        assert len(rows) <= text.TOP_ROWS + 2, file
        # Where rows are left out it is said which file has them.
        if len(rows) == text.TOP_ROWS + 2 and len(tables(report)[file.stem]) > text.TOP_ROWS + 1:
            assert f"[{file.stem}.csv]" in told


# --- numbers for people -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "value, told",
    [
        (0.17, "170 ms"), (0.5, "0.5 s"), (3.4e-4, "340 µs"), (9.996e-4, "1 ms"), (0.4499, "450 ms"), (1.0, "1 s"),
        (2.46, "2.5 s"), (99.6, "100 s"), (1234.0, "1,200 s"), (nan, "unknown"), (0.0, "0 µs"),
    ],
)  # fmt: skip
def test_times_are_told_with_two_digits_and_no_power_of_ten(value, told):
    assert number_format.seconds(value) == told


@pytest.mark.parametrize(
    "value, told",
    [(660.3, "660 ×"), (1560.0, "1,600 ×"), (9.96, "10 ×"), (0.29, "0.29 ×"), (8.04, "8 ×"), (0.3, "0.3 ×")],
)
def test_ratios_are_told_with_two_digits_and_no_power_of_ten(value, told):
    assert number_format.times(value) == told


def test_accuracies_are_told_as_they_are_asked_for():
    assert [number_format.level(a) for a in (1e-2, 1e-4, 1e-12)] == ["0.01", "1e-4", "1e-12"]
