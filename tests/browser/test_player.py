"""The player and its plots in a real browser."""

from __future__ import annotations

import csv
import re

import pytest

from .conftest import CASES
from .reading import DISC, after_frames, time_of


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
    drawn = [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", page.get_attribute(f"{player} .plate", "transform"))]
    # Numbers travel with 16 bits of mantissa: 1e-5 of a pose of 1 m.
    assert drawn[:2] == pytest.approx([truth.x, truth.y], abs=1e-5)
    ghost = f"{player} .ghost[data-solver=pymunk]"
    near = page.get_attribute(ghost, "transform")
    page.eval_on_selector(f"{player} .larger", "e => { e.value = 3; e.dispatchEvent(new Event('input')); }")
    far = page.get_attribute(ghost, "transform")
    one, other = ([float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)[:2]] for text in (near, far))
    off, large = (max(abs(a - b) for a, b in zip(text, drawn, strict=False)) for text in (one, other))
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
