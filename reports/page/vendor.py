"""The libraries inside the page: npm packages, fetched by `python -m reports.page.vendor` (which needs npm).

`vendor/packages.json` says which versions; beside it stand the files that the page takes in, each package's licence,
and `vendored.json`: what they are and their digests, which a test compares.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path
from typing import Any

from cases.owned_folder import write

FOLDER = Path(__file__).parent / "vendor"
ASKED, TOLD = FOLDER / "packages.json", FOLDER / "vendored.json"


def update(latest: bool = False) -> list[dict[str, Any]]:
    """Fetch every package in its version, or in its latest one, and write its files; what was written. Raises OSError
    if npm is not there, CalledProcessError if it cannot fetch, KeyError if a package no longer has such a file."""
    asked = json.loads(ASKED.read_text(encoding="utf-8"))
    told = [_fetched(name, "latest" if latest else wish["version"], wish["files"]) for name, wish in asked.items()]
    for one in told:
        asked[one["package"]]["version"] = one["version"]
    for file, content in ((ASKED, asked), (TOLD, told)):
        write(file, json.dumps(content, indent=1) + "\n")
    return told


def vendored() -> list[dict[str, Any]]:
    """The packages as they stand here: package, version, licence, homepage, files with their digests."""
    return json.loads(TOLD.read_text(encoding="utf-8"))


def _fetched(name: str, version: str, files: dict[str, str]) -> dict[str, Any]:
    """One package; `files`: names here by paths there."""
    with tempfile.TemporaryDirectory() as place:
        told = subprocess.run(
            ["npm", "pack", "--silent", f"{name}@{version}"], cwd=place, check=True, capture_output=True, text=True
        )
        with tarfile.open(Path(place) / told.stdout.split()[-1]) as archive:
            held = {m.name.partition("/")[2]: archive.extractfile(m) for m in archive.getmembers() if m.isfile()}
            about = json.loads(held["package.json"].read())  # type: ignore[union-attr]
            digests = {}
            for path, own in files.items():
                data = held[path].read()  # type: ignore[union-attr]
                write(FOLDER / own, data)
                digests[own] = hashlib.sha256(data).hexdigest()
    return {
        "package": name,
        "version": about["version"],
        "licence": about["license"],
        "homepage": about.get("homepage", ""),
        "files": digests,
    }


if __name__ == "__main__":
    for package in update("--latest" in sys.argv[1:]):
        print(f"{package['package']} {package['version']} ({package['licence']}): {', '.join(package['files'])}")
