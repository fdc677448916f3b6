"""The history of engines as Markdown: what each release changed, and a line per case and route with a change."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any

TITLES = {"box2d": "Box2D (pyb2d3)", "exudyn": "Exudyn", "pymunk": "pymunk"}
# Why a release changed answers, as far as it was looked up.
CAUSES = {
    ("exudyn", "1.9.0"): "The route `integrator` no longer stops in `disc_in_ellipse`, and is 5 and 200 times more "
    "accurate in `disc_in_catenary` and `driven_disc`. The cause in the engine was not looked for.",
    ("exudyn", "1.10.0"): "This release has the contact objects of a sphere with a sphere and with a triangle, which "
    "the route `native` is made of. Before it, that route runs on no scene that needs them.",
}
_WIDTH = 125
_SMALL = re.compile(r"\b0\.0000\d+ %")


def render(lines: Sequence[Mapping[str, Any]], releases: Sequence[Mapping[str, Any]], origin: str, command: str) -> str:
    """The page from the rows of the tables `history_lines` and `history_releases`, which may be text; `origin`: when
    and where the runs were made."""
    engines = list(dict.fromkeys(row["engine"] for row in releases))
    names = [TITLES.get(engine, engine) for engine in engines]
    subject = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
    scenes = len({row["case"] for row in lines})
    intro = (
        f"Which release of {subject} changed an answer: {scenes} scenes, with default settings and with one fine "
        "setting, on each route, with the same adapter. Numbers are the error (off) in percent of the error of "
        "ignoring friction's law. A release changed an answer if the outcome or the sequence of transitions is another "
        "one, or if off differs by more than one percent of it."
    )
    note = (
        f"makes this page and the tables. The runs are of {origin}. With `--from-source`, versions "
        "without a wheel for this Python are compiled. The tables: [every line](engine_history/history_lines.csv), "
        "[every release](engine_history/history_releases.csv)."
    )
    parts = ["# Engines over their versions", _fold(intro), f"```sh\n{command}\n```", _fold(note)]
    for engine in engines:
        of_engine = [row for row in releases if row["engine"] == engine]
        parts += _engine(engine, [row for row in lines if row["engine"] == engine], of_engine)
    return "\n\n".join(parts) + "\n"


def _engine(engine: str, lines: Sequence[Mapping[str, Any]], releases: Sequence[Mapping[str, Any]]) -> list[str]:
    """The parts of one engine's section."""
    ran, lost = ([row for row in releases if bool(row["note"]) is missing] for missing in (False, True))
    changes = [row for row in ran if int(row["changed"])]
    text = f"{len(ran)} versions were run: {', '.join(row['version'] for row in ran) or 'none'}."
    for note in dict.fromkeys(_reason(row["note"]) for row in lost):
        text += f" Not run: {', '.join(row['version'] for row in lost if _reason(row['note']) == note)} ({note})."
    if not changes:
        digits = sum(int(row["digits"]) for row in ran)
        text += " No release changed an answer." if digits else " No release changed a single digit of an answer."
    parts = [f"## {TITLES.get(engine, engine)}", _fold(text)]
    if not changes:
        return parts
    cells: dict[tuple[str, str], dict[str, str]] = {}
    changed = {(row["case"], row["route"]) for row in lines if row["changes"]}
    for row in (row for row in lines if (row["case"], row["route"]) in changed):
        kind = "default" if "rung=defaults" in row["setting"] else "fine"
        text = row["oldest"] + (f"; **{row['changes']}**" if row["changes"] else "")
        cells.setdefault((row["case"], row["route"]), {})[kind] = _SMALL.sub("under 0.0001 %", text)
    table = ["| case | route | default settings | fine setting |", "| --- | --- | --- | --- |"]
    table += [f"| `{c}` | {r} | {each.get('default', '')} | {each.get('fine', '')} |" for (c, r), each in cells.items()]
    return [*parts, "\n".join(_change(engine, row) for row in changes), "\n".join(table)]


def _change(engine: str, row: Mapping[str, Any]) -> str:
    text = f"- **{row['version']}**: {row['changed']} answers changed, {row['better']} better, {row['worse']} worse"
    text += f"; {row['digits']} more changed in digits." if int(row["digits"]) else "."
    return _fold(f"{text} {CAUSES.get((engine, row['version']), 'The cause was not looked for.')}", "  ")


def _reason(note: str) -> str:
    """The reason without the version: versions with the same reason share a sentence."""
    return "no wheel for this Python" if note.startswith("the package index has no") else note


def _fold(text: str, indent: str = "") -> str:
    return fill(text, _WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
