"""The folder a report stands in: written beside its place and moved there when it is whole, so that a partial one is
never taken for it; a folder that holds anything else is left alone."""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..running import scratch

MADE_BY = "slip-to-roll report"
_MANIFEST, _PAGE = "manifest.json", "index.html"


def rehearse(out: Path) -> None:
    """Do with an empty file what is done with a report when all the work is over; raises OSError if that cannot be."""
    with suppress(FileExistsError):
        out.parent.mkdir(parents=True)
    for place in (out, out.parent):
        if place.exists():
            scratch.Folder(f".{out.name}.", ".partial", place).remove()
            return


@contextmanager
def written_whole(out: Path) -> Iterator[Path]:
    """A folder to write a report into, which takes the place of `out` when the block ends well.

    It stands beside `out`; where nothing can be made there, among the system's temporary ones.
    """
    out.parent.mkdir(parents=True, exist_ok=True)
    sweep(out)
    try:
        partial = scratch.Folder(f".{out.name}.", ".partial", out.parent)
    except OSError:
        partial = scratch.Folder(f".{out.name}.", ".partial")
    try:
        partial.path.chmod(0o755)  # mkdtemp's folders are private; a report is for reading
        yield partial.path
        _move(partial.path, out)
    finally:
        partial.remove()


def sign(folder: Path, told: dict[str, Any]) -> None:
    """Write the manifest: what is told, and which files are ours."""
    files = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    told = {"made_by": MADE_BY, **told, "files": [*files, _MANIFEST]}
    text = json.dumps(told, indent=1, ensure_ascii=False) + "\n"
    (folder / _MANIFEST).write_text(text, encoding="utf-8", errors="backslashreplace")


def foreign_file(out: Path) -> str:
    """A file in the folder that no report of ours wrote, or ""."""
    files = [p for p in out.rglob("*") if not p.is_dir() or p.is_symlink()] if out.is_dir() else []
    known: set[str] = set()
    try:
        # A pipe of that name would be waited for.
        manifest = json.loads((out / _MANIFEST).read_text(encoding="utf-8")) if (out / _MANIFEST).is_file() else {}
        if manifest.get("made_by") == MADE_BY:
            known = set(manifest["files"])
    except (OSError, ValueError, KeyError, AttributeError, TypeError, RecursionError):
        pass  # no manifest, or not one of ours: everything in the folder is somebody's
    return next((str(p.relative_to(out)) for p in sorted(files) if p.relative_to(out).as_posix() not in known), "")


def sweep(out: Path) -> None:
    """Remove what a build that was killed left beside the report, and among the system's temporary folders."""
    name = re.compile(rf"\.{re.escape(out.name)}\.\w+\.partial")
    for place in (out.parent, out, Path(tempfile.gettempdir())):
        with suppress(OSError):
            scratch.sweep(path for path in place.iterdir() if name.fullmatch(path.name))


def _move(partial: Path, out: Path) -> None:
    """Put the whole report in its place; an older one is kept aside until it stands. Where nothing can be renamed (a
    mount point, another file system) it is copied."""
    foreign = foreign_file(out)
    if foreign:
        raise OSError(f"{out} has come to hold {foreign} meanwhile, which is no part of a report")
    try:
        if out.exists():
            _replace(partial, out)
        else:
            partial.rename(out)
    except OSError:
        _copy(partial, out)


def _replace(partial: Path, out: Path) -> None:
    aside = Path(tempfile.mkdtemp(prefix=f".{out.name}.", suffix=".old", dir=out.parent))
    try:
        out.rename(aside / "report")
        try:
            partial.rename(out)
        except OSError:
            (aside / "report").rename(out)
            raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _copy(partial: Path, out: Path) -> None:
    """File by file, the page last: while it is missing nobody takes the folder for a report, and the manifest says that
    all that is there is ours."""
    out.mkdir(exist_ok=True)
    new = [path.relative_to(partial) for path in sorted(partial.rglob("*")) if path.is_file()]
    old = [path.relative_to(out) for path in sorted(out.rglob("*")) if path.is_file()]
    all_of_them = sorted({path.as_posix() for path in (*new, *old)} | {_MANIFEST})
    (out / _PAGE).unlink(missing_ok=True)
    (out / _MANIFEST).write_text(json.dumps({"made_by": MADE_BY, "files": all_of_them, "unfinished": True}))
    for path in old:
        if path.as_posix() != _MANIFEST:
            (out / path).unlink(missing_ok=True)
    for path in sorted(new, key=lambda path: path.as_posix() == _PAGE):
        if path.as_posix() != _MANIFEST:
            (out / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(partial / path, out / path)
    shutil.copyfile(partial / _MANIFEST, out / _MANIFEST)
    for place in sorted((path for path in out.rglob("*") if path.is_dir()), reverse=True):
        with suppress(OSError):  # it holds something
            place.rmdir()
