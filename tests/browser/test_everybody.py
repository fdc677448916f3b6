"""Dark, keyboard, print and accessibility in a real browser."""

from __future__ import annotations

import pytest

from .reading import DISC, LINE, SHOW_ALL, after_frames, chapters


def test_dark_is_dark_by_wish_and_by_button(open_page):
    ground, colour = "getComputedStyle(document.body).backgroundColor", "suite.colourOf('exudyn')"
    page = open_page(color_scheme="dark")
    assert page.evaluate(ground) == "rgb(20, 24, 29)"
    dark = page.evaluate(colour)
    page.emulate_media(color_scheme="light")
    assert page.evaluate(ground) == "rgb(255, 255, 255)"
    light = page.evaluate(colour)
    page.click(".theme")
    assert page.evaluate(ground) == "rgb(20, 24, 29)" and page.evaluate(colour) == dark != light
    page.emulate_media(color_scheme="dark")
    page.click(".theme")
    assert page.evaluate(ground) == "rgb(255, 255, 255)" and page.evaluate(colour) == light


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
    for place in ("#answer", "#headline", DISC, LINE, "#cost", "#proved", "#parts", "#data"):
        assert page.locator(place).is_visible(), place
    cut = """() => [...document.querySelectorAll('table')].filter(e => e.checkVisibility() && e.closest('.scroll'))
        .filter(e => getComputedStyle(e.closest('.scroll')).overflowX !== 'visible'
            || e.getBoundingClientRect().right > innerWidth + 1)
        .map(e => e.outerHTML.slice(0, 200))"""
    assert page.evaluate(cut) == []
    assert not any(one.is_visible() for one in page.locator("nav, .switches, .tools, .player").all())
    assert page.locator("figure svg:visible").count() == 3
    assert page.heard.foreign(page_file.as_uri()) == []


# The dark page differs in its colours only. Rules that pass are not listed: a list takes longer than the check.
RULES = {
    "light": {"resultTypes": ["violations"]},
    "dark": {"resultTypes": ["violations"], "runOnly": ["color-contrast", "link-in-text-block"]},
}
# Rows of a table are made alike.
FEW_ROWS = {"exclude": [["tbody tr:nth-child(n+4)"]]}
OPEN_ALL = "document.querySelectorAll('details').forEach(one => { one.open = true })"


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


def test_axe_finds_no_serious_fault(open_page):
    page = open_page(color_scheme="light", reduced_motion="reduce")
    for place in chapters(page):
        visit(page, place)
    page.evaluate(SHOW_ALL)
    after_frames(page)
    assert all(page.locator(place).is_visible() for place in chapters(page))
    for scheme in RULES:
        page.emulate_media(color_scheme=scheme)
        assert serious_faults(page, FEW_ROWS, scheme) == [], scheme
