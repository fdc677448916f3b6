"""The page of an engine's history: a sentence per release that changed an answer, and a line per scene."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup

from ..analysis.version_history import HistoryLine
from ..running.records import Row
from .fragments import environment

_STYLE = Path(__file__).parent / "static" / "page.css"


class Column(NamedTuple):
    """Consecutive versions between which no answer of the engine changed."""

    first: str
    last: str

    @property
    def name(self) -> str:
        """The versions as text."""
        return self.first if self.first == self.last else f"{self.first} to {self.last}"


def columns(lines: Sequence[HistoryLine]) -> list[Column]:
    """The columns of one engine's table, oldest versions first."""
    result: list[Column] = []
    for version in lines[0].answers if lines else ():
        if result and not any(line.changes.get(version) == "changed" for line in lines):
            result[-1] = Column(result[-1].first, version)
        else:
            result.append(Column(version, version))
    return result


def render(lines: Sequence[HistoryLine], releases: Sequence[Row], manifest: dict[str, Any]) -> str:
    """The page as HTML."""
    engines = []
    for engine, group in groupby(lines, key=lambda line: line.engine):
        own = list(group)
        cells = columns(own)
        rows = [
            {
                "line": line,
                "cells": [
                    {"text": line.answers[c.first].text, "changed": line.changes[c.first] == "changed"}
                    for c in cells
                    if c.first in line.answers
                ],
            }
            for line in own
        ]
        of_engine = [row for row in releases if row["engine"] == engine]
        engines.append({"name": engine, "columns": cells, "rows": rows, "releases": of_engine})
    template = environment().get_template("history.html")
    style = Markup(_STYLE.read_text(encoding="utf-8"))
    return template.render(engines=engines, manifest=manifest, style=style)
