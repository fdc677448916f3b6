"""The JavaScript libraries inside the page: npm packages, which `python -m tests.browser.vendor` fetches in a clone.

`vendor/packages.json` lists their versions. The same folder holds the files that the page includes, each package's
licence, and `vendored.json` with versions and digests, which a test compares with the files.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "vendor"
PACKAGES, VERSIONS = FOLDER / "packages.json", FOLDER / "vendored.json"


def libraries() -> list[dict[str, Any]]:
    """The packages in the folder: package, version, licence, homepage, files with their digests."""
    return json.loads(VERSIONS.read_text(encoding="utf-8"))
