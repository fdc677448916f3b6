"""The folder of a sweep: its identity, and a Parquet file for each completed part."""

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
from cases.files.owned_folder import OwnedFolder

RECORD = "sweep.json"
_PART = re.compile(r"part-(\d{12})\.parquet")


class Folder(OwnedFolder):
    """A folder with the rows of a sweep."""

    def __init__(self, path: Path, fresh: bool = False):
        """`fresh`: existing rows will be deleted."""
        claims = (RECORD, "*/part-*.parquet", "map*.svg", "map*.png", "boundary.parquet")
        super().__init__(path, "sweep", claims, unread="" if fresh else claims[1])
        self.fresh = fresh

    @contextmanager
    def exclusive(self, identity: dict[str, Any]) -> Iterator[None]:
        """A context with exclusive access to the folder, which is new, empty, or holds the sweep of this `identity`.

        Raises BadValue if the folder holds anything else (with `fresh`, any sweep is accepted), if a user's file has
        the name of one of ours, or if another process writes to it.
        """
        with self.write_lock(patience=0.0):
            if self.fresh:
                self.clear()
            other = _first_difference(self.value("asked"), json.loads(json.dumps(identity)))
            if other and not self.is_empty and not self._has_rows:
                self.clear()  # of a sweep that ended before its first part
            elif other and not self.is_empty:
                raise BadValue(
                    f"{self.path} holds another sweep ({other}); give another --out, or --fresh to delete its files"
                )
            self.record({"asked": identity})
            yield

    @property
    def _has_rows(self) -> bool:
        return any(self.path.glob("*/part-*.parquet"))

    def _entries(self) -> dict[str, Any]:
        file = self.path / RECORD
        try:
            record = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
        except (OSError, ValueError, RecursionError):
            return {}
        return record if isinstance(record, dict) else {}

    def value(self, name: str) -> Any:
        """The recorded value of that name; None if there is none."""
        return self._entries().get(name)

    def record(self, entries: dict[str, Any]) -> None:
        """Add entries to the record of the sweep."""
        text = json.dumps(self._entries() | entries, indent=1, ensure_ascii=False)
        self.write(RECORD, (text + "\n").encode())

    def file(self, kind: str, start: int) -> Path:
        """The file of the part whose first scenario is `start`."""
        return self.path / kind / f"part-{start:012d}.parquet"

    def part_starts(self, kind: str) -> set[int]:
        """The first scenarios of the completed parts."""
        if not (self.path / kind).is_dir():
            return set()
        return {int(name[1]) for file in (self.path / kind).iterdir() if (name := _PART.fullmatch(file.name))}

    def add_part(self, kind: str, start: int, content: bytes) -> None:
        """Write a part."""
        self.write(self.file(kind, start).relative_to(self.path).as_posix(), content)

    def rows(self, kind: str, columns: list[str] | None = None) -> Iterator[pa.Table]:
        """The parts in the order of their scenarios, one at a time."""
        for start in sorted(self.part_starts(kind)):
            file = self.file(kind, start)
            try:
                part = parquet.read_table(file, columns=columns) if file.is_file() else pa.table({})
                lacks = {*(columns or ())} - {*part.column_names}
                problem_text = (
                    f"it has no column {min(lacks)}" if lacks else "" if part.num_columns else "it has no columns"
                )
            except (pa.ArrowException, OSError) as problem:
                problem_text = str(problem).partition("\n")[0]
            if problem_text:
                raise BadValue(
                    f"{file} is not a part of a sweep ({problem_text}); delete it and run the same command again"
                )
            yield part


def _first_difference(there: Any, identity: dict[str, Any]) -> str:
    """The first thing in which two sweeps differ; "" if they are the same."""
    if not isinstance(there, dict):
        return f"{RECORD} does not identify it"
    for name in identity:
        if there.get(name) != identity[name]:
            return f"{name} {_short(there.get(name))}, not {_short(identity[name])}"
    return ""


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}…"
