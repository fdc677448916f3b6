"""A small report, and a real browser without a window to read it; skipped, with the reason, where there is none.

The browser is Chromium as a Linux distribution packs it (`apt-get install chromium`), driven by Playwright
(`pip install -e ".[browser]"`). `.ci/nightly` installs both.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil

import pytest

from reports import build

CASES = ("disc_in_circle[mu=0.2]", "disc_on_line[mu=0.3]")
_NAMES = ("chromium", "chromium-browser", "google-chrome")
# As root in a container there is no sandbox; the rest keeps a fresh profile from calling home.
_FLAGS = ("--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")


@pytest.fixture(scope="session")
def page_file(tmp_path_factory, in_process):
    """The page of a quick report, which the processes of a parallel run share: the first makes it, others wait."""
    base = tmp_path_factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "report_of_browser_tests"
    place.mkdir(exist_ok=True)
    with open(place / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (place / "report").exists():
            argv = ["--quick", "--case", *CASES, "--solver", "reference", "pymunk", "exudyn"]
            with in_process():
                assert build.main([*argv, "--out", str(place / "report"), "--store", str(place / "store")]) == 0
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
        return [url for url in self.asked if re.split("[?#]", url)[0] != own and not url.startswith(("data:", "blob:"))]


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


# All solvers and routes shown, all cases listed, the top of the page: as a reader opens it.
_AS_OPENED = """() => {
    document.querySelectorAll("input[data-switch]").forEach(one => { if (!one.checked) one.click(); });
    const filter = document.querySelector(".index input");
    filter.value = "";
    filter.dispatchEvent(new Event("input"));
    scrollTo(0, 0);
}"""


# The listeners of the page are called first.
_GO = """place => new Promise(done => {
    if (location.hash === place) { done(); return; }
    addEventListener("hashchange", () => done(), { once: true });
    location.hash = place;
})"""


@pytest.fixture(scope="session")
def _desk_page(chromium, page_file):
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    page.heard = Heard(page)
    page.goto(page_file.as_uri())
    yield page
    page.close()


@pytest.fixture
def shared_page(_desk_page, page_file):
    """One page in a window of a desk for all tests that leave its players and tables as they are, at a place:
    `shared_page("#data")`. A page is as large as a program: to open one takes longer than most tests."""

    def going(place="#answer"):
        _desk_page.bring_to_front()
        _desk_page.evaluate(_AS_OPENED)
        _desk_page.evaluate(_GO, place)
        return _desk_page

    yield going
    assert _desk_page.heard.said == []
    assert _desk_page.heard.foreign(page_file.as_uri()) == []
