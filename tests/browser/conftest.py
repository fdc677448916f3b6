"""A small report, and a real browser without a window to read it; skipped, with the reason, where there is none.

The browser is Chromium as a Linux distribution packs it (`apt-get install chromium`), driven by Playwright
(`pip install -e ".[browser]"`). `.ci/run` installs both.
"""

from __future__ import annotations

import os
import shutil

import pytest

from reports import build

CASES = ("disc_in_circle[mu=0.2]", "disc_on_line[mu=0.3]")
_NAMES = ("chromium", "chromium-browser", "google-chrome")
# As root in a container there is no sandbox; the rest keeps a fresh profile from calling home.
_FLAGS = ("--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")


@pytest.fixture(scope="session")
def page_file(tmp_path_factory, in_process):
    """The page of a quick report."""
    place = tmp_path_factory.mktemp("page")
    argv = ["--quick", "--case", *CASES, "--solver", "reference", "pymunk", "exudyn", "--out", str(place / "report")]
    with in_process():
        assert build.main([*argv, "--store", str(place / "store")]) == 0
    return place / "report" / "index.html"


@pytest.fixture(scope="session")
def chromium():
    """The browser; a test without one is skipped, but for where `SLIP_TO_ROLL_BROWSER=needed` says that it must be."""
    needed = os.environ.get("SLIP_TO_ROLL_BROWSER") == "needed"
    path = next(filter(None, map(shutil.which, _NAMES)), None)
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        sync_playwright = None
    lacking = "no Chromium is installed" if path is None else 'Playwright is missing: pip install -e ".[browser]"'
    if path is None or sync_playwright is None:
        (pytest.fail if needed else pytest.skip)(lacking)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=list(_FLAGS))
        yield browser
        browser.close()


class Heard:
    """What a page said and asked for while it was open."""

    def __init__(self, page):
        self.said, self.asked = [], []
        page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda problem: self.said.append(str(problem)))
        page.on("request", lambda request: self.asked.append(request.url))

    def foreign(self, own: str) -> list[str]:
        """Requests for anything but the page itself and what stands inside it."""
        return [url for url in self.asked if url.partition("#")[0] != own and not url.startswith(("data:", "blob:"))]


@pytest.fixture
def open_page(chromium, page_file):
    """Opens the page in a window of its own: `open_page(width=…, height=…, color_scheme=…)`. When the test ends, no
    page may have complained nor asked for anything."""
    opened = []

    def opening(width=1440, height=900, place="", **options):
        page = chromium.new_page(viewport={"width": width, "height": height}, **options)
        page.heard = Heard(page)
        opened.append(page)
        page.goto(page_file.as_uri() + place)
        return page

    yield opening
    for page in opened:
        page.close()
        assert page.heard.said == []
        assert page.heard.foreign(page_file.as_uri()) == []
