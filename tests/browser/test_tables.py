"""Tables, files, links and switches in a real browser."""

from __future__ import annotations

import csv
import re
from fractions import Fraction

import pytest

import cases
from reports import build
from reports.page.chapters import anchor

from .conftest import CASES
from .reading import DISC, LINE, table_of


def test_a_long_table_says_how_much_it_shows_and_gives_all_rows_sorted_and_filtered(open_page, page_file):
    page = open_page(place="#data")
    files = table_of(page_file, "transitions")
    part = page.locator("details.file", has=page.locator("table[data-name=transitions]"))
    assert f"{len(files)} rows" in part.locator("summary").inner_text()
    part.locator("summary").click()
    rows = part.locator("table tbody tr")
    page.wait_for_selector("details[open] table[data-name=transitions] tbody tr td.number")
    shown = min(50, len(files))
    assert rows.count() == shown
    assert len(files) <= 50 or f"rows 1 to {shown} of {len(files)}" in part.locator(".dt-info").inner_text()
    heads = part.locator("table thead th")
    columns = heads.evaluate_all("all => all.map(e => e.dataset.column)")
    assert columns[:3] == ["case", "solver", "route"] and "s" in heads.nth(columns.index("error")).inner_text().split()
    if len(files) > 50:
        part.locator(".dt-length select").select_option("-1")
    assert rows.count() == len(files)
    heads.nth(columns.index("error")).click()
    page.wait_for_selector("table[data-name=transitions] th[aria-sort=ascending]")
    cell = f"td:nth-child({columns.index('error') + 1})"
    values = [float(v) for v in rows.locator(cell).evaluate_all("all => all.map(e => e.innerText).filter(Boolean)")]
    assert values == sorted(values) and len(set(values)) > 2
    part.locator(".dt-search input").fill("pymunk native")
    matching = [r for r in files if r["solver"] == "pymunk" and r["route"] == "native"]
    assert rows.count() == len(matching) < len(files)


def same(one: str, other: str) -> bool:
    """Whether two cells of a file are equal, to nine digits if they are numbers."""
    try:
        return one == other or float(one) == float(f"{float(other):.9g}")
    except ValueError:
        return False


def test_the_button_of_a_file_gives_the_file_with_and_without_its_folder(shared_page, page_file):
    """Times with all digits, other numbers with nine."""
    page = shared_page(DISC)
    button = page.locator(f"{DISC} a.csv").first
    name = button.inner_text()
    with page.expect_download() as saving:
        button.click()
    assert saving.value.suggested_filename == name
    assert saving.value.path().read_text(encoding="utf-8") == page.evaluate("name => suite.file(name)", name[:-4])
    page.evaluate("location.hash = '#data'")
    for name in page.locator("details.file a.csv").evaluate_all("all => all.map(e => e.textContent)"):
        inside = list(csv.DictReader(page.evaluate("name => suite.file(name)", name[:-4]).splitlines()))
        rows = table_of(page_file, name[:-4])
        assert len(inside) == len(rows) and all(list(one) == list(row) for one, row in zip(inside, rows, strict=True))
        for one, row in zip(inside, rows, strict=True):
            assert all(same(one[column], row[column]) for column in row), name
            assert all(one[column] == row[column] for column in ("time", "reference_time") if column in row), name


def test_a_case_has_the_errors_of_the_table(shared_page, page_file):
    page = shared_page(DISC)
    table = page.locator(f"{DISC} table[data-name=transitions]")
    assert table.locator("tbody tr").count() == 4
    heads = table.locator("thead th").all_inner_texts()
    fine = {
        (r["solver"], r["route"]): r["finest_setting"] for r in table_of(page_file, "headline") if r["case"] == CASES[0]
    }
    checked = 0
    for row in table_of(page_file, "transitions"):
        key = (row["solver"], row["route"])
        if (
            row["case"] != CASES[0]
            or row["pairing"] == "spurious"
            or fine[key] != row["setting"]
            or key[0] == "reference"
        ):
            continue
        column = next(i for i, head in enumerate(heads) if head.split()[:2] == [*key])
        shown = table.locator("tbody tr").nth(int(row["event"]) - 1).locator("td").nth(column).inner_text()
        assert float(shown) == pytest.approx(float(row["error"]), rel=0.06, abs=1e-300)
        checked += 1
    assert checked == 4 * 4
    engines = page.locator(f"{DISC} table[data-name=engines] tbody tr")
    rows = {(r["solver"], r["route"]): r for r in table_of(page_file, "headline") if r["case"] == CASES[0]}
    assert engines.count() == 4
    for line in engines.all():
        solver, route, default, default_factor, finest, finest_factor, _ = line.locator("td").all_inner_texts()
        row = rows[solver, route]
        for shown, name in ((default.split()[0], "default_off"), (finest, "finest_off")):
            assert float(shown.removeprefix("<")) == pytest.approx(100 * float(row[name]), rel=0.06, abs=1e-4)
        for shown, name in ((default_factor, "default"), (finest_factor, "finest")):
            assert float(shown) == pytest.approx(float(row[f"{name}_friction_factor"]), rel=0.06)


def test_the_evidence_lists_enclosures_inside_the_error_bars(shared_page, page_file):
    from reference.proofs import catalogue

    page = shared_page("#evidence")
    rows = page.locator("#proved table tbody tr")
    truths = {r["case"]: r for r in table_of(page_file, "truth") if r["event"] == "1"}
    assert rows.count() == len(CASES)
    for row in rows.all():
        case, _, change, shown, width, _ = row.locator("td").all_inner_texts()
        common, low, high = re.fullmatch(r"([\d.]*)\[(\d+), (\d+)\]", shown).groups()
        low, high = Fraction(common + low), Fraction(common + high)
        truth = truths[case]
        bar = Fraction(truth["truth_error_bar"])
        assert Fraction(truth["time"]) - bar <= low < high <= Fraction(truth["time"]) + bar
        assert float(width) == pytest.approx(float(high - low), rel=0.6) and float(width) < 1e-12
        assert change == f"{truth['before']} → {truth['after']}".replace("_", " ")
        assert row.get_attribute("title") == catalogue.read()[case].statement


def test_a_solver_switched_off_is_gone_everywhere(shared_page):
    page = shared_page()
    page.uncheck("input[data-switch=solver][value=pymunk]")
    assert not any(row.is_visible() for row in page.locator("table.answer tr[data-solver=pymunk]").all())
    assert page.locator("table.answer tr[data-solver=exudyn]").first.is_visible()
    page.evaluate(f"location.hash = {DISC!r}")
    page.wait_for_selector(f"{DISC} .player[data-time]")
    assert not page.locator(f"{DISC} .ghost[data-solver=pymunk]").first.is_visible()
    assert not page.locator(f"{DISC} table tr[data-solver=pymunk]").first.is_visible()
    page.check("input[data-switch=solver][value=pymunk]")
    page.uncheck("input[data-switch=route][value=assisted]")
    assert page.locator(f"{DISC} table tr[data-solver=pymunk][data-route=native]").first.is_visible()
    assert not page.locator(f"{DISC} table tr[data-solver=pymunk][data-route=assisted]").first.is_visible()
    page.evaluate("location.hash = '#headline'")
    assert page.locator("#headline td[data-route=native]").first.is_visible()
    assert not page.locator("#headline td[data-route=assisted]").first.is_visible()


def test_the_address_has_switches_and_the_players_time_and_setting(open_page):
    page = open_page(place=DISC, reduced_motion="reduce")
    page.wait_for_selector(f"{DISC} .player[data-time]")
    page.uncheck("input[data-switch=solver][value=pymunk]")
    page.locator(f"{DISC} .mode").nth(2).click()
    page.eval_on_selector(
        f"{DISC} .setting", "e => { e.value = 1; e.dispatchEvent(new Event('input', { bubbles: true })); }"
    )
    time, address = page.get_attribute(f"{DISC} .player", "data-time"), page.url
    again = open_page(place=address.partition("index.html")[2], reduced_motion="reduce")
    again.wait_for_selector(f"{DISC} .player[data-time]")
    assert not again.is_checked("input[data-switch=solver][value=pymunk]")
    assert not again.locator(f"{DISC} .ghost[data-solver=pymunk]").first.is_visible()
    assert float(again.get_attribute(f"{DISC} .player", "data-time")) == pytest.approx(float(time), rel=1e-5)
    assert again.locator(f"{DISC} .setting").input_value() == "1"
    again.evaluate("location.hash = '#cost'")
    again.wait_for_function("!location.search.includes('at=') && location.search.includes('without=pymunk')")


def test_cases_are_found_by_a_word_and_shown_one_at_a_time(shared_page):
    page = shared_page("#cases")
    assert page.locator("article:visible").count() == 1
    page.fill(".index input", "bowling")
    shown = page.locator(".index li:visible")
    assert shown.count() == 1 and CASES[1] in shown.inner_text()
    shown.locator("a").click()
    assert page.locator("article:visible h3").first.inner_text() == CASES[1]
    page.wait_for_selector(f"{LINE} .player[data-time]")


def test_a_case_with_impacts_has_the_impulses_of_truth_and_engines(chromium, in_process, tmp_path):
    """Thrown at a floor, e = 0.8: 1.8 times the closing momentum, and no friction where it rolls by then."""
    name = "rebound_with_spin[e=0.8]"
    argv = ["--quick", "--case", name, "--solver", "reference", "pymunk", "--out", str(tmp_path / "a")]
    with in_process():
        assert build.main([*argv, "--store", str(tmp_path / "store")]) == 0
    page, place = chromium.new_page(), f"#{anchor(cases.load(name).label)}"
    page.goto((tmp_path / "a" / "index.html").as_uri() + place)
    table = page.locator(f"{place} table[data-name=impulses]")
    table.wait_for()
    heads = table.locator("thead th").all_inner_texts()
    rows = [row.locator("td").all_inner_texts() for row in table.locator("tbody tr").all()]
    true = table_of(tmp_path / "a" / "index.html", "impulses")[:2]
    assert [row[2] for row in rows] == [f"{float(true[0]['reference_normal']):.3g}, -1.33", "6.38, 0"]
    column = next(i for i, head in enumerate(heads) if head.split()[:2] == ["pymunk", "native"])
    assert float(rows[0][column].split(",")[0]) == pytest.approx(float(true[0]["reference_normal"]), rel=0.02)
    page.close()
