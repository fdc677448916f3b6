"""Points of measured or drawn curves: from an array, a pandas frame, a CSV file or SVG path data."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

import numpy as np

from ..errors import BadValue, NotSupported
from ..files import user_files

# Bytes of a file of points: a hundred thousand of them.
LARGEST_FILE = 4 * 2**20
# The fewest points along SVG path data, and those on each of its curved commands.
FEWEST, EACH = 200, 16

# The folder of the case file that is being read, from which its paths count; outside of one: where one works.
_folder: ContextVar[Path] = ContextVar("_folder", default=Path())

# A heading names its columns; a first row with a typing error has a digit, a sign or nothing where a name begins.
_HEADING = re.compile(r"\s*[^\W\d_]")
# SVG path data begin with a move to a pair of numbers; no file is called like that.
_PATH_DATA = re.compile(r"\s*[Mm]\s*[-+.\d]+[\s,]+[-+.\d]")


@contextmanager
def paths_count_from(folder: Path) -> Iterator[None]:
    """Inside, relative paths of points count from that folder."""
    before = _folder.set(folder)
    try:
        yield
    finally:
        _folder.reset(before)


def as_points(source) -> np.ndarray:
    """Points (n, 2) from an array, a frame with columns x and y, the name of a CSV file, or SVG path data."""
    if isinstance(source, str) and _PATH_DATA.match(source):
        return along_path(source)
    if isinstance(source, str | Path):
        return read(source)
    columns = getattr(source, "columns", None)
    if columns is not None:
        if not {"x", "y"} <= set(columns):
            raise BadValue(f"the frame has the columns {', '.join(map(str, columns))}; give one with columns x and y")
        source = source[["x", "y"]]
    try:
        points = np.array(source, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise BadValue("points are not numbers; give a list of pairs (x, y) in metres") from None
    if points.ndim != 2 or points.shape[1] != 2:
        raise BadValue(f"points have shape {points.shape}; give pairs (x, y), shape (n, 2)")
    return points


def read(path: str | Path) -> np.ndarray:
    """Points from a CSV file of two columns x, y, with or without a heading; shape (n, 2).

    A relative path counts from the case file that names it, else from the working folder.
    Raises UnknownName for a file that is not there, BadValue, with the line, for one that holds something else.
    """
    import csv  # of files alone

    what = "file of points"
    path = user_files.existing(what, Path(_folder.get(), user_files.place(what, path)))
    rows = []
    try:
        lines = list(csv.reader(user_files.text(what, path, LARGEST_FILE).splitlines()))
    except csv.Error as problem:
        raise BadValue(f"{path} is no CSV text ({problem}); give two columns x,y in metres") from None
    data_rows = [(n, row) for n, row in enumerate(lines, start=1) if row and not row[0].lstrip().startswith("#")]
    for number, row in data_rows:
        try:
            x, y = (float(cell) for cell in row)
        except ValueError:
            if number == data_rows[0][0] and all(_HEADING.match(cell) for cell in row):
                continue
            raise BadValue(f"{path}:{number} is {','.join(row)!r}; give two numbers x,y in metres") from None
        rows.append((x, y))
    return np.array(rows, dtype=float).reshape(-1, 2)


def along_path(text: str) -> np.ndarray:
    """Points along SVG path data, in the drawing's units, with y upwards; shape (n, 2).

    Ends of all commands are points, and places between them.
    """
    try:
        from svg.path import parse_path
    except ImportError:
        raise NotSupported('SVG path data need svg.path; type: pip install "slip-to-roll[svg]"') from None
    if len(text) > LARGEST_FILE:
        raise BadValue(f"the path data have {len(text)} letters; give at most {LARGEST_FILE}")
    try:
        commands = [part for part in parse_path(text) if type(part).__name__ != "Move" and part.length() > 0.0]
        parts = max(EACH, FEWEST // max(len(commands), 1))
        places = [part.point(k / parts) for part in commands for k in range(parts)]
        places += [commands[-1].point(1.0)] if commands else []
    except Exception as problem:  # the library raises errors of many kinds
        raise BadValue(f"the SVG path data cannot be read ({problem}); give those of one path's d attribute") from None
    return np.array([(place.real, -place.imag) for place in places]).reshape(-1, 2)
