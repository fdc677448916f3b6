"""Polynomials through the nodes of the steps of a motion: integrals, least values, slopes.

A step of the Taylor method is a polynomial of degree 20 to 25, so that 25 nodes integrate what it is made of to
rounding. Arrays have the nodes as last axis.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

COUNT = 25
_DEGREE = COUNT - 1
# Both ends are nodes: Chebyshev's points of the second kind on [-1, 1].
_X = -np.cos(np.pi * np.arange(COUNT) / _DEGREE)
NODES = 0.5 + 0.5 * _X
# Values at the nodes -> coefficients of Chebyshev polynomials.
_FIT = np.linalg.inv(chebyshev.chebvander(_X, _DEGREE))
_EVEN = np.arange(COUNT) % 2 == 0
# Weights of Clenshaw's and Curtis' quadrature on [0, 1].
WEIGHTS = 0.5 * np.where(_EVEN, 2.0 / (1.0 - np.arange(COUNT) ** 2 + (~_EVEN)), 0.0) @ _FIT
# Values at the nodes -> rates at the nodes of a step of unit length.
RATES = 2.0 * (chebyshev.chebvander(_X, _DEGREE - 1) @ chebyshev.chebder(np.eye(COUNT), axis=0)) @ _FIT
# By how much roundings of values are larger in a rate at the first node.
AMPLIFICATION = float(np.abs(RATES[0]).sum())
# Between the nodes a least value is looked for at so many points, and refined by so many steps of Newton's method.
_FINE = np.linspace(-1.0, 1.0, 201)
_ON_FINE = chebyshev.chebvander(_FINE, _DEGREE) @ _FIT
_NEWTON = 4


def coefficients(values: np.ndarray) -> np.ndarray:
    """Those of Chebyshev polynomials in 2 (t − start)/(end − start) − 1, of values at the nodes of steps; both of
    shape (n, 25)."""
    return values @ _FIT.T


def tail(values: np.ndarray) -> np.ndarray:
    """The largest of the last three coefficients: how far a polynomial is from the function at the nodes."""
    return np.abs(values @ _FIT[-3:].T).max(axis=-1)


def least(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least values of some polynomials, (n, 25) -> (n,), and where on [0, 1] they are."""
    fine = values @ _ON_FINE.T
    at = _FINE[np.argmin(fine, axis=-1)]
    c = _FIT @ values.T
    first, second = chebyshev.chebder(c), chebyshev.chebder(c, 2)
    x = at
    for _ in range(_NEWTON):
        bend = chebyshev.chebval(x, second, tensor=False)
        step = np.where(bend > 0.0, chebyshev.chebval(x, first, tensor=False) / np.where(bend > 0.0, bend, 1.0), 0.0)
        x = np.clip(x - np.clip(step, -0.01, 0.01), -1.0, 1.0)
    rows = np.array([fine.min(axis=-1), chebyshev.chebval(x, c, tensor=False), values.min(axis=-1)])
    best = np.argmin(rows, axis=0)
    places = np.array([at, x, _X[np.argmin(values, axis=-1)]])
    every = np.arange(rows.shape[1])
    return rows[best, every], 0.5 + 0.5 * places[best, every]
