"""Functions that evaluate a curve's position and first three derivatives, written from its structure."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from ..derivation import in_one_thread
from ..formulas.expression_code import ON_ARRAYS, ON_FLOATS, python_function
from ..formulas.expression_graph import Node, derivatives, from_sympy, symbol
from ..formulas.formula_symbols import NAMES

# A curve's formulas with symbols for its sizes, and these symbols: nodes; of a curve in pieces SymPy's.
Structure = tuple[tuple[Any, Any], tuple[Any, ...]]

# The parameter of every curve.
S = symbol(str(NAMES["PARAMETER"]))


@lru_cache(maxsize=512)
@in_one_thread
def jet_function(structure: Structure, on_arrays: bool) -> Callable:
    """A function (s, constants) -> eight rows of a structure, for floats or arrays."""
    arguments, rows = jet_rows(structure)
    return python_function(arguments, rows, ON_ARRAYS if on_arrays else ON_FLOATS)


def jet_rows(structure: Structure) -> tuple[tuple[Node, list[Node]], list[Node]]:
    """The parameter and the constants of a structure as nodes, and the eight rows that `jet_function` evaluates."""
    (x, y), symbols = structure
    rows = [from_sympy(x), from_sympy(y)]
    for _ in range(3):
        rows += derivatives(rows[-2:], S)
    return (S, [symbol(size.name) for size in symbols]), rows
