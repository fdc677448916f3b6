"""The folders of a report, of a study and of a published report; `manifest.json` records how each was made."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from cases.files.owned_folder import OwnedFolder

MADE_BY = "slip-to-roll report"
PAGE, MANIFEST, HISTORY = "index.html", "manifest.json", "history.md"
TABLES = ("csv", "md", "tex", "json")
FIGURES = ("svg", "png", "pdf")


def of_report(path: Path, kind: str = "report") -> OwnedFolder:
    """The folder of a report; it counts as unfinished without page or manifest."""
    return OwnedFolder(path, kind, (PAGE, MANIFEST, "tables/*", "figures/*"), (PAGE, MANIFEST))


def of_history(path: Path) -> OwnedFolder:
    """The folder of the history of engines."""
    return OwnedFolder(path, "history", (MANIFEST, HISTORY, "tables/*"), (MANIFEST, HISTORY))


def of_study(path: Path) -> OwnedFolder:
    """The folder of one study, without subfolders."""
    return OwnedFolder(path, "study", [f"*.{ending}" for ending in (*TABLES, *FIGURES)], (MANIFEST,))


def sign(folder: Path, facts: dict[str, Any]) -> None:
    """Write the manifest: `facts` about how the files were made."""
    text = json.dumps({"made_by": MADE_BY, **facts}, indent=1, ensure_ascii=False) + "\n"
    (folder / MANIFEST).write_text(text, encoding="utf-8", errors="backslashreplace")
