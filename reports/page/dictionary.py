"""The data dictionary of all tables: `columns.md` for readers, `datapackage.json` for programs (a Data Package:
https://datapackage.org/standard/data-package/, each table a resource with its schema)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.columns import Table, unit_of

if TYPE_CHECKING:
    import pandas as pd

NAMES = ("columns.md", "datapackage.json")


def write(tables: Mapping[str, pd.DataFrame], words: Mapping[str, Table], folder: Path, command: str) -> list[Path]:
    """Write both files for all tables to a folder; returns them. Raises ValueError for a column without description."""
    for name, frame in tables.items():
        missing = [c for c in frame.columns if not words[name].columns.get(str(c))]
        if missing:
            raise ValueError(f"no description of {', '.join(map(str, missing))} in the table {name}")
    files = [folder / name for name in NAMES]
    files[0].write_text(_for_people(tables, words, command), encoding="utf-8")
    package = {"name": "slip-to-roll-tables", "resources": [_resource(n, f, words[n]) for n, f in tables.items()]}
    files[1].write_text(json.dumps(package, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return files


def _for_people(tables: Mapping[str, pd.DataFrame], words: Mapping[str, Table], command: str) -> str:
    parts = ["# What the columns mean\n\nEmpty: not measured or not applicable.\n"]
    for name, frame in tables.items():
        rows = "".join(f"- `{c}`: {words[name].columns[str(c)]}\n" for c in frame.columns)
        parts.append(f"## {name}.csv\n\n{words[name].holds}.\n\n{rows}")
    return "\n".join(parts) + f"\nMake it again: `{command}`\n"


def _resource(name: str, frame: pd.DataFrame, words: Table) -> dict[str, Any]:
    fields = []
    for column in map(str, frame.columns):
        field = {"name": column, "type": kind(frame[column]), "description": words.columns[column]}
        # The standard has no property for units, but allows additional properties.
        fields.append(field | ({"unit": unit_of(column)} if unit_of(column) else {}))
    return {
        "name": name,
        "path": f"{name}.csv",
        "format": "csv",
        "mediatype": "text/csv",
        "encoding": "utf-8",
        "description": words.holds,
        "schema": {"fields": fields, "missingValues": [""]},
    }


def kind(values: pd.Series) -> str:
    """The type of a column by the standard's names: boolean, integer, number or string."""
    if not len(values):
        return "string"
    if all(isinstance(v, bool | np.bool_) for v in values):
        return "boolean"
    if all(isinstance(v, int | np.integer) for v in values):
        return "integer"
    return "number" if all(isinstance(v, int | float | np.number) for v in values) else "string"
