"""The documentation's site as a reader opens it from a folder: no link is broken, and its search asks no network."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import adapters
import cases
import reference

from .conftest import Heard

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """The site as `make docs` builds it, but for the gallery, which is not run."""
    for name in ("material", "mkdocstrings", "mkdocs_jupyter"):
        pytest.importorskip(name, reason='the site\'s tools are missing: pip install -e ".[docs]"')
    place = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(place)]
    environment = os.environ | {"GALLERY": "false", "NO_MKDOCS_2_WARNING": "1"}
    output = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert output.returncode == 0, output.stderr
    return place


def test_the_search_of_the_site_works_from_a_folder_without_network(site, chromium):
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    heard = Heard(page)
    page.goto((site / "index.html").as_uri())
    page.locator(".md-search__input").click()
    page.keyboard.type("restitution")
    page.locator(".md-search-result__item").first.wait_for()
    assert "estitution" in page.locator(".md-search-result__item").first.inner_text()
    assert not [url for url in heard.asked if not url.startswith((site.as_uri(), "data:", "blob:"))]
    page.close()


@pytest.mark.parametrize("room", [cases, reference, adapters], ids=lambda room: room.__name__)
def test_the_page_of_a_room_has_every_public_name(room, site):
    text = (site / f"api_{room.__name__}.html").read_text(encoding="utf-8")
    assert not [name for name in room.__all__ if f'id="{room.__name__}.{name}"' not in text]
