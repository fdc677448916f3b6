"""The pieces of a curve that is given by a formula of its own on each interval between knots, such as a spline.

Pieces of one form (structure) differ only in their numbers. Solvers compile a form once, and exchange the numbers
where a motion passes a knot. The first number of every piece is its origin: its formula is one of s − q0.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from functools import cached_property
from math import floor
from typing import Any, NamedTuple

import numpy as np

from ..formulas import late_sympy as sp
from ..formulas.expressions import as_tree, from_tree
from ..formulas.features import Features, union
from .jets import Structure, jet_function

EPS = float(np.finfo(float).eps)

# A piece is continued beyond its knots by this part of its length, so that a motion that rests at a knot does not
# change its piece at each instant. With k continuous derivatives the continuation departs from the next piece by
# its length to the power k + 1; in all that a motion depends on this is below rounding for a length of EPS^(1/k).
OVERLAP = 1e-6


class CurvePart(NamedTuple):
    """One piece as a curve with ends: what the equations of a contact are made from. The domain includes the overlaps
    beyond its knots."""

    structure: Structure
    constants: tuple[float, ...]
    domain: tuple[float, float]
    features: Features | None = None
    period: None = None

    @property
    def ends(self) -> tuple[float, float]:
        """The parameters of its ends."""
        return self.domain


@dataclass(frozen=True, eq=False)
class CurvePieces:
    """The pieces between `breaks` (n + 1,): for each of n pieces its form's number, its origin and its further numbers.

    `order`: how many derivatives by the parameter are continuous at every knot; `period`: of a closed curve. A piece's
    number counts turns of a closed curve: the first piece of the next turn has the number n.
    """

    breaks: tuple[float, ...]
    forms: tuple[Structure, ...]
    form_numbers: tuple[int, ...]
    origins: tuple[float, ...]
    sizes: tuple[tuple[float, ...], ...]
    order: int
    period: float | None
    # Of each piece whose formula has finer scales: the parameters between which it has none; () of any other.
    inner_edges: tuple[tuple[float, ...], ...] = ()

    def __reduce__(self):
        """Pieces travel to another process as their numbers and the trees of their formulas."""
        forms = tuple((tuple(map(as_tree, rows)), tuple(size.name for size in sizes)) for rows, sizes in self.forms)
        numbers = self.form_numbers, self.origins, self.sizes, self.order, self.period, self.inner_edges
        return _restore, (self.breaks, forms, *numbers)

    @cached_property
    def key(self) -> tuple:
        """What equal pieces share."""
        return self.breaks, self.forms, self.form_numbers, self.origins, self.sizes, self.order, self.period

    def translate(self, x: float, y: float) -> CurvePieces:
        """The pieces, moved by (x, y) m."""
        number = len(self.forms[0][1])
        offsets = sp.symbols(f"q{number} q{number + 1}", real=True)
        forms = [((row + offsets[0], other + offsets[1]), (*symbols, *offsets)) for (row, other), symbols in self.forms]
        sizes = tuple((*some, x, y) for some in self.sizes)
        return replace(self, forms=tuple(forms), sizes=sizes)

    @property
    def count(self) -> int:
        """The number of pieces, of one turn of a closed curve."""
        return len(self.sizes)

    @property
    def edges(self) -> tuple[float, ...]:
        """Parameters between which the curve is smooth and has no finer scale: the knots, and more where needed."""
        inner = [edge for edges in self.inner_edges for edge in edges]
        return tuple(union(self.breaks, inner).tolist()) if inner else self.breaks

    @cached_property
    def _arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray]]:
        """Breaks, form numbers, origins, and for each form the numbers of all pieces, (numbers, pieces)."""
        forms = np.array(self.form_numbers)
        tables = []
        for number, (_, symbols) in enumerate(self.forms):
            table = np.full((len(symbols) - 1, self.count), np.nan)
            for piece in np.flatnonzero(forms == number):
                table[:, piece] = self.sizes[piece]
            tables.append(table)
        return np.array(self.breaks), forms, np.array(self.origins), tables

    def number(self, s: float) -> int:
        """The number of the piece at a parameter; beyond the ends of an open curve that of the last one."""
        turns = floor((s - self.breaks[0]) / self.period) if self.period else 0
        at = s - turns * self.period if self.period else s
        return min(max(bisect_right(self.breaks, at) - 1, 0), self.count - 1) + turns * self.count

    def numbers(self, s: np.ndarray) -> np.ndarray:
        """The same for an array of parameters; 0 for those that are not finite."""
        s = np.where(np.isfinite(s), s, self.breaks[0])
        turns = np.floor((s - self.breaks[0]) / self.period) if self.period else np.zeros_like(s)
        at = s - turns * (self.period or 0.0)
        breaks = self._arrays[0]
        piece = np.clip(np.searchsorted(breaks, at, side="right") - 1, 0, self.count - 1)
        return piece + (turns * self.count).astype(np.int64)

    def ends(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The parameters at which pieces begin and end."""
        turns, piece = np.divmod(numbers, self.count)
        breaks, shift = self._arrays[0], turns * (self.period or 0.0)
        return breaks[piece] + shift, breaks[piece + 1] + shift

    def form(self, numbers: np.ndarray) -> np.ndarray:
        """The numbers of the pieces' forms."""
        return self._arrays[1][numbers % self.count]

    def jet(self, s: float) -> list[float]:
        """(x, y, x_p, …, y_t) at one parameter."""
        number = self.number(s)
        return self.jet_on(s, number)

    def jet_on(self, s: float, number: int) -> list[float]:
        """The same by the formula of a given piece, also beyond its ends."""
        return self._function(number, False)(s, self._numbers_of(number))

    def jets(self, s: np.ndarray) -> np.ndarray:
        """The same for an array, shape (8, n)."""
        result, numbers = np.empty((8, *s.shape)), self.numbers(s)
        forms = self.form(numbers)
        for form in range(len(self.forms)):
            some = forms == form if len(self.forms) > 1 else np.ones(s.shape, dtype=bool)
            if some.any():
                for row, values in zip(result, self.rows_on(s[some], numbers[some]), strict=True):
                    row[some] = values
        return result

    def rows_on(self, s: Any, numbers: np.ndarray) -> list:
        """The eight rows on given pieces, all of one form; parameters may be anything NumPy's functions take."""
        turns, piece = np.divmod(numbers, self.count)
        _, forms, origins, tables = self._arrays
        constants = [origins[piece] + turns * (self.period or 0.0), *tables[forms[piece[0]]][:, piece]]
        return self._function(int(piece[0]), True)(s, constants)

    def part(self, number: int) -> CurvePart:
        """A piece as a curve with ends."""
        low, high = (float(end[0]) for end in self.ends(np.array([number])))
        structure = self.forms[self.form_numbers[number % self.count]]
        before, after = (self.overlap(number) if self.has_neighbour(number, step) else 0.0 for step in (-1, 1))
        edges = self.inner_edges[number % self.count] if self.inner_edges else ()
        shift = number // self.count * (self.period or 0.0)
        features = Features.of_edges([edge + shift for edge in edges], False) if edges else None
        return CurvePart(structure, self._numbers_of(number), (low - before, high + after), features)

    def has_neighbour(self, number: int, step: int) -> bool:
        """Whether there is a piece before (step −1) or after (1) one."""
        return self.period is not None or 0 <= number + step < self.count

    def overlap(self, number: int) -> float:
        """By how much a piece continues beyond its knots."""
        (low,), (high,) = self.ends(np.array([number]))
        rounding = 4 * EPS * max(abs(low), abs(high))
        return max(rounding, min(OVERLAP, EPS ** (1.0 / max(self.order, 1))) * float(high - low))

    def across(self, number: int, step: int, s: float) -> float:
        """A parameter at the end of a piece's overlap, moved by roundings if it does not belong to the neighbour."""
        low, high = (float(end[0]) for end in self.ends(np.array([number])))
        rounding = 2 * EPS * max(abs(low), abs(high))
        return max(s, high + rounding) if step > 0 else min(s, low - rounding)

    def _numbers_of(self, number: int) -> tuple[float, ...]:
        turns, piece = divmod(number, self.count)
        return (self.origins[piece] + turns * (self.period or 0.0), *self.sizes[piece])

    def _function(self, number: int, on_arrays: bool):
        return jet_function(self.forms[self.form_numbers[number % self.count]], on_arrays)


def _restore(breaks, forms, *numbers) -> CurvePieces:
    """The pieces that a process sent."""
    structures = []
    for (x, y), names in forms:
        rows = from_tree(x), from_tree(y)
        symbols = {symbol.name: symbol for row in rows for symbol in row.free_symbols}
        # A number that no formula contains has no symbol in them.
        structures.append((rows, tuple(symbols.get(name, sp.Symbol(name, real=True)) for name in names)))
    return CurvePieces(breaks, tuple(structures), *numbers)
