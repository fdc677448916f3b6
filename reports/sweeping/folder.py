"""The folder of a sweep: what was asked, and a Parquet file for each part. A part that is there is done."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from cases import BadValue
from cases.owned_folder import OwnedFolder

TOLD = "sweep.json"
_PART = re.compile(r"part-(\d{12})\.parquet")


class Folder(OwnedFolder):
    """Where a sweep's rows are kept."""

    def __init__(self, path: Path, fresh: bool = False):
        """`fresh`: the rows that are there will be deleted."""
        claims = (TOLD, "*/part-*.parquet", "map*.svg", "map*.png", "boundary.parquet")
        super().__init__(path, "sweep", claims, unread="" if fresh else claims[1])
        self.fresh = fresh

    @contextmanager
    def opened(self, asked: dict[str, Any]) -> Iterator[None]:
        """Inside, the folder is this process's alone: a new or an empty one, or one that holds the same sweep.

        Raises BadValue for a folder that holds anything else (if it is to be `fresh`, any sweep will do), has a file of
        the user's in the place of one of ours, or is written by another process."""
        with self.locked(patience=0.0):
            if self.fresh:
                self.clear()
            other = _different(self.told("asked"), json.loads(json.dumps(asked)))
            if other and not self.is_empty:
                raise BadValue(
                    f"{self.path} holds another sweep ({other}); give another --out, or --fresh to delete its files"
                )
            self.tell({"asked": asked})
            yield

    def _told(self) -> dict[str, Any]:
        file = self.path / TOLD
        try:
            told = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
        except (OSError, ValueError, RecursionError):
            return {}
        return told if isinstance(told, dict) else {}

    def told(self, name: str) -> Any:
        """What was noted under that name; None if nothing was."""
        return self._told().get(name)

    def tell(self, told: dict[str, Any]) -> None:
        """Note more of it."""
        text = json.dumps(self._told() | told, indent=1, ensure_ascii=False)
        self.write(TOLD, (text + "\n").encode())

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
        self.write(self.file(kind, start).relative_to(self.path).as_posix(), content)

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


def _different(there: Any, asked: dict[str, Any]) -> str:
    """The first thing in which two sweeps differ; "" if they are the same."""
    if not isinstance(there, dict):
        return f"{TOLD} does not say which"
    for name in asked:
        if there.get(name) != asked[name]:
            return f"{name} {_short(there.get(name))}, not {_short(asked[name])}"
    return ""


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}…"
