"""The page in a real browser: what a reader sees, does and can reach. No test here may end with a word in the console
or a request (`open_page`)."""

from __future__ import annotations

import base64
import csv
import math
import re
import zlib
from fractions import Fraction
from html import unescape

import pytest

from reports.page.chapters import anchor
from reports.page.fragments import verbatim
from reports.page.text import shorten

from .conftest import CASES

WIDTHS = {"desk": (1440, 900), "tablet": (1024, 768), "phone": (390, 844)}
DISC, LINE = (f"#{anchor(label)}" for label in CASES)


def chapters(page):
    return page.eval_on_selector_all("nav.chapters a", "links => links.map(a => a.hash)")


def time_of(page, player):
    return float(page.eval_on_selector(player, "one => one.dataset.time"))


def after_frames(page, count=20):
    """Wait until the page has been drawn so many times, however long that takes."""
    page.evaluate(
        "count => new Promise(done => { const next = () => count-- ? requestAnimationFrame(next) : done(); next() })",
        count,
    )


# --- the first screen -------------------------------------------------------------------------------------------------


def table_of(page_file, name):
    """The rows of a table's file."""
    return list(csv.DictReader((page_file.parent / "tables" / f"{name}.csv").read_text().splitlines()))


@pytest.mark.parametrize("width", WIDTHS)
def test_the_first_screen_holds_sentence_and_map_whole(open_page, width):
    wide, high = WIDTHS[width]
    page = open_page(wide, high)
    page.wait_for_selector(".pair .player[data-time]")
    assert page.locator("p.verdict").bounding_box()["y"] < high / 3
    box = page.locator("table.map").bounding_box()
    assert box["x"] >= 0 and box["y"] + box["height"] <= high
    # A phone shows the map's first columns and scrolls the others within its frame; the page scrolls nowhere sideways.
    assert width == "phone" or box["x"] + box["width"] <= wide
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    rows = page.locator("table.map tbody tr")
    assert rows.count() == 9 and all(row.is_visible() for row in rows.all())  # two of each route, and a line
    tabs = page.locator("nav.chapters a")
    assert tabs.all_inner_texts() == ["Answer", "Cases", "Cost", "Evidence", "Data"]
    assert all(0 <= tab.bounding_box()["x"] and sum_of(tab.bounding_box()) <= wide for tab in tabs.all())


def sum_of(box):
    return box["x"] + box["width"]


def test_each_cell_of_the_map_has_the_numbers_of_the_tables(open_page, page_file):
    page = open_page()
    cases_shown = page.locator("table.map .case").all_inner_texts()
    assert set(cases_shown) == set(CASES)
    rows = {
        (r["case"], r["solver"], r["route"]): r for r in table_of(page_file, "headline") if r["solver"] != "reference"
    }
    runs = table_of(page_file, "trajectories")
    seen = 0
    for body in page.locator("table.map tbody[data-solver]").all():
        key = (body.get_attribute("data-solver"), body.get_attribute("data-route"))
        for line in body.locator("tr").all():
            settings = line.locator("th").last.inner_text()
            for case, cell in zip(cases_shown, line.locator("td").all(), strict=True):
                row = rows[case, *key]
                off, grade = float(row[f"{settings}_off"]), row[f"{settings}_grade"]
                shown, _, small = cell.inner_text().partition(" ")
                number = float(shown.removeprefix("<"))
                assert 100 * off < 0.005 if shown == "<.01" else number == pytest.approx(100 * off, rel=0.06, abs=0.006)
                assert cell.get_attribute("class").split()[0] == grade.replace(" ", "-")
                setting = row["finest_setting"] if settings == "finest" else "rung=defaults"
                run = next(
                    r
                    for r in runs
                    if (r["case"], r["solver"], r["route"]) == (case, *key) and r["setting"].startswith(setting)
                )
                factor = float(run["friction_factor"] or "nan")
                if not 0.9 <= factor <= 1.1:
                    assert float(small.removeprefix("friction × ")) == pytest.approx(factor, rel=0.06)
                else:
                    assert (small == "") == run["sequence"].startswith("same sequence")
                seen += 1
    assert seen == 2 * 4 * len(CASES)


def test_a_click_on_the_map_opens_the_case(open_page):
    page = open_page()
    page.locator("table.map tbody td a").first.click()
    page.wait_for_selector("article:visible .player[data-time]")
    assert page.locator("article:visible h3").first.inner_text() == page.locator(
        "table.map .case"
    ).first.inner_text() or (page.url.endswith(page.locator("table.map .case a").first.get_attribute("href")))


def test_the_colours_of_grades_are_those_of_the_limits(open_page):
    page = open_page()
    keys = page.locator("#answer .key").all_inner_texts()
    assert keys == ["excellent", "very good", "good", "rough", "poor", "unusable", "hatched"]
    colour = "e => getComputedStyle(e).backgroundColor"
    legend = {key.inner_text().replace(" ", "-"): key.evaluate(colour) for key in page.locator("#answer .key").all()}
    for cell in page.locator("table.map td[class]").all():
        assert cell.evaluate(colour) == legend[cell.get_attribute("class").split()[0]]


def test_the_chart_has_every_setting_of_its_case_at_its_place(open_page, page_file):
    page = open_page()
    runs = [r for r in table_of(page_file, "trajectories") if r["case"] == CASES[0] and r["solver"] != "reference"]
    marks = page.locator(".chart g .mark")
    tips = marks.locator("title").evaluate_all("all => all.map(one => one.textContent)")
    assert len(tips) == len(runs) > 10
    places = [
        float(n)
        for n in marks.evaluate_all("all => all.map(e => e.getAttribute('transform').match(/ ([\\d.]+)\\)/)[1])")
    ]
    by_tip = {tip.partition(": ")[0]: (place, tip) for tip, place in zip(tips, places, strict=True)}
    offs = []
    for run in runs:
        place, tip = by_tip[f"{run['solver']} {run['route']}, {run['setting']}"]
        share = float(tip.partition(": ")[2].split(" %")[0].removeprefix("less than "))
        assert share == pytest.approx(100 * float(run["off"]), rel=0.06, abs=1e-4)
        offs.append((float(run["off"]), place))
    # A larger error is higher, by the same length for each power of ten.
    (low, y0), (high, y1) = min(offs), max(offs)
    assert y1 < y0
    slope = (y0 - y1) / math.log10(high / max(low, 1e-6))
    for off, place in offs:
        assert place == pytest.approx(y1 + slope * math.log10(high / max(off, 1e-6)), abs=0.3)


def test_the_first_sentence_names_the_best_engine_by_itself_and_follows_the_switches(open_page, page_file):
    page = open_page()
    rows = list(csv.DictReader((page_file.parent / "tables" / "verdict.csv").read_text().splitlines()))
    ranked = [row for row in rows if row["digits_rank"]]
    assert len(ranked) == 2 and {row["route"] for row in ranked} == {"native"}
    sentence = page.locator("p.verdict")
    without_scripts = unescape(re.search(r'<p class="verdict"[^>]*>([^<]*)<', page_file.read_text()).group(1))
    assert sentence.inner_text() == without_scripts
    first, second = (row["solver"] for row in ranked)
    assert f"{first} native" in sentence.inner_text() and "assisted" not in sentence.inner_text()
    page.uncheck(f"input[data-switch=solver][value={first}]")
    assert f"{second} native" in sentence.inner_text() and first not in sentence.inner_text()
    page.uncheck("input[data-switch=route][value=native]")
    assert sentence.inner_text() == "No engine is shown."
    page.check(f"input[data-switch=solver][value={first}]")
    page.check("input[data-switch=route][value=native]")
    assert sentence.inner_text() == without_scripts


def test_a_hidden_route_is_on_no_part_of_the_first_screen(open_page):
    page = open_page()
    page.wait_for_selector(".pair .player[data-time]")
    parts = (
        "table.map tbody",
        ".chart g",
        ".chart .legend span",
        ".pair .ghost",
        ".pair .engines li",
        "table.answer tr",
    )
    page.uncheck("input[data-switch=route][value=native]")
    page.uncheck("input[data-switch=solver][value=exudyn]")
    for part in parts:
        shown = page.locator(f"{part}[data-solver]:visible").evaluate_all(
            "all => all.map(e => `${e.dataset.solver} ${e.dataset.route}`)"
        )
        assert set(shown) == {"pymunk assisted"}, part
    visible = page.locator("#answer").inner_text()
    assert "exudyn native" not in visible and "pymunk native" not in visible
    page.check("input[data-switch=route][value=native]")
    for part in parts:
        assert page.locator(f"{part}[data-solver=pymunk][data-route=native]").first.is_visible(), part


def test_the_slider_goes_over_the_ladder_and_names_each_setting_with_its_error(open_page, page_file):
    page = open_page(reduced_motion="reduce")
    page.wait_for_selector(".pair .player[data-time]")
    runs = [
        r
        for r in table_of(page_file, "trajectories")
        if (r["case"], r["solver"], r["route"]) == (CASES[0], "pymunk", "native")
    ]
    defaults = [r for r in runs if r["setting"].startswith("rung=defaults")]
    ladder = [defaults[0], *(r for r in runs if r not in defaults)]
    end = page.evaluate("label => suite.motion(label).then(m => m.end)", CASES[0])
    page.eval_on_selector(".pair .time", "e => { e.value = 1000; e.dispatchEvent(new Event('input')); }")
    assert time_of(page, ".pair .player") == pytest.approx(end)
    distances = []
    for place, run in enumerate(ladder):
        page.eval_on_selector(".pair .setting", f"e => {{ e.value = {place}; e.dispatchEvent(new Event('input')); }}")
        line = page.locator(".pair .engines li[data-solver=pymunk][data-route=native]").inner_text()
        share = float(re.search(r"([\d.]+) % off", line)[1])
        assert share == pytest.approx(100 * float(run["off"]), rel=0.06, abs=1e-4)
        assert run["setting"].removeprefix("rung=defaults").strip(", ").split(",")[0] in line.replace(", ", ",")
        poses = [
            [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", page.get_attribute(f".pair {who}", "transform"))]
            for who in (".plate", ".ghost[data-solver=pymunk][data-route=native]")
        ]
        distances.append(math.dist(poses[0][:2], poses[1][:2]))
    # With default settings the engine is visibly apart from the truth: by a tenth of the circle's radius.
    assert distances[0] > 0.1 and distances[0] > 20 * distances[-1]


def test_the_first_paint_is_early(chromium, page_file):
    page = chromium.new_page()
    times = []
    for _ in range(3):
        page.goto(page_file.as_uri())
        page.wait_for_function("performance.getEntriesByName('first-contentful-paint').length")
        times.append(page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime"))
    page.close()
    # ms; asked for is 300 on a machine that does nothing else, and tests do.
    assert min(times) < 600.0, times


def test_without_scripts_every_table_and_figure_is_there(chromium, page_file):
    context = chromium.new_context(java_script_enabled=False, viewport={"width": 1440, "height": 900})
    page = context.new_page()
    page.goto(page_file.as_uri())
    for place in (
        "#answer",
        "table.map",
        ".chart > svg",
        "#cases",
        "#headline",
        "#failures",
        "#cost",
        "#proved",
        "#tables",
        "#made",
    ):
        assert page.locator(place).is_visible()
    assert page.locator("#cases article").count() == len(CASES) + 2
    assert all(one.is_visible() for one in page.locator("article").all())
    assert not page.locator(".player").first.is_visible()
    figures = page.locator("article img:visible")
    assert figures.count() >= 2 * len(CASES)
    context.close()


# --- the player -------------------------------------------------------------------------------------------------------


def test_the_disc_on_the_first_screen_moves_by_itself_and_stops_when_asked(open_page):
    page = open_page()
    page.wait_for_function("+document.querySelector('.pair .player').dataset.time > 0.05")
    page.click(".pair [data-do=play]")
    stopped = time_of(page, ".pair .player")
    after_frames(page)
    assert time_of(page, ".pair .player") == stopped
    assert page.get_attribute(".pair [data-do=play]", "aria-label") == "play"


def test_who_asks_for_less_motion_gets_none_until_play_is_pressed(open_page):
    page = open_page(reduced_motion="reduce")
    page.wait_for_selector(".pair .player[data-time]")
    start = time_of(page, ".pair .player")
    after_frames(page)
    assert time_of(page, ".pair .player") == start > 0.0
    page.click(".pair [data-do=play]")
    page.wait_for_function(f"+document.querySelector('.pair .player').dataset.time !== {start!r}")


def test_a_case_plays_scrubs_and_steps_by_keyboard(open_page):
    page = open_page(place=DISC)
    player = f"{DISC} .player"
    page.wait_for_selector(f"{player}[data-time]")
    page.focus(f"{player} .stage")
    page.keyboard.press(" ")
    page.wait_for_function(f"+document.querySelector({player!r}).dataset.time > 0.05")
    page.keyboard.press(" ")
    page.keyboard.press("Home")
    assert time_of(page, player) == 0.0
    page.keyboard.press("ArrowRight")
    assert time_of(page, player) > 0.0
    plate = page.get_attribute(f"{player} .plate", "transform")
    page.eval_on_selector(f"{player} .time", "e => { e.value = 500; e.dispatchEvent(new Event('input')); }")
    end = page.evaluate("label => suite.motion(label).then(m => m.end)", CASES[0])
    assert time_of(page, player) == pytest.approx(end / 2, rel=1e-9)
    assert page.get_attribute(f"{player} .plate", "transform") != plate


def test_a_click_on_a_transition_lands_at_its_very_time(open_page, page_file):
    page = open_page(place=DISC)
    player = f"{DISC} .player"
    page.wait_for_selector(f"{player}[data-time]")
    rows = list(csv.DictReader((page_file.parent / "tables" / "truth.csv").read_text().splitlines()))
    times = [float(row["time"]) for row in rows if row["case"] == CASES[0]]
    assert len(times) >= 3
    buttons = page.locator(f"{player} .mode")
    for place, time in enumerate(times, start=1):
        buttons.nth(place).click()
        assert time_of(page, player) == time
        assert buttons.nth(place).get_attribute("data-now") is not None
    page.click(f"{player} [data-do=back]")
    assert time_of(page, player) == times[-2]
    page.click(f"{player} [data-do=next]")
    assert time_of(page, player) == times[-1]


def test_the_plate_stands_where_the_truth_has_it_and_ghosts_move_away_as_they_are_enlarged(open_page):
    import cases
    import reference

    page = open_page(place=DISC)
    player = f"{DISC} .player"
    page.wait_for_selector(f"{player}[data-time]")
    page.locator(f"{player} .mode").nth(1).click()
    motion = reference.simulate(cases.load(CASES[0]), rtol=1e-10)
    truth = motion(motion.transitions[0].time)
    told = [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", page.get_attribute(f"{player} .plate", "transform"))]
    # Numbers travel with 16 bits of mantissa: 1e-5 of a pose of 1 m.
    assert told[:2] == pytest.approx([truth.x, truth.y], abs=1e-5)
    ghost = f"{player} .ghost[data-solver=pymunk]"
    near = page.get_attribute(ghost, "transform")
    page.eval_on_selector(f"{player} .larger", "e => { e.value = 3; e.dispatchEvent(new Event('input')); }")
    far = page.get_attribute(ghost, "transform")
    one, other = ([float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)[:2]] for text in (near, far))
    off, large = (max(abs(a - b) for a, b in zip(text, told, strict=False)) for text in (one, other))
    assert large == pytest.approx(1000 * off, rel=1e-3) and off > 0.0


def test_plots_follow_the_player_and_lead_it(open_page):
    page = open_page(place=DISC)
    page.wait_for_selector(f"{DISC} .plots .u-over")
    panels = page.locator(f"{DISC} .plots .panel")
    assert panels.count() == 6 and page.locator(f"{DISC} .plots canvas").count() == 6
    needle = page.locator(f"{DISC} .plots .needle").first
    before = needle.evaluate("e => e.style.left")
    page.locator(f"{DISC} .mode").nth(2).click()
    assert needle.evaluate("e => e.style.left") != before
    over = page.locator(f"{DISC} .plots .u-over").first
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    end = page.evaluate("label => suite.motion(label).then(m => m.end)", CASES[0])
    assert time_of(page, f"{DISC} .player") == pytest.approx(end / 2, rel=0.02)


# --- tables and switches ----------------------------------------------------------------------------------------------


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


def test_rows_that_a_script_adds_read_as_those_of_the_page(open_page):
    page = open_page(place="#data")
    values = ["", "0.0", "1.23456789e-07", "-0.00034", "1712.5", "0.0627", "3", "True", "nan of a text"]
    columns = ["error", "cpu_s", "time", "order", "published"]
    read = page.evaluate(
        "([values, columns]) => columns.map(c => values.map(v => suite.shorten(v, c, v !== 'nan of a text')))",
        [values, columns],
    )
    for column, texts in zip(columns, read, strict=True):
        for value, text in zip(values, texts, strict=True):
            if value in ("", "3", "True", "nan of a text"):
                assert text == {"True": "yes"}.get(value, value)
            else:
                assert text == verbatim(shorten(float(value), column)), (column, value)


def test_the_button_of_a_file_gives_the_file_with_and_without_its_folder(open_page, page_file):
    page = open_page(place=DISC)
    button = page.locator(f"{DISC} a.csv").first
    name = button.get_attribute("data-file")
    with page.expect_download() as saving:
        button.click()
    assert saving.value.suggested_filename == f"{name}.csv"
    assert saving.value.path().read_bytes() == (page_file.parent / "tables" / f"{name}.csv").read_bytes()
    page.evaluate("location.hash = '#data'")
    for name in page.locator("details.file a.csv").evaluate_all("all => all.map(e => e.dataset.file)"):
        inside = page.evaluate("name => suite.file(name)", name)
        assert inside == (page_file.parent / "tables" / f"{name}.csv").read_text(encoding="utf-8"), name


def test_a_case_has_the_errors_of_the_table(open_page, page_file):
    page = open_page(place=DISC)
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


def test_the_evidence_lists_enclosures_inside_the_error_bars(open_page, page_file):
    from reference.proofs import catalogue

    page = open_page(place="#evidence")
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


@pytest.mark.parametrize(
    "old, tab, visible",
    [("motions", "cases", DISC), ("headline", "cases", "#headline"), ("failures", "cases", "#failures"),
     ("precision", "cost", "#cost"), ("definitions", "answer", "table.answer"), ("tables", "data", "#tables"),
     ("made", "data", "#made"), (DISC[1:], "cases", DISC), ("nothing", "answer", "table.map")],
)  # fmt: skip
def test_links_to_the_chapters_of_older_pages_lead_to_the_right_tab(open_page, old, tab, visible):
    page = open_page(place=f"#{old}")
    assert page.get_attribute("nav.chapters a[aria-current]", "href") == f"#{tab}"
    assert page.locator(visible).is_visible() and page.locator("main > .chapter:visible").count() == 1


def test_a_solver_switched_off_is_gone_everywhere(open_page):
    page = open_page()
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


def test_cases_are_found_by_a_word_and_shown_one_at_a_time(open_page):
    page = open_page(place="#cases")
    assert page.locator("article:visible").count() == 1
    page.fill(".index input", "bowling")
    shown = page.locator(".index li:visible")
    assert shown.count() == 1 and CASES[1] in shown.inner_text()
    shown.locator("a").click()
    assert page.locator("article:visible h3").first.inner_text() == CASES[1]
    page.wait_for_selector(f"{LINE} .player[data-time]")


POINTS = """case,solver,route,setting,quantity,unit,cpu_s,call_s,steps,absolute_error,floor_error
a case,pymunk,native,h=0.01,off,1,0.1,0.2,100,1e-3,1e-12
a case,pymunk,native,h=0.001,off,1,1.0,1.1,1000,1e-4,1e-12
"""


def test_a_point_of_the_precision_plot_tells_its_setting_and_command(open_page):
    page = open_page(place="#cost")
    page.evaluate(
        """([text, bytes]) => { const data = document.createElement("script"), place = document.createElement("div");
        Object.assign(data, {type: "text/plain", className: "file", textContent: bytes});
        data.dataset.name = "work_precision";
        place.className = "precision";
        place.dataset.command = "python -m reports.build";
        document.querySelector("#cost").append(data, place);
        return suite.precision(place); }""",
        [POINTS, base64.b64encode(zlib.compress(POINTS.encode())).decode()],
    )
    assert page.locator(".precision circle").count() == 2
    assert page.locator(".precision .work").input_value() == "call_s"
    page.hover(".precision circle >> nth=1")
    told = page.inner_text(".precision .details")
    assert "h=0.001" in told and "0.01 % off" in told and "1.1 s a whole call" in told
    assert 'python -m reports.build --case "a case" --solver pymunk' in told
    page.focus(".precision svg")
    page.keyboard.press("ArrowLeft")
    assert "h=0.01:" in page.inner_text(".precision .details")
    page.uncheck("input[data-switch=solver][value=pymunk]")
    assert page.locator(".precision circle").count() == 0


# --- for everybody ----------------------------------------------------------------------------------------------------


def test_dark_is_dark_by_wish_and_by_button(open_page):
    ground = "getComputedStyle(document.body).backgroundColor"
    dark, light = open_page(color_scheme="dark"), open_page(color_scheme="light")
    assert dark.evaluate(ground) == "rgb(20, 24, 29)" and light.evaluate(ground) == "rgb(255, 255, 255)"
    colour = "suite.colourOf('exudyn')"
    was = light.evaluate(colour)
    light.click(".theme")
    assert light.evaluate(ground) == "rgb(20, 24, 29)" and light.evaluate(colour) == dark.evaluate(colour) != was
    dark.click(".theme")
    assert dark.evaluate(ground) == "rgb(255, 255, 255)"


def test_in_the_dark_only_cells_of_a_grade_have_dark_text(open_page):
    page = open_page(color_scheme="dark", place=DISC)
    page.wait_for_selector(f"{DISC} table[data-name=engines]")
    page.evaluate(SHOW_ALL)
    cells = page.evaluate(
        """() => [...document.querySelectorAll('td')].filter(e => e.checkVisibility() && e.innerText.trim()).map(e =>
        [e.matches('.excellent, .very-good, .good, .rough, .poor, .unusable') && Boolean(e.closest('.map, .grades')),
         getComputedStyle(e.querySelector('a') ?? e).color])"""
    )
    grades = {colour for is_grade, colour in cells if is_grade}
    assert grades == {"rgb(16, 20, 24)"} and grades.isdisjoint({colour for is_grade, colour in cells if not is_grade})


def test_the_keyboard_alone_reaches_everything(open_page):
    page = open_page(place=DISC, reduced_motion="reduce")
    page.wait_for_selector(f"{DISC} .plots .u-over")
    wanted = page.evaluate(
        """() => [...document.querySelectorAll("a[href], button, input, select, summary, [tabindex='0']")]
        .filter(e => e.checkVisibility({checkVisibilityCSS: true, contentVisibilityAuto: true}) && !e.disabled)
        .map((e, i) => (e.dataset.wanted = i, e.outerHTML.slice(0, 80)))"""
    )
    page.evaluate("document.activeElement.blur(); scrollTo(0, 0)")
    reached = set()
    for _ in range(len(wanted) + 20):
        page.keyboard.press("Tab")
        found = page.evaluate("document.activeElement?.dataset.wanted ?? null")
        if found is not None:
            reached.add(int(found))
    assert [text for place, text in enumerate(wanted) if place not in reached] == []


def test_print_has_every_chapter_and_figure_and_cuts_no_table(open_page, page_file):
    page = open_page(794, 1123)  # A4
    page.wait_for_selector(".pair .player[data-time]")
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    for place in ("#answer", "#headline", DISC, LINE, "#cost", "#proved", "#data"):
        assert page.locator(place).is_visible(), place
    page.wait_for_function(
        "[...document.images].every(e => e.complete && (e.naturalWidth > 0 || !e.checkVisibility()))"
    )
    cut = """() => [...document.querySelectorAll('table')].filter(e => e.checkVisibility() && e.closest('.scroll'))
        .filter(e => getComputedStyle(e.closest('.scroll')).overflowX !== 'visible'
            || e.getBoundingClientRect().right > innerWidth + 1)
        .map(e => e.outerHTML.slice(0, 200))"""
    assert page.evaluate(cut) == []
    assert not any(one.is_visible() for one in page.locator("nav, .switches, .tools, .player").all())
    # The headline, and of each case scene, motion and errors.
    assert page.locator("figure img:visible").count() == 1 + 3 * len(CASES)
    # Those of cases are files of the report's folder, which are read for print only.
    files = page.heard.foreign(page_file.as_uri())
    assert {url.rpartition("/")[0] for url in files} == {(page_file.parent / "figures").as_uri()}
    page.heard.asked.clear()


# In the dark the page is the same but for its colours. What passes is not told: that takes longer than to check it.
RULES = {
    "light": {"resultTypes": ["violations"]},
    "dark": {"resultTypes": ["violations"], "runOnly": ["color-contrast", "link-in-text-block"]},
}
# Rows of a table are made alike.
FEW_ROWS = {"exclude": [["tbody tr:nth-child(n+4)"]]}
OPEN_ALL = "document.querySelectorAll('details').forEach(one => { one.open = true })"
# Each look of axe begins with the whole document, shown or not: one look at all chapters is a third of one at each.
SHOW_ALL = (
    "document.querySelectorAll('.chapter[hidden], article[hidden]').forEach(one => { one.removeAttribute('hidden') })"
)


def serious_faults(page, part, scheme) -> list[str]:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    page.evaluate(OPEN_ALL)
    return [
        f"{one['id']}: {one['help']}: {one['nodes'][0]['html'][:200]}"
        for one in axe.run(page, part, RULES[scheme]).response["violations"]
        if one["impact"] in ("serious", "critical")
    ]


def visit(page, place) -> None:
    page.evaluate("place => { location.hash = place }", place)
    page.wait_for_selector(f"{place}:not([hidden])")


@pytest.mark.parametrize("scheme", RULES)
def test_axe_finds_no_serious_fault(open_page, scheme):
    page = open_page(color_scheme=scheme, reduced_motion="reduce")
    for place in chapters(page):
        visit(page, place)
    page.evaluate(SHOW_ALL)
    after_frames(page)
    assert all(page.locator(place).is_visible() for place in chapters(page))
    assert serious_faults(page, FEW_ROWS, scheme) == []


@pytest.mark.slow
@pytest.mark.parametrize("scheme", RULES)
def test_axe_finds_no_serious_fault_in_any_row_of_any_chapter(open_page, scheme):
    page = open_page(color_scheme=scheme, reduced_motion="reduce")
    for place in chapters(page):
        visit(page, place)
        after_frames(page)
        assert serious_faults(page, None, scheme) == [], place
