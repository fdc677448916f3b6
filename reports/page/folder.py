"""The folder of a report, of a study, and of a report that is published; `manifest.json` says what made it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from cases.owned_folder import OwnedFolder

MADE_BY = "slip-to-roll report"
PAGE, MANIFEST = "index.html", "manifest.json"
TABLES = ("csv", "md", "tex", "json")
FIGURES = ("svg", "png", "pdf")


def of_report(path: Path, kind: str = "report") -> OwnedFolder:
    """The folder of a report; without page or manifest it counts as unfinished."""
    return OwnedFolder(path, kind, (PAGE, MANIFEST, "tables/*", "figures/*"), (PAGE, MANIFEST))


def of_study(path: Path) -> OwnedFolder:
    """The folder of one study, without folders inside."""
    return OwnedFolder(path, "study", [f"*.{ending}" for ending in (*TABLES, *FIGURES)], (MANIFEST,))


def sign(folder: Path, told: dict[str, Any]) -> None:
    """Write the manifest: what made the files."""
    text = json.dumps({"made_by": MADE_BY, **told}, indent=1, ensure_ascii=False) + "\n"
    (folder / MANIFEST).write_text(text, encoding="utf-8", errors="backslashreplace")
