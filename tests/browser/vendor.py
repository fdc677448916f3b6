"""`python -m tests.browser.vendor [--latest]`: fetch the JavaScript libraries inside the page from npm (needs npm)."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cases.files.command_line import status
from cases.files.owned_folder import write
from reports.page.vendor import FOLDER, PACKAGES, VERSIONS


def update(latest: bool = False) -> list[dict[str, Any]]:
    """Fetch every package in its listed or latest version and write its files; returns what was written.

    Raises OSError if npm is missing or a package no longer has a file, CalledProcessError if npm fails.
    """
    request = json.loads(PACKAGES.read_text(encoding="utf-8"))
    packages = [
        _fetch(name, "latest" if latest else entry["version"], entry["files"]) for name, entry in request.items()
    ]
    for package in packages:
        request[package["package"]]["version"] = package["version"]
    for file, content in ((PACKAGES, request), (VERSIONS, packages)):
        write(file, json.dumps(content, indent=1) + "\n")
    return packages


def _fetch(name: str, version: str, files: dict[str, str]) -> dict[str, Any]:
    """Fetch one package; `files`: local file names by path in the package."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["npm", "pack", "--silent", f"{name}@{version}"]
        packing = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
        shutil.unpack_archive(Path(folder) / packing.stdout.split()[-1], folder, filter="data")
        place, digests = Path(folder) / "package", {}
        about = json.loads((place / "package.json").read_text(encoding="utf-8"))
        for path, file_name in files.items():
            data = (place / path).read_bytes()
            write(FOLDER / file_name, data)
            digests[file_name] = hashlib.sha256(data).hexdigest()
    return {
        "package": name,
        "version": about["version"],
        "licence": about["license"],
        "homepage": about.get("homepage", ""),
        "files": digests,
    }


def _update_and_list(words: Sequence[str]) -> None:
    for package in update("--latest" in words):
        print(f"{package['package']} {package['version']} ({package['licence']}): {', '.join(package['files'])}")


if __name__ == "__main__":
    sys.exit(status("tests.browser.vendor", _update_and_list, None))
