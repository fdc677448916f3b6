"""Features of a curve or a load: where and at which scale it changes, so that steps and searches do not miss them.

A step's size comes from derivatives at its start, and a bump ahead does not affect them. So curvature and speed of a
curve, and a load as a function of time, are resolved once by piecewise Chebyshev interpolation: a piece is halved until
its coefficients fall to rounding and the interpolant agrees with the function at all other samples (the
construction of Chebfun's splitting: Pachón, Platte & Trefethen 2010, IMA J. Numer. Anal. 30, 898; not looked up). The
length of a piece is then that of the finest feature in it.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from math import copysign, inf, isfinite

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from ..derivation import LOCK
from . import late_sympy as sp
from .expression_graph import ARITHMETIC, INTEGRAL, Node, node, preorder

# Sixteen is about the order of the Taylor method, so that a piece is about as long as one step.
DEGREE = 16
# Even intervals in a piece, which holds at most half an oscillation.
INTERVALS_A_PIECE = 4
# Coefficients below this fraction of the function's size are rounding of some tens of operations.
RESOLUTION = 1e-13
# Samples of each window besides the nodes. A Gaussian exp(-(s/w)²) shows above rounding over 11 w: in a window of
# length 16 none wider than a thousandth hides between them, and narrower ones have their centre in the formula.
SAMPLES = 2048
# Around a centre the distances of samples are halved, down to a billionth of the window.
HALVINGS = 30
# A window with more pieces than this is no longer refined; the next one is as wide as a window only up to CROWDED.
MOST_PIECES, MANY_PIECES = 20_000, 64
# A step covers at most this fraction of a piece: at one end of a piece the function may be rounding, at the other not.
PART = 0.5
# Points per piece that give a function's extremes to a hundredth of its change: a piece holds half an oscillation.
POINTS = 16
# Pieces whose lengths differ by at most the factor ALIKE have one scale, unless the function is quiet in one of them:
# changes there by less than the fraction QUIET of its change elsewhere.
ALIKE, QUIET = 4.0, 1e-3
# The first window on each side of zero of a parameter without end; the next is twice as wide.
WINDOW = 16.0

_TWO = node(2)
_NODES = chebyshev.chebpts1(DEGREE + 1)
_TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, DEGREE))

# What is resolved: an array of n parameters to rows (k, n) and the sizes (k, n) of the terms they are differences of.
Function = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def union(*parts) -> np.ndarray:
    """All values in order, each once. (`np.union1d` imports NumPy's masked arrays, a third of a first `load`.)"""
    values = np.sort(np.concatenate([np.ravel(part) for part in parts]))
    return values[np.concatenate([np.ones(min(len(values), 1), dtype=bool), values[1:] != values[:-1]])]


class Window:
    """A stretch of the parameter in resolved pieces: their `edges`, and the longest `strides` a step may take in each.

    A stride is infinite where nothing changes, and everywhere if the window has only one scale. Rounding is measured by
    the function's size in the window, and at least by `sizes` (k,).
    """

    def __init__(
        self,
        function: Function,
        low: float,
        high: float,
        centres: Iterable[float] = (),
        sizes: np.ndarray | float = 0.0,
    ):
        with np.errstate(all="ignore"):  # an overflow gives values that are not finite
            edges, changes = _resolve_interval(function, low, high, centres, sizes)
        lengths = np.diff(edges)
        varies = changes > 0.0
        alike = not varies.any() or (
            np.ptp(np.log2(lengths)) <= np.log2(ALIKE) and changes.min() >= QUIET * changes.max()
        )
        self.low, self.high = low, high
        self.edges: list[float] = edges.tolist()
        self.strides: list[float] = np.where(varies & (not alike), PART * lengths, inf).tolist()
        self.plain = bool(alike)

    @classmethod
    def of_edges(cls, edges: Sequence[float]) -> Window:
        """A window whose pieces are known: the function is smooth between the edges and has no finer scale there."""
        window = object.__new__(cls)
        window.low, window.high, window.plain = edges[0], edges[-1], False
        window.edges, window.strides = list(edges), (PART * np.diff(edges)).tolist()
        return window


class Features:
    """The pieces of a function of one parameter, on (low, high), repeated if periodic.

    Without limits it is resolved on demand, window after window outwards from zero; the result does not depend on the
    requests. `sizes` (k,): a lower bound on the size of the terms of which each row is a difference: the tail of a step
    1 - tanh² at 1e-10 of the step's height is rounding, and no feature, in a window that holds nothing else.
    """

    def __init__(
        self,
        function: Function,
        centres: Iterable[float] = (),
        limits: tuple[float, float] | None = None,
        periodic: bool = False,
        sizes: np.ndarray | float = 0.0,
        window: float = WINDOW,
    ):
        self._function, self._centres, self._limits = function, tuple(centres), limits
        self._sizes, self._first = sizes, window
        self._period = limits[1] - limits[0] if limits and periodic else None
        self._sides: dict[bool, list[Window]] = {True: [], False: []}
        if limits:
            self._sides[True].append(Window(function, *limits, self._centres, sizes))

    @classmethod
    def of_edges(cls, edges: Sequence[float], periodic: bool) -> Features:
        """The features of a function that is smooth between known edges, and has no finer scale there."""
        features = object.__new__(cls)
        features._limits, features._period = (edges[0], edges[-1]), edges[-1] - edges[0] if periodic else None
        features._sides = {True: [Window.of_edges(edges)], False: []}
        return features

    @property
    def plain(self) -> bool:
        """Whether there is certainly no feature that a step could miss."""
        return self._limits is not None and self._sides[True][0].plain

    def clear(self, start: float, goal: float) -> float:
        """The farthest end of a step from `start` towards `goal`: at the next finer piece or after the stride."""
        if self.plain or not (isfinite(start) and isfinite(goal)) or start == goal:
            return goal
        limit = abs(goal - start)
        for distance, stride in self._ahead(start, goal > start):
            if distance >= limit:
                break
            limit = min(limit, max(distance, stride))
        return goal if limit >= abs(goal - start) else start + copysign(limit, goal - start)

    def finest(self, low: float, high: float) -> float:
        """The shortest stride on (low, high), in units of the parameter; infinite if there is none."""
        return min((stride for a, b, stride in self._pieces(low, high)), default=inf)

    def places(self, low: float, high: float, apart: float = inf) -> np.ndarray:
        """Sorted parameters on (low, high), at most `apart` from each other, that resolve every feature."""
        ends = np.array([(a, b) for a, b, stride in self._pieces(low, high) if stride < inf]).reshape(-1, 2).T
        count = int(np.ceil((high - low) / apart)) if apart < inf else 1
        fine = np.linspace(ends[0], ends[1], DEGREE, endpoint=False)
        every = np.concatenate([np.linspace(low, high, count + 1), fine.ravel()])
        return union(every[(every >= low) & (every <= high)])

    def piece_length(self, at: float) -> float:
        """The length of the piece that a parameter lies in: there the function is a polynomial of degree `DEGREE`."""
        _, window, shift = self._window(at)
        i = min(max(bisect_right(window.edges, at - shift) - 1, 0), len(window.strides) - 1)
        return window.edges[i + 1] - window.edges[i]

    def nodes(self, low: float, high: float) -> np.ndarray:
        """Sorted parameters on (low, high) that give the function's extremes in every piece."""
        edges = self.edges(low, high)
        parts = edges[:-1, None] + np.diff(edges)[:, None] * np.linspace(0.0, 1.0, POINTS, endpoint=False)
        return union(parts, [high])

    def intervals_of_one_scale(self, low: float, high: float) -> int:
        """The number of even intervals that resolve features of one scale on (low, high), of which `places` has none; 0
        if there are several scales."""
        return 0 if self.finest(low, high) < inf else INTERVALS_A_PIECE * (len(self.edges(low, high)) - 1)

    def edges(self, low: float, high: float) -> np.ndarray:
        """Both limits and the sorted ends of all pieces on (low, high), whether or not they have one scale."""
        results = [np.array([low, high])]
        number, window, shift = self._window(low)
        while True:
            edges = np.array(window.edges) + shift
            results.append(edges[(edges > low) & (edges < high)])
            number += 1
            following = self._window_at(number) if window.high + shift < high else None
            if following is None:
                return union(*results)
            window, shift = following

    def _pieces(self, low: float, high: float) -> Iterator[tuple[float, float, float]]:
        """(start, end, stride) of the pieces that meet (low, high)."""
        if self.plain:
            return
        before, last = low, inf
        for distance, stride in self._ahead(low, forward=True):
            if distance > 0.0:
                yield before, low + distance, last
                before = low + distance
            if before >= high:
                return
            last = stride
        yield before, high, last

    def _ahead(self, start: float, forward: bool) -> Iterator[tuple[float, float]]:
        """(distance, stride) of each piece in order, from the one that contains `start`."""
        number, window, shift = self._window(start)
        at = start - shift
        i = min(max(bisect_right(window.edges, at) - 1, 0), len(window.strides) - 1)
        yield 0.0, window.strides[i]
        while True:
            i += 1 if forward else -1
            if not 0 <= i < len(window.strides):
                number += 1 if forward else -1
                following = self._window_at(number)
                if following is None:
                    return
                window, shift = following
                i = 0 if forward else len(window.strides) - 1
            edge = window.edges[i] if forward else window.edges[i + 1]
            yield max(abs(edge + shift - start), 0.0), window.strides[i]

    def _window(self, s: float) -> tuple[int, Window, float]:
        """The window that contains s: its number, the window, and the shift of its edges."""
        if self._limits:
            number = int((s - self._limits[0]) // self._period) if self._period else 0
            return number, self._sides[True][0], number * (self._period or 0.0)
        forward, k = s >= 0.0, 0
        while not self._side(forward, k).low <= s <= self._side(forward, k).high:
            k += 1
        return (k if forward else -1 - k), self._side(forward, k), 0.0

    def _window_at(self, number: int) -> tuple[Window, float] | None:
        if self._limits:
            return (self._sides[True][0], number * self._period) if self._period else None
        return self._side(number >= 0, number if number >= 0 else -1 - number), 0.0

    def _side(self, forward: bool, k: int) -> Window:
        """The k-th window away from zero."""
        windows = self._sides[forward]
        if len(windows) <= k:
            with LOCK:
                self._resolve(windows, forward, k)
        return windows[k]

    def _resolve(self, windows: list[Window], forward: bool, k: int) -> None:
        """Append windows up to the k-th."""
        while len(windows) <= k:
            near, length = 0.0, self._first
            if windows:
                last = windows[-1]
                near = last.high if forward else last.low
                length = (last.high - last.low) * (2.0 if len(last.strides) <= MANY_PIECES else 1.0)
            ends = (near, near + length) if forward else (near - length, near)
            windows.append(Window(self._function, *ends, self._centres, self._sizes))


def largest(function: Function, low: float, high: float, centres: Iterable[float]) -> np.ndarray:
    """The sizes (k,) of a function's rows on an interval that holds (low, high) and all its centres."""
    points = [*centres]
    with np.errstate(all="ignore"):
        return _largest(function(_samples(min([low, *points]), max([high, *points]), points))[1])


def _largest(sizes: np.ndarray) -> np.ndarray:
    return np.max(np.where(np.isfinite(sizes), np.abs(sizes), 0.0), axis=1)


def _resolve_interval(
    function: Function, low: float, high: float, centres: Iterable[float], least: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """Edges (n + 1,) of the pieces, and how much the function changes in each (n,), in parts of its size; 0: not."""
    s = _samples(low, high, centres)
    rows, sizes = function(s)
    scale = np.maximum(_largest(sizes), least)
    scale[scale == 0.0] = 1.0
    rows = rows / scale[:, None]
    todo, pieces = np.array([[low], [high]]), []
    while todo.shape[1]:
        a, b = todo
        nodes = 0.5 * (a + b)[:, None] + 0.5 * (b - a)[:, None] * _NODES
        values = function(nodes.ravel())[0].reshape(len(scale), *nodes.shape) / scale[:, None, None]
        coefficients = values @ _TO_COEFFICIENTS.T
        # A rounding of the parameter changes the function by its slope.
        slope = np.max(np.abs(np.diff(values) / np.diff(nodes)), axis=2)
        error = RESOLUTION + 8 * np.finfo(float).eps * slope * np.maximum(abs(a), abs(b))
        good = np.all(np.max(np.abs(coefficients[:, :, -3:]), axis=2) <= error, axis=0)
        good &= ~_missing(s, rows, a, b, coefficients, error, good)
        # Without finite values there is nothing to resolve; a piece is halved as long as its middle is finite.
        hopeless = (b - a <= 1e-12 * (high - low)) | ~np.isfinite(values).any(axis=(0, 2))
        change = np.max(np.where(np.isfinite(coefficients[:, :, 1:]), np.abs(coefficients[:, :, 1:]), 0.0), axis=2)
        change = np.max(np.where(change > error, change, 0.0), axis=0)
        stop = good | hopeless | (todo.shape[1] > MOST_PIECES)
        pieces.append(np.array([a[stop], change[stop]]))
        a, b = a[~stop], b[~stop]
        middle = 0.5 * (a + b)
        todo = np.array([np.concatenate([a, middle]), np.concatenate([middle, b])])
    starts, changes = np.concatenate(pieces, axis=1)
    order = np.argsort(starts)
    return np.append(starts[order], high), changes[order]


def _missing(s, rows, a, b, coefficients, error, good) -> np.ndarray:
    """Which of the pieces that seem resolved disagree with the samples in them."""
    wrong = np.zeros(len(a), dtype=bool)
    order = np.argsort(a)
    piece = order[np.clip(np.searchsorted(a[order], s, side="right") - 1, 0, None)]
    selection = good[piece] & (s >= a[piece]) & (s <= b[piece])
    if not selection.any():
        return wrong
    s, piece = s[selection], piece[selection]
    x = (2 * s - a[piece] - b[piece]) / (b[piece] - a[piece])
    values = np.einsum("nd,knd->kn", chebyshev.chebvander(x, DEGREE), coefficients[:, piece])
    # Ten: the factor by which interpolation may increase the errors of its nodes.
    off = np.any(np.abs(values - rows[:, selection]) > 10 * error[:, piece], axis=0)
    wrong[piece[off]] = True
    return wrong


def _samples(low: float, high: float, centres: Iterable[float]) -> np.ndarray:
    """Parameters at which an interpolant has to agree: even ones, and increasingly dense ones around each centre."""
    steps = (high - low) * 0.5 ** np.arange(1, HALVINGS + 1)
    around = np.concatenate([-steps, [0.0], steps])
    every = np.concatenate([np.linspace(low, high, SAMPLES), *(centre + around for centre in centres)])
    return union(every[(every >= low) & (every <= high)])


# --- special points of a formula --------------------------------------------------------------------------------------


def centres(formulas: Iterable[Node], by: Node) -> tuple[float, ...]:
    """Zeros and extremes of the arguments of functions (and of divisors) that are polynomials in a symbol.

    The middle of exp(-((s - c)/w)²), tanh((s - c)/w), 1/(w² + (s - c)²) is c, however small w is.
    """
    results: set[float] = set()
    for argument in dict.fromkeys(a for formula in formulas for a in arguments(formula, {by})):
        whole = coefficients(argument, by)
        if whole is None:
            continue
        for ascending in (whole, polynomial.polyder(whole)):
            results.update(float(root.real) for root in np.atleast_1d(polynomial.polyroots(ascending)))
    return tuple(sorted(c for c in results if isfinite(c)))


def coefficients(formula: Node, by: Node) -> np.ndarray | None:
    """Those of a polynomial in a symbol, from the constant up; None for any other formula."""
    if formula is by:
        return np.array([0.0, 1.0])
    if formula.op == "number":
        return np.array([float(formula.args[0])])
    if formula.op not in ARITHMETIC:
        return None
    one, other = (coefficients(part, by) for part in formula.args)
    if one is None or other is None:
        return None
    if formula.op == "**":
        power = formula.args[1].args[0]
        if len(one) > 1 and isinstance(power, int) and power > 0:
            return polynomial.polypow(one, power)
        return one**other if len(one) == len(other) == 1 else None
    if formula.op == "/":
        return one / other[0] if len(other) == 1 else None
    combine = {"+": polynomial.polyadd, "-": polynomial.polysub, "*": polynomial.polymul}[formula.op]
    return combine(one, other)


def arguments(formula: Node, symbols: Set[Node]) -> Iterator[Node]:
    """The arguments of functions, and the bases of powers other than squares and divisors, that contain one of the
    symbols; not the arguments of sines and cosines that are linear in the symbols."""
    for current in preorder(formula):
        if current.op in ("sin", "cos") and degree(current.args[0], symbols) <= 1:
            continue
        yield from (a for a in _inner(current) if symbols & a.symbols)


def _inner(current: Node) -> Iterable[Node]:
    """The argument of a function, the base of a power other than a square, the bases in a divisor."""
    if current.op == "/":
        return _bases(current.args[1])
    if current.op == "**":
        return current.args if current.args[1] is not _TWO else ()
    return current.args if current.op not in ARITHMETIC and not current.op.startswith(INTEGRAL) else ()


def _bases(divisor: Node) -> Iterator[Node]:
    """The bases of the factors of a divisor."""
    if divisor.op == "*":
        for factor in divisor.args:
            yield from _bases(factor)
    else:
        yield divisor.args[0] if divisor.op == "**" else divisor


def singular_arguments(formula: Node) -> Iterator[Node]:
    """The arguments of logarithms, arc sines and arc cosines, and the bases of roots and fractions."""
    for current in preorder(formula):
        if current.op in ("log", "asin", "acos"):
            yield current.args[0]
        elif current.op == "/":
            yield from _bases(current.args[1])
        elif current.op == "**" and not (isinstance(power := current.args[1].args[0], int) and power > 0):
            yield current.args[0]


def degree(formula: Node, symbols: Set[Node]) -> float:
    """An upper bound on the formula's degree as a polynomial in the symbols; infinite where it is none."""
    if not symbols & formula.symbols:
        return 0
    if formula in symbols:
        return 1
    if formula.op not in ARITHMETIC:
        return inf
    one, other = (degree(part, symbols) for part in formula.args)
    if formula.op in "+-":
        return max(one, other)
    if formula.op == "*":
        return one + other
    if other:
        return inf
    if formula.op == "/":
        return one
    power = formula.args[1].args[0]
    return one * power if isinstance(power, int) and power > 0 else inf


def alone(expressions: Iterable[sp.Expr], symbol: sp.Symbol) -> tuple[sp.Expr, ...]:
    """The largest parts of expressions in which only that symbol occurs, without the symbol itself."""
    results: dict[sp.Expr, None] = {}
    for expression in expressions:
        walk = sp.preorder_traversal(expression)
        for part in walk:
            if part.free_symbols == {symbol}:
                walk.skip()
                if part != symbol:
                    results[part] = None
    return tuple(results)
