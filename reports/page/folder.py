"""The folder a report stands in: written beside its place and moved there when it is whole, so that a partial one is
never taken for it; a folder that holds anything else is left alone."""

from __future__ import annotations

import json
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

MADE_BY = "slip-to-roll report"
# A report is written in a minute or two: a part of one that is a day old (s) was left by a build that was killed.
_LEFT_BEHIND = 86400.0


@contextmanager
def written_whole(out: Path) -> Iterator[Path]:
    """A folder to write a report into, which takes the place of `out` when the block ends well."""
    out.parent.mkdir(parents=True, exist_ok=True)
    sweep(out)
    partial = Path(tempfile.mkdtemp(prefix=f".{out.name}.", suffix=".partial", dir=out.parent))
    try:
        partial.chmod(0o755)  # mkdtemp's folders are private; a report is for reading
        yield partial
        _move(partial, out)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def sign(folder: Path, told: dict[str, Any]) -> None:
    """Write the manifest: what is told, and which files are ours."""
    files = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    told = {"made_by": MADE_BY, **told, "files": [*files, "manifest.json"]}
    (folder / "manifest.json").write_text(json.dumps(told, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def foreign_file(out: Path) -> str:
    """A file in the folder that no report of ours wrote, or ""."""
    files = [p for p in out.rglob("*") if not p.is_dir() or p.is_symlink()] if out.is_dir() else []
    known: set[str] = set()
    try:
        manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
        if manifest.get("made_by") == MADE_BY:
            known = set(manifest["files"])
    except (OSError, ValueError, KeyError, AttributeError, TypeError):
        pass  # no manifest, or not one of ours: everything in the folder is somebody's
    return next((str(p.relative_to(out)) for p in sorted(files) if p.relative_to(out).as_posix() not in known), "")


def sweep(out: Path) -> None:
    """Remove what a build that was killed left beside the report."""
    for left in out.parent.glob(f".{out.name}.*.partial"):
        with suppress(OSError):  # another build may be at it, or it is somebody else's: it harms nobody
            if time.time() - left.stat().st_mtime > _LEFT_BEHIND:
                shutil.rmtree(left)


def _move(partial: Path, out: Path) -> None:
    """Put the whole report in its place; an older one is kept aside until it stands."""
    foreign = foreign_file(out)
    if foreign:
        raise OSError(f"{out} has come to hold {foreign} meanwhile, which is no part of a report")
    if not out.exists():
        partial.rename(out)
        return
    aside = Path(tempfile.mkdtemp(prefix=f".{out.name}.", suffix=".old", dir=out.parent))
    out.rename(aside / "report")
    try:
        partial.rename(out)
    except OSError:
        (aside / "report").rename(out)
        raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)
