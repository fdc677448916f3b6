"""A table of poses from comma-separated text: every cell is checked before it counts as a number.

Columns: t, x, y, theta of the plate (s, m, rad; the centre of mass), in any order and among others; optional vx, vy,
omega (m/s, rad/s), slip (m/s), normal_force and friction_force (N), and `creep` (m/s), the speed with which the
solver's contacts creep while they stick; a line `# creep = 5e-3` before the columns declares it as well. Of several
plates each has its columns: those of a further plate called upper are `x of upper`, `y of upper`, `theta of upper` and,
optionally, its rates.
"""

from __future__ import annotations

import re
from io import StringIO
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cases import BadValue
from cases.files import user_files
from cases.scene.contact_names import FIRST

if TYPE_CHECKING:
    import pandas as pd

REQUIRED_COLUMNS = ("t", "x", "y", "theta")
OPTIONAL_COLUMNS = ("vx", "vy", "omega", "slip", "normal_force", "friction_force")
# Those of them that have no value at some times.
OPEN_COLUMNS = ("slip", "normal_force", "friction_force")
# What the comments before the columns may declare: the creep (m/s), and the share of a gap or an overlap, from the
# plate, at which the engine's friction acts.
CREEP, LEVER = "creep", "lever"
# The columns of a further plate, as `of_plate` names them.
_FURTHER = re.compile("(x|y|theta|vx|vy|omega) of [A-Za-z0-9_-]{1,30}")

# Largest size of a file in bytes, and most samples: each sample is processed by itself, in a tenth of a millisecond.
LARGEST_FILE, MOST_SAMPLES = 100 * 2**20, 200_000
# Squares of the values read, and of their slopes, have to be finite doubles.
LARGEST = 1e100
# Samples that a slope of second order needs. (The built-in adapters need no more.)
LEAST_SAMPLES = 3


def read(path: str | Path) -> pd.DataFrame:
    """Read the columns of a file as finite floats with increasing times. Raises CaseError, in one sentence."""
    path = user_files.existing("file", path)
    return parse(user_files.text("file", path, LARGEST_FILE), path.name)


def parse(text: str, file: str) -> pd.DataFrame:
    """Read the columns of a text; lines that begin with # are comments, and may declare creep and lever.

    `file` is the name that messages give. Raises BadValue, in one sentence.
    """
    comments = list(takewhile(lambda line: line.startswith("#"), text.splitlines()))
    table = _cells(text, file)
    first_line = len(comments) + 2  # of the file, that has the table's first row
    duplicates = table.duplicated().to_numpy()
    if duplicates.any():
        line = np.argmax(duplicates) + first_line
        raise BadValue(f"line {line} of {file} repeats an earlier line; remove duplicates")
    known = (*REQUIRED_COLUMNS, *OPTIONAL_COLUMNS, CREEP, *filter(_FURTHER.fullmatch, table.columns))
    table = table[[name for name in known if name in table]]
    table = table.assign(**_declarations(comments))
    for name in table:
        table = table.assign(**{str(name): _numbers(table[name], str(name), file, first_line)})
    backwards = np.flatnonzero(np.diff(table["t"]) <= 0.0)
    if len(backwards):
        line = backwards[0] + 1 + first_line
        raise BadValue(f"the time in line {line} of {file} does not increase; sort the lines by t")
    if len(table) < LEAST_SAMPLES:
        raise BadValue(f"{file} has {len(table)} samples, too few for a slope; give at least {LEAST_SAMPLES}")
    return table


def columns_of(table: pd.DataFrame) -> dict[str, np.ndarray]:
    """The table's columns by name."""
    return {str(name): table[name].to_numpy() for name in table}


def of_plate(column: str, plate: str) -> str:
    """The name of a plate's column: that of the case's plate is the column's own."""
    return column if plate == FIRST else f"{column} of {plate}"


def _cells(text: str, file: str) -> pd.DataFrame:
    """The table as text under the names of its first line. Raises BadValue for a table that lacks a column or is too
    long."""
    import pandas as pd  # the import takes half a second, and most callers read no file

    try:
        # Read every cell as text; the code below decides what is a number, not pandas.
        table = pd.read_csv(StringIO(text), skipinitialspace=True, comment="#", header=None, dtype=str, index_col=False)
    except (ValueError, OverflowError, RecursionError) as problem:
        raise BadValue(f"{file} cannot be read as comma-separated values: {problem}") from problem
    names = ["" if pd.isna(cell) else str(cell).strip() for cell in table.iloc[0]]
    _check_names(file, names)
    table = table.iloc[1:].reset_index(drop=True)
    if len(table) > MOST_SAMPLES:
        raise BadValue(f"{file} has {len(table)} samples; give at most {MOST_SAMPLES}")
    return table.set_axis(names, axis="columns")


_UNITS = "(ms|us|min|h|mm|cm|km|deg|in|ft)"


def _check_names(file: str, names: list[str]) -> None:
    """Raise BadValue for a first line that does not define what each column holds."""
    # pandas writes a column without a name that it has read as "Unnamed: 0".
    nameless = [not name or name.startswith("Unnamed:") for name in names]
    if any(nameless):
        number = nameless.index(True) + 1
        raise BadValue(f"column {number} of {file} has no name (an index?); name it or leave it out")
    for name in (*REQUIRED_COLUMNS, *OPTIONAL_COLUMNS, *filter(_FURTHER.fullmatch, names)):
        if names.count(name) > 1:
            raise BadValue(f"{file} has {names.count(name)} columns {name}; keep one")
    for name in (*REQUIRED_COLUMNS, *OPTIONAL_COLUMNS):
        # t_ms, x [mm], time (min): a unit next to a column's name shows that it is not in metres or seconds.
        other = [column for column in names if re.fullmatch(rf"{name}[\s_(\[/]+{_UNITS}.*", column)]
        if other and name not in names:
            raise BadValue(f"{file} has a column {other[0]!r}; give {name} in SI units and radians, and call it {name}")
    missing = [name for name in REQUIRED_COLUMNS if name not in names]
    if missing:
        first = ",".join(names)
        raise BadValue(
            f"{file} has no column {', '.join(missing)}: its first line is {first[:60]!r}, and has to name "
            "t, x, y, theta, separated by commas"
        )


# A comment that declares a number, such as `# creep = 5e-3`, `# creep: 0.005 m/s` or `# lever = 0.5`.
_DECLARATION = re.compile(rf"#\s*({CREEP}|{LEVER})\s*[=:]\s*(\S+)(\s*m/s)?\s*", re.IGNORECASE)


def _declarations(comments: list[str]) -> dict[str, str]:
    """The numbers that the comments before the columns declare, as text by name."""
    return {match[1].lower(): match[2] for line in comments if (match := _DECLARATION.fullmatch(line))}


def _numbers(cells: pd.Series, name: str, file: str, first_line: int) -> pd.Series:
    """The cells of a column as floats; NaN where those of `OPEN_COLUMNS` are empty. Raises BadValue for what is no
    number."""
    import pandas as pd

    numbers = pd.to_numeric(cells, errors="coerce")
    # In flight there is no slip, and where it is open which forces act there are none: `Trajectory.to_csv` writes an
    # empty cell.
    empty = cells.isna() if name in OPEN_COLUMNS else np.zeros(len(cells), dtype=bool)
    bad = np.flatnonzero(~np.isfinite(numbers) & ~empty)
    if len(bad):
        raise BadValue(f"{name} in line {bad[0] + first_line} of {file} is not a finite number")
    large = np.flatnonzero(np.abs(numbers) > LARGEST)
    if len(large):
        line = large[0] + first_line
        raise BadValue(f"{name} in line {line} of {file} is too large; give numbers up to {LARGEST:g}")
    # Convert the text: before pandas 3 `to_numeric` is off by a unit in the last place.
    return cells.where(np.isfinite(numbers)).astype(float)
