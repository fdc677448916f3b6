"""Search for boundaries between kinds of motion: a quadtree where the kind changes, then bisection along its edges.

The search starts with the plan's grid. A cell whose corners differ is divided in four, down to cells of 1/256 of the
ranges. Every edge of these cells whose ends differ contains a point of a boundary; all these edges are bisected
together. A motion of a third kind inside an edge gives two boundaries instead of one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
import pyarrow as pa

from cases import BadValue
from reference.sweeping import Plan, table

from . import parts
from .map_figures import kind
from .sweep_folder import Folder

FILE = "boundary.parquet"
# Cells per range at the quadtree's last level.
CELLS = 256
# The integrator's tolerance as a factor of the requested width, and its minimum: decisions at the friction cone must be
# more accurate than the width.
FINER, FINEST = 1e-2, 1e-14
# Scenarios computed together.
TOGETHER = 4000

Place = tuple[int, ...]


class BoundaryPoints(NamedTuple):
    """Points of boundaries, the kinds on both sides, the width of each bracket, and the number of scenarios."""

    x: np.ndarray
    y: np.ndarray
    kinds: tuple[tuple[str, str], ...]
    width: np.ndarray
    scenarios: int

    @property
    def points(self) -> int:
        """Number of points."""
        return len(self.x)


class _Bracket(NamedTuple):
    """Two places (as fractions of the ranges) along one axis, between which the kind changes."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    before: str
    after: str


def check(plan: Plan) -> None:
    """Raise BadValue for a plan whose boundaries cannot be searched."""
    if plan.sample != "grid" or len(plan.axes) > 2:
        raise BadValue("--refine needs a grid of one or two parameters")
    for axis in plan.axes:
        if axis.values or len(axis) < 2:
            raise BadValue(
                f"--refine needs a range to divide; write {axis.name}=low:high:count, with a count of 2 or more"
            )


def search_and_write(plan: Plan, folder: Folder, width: float) -> BoundaryPoints:
    """Search the boundaries to a width in the first parameter (in the second: the same fraction of its range), and
    write them to the folder."""
    edges = find_boundaries(plan, width)
    columns = {plan.axes[0].name: edges.x}
    columns |= {plan.axes[1].name: edges.y} if len(plan.axes) == 2 else {}
    columns |= {"width": edges.width}
    columns |= {
        name: np.array([pair[i] for pair in edges.kinds], dtype=object) for i, name in enumerate(("low", "high"))
    }
    folder.write(FILE, parts.pack(pa.table(columns)))
    return edges


def find_boundaries(plan: Plan, width: float) -> BoundaryPoints:
    """The boundaries of a plan to a width in the first parameter."""
    check(plan)
    search = _Search(replace(plan, rtol=min(plan.rtol, max(FINER * width, FINEST))))
    brackets = search.brackets()
    part = width / (plan.axes[0].high - plan.axes[0].low)
    while True:
        wide = [b for b in brackets if _length(b) > max(part, 4 * np.spacing(1.0))]
        if not wide:
            break
        brackets = [b for b in brackets if _length(b) <= max(part, 4 * np.spacing(1.0))] + search.halves(wide)
    brackets.sort()
    middles = np.array([0.5 * (np.array(b.low) + b.high) for b in brackets]).reshape(-1, len(plan.axes))
    places = [axis.at_parts(middles[:, i]) for i, axis in enumerate(plan.axes)]
    wide_by = np.array([_length(b) for b in brackets]) * (plan.axes[0].high - plan.axes[0].low)
    kinds = tuple((b.before, b.after) for b in brackets)
    return BoundaryPoints(places[0], places[-1], kinds, wide_by, search.scenarios)


def _length(bracket: _Bracket) -> float:
    return max(b - a for a, b in zip(bracket.low, bracket.high, strict=True))


class _Search:
    """Kinds of motion at places (as fractions of the ranges), with the number of scenarios computed."""

    def __init__(self, plan: Plan):
        self.plan, self.scenarios = plan, 0
        # Levels from the grid to the lattice of the finest cells: 1/CELLS of the ranges, or the grid if it is finer.
        self.level = max(0, *(int(np.ceil(np.log2(CELLS / (len(axis) - 1)))) for axis in plan.axes))
        self.size = tuple((len(axis) - 1) << self.level for axis in plan.axes)
        self.kind_at: dict[Place, str] = {}

    def kinds(self, places: np.ndarray) -> list[str]:
        """The kinds of motion at places (n, axes), given as fractions of the ranges."""
        kind_names: list[str] = []
        for start in range(0, len(places), TOGETHER):
            batch = places[start : start + TOGETHER]
            columns = {axis.name: axis.at_parts(batch[:, i]) for i, axis in enumerate(self.plan.axes)}
            rows = table.rows(self.plan, columns)
            self.scenarios += len(batch)
            pairs = zip(rows.column("sequence").to_pylist(), rows.column("outcome").to_pylist(), strict=True)
            kind_names += [kind(sequence or "", outcome) for sequence, outcome in pairs]
        return kind_names

    def look(self, places: Iterable[Place]) -> None:
        """Compute the kinds of motion at places of the lattice that are still missing."""
        new = sorted({place for place in places if place not in self.kind_at})
        if new:
            self.kind_at |= zip(new, self.kinds(np.array(new) / self.size), strict=True)

    def brackets(self) -> list[_Bracket]:
        """Brackets: the edges of the quadtree's finest cells whose ends differ."""
        step = 1 << self.level
        cells = [tuple(place) for place in product(*(range(0, size, step) for size in self.size))]
        while True:
            self.look(corner for cell in cells for corner in _corners(cell, step))
            cells = [cell for cell in cells if len({self.kind_at[corner] for corner in _corners(cell, step)}) > 1]
            if step == 1 or not cells:
                break
            step //= 2
            cells = [
                tuple(map(sum, zip(cell, part, strict=True)))
                for cell in cells
                for part in _corners((0,) * len(cell), step)
            ]
        edges = {edge for cell in cells for edge in _edges(cell, step)}
        return [self._bracket(*edge) for edge in sorted(edges) if self.kind_at[edge[0]] != self.kind_at[edge[1]]]

    def _bracket(self, low: Place, high: Place) -> _Bracket:
        ends = [tuple(float(i / size) for i, size in zip(place, self.size, strict=True)) for place in (low, high)]
        return _Bracket(ends[0], ends[1], self.kind_at[low], self.kind_at[high])

    def halves(self, brackets: list[_Bracket]) -> list[_Bracket]:
        """Bisect brackets; returns the halves in which the kind changes."""
        middles = [tuple(0.5 * (a + b) for a, b in zip(k.low, k.high, strict=True)) for k in brackets]
        halves = []
        for bracket, middle, there in zip(brackets, middles, self.kinds(np.array(middles)), strict=True):
            if there != bracket.before:
                halves.append(_Bracket(bracket.low, middle, bracket.before, there))
            if there != bracket.after:
                halves.append(_Bracket(middle, bracket.high, there, bracket.after))
        return halves


def _corners(cell: Place, step: int) -> list[Place]:
    return [tuple(place) for place in product(*((i, i + step) for i in cell))]


def _edges(cell: Place, step: int) -> list[tuple[Place, Place]]:
    """A cell's edges, each from its lower end to its upper one."""
    corners = _corners(cell, step)
    return [(a, b) for a in corners for b in corners if a < b and sum(i != j for i, j in zip(a, b, strict=True)) == 1]
