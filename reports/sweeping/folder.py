"""The folder of a sweep: what was asked, and one Parquet file a part, each put there whole. What is there is done."""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from cases import BadValue

MADE_BY = "slip-to-roll sweep"
TOLD = "sweep.json"
_PART = re.compile(r"part-(\d{12})\.parquet")


@dataclass(frozen=True)
class Folder:
    """Where a sweep's rows are kept."""

    path: Path

    @classmethod
    def opened(cls, path: Path, asked: dict[str, Any], fresh: bool) -> Folder:
        """A folder that is new, empty, or holds the same sweep, or any sweep if it is made `fresh`.

        Raises BadValue for one with anything else in it."""
        folder = cls(path)
        if path.exists() and not path.is_dir():
            raise BadValue(f"--out is {path}, which is a file; give a folder")
        there = folder._told()
        if there is None and path.is_dir() and any(path.iterdir()):
            raise BadValue(f"--out is {path}, which holds something else; give another folder")
        if there is not None and fresh:
            shutil.rmtree(path)
            there = None
        if there is not None:
            other = _different(there.get("asked", {}), json.loads(json.dumps(asked)))
            if other:
                raise BadValue(
                    f"{path} holds another sweep ({other}); give another --out, or --fresh to forget that one"
                )
        else:
            path.mkdir(parents=True, exist_ok=True)
            folder.tell({"asked": asked})
        return folder

    def _told(self) -> dict[str, Any] | None:
        file = self.path / TOLD
        try:
            told = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else None
        except (OSError, ValueError, RecursionError):
            return None
        ours = isinstance(told, dict) and told.get("made_by") == MADE_BY and isinstance(told.get("asked", {}), dict)
        return told if ours else None

    def told(self, name: str) -> Any:
        """What was noted under that name; None if nothing was."""
        return (self._told() or {}).get(name)

    def tell(self, told: dict[str, Any]) -> None:
        """Note more of it."""
        text = json.dumps({"made_by": MADE_BY, **(self._told() or {}), **told}, indent=1, ensure_ascii=False)
        self._write(self.path / TOLD, (text + "\n").encode())

    def _write(self, file: Path, content: bytes) -> None:
        """At once and whole, or not at all."""
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=file.parent, prefix=".", suffix=".partial")
        try:
            with open(handle, "wb") as stream:
                stream.write(content)
            os.chmod(name, 0o644)
            os.replace(name, file)
        except BaseException:
            os.unlink(name)
            raise

    def file(self, kind: str, start: int) -> Path:
        """The file of the part that begins with that scenario."""
        return self.path / kind / f"part-{start:012d}.parquet"

    def done(self, kind: str) -> set[int]:
        """The first scenarios of the parts that are there."""
        if not (self.path / kind).is_dir():
            return set()
        return {int(name[1]) for file in (self.path / kind).iterdir() if (name := _PART.fullmatch(file.name))}

    def put(self, kind: str, start: int, content: bytes) -> None:
        """Keep a part."""
        self._write(self.file(kind, start), content)

    def keep(self, name: str, content: bytes) -> None:
        """Keep a file of that name."""
        self._write(self.path / name, content)

    def rows(self, kind: str, columns: list[str] | None = None) -> Iterator[pa.Table]:
        """The parts in the order of their scenarios, one at a time."""
        for start in sorted(self.done(kind)):
            file = self.file(kind, start)
            try:
                part = parquet.read_table(file, columns=columns) if file.is_file() else pa.table({})
                lacks = {*(columns or ())} - {*part.column_names}
                said = f"it has no column {min(lacks)}" if lacks else "" if part.num_columns else "it has no columns"
            except (pa.ArrowException, OSError) as problem:
                said = str(problem).partition("\n")[0]
            if said:
                raise BadValue(f"{file} is no part of a sweep ({said}); delete it, and give the same command")
            yield part


def _different(there: dict[str, Any], asked: dict[str, Any]) -> str:
    """The first thing in which two sweeps differ; "" if they are the same."""
    for name in asked:
        if there.get(name) != asked[name]:
            return f"{name} {_short(there.get(name))}, not {_short(asked[name])}"
    return ""


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}…"
