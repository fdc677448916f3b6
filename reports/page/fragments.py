"""Elements of the page: templates, figures, compress files, short numbers, and the command that reproduces them."""

from __future__ import annotations

import re
import zlib
from base64 import b85encode
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ..drawing import svg_writer
from ..drawing.colours import LineStyles
from ..drawing.figure_files import short_digest
from ..drawing.traces import Diagram
from ..running.names import REFERENCE

if TYPE_CHECKING:
    import pandas as pd

_TEMPLATES = Path(__file__).parent / "templates"
_POWER, _ZERO = re.compile(r"(\d)e([+-])0(\d)\b"), re.compile(r"\b0\.0e\+00\b")


@lru_cache(maxsize=1)
def environment() -> Environment:
    """The templates of the page; all text is escaped, and an undefined name is an error."""
    result = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    # A number stays on one line with its percent sign.
    result.filters["joined"] = lambda text: text.replace(" %", "\N{NO-BREAK SPACE}%")
    return result


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a frame as dictionaries with text keys."""
    return [{str(column): value for column, value in row.items()} for row in frame.to_dict("records")]


def compress(data: bytes) -> str:
    """Bytes as text of compressed data: base 85, a fifteenth shorter than base 64. A comma stands for its "<", so that
    no text can close or open an element."""
    return b85encode(zlib.compress(data, 9)).decode().replace("<", ",")


def command_of(label: str, manifest: dict[str, Any]) -> str:
    """The command that reproduces one case's figures and tables; with an empty label, those of all cases."""
    if not label:
        return manifest["command"]
    return f'slip-to-roll report {manifest["options"]} --case "{label}"'.replace("  ", " ")


def anchor(label: str) -> str:
    """The HTML anchor of a case on the page; with a digest of the label where characters of it are replaced, so that no
    two cases have the same."""
    readable = "".join(c if c.isalnum() or c == "_" else "-" for c in label)
    return f"case-{readable}" if readable == label else f"case-{readable.strip('-')}-{short_digest(label)}"


def figure_of(diagram: Diagram | None, looks: LineStyles, height: float = 210.0) -> dict[str, Any] | None:
    """Data of a figure for its template; None for none."""
    if diagram is None:
        return None
    words = {"title": diagram.title, "caption": diagram.caption}
    return words | {"svg": svg_writer.svg(diagram, looks, height)}


def verbatim(text: str) -> str:
    """A number's text in its short form: 1.1e-7 and 0, not 1.1e-07 and 0.0e+00."""
    return _POWER.sub(lambda m: f"{m[1]}e{m[2].removeprefix('+')}{m[3]}", _ZERO.sub("0", text))


def short_percent(off: float) -> str:
    """Off in percent with few characters and without the sign: 278, 31, 2.1, .27, <.01."""
    share = 100.0 * off
    if share < 0.005:
        return "<.01"
    if share >= 9.95:
        return f"{share:,.0f}"
    return f"{share:.1f}" if share >= 0.995 else f"{share:.2f}".removeprefix("0")


def switch(solver: str, route: str) -> str:
    """The route if the page has a switch for it, otherwise ""; the reference's methods have none."""
    return "" if solver == REFERENCE else route
