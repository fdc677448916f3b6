"""Tables of a paper: six columns as a LaTeX longtable with caption, label and numbers in `\\num`."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from ..analysis.columns import unit_of

if TYPE_CHECKING:
    import pandas as pd

# A page is wide enough for six columns.
MOST_COLUMNS = 6
# The columns of the tables that a paper shows most; of any other table the first six that are short and vary.
COLUMNS = {
    "verdict": ("solver", "route", "default_off", "finest_off", "good_cases", "worst_friction_factor"),
    "headline": ("case", "solver", "route", "default_off", "finest_off", "finest_first_error"),
    "trajectories": ("case", "solver", "route", "setting", "off", "grade"),
    "transitions": ("case", "solver", "route", "event", "time", "error"),
    "truth": ("case", "event", "before", "after", "time", "truth_error_bar"),
}
# Longest text of a column that is chosen by itself, in characters.
_SHORT = 24
_ESCAPES = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    **{character: f"\\{character}" for character in "&%$#_"},
    "μ": r"\ensuremath{\mu}", "ξ": r"\ensuremath{\xi}", "θ": r"\ensuremath{\theta}", "λ": r"\ensuremath{\lambda}",
    "×": r"\ensuremath{\times}", "≤": r"\ensuremath{\le}", "−": r"\ensuremath{-}", "→": r"\ensuremath{\to}",
    "°": r"\ensuremath{^\circ}", "²": r"\ensuremath{^2}", "₀": r"\ensuremath{_0}", "₁": r"\ensuremath{_1}",
    "₂": r"\ensuremath{_2}", "‖": r"\ensuremath{\|}", "√": r"\ensuremath{\surd}", "–": "--", "…": r"\ldots{}",
}  # fmt: skip
_NUMBER = re.compile(r"[-+]?[\d,]*\.?\d+(?:e[-+]?\d+)?")


def table(name: str, frame: pd.DataFrame, caption: str, command: str, shorten: Callable[[object, str], str]) -> str:
    """The table as LaTeX text; `command` reproduces it, `shorten` rounds a value of a column for reading. Needs the
    packages longtable, booktabs and siunitx."""
    columns = chosen_columns(name, frame)
    rows = [[cell(shorten(row[column], column)) for column in columns] for row in frame.to_dict("records")]
    is_number = [all(text.startswith(r"\num{") or not text for text in column) for column in zip(*rows, strict=True)]
    kinds = "".join("r" if number else "l" for number in is_number or [False] * len(columns))
    head = " & ".join(_heading(column) for column in columns) + r" \\"
    return "\n".join(
        [
            "% needs \\usepackage{longtable, booktabs, siunitx}",
            f"% Make it again: {command}",
            rf"\begin{{longtable}}{{{kinds}}}",
            rf"\caption{{{escape(caption)}.}}\label{{tab:{name}}}\\",
            rf"\toprule {head} \midrule \endfirsthead",
            rf"\toprule {head} \midrule \endhead",
            r"\bottomrule \endfoot",
            *(" & ".join(row) + r" \\" for row in rows),
            r"\end{longtable}",
            "",
        ]
    )


def chosen_columns(name: str, frame: pd.DataFrame) -> list[str]:
    """At most six columns of a table: those of `COLUMNS`, else the first that are short and vary."""
    columns = [str(column) for column in frame.columns]
    known = [column for column in COLUMNS.get(name, ()) if column in columns]
    if known:
        return known
    short = [column for column in columns if frame[column].map(lambda value: len(str(value)) <= _SHORT).all()]
    varied = [column for column in short if len(frame) < 2 or frame[column].map(str).nunique() > 1]
    return (varied or short or columns)[:MOST_COLUMNS]


def cell(text: str) -> str:
    """A cell: a number in `\\num`, any other text escaped."""
    return rf"\num{{{text.replace(',', '')}}}" if _NUMBER.fullmatch(text) else escape(text)


def escape(text: str) -> str:
    """Text with the characters that LaTeX would interpret, or that its fonts lack, as commands."""
    return "".join(_ESCAPES.get(character, character) for character in text)


def _heading(column: str) -> str:
    unit = unit_of(column)
    return escape(column.replace("_", " ") + (f" / {unit}" if unit and unit != "1" else ""))
