"""The verdict in words: its sentence, and its table for the terminal and the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from textwrap import wrap
from typing import Any

from ..judging.grades import percent
from .verdict import is_engine, name

LEAD = "Off (100 %: as bad as ignoring friction's law), medians over the"
# Widest table of the terminal, in characters: that of a terminal that was not resized.
WIDTH = 80


def sentence(table: Sequence[Mapping[str, Any]], pair_rows: Sequence[Mapping[str, Any]] = ()) -> str:
    """The errors of the engines by themselves on their common cases, and how many each answers."""
    own = [row for row in table if is_engine(row)]
    if not any(row["answered"] for row in own):
        return "No engine is compared: none answers a case that depends on friction's law."
    errors = [row for row in own if row["answered"]]
    many = errors[0]["common_cases"]
    if many:
        texts = "; ".join(
            f"{name(row)} {off_text(row['common_default_off'])} by default, {off_text(row['common_finest_off'])} "
            "at the finest setting run"
            for row in errors
        )
        which = f"{len(errors)} engines" if len(errors) > 1 else "engine"
        start = (
            f"{LEAD} {many} case{'s' * (many != 1)} that the {which} shown answer{'s' * (len(errors) == 1)}: {texts}."
        )
    else:
        start = "No case is answered by all engines shown."
    answers = ", ".join(f"{name(row)} answers {row['answered']}" for row in own)
    nearer = [
        f" Of two, {row['solver']} is nearer in {row['nearer']}, {row['other_solver']} in {row['other_nearer']}, and "
        f"{row['undecided']} are not decided."
        for row in pair_rows
        if len(own) == 2 and row["common_cases"]
    ]
    return f"{start}{''.join(nearer)} Of all {own[0]['friction_cases']}, {answers}."


def cells(row: Mapping[str, Any]) -> dict[str, str]:
    """The row for readers, by heading."""
    factor = row["worst_friction_factor"]
    return {
        "answers": f"{row['answered']} of {row['friction_cases']}",
        "default": off_text(row["common_default_off"]),
        "finest": off_text(row["common_finest_off"]),
        "≤ 1 %": confirmed(row, "good"),
        "friction ×": f"{float(f'{factor:.2g}'):g}" if isfinite(factor) else "–",
    }


def confirmed(row: Mapping[str, Any], level: str) -> str:
    """The cases within a level that finer settings confirm, and those that only the finest setting reaches."""
    lucky = row[f"{level}_one_setting"]
    return f"{row[f'{level}_cases'] - lucky} + {lucky}"


def off_text(off: float) -> str:
    """An error in percent, or a dash if there is none."""
    return percent(off).replace("less than ", "< ") if isfinite(off) else "–"


def in_terminal(table: Sequence[Mapping[str, Any]]) -> str:
    """The table for the terminal, at most `WIDTH` wide: engines, then routes that are partly this project's."""
    from tabulate import tabulate

    lines = [cells(row) for row in table]

    def text(names: Sequence[str], is_dense: bool) -> str:
        pairs = [{"engine": one} | dict(line) for one, line in zip(names, lines, strict=True)]
        options: dict[str, Any] = dict(tablefmt="plain", disable_numparse=True, stralign="right")
        if is_dense:  # tabulate pads columns with a heading by two more spaces
            return tabulate([list(pairs[0]), *(list(pair.values()) for pair in pairs)], **options)
        return tabulate(pairs, headers="keys", **options)

    def excess(text: str) -> int:
        return max(map(len, text.splitlines()), default=0) - WIDTH

    names = [name(row) for row in table]
    if excess(text(names, False)) <= 0:
        return text(names, False)
    # The engines' names are the only cells without a bound.
    longest = max(map(len, names)) - max(0, excess(text(names, True)))
    return text([_shorten(one, longest) for one in names], True)


def _shorten(words: str, longest: int) -> str:
    return words if len(words) <= longest else f"{words[: longest - 1]}…"


def legend(table: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the columns of `in_terminal` mean, in lines of at most `WIDTH` characters."""
    ours = [name(row) for row in table if row["our_part"]]
    return filled(
        "default, finest: error with default settings (the median one of usual values) and at the finest setting run, "
        "100 % = as bad as ignoring friction's law; medians over the cases that all engines answer.",
        "≤ 1 %: cases that stay within 1 %, confirmed by two settings + by the finest setting only, perhaps by luck. "
        "friction ×: friction compared with the law's, in the worst case.",
        *([f"Not compared, because this project computes the contact: {', '.join(ours)}."] if ours else []),
    )


def filled(*texts: str) -> list[str]:
    """The texts in lines of at most `WIDTH`; a number and its percent sign stay together."""
    joined = [text.replace(" %", "\N{NO-BREAK SPACE}%") for text in texts]
    return [
        line.replace("\N{NO-BREAK SPACE}", " ") for text in joined for line in wrap(text, WIDTH, break_on_hyphens=False)
    ]
