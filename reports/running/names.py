"""The reference's name among the solvers, and texts of solvers in printable form; imports nothing slow."""

from __future__ import annotations

from cases.errors import printable

REFERENCE = "reference"
# Size limit of a text in characters: the last error message of an engine fits.
_LONGEST_TEXT = 2000


def legible(text: object, most: int = _LONGEST_TEXT) -> str:
    """A solver's text for files and terminals: at most `most` characters, with characters that cannot be printed (a
    lone surrogate, NUL, an escape) spelled out."""
    whole = str(text)
    short = whole if len(whole) <= most else f"{whole[: most - 1]}…"
    return printable(short).replace("\t", r"\t")
