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
# The data of a path in a drawing. No entity is read: path data are numbers and letters of commands.
_PATH_ELEMENT = re.compile(r"<path\b[^>]*?\sd=[\"']([^\"'<&]*)[\"']")
_TRANSFORM = re.compile(r"\stransform\s*=")
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
    """Points (n, 2) from a file: two columns x, y with commas or spaces, with or without a heading; an airfoil in
    Selig's order (from the trailing edge over the upper side) or in Lednicer's (numbers of points of both sides, then
    each from the leading edge), which is put into Selig's; the only path of a drawing NAME.svg.

    A relative path counts from the case file that names it, else from the working folder.
    Raises UnknownName for a file that is not there, BadValue, with the line, for one that holds something else.
    """
    what = "file of points"
    path = user_files.existing(what, Path(_folder.get(), user_files.place(what, path)))
    text = user_files.text(what, path, LARGEST_FILE)
    if path.suffix.lower() == ".svg":
        return along_path(_path_of(path, text))
    rows = _rows(path, text)
    upper, lower = (round(count) for count in (rows[0] if len(rows) else (0, 0)))
    if upper > 1 < lower and len(rows) == 1 + upper + lower and (rows[0] == (upper, lower)).all():
        return np.vstack([rows[upper:0:-1], rows[upper + 2 :]])  # both sides begin with the leading edge
    return rows


def _rows(path: Path, text: str) -> np.ndarray:
    """The numbers of two columns, shape (n, 2). Lines of words may come first, and of comments and blanks anywhere."""
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        has_commas = "," in line
        cells = [cell.strip().strip('"') for cell in (line.split(",") if has_commas else line.split())]
        if not cells or line.lstrip().startswith("#"):
            continue
        try:
            x, y = map(float, cells)
        except ValueError:
            names = [_HEADING.match(cell) for cell in cells]  # of an airfoil's title only one word needs to be one
            if not rows and (all(names) if has_commas else any(names)):
                continue
            raise BadValue(f"{path}:{number} is {line.strip()!r}; give two numbers x,y in metres") from None
        rows.append((x, y))
    return np.array(rows, dtype=float).reshape(-1, 2)


def _path_of(path: Path, text: str) -> str:
    """The path data of the only path of a drawing. Raises BadValue for other drawings, and for one that is
    transformed."""
    found = _PATH_ELEMENT.findall(text)
    if not found:
        raise BadValue(f'{path} has no path element with data in d="…"; draw the curve as a path')
    if len(found) > 1:
        raise BadValue(f"{path} has {len(found)} paths; leave one of them in the drawing")
    if _TRANSFORM.search(text):
        raise BadValue(f"{path} has a transform attribute; apply it to the path's coordinates in the drawing program")
    return str(found[0])


def along_path(text: str) -> np.ndarray:
    """Points along SVG path data, in the drawing's units, with y upwards; shape (n, 2).

    Ends of all commands are points, and places between them.
    """
    try:
        from svg.path import parse_path
    except ImportError:
        raise NotSupported("SVG path data need svg.path; type: pip install svg.path") from None
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
