"""What several tests of the page use: its places, its tables' files, the time of a player."""

from __future__ import annotations

import csv

from reports.page.chapters import anchor

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


def table_of(page_file, name):
    """The rows of a table's file."""
    return list(csv.DictReader((page_file.parent / "tables" / f"{name}.csv").read_text().splitlines()))


def sum_of(box):
    return box["x"] + box["width"]


# Each look of axe begins with the whole document, shown or not: one look at all chapters is a third of one at each.
SHOW_ALL = (
    "document.querySelectorAll('.chapter[hidden], article[hidden]').forEach(one => { one.removeAttribute('hidden') })"
)
