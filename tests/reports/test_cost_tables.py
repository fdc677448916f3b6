"""The tables of a report with timings: levels, fastest engines, the first sentence, the dictionary of columns."""

import csv
import io
import json
import re
from contextlib import redirect_stdout
from dataclasses import replace
from html import unescape

import pandas as pd
import pytest

from reports import build, options
from reports.analysis import cost_conclusions, verdict_text, which_engine
from reports.judging.grades import LEVELS
from reports.running import solvers
from reports.running.records import one_default
from reports.running.timing import clock, timed_pass

CASE = "disc_in_circle[mu=0.2]"


@pytest.fixture(scope="module")
def report(tmp_path_factory, without_figures):
    """A report of one case with little time for timings, made by the command. Calls from cold are those made for the
    imports, one each, and parts end by their own count of repeats: on a busy machine as on a quiet one."""
    out = tmp_path_factory.mktemp("made") / "report"
    together = timed_pass.together

    def undisturbed(*given):
        """What is tested is the tables: that something else runs on the machine is none of their business here."""
        found, failed = together(*given)
        timings = {key: replace(one, disturbed=False) for key, one in found.items() if isinstance(one, clock.Timing)}
        return found | timings, failed

    def coarse(plan, case, solver, route, ladder):
        """As many settings as a curve has at least: the finest of an engine take as long as all others together."""
        return tuple(one_default(ladder))[: timed_pass.LEAST_SETTINGS] if solver == "pymunk" else ladder

    contestants = timed_pass.contestants

    def fast(*given):
        """Without the paper's matrix, whose runs take as long as all others: so all are timed on a busy machine."""
        return [one for one in contestants(*given) if one.route != "augmented"]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timed_pass, "together", undisturbed)
        patch.setattr(timed_pass, "contestants", fast)
        patch.setattr(options.BuildPlan, "select_rungs", coarse)
        for name, seconds in (("BUDGET", 6.0), ("COLD_BUDGET", 0.0), ("PARTS_BUDGET", 60.0)):
            patch.setattr(timed_pass, name, seconds)
        patch.setattr(which_engine, "MEASURED", (cost_conclusions.LEVEL,))
        with redirect_stdout(io.StringIO()) as output, without_figures():
            assert build.main(["--case", CASE, "--solver", "reference", "pymunk", "--out", str(out)]) == 0
    (out.parent / "terminal.txt").write_text(output.getvalue())
    return out


def read(report, name: str) -> pd.DataFrame:
    return pd.read_csv(report / "tables" / f"{name}.csv", keep_default_na=False, na_values=[""])


# --- levels ----------------------------------------------------------------------------------------------------------


def test_the_table_of_levels_has_all_settings_and_the_same_words(report):
    output, every = read(report, "time_to_accuracy"), read(report, "levels")
    words = {
        tuple(row[:4]): row[4] for row in every[["case", "solver", "route", "level", "reached"]].itertuples(index=False)
    }
    assert len(words) == len(every) >= len(output)
    for row in output.itertuples():
        word = words[row.case, row.solver, row.route, row.level]
        assert word == row.reached or row.reached in ("not timed", "disturbed"), row


# --- what is answered -------------------------------------------------------------------------------------------------


def spent(row, runs: int) -> float:
    return row.first_call_s + (runs - 1) * row.call_s


def test_answers_are_the_cheapest_of_each_side(report):
    output, answers = read(report, "time_to_accuracy"), read(report, "which_engine")
    assert [(row.level, row.runs) for row in answers.itertuples()] == [(a, n) for a in LEVELS for n in (1, 1000)]
    for answer in answers.itertuples():
        level = output[(output.level == answer.level) & output.first_call_s.notna()]
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
            # Computing times are written with six digits.
            assert (name, seconds) == (min(side, key=side.get), pytest.approx(min(side.values()), rel=1e-5))
        if isinstance(answer.cheaper, str) and answer.cheaper:
            pair = {answer.engine: answer.engine_total_s, answer.reference: answer.reference_total_s}
            assert answer.factor == pytest.approx(max(pair.values()) / min(pair.values()), rel=2e-5)
            assert answer.cheaper == ("tie" if answer.factor < 1.1 else min(pair, key=pair.get))


def test_terminal_page_and_file_give_the_same_verdict(report):
    terminal = (report.parent / "terminal.txt").read_text()
    page = (report / "index.html").read_text()
    table = page.partition('<table class="answer by-engine"')[2].partition("</table>")[0]
    shown = re.findall(r'<span class="of">(.*?)</span>.*?</th>(.*?)</tr>', table, re.DOTALL)
    rows = read(report, "verdict").fillna({"our_part": ""}).to_dict("records")
    own = [row for row in rows if not row["our_part"]]
    assert len(rows) == len(solvers.solver("pymunk").routes) and len(own) == len(shown) == 1
    for row, (who, cells) in zip(own, shown, strict=True):
        texts = [unescape(text) for text in re.findall(r"<td[^>]*>(.*?)</td>", cells, re.DOTALL)]
        expected = verdict_text.cells(row)
        assert who == row["solver"] and texts[2].startswith(expected["answers"])
        assert texts[3].startswith(f"{expected['default']} default") and f"{expected['finest']} finest" in texts[3]
        assert f"{expected['≤ 1 %']} within 1 %" in texts[2]
    assert verdict_text.in_terminal(rows) in terminal
    assert "\n".join(verdict_text.filled(verdict_text.sentence(rows))) in terminal
    assert terminal.splitlines()[-1] == str(report / "index.html")


def test_sentences_of_the_page_are_those_of_its_tables(report):
    """Each number is read from a sentence and computed again from the files alone."""
    page = re.sub(r"<(script|style|svg).*?</\1>", " ", (report / "index.html").read_text(), flags=re.DOTALL)
    text = unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", "", page))).replace("\N{NO-BREAK SPACE}", " ")

    def said(pattern: str) -> list[float]:
        match = re.search(pattern, text)
        assert match, pattern
        return [float(one.replace(",", "").replace("One", "1")) for one in match.groups()]

    runs, truth = read(report, "trajectories"), read(report, "truth")
    cases, events = truth.drop_duplicates("case"), truth[truth.event > 0]
    ranked = cases[cases.not_ranked.isna()]
    engines = runs[(runs.solver != "reference") & runs.off.notna()]
    assert said(r"(One|[\d,]+) scenes? in which a disc") == [len(ranked)]
    assert said(r"([\d,]+) scenes? of rigid plates") == [len(cases)]
    assert said(r"in ([\d,]+) motions of pymunk") == [len(engines)]
    assert said(r"Of (\d+) transitions (\d+) are also proved") == [len(events), sum(events.certificate == "proved")]
    usual = read(report, "headline").set_index(["solver", "route"]).default_off["pymunk", "native"]
    assert said(r"pymunk needs .*? for 1 % \(([\d.]+) % with default") == [pytest.approx(100 * usual, rel=0.06)]
    wrong = (1e-4 / ranked.friction_sensitivity).median()
    assert said(r"1 % off is what μ wrong by ([\d.]+) % makes") == [pytest.approx(100 * wrong, rel=0.06)]
    for name, file in tables(report).items():
        assert said(rf"\b{name}: [^;]*?(?:; [^;]*?)?, ([\d,]+) rows") == [len(file) - 1], name
    answers = read(report, "which_engine").query("cheaper.notna()")
    assert len(answers) or "No case has times of both an engine and the reference within one level." in text
    level = 0.01 if 0.01 in set(answers.level) else answers.level.max()
    for row in answers[answers.level == level].itertuples():
        times = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}
        what = "the first run takes" if row.runs == 1 else f"{row.runs:,} runs take"
        for route, seconds in ((row.engine, row.engine_total_s), (row.reference, row.reference_total_s)):
            value, unit = re.search(rf"{what} [^;]*?([\d.,]+) (s|ms|µs) with {route}", text).groups()
            assert float(value.replace(",", "")) * times[unit] == pytest.approx(seconds, rel=0.06)


def test_the_parts_of_an_engines_runs_are_in_the_table(report):
    output = read(report, "time_to_accuracy")
    rows = output[output.engine_s.notna() & (output.solver == "pymunk")]
    assert len(rows)
    parts = rows[["engine_s", "binding_s", "callback_s", "notes_s"]]
    # That they add up to the whole is measured in `test_shares`.
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
