"""Formulas through samples of a measurement, for effects, whose formulas need derivatives: a record in time, a friction
curve. Each has the fewest terms that come within a tolerance of every sample."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np

from .errors import BadValue, positive, whole

# The longest period of a fit in time, in lengths of the record: it need not return to its first value.
PERIOD = 2.4
# Frequencies of a fit in time (more would not fit into a formula), and decays of a friction curve.
MOST_WAVES, MOST_DECAYS = 20, 4
# Decays are searched up to this factor below the least speed of a table and above the greatest.
REACH = 10.0
# Combinations of terms whose size is below this part of the largest are left out: their factors would only cancel, and
# what is left of them in a formula's derivatives would be rounding.
INDEPENDENT = 1e-6


def fit_waves(t, values, within: float, integrals: int = 0) -> str:
    """A formula in t that is no farther than `within` from each of the `values` (n,) at the times `t` (n,), s.

    It is a constant and cosines and sines of at most 20 frequencies. With `integrals` 1 or 2 it is integrated so many
    times from 0 at t = 0: an acceleration becomes the place of a track that starts at rest. After the record it has no
    meaning; end the case before. Raises BadValue if no such formula comes that near, or for anything else.
    """
    t, values = _samples(("t", t), ("values", values))
    positive("within", within)
    whole("integrals", integrals, 0, 2)
    base, best = 2.0 * np.pi / (PERIOD * np.ptp(t)), np.inf
    for number in range(min(MOST_WAVES, (len(t) - 1) // 2) + 1):
        rates = base * np.arange(1, number + 1)
        phases = np.outer(t, rates)
        terms = np.hstack([np.ones((len(t), 1)), np.cos(phases), np.sin(phases)])
        factors = np.linalg.lstsq(terms, values, rcond=INDEPENDENT)[0]
        best = min(best, off := float(np.max(np.abs(terms @ factors - values))))
        if off <= within:
            return _waves(factors[0], factors[1 : number + 1], factors[number + 1 :], rates, integrals)
    raise BadValue(_too_far("values", within, best, f"frequencies up to {MOST_WAVES * base:.3g} rad/s"))


def fit_friction(v, mu, within: float) -> str:
    """A formula in v that is no farther than `within` from each of the coefficients `mu` (n,) at the slip speeds `v`
    (n,), m/s, for `CoulombFriction`.

    It is a constant, a multiple of v, and at most 4 decays exp(-v/c). At speeds above the table's it has no meaning.
    Raises BadValue if no such formula comes that near, or for anything else.
    """
    from scipy.optimize import least_squares  # slow to import, and few scenes have a table

    v, mu = _samples(("v", v), ("mu", mu))
    positive("within", within)
    if v[0] < 0.0:
        raise BadValue(f"v begins at {v[0]:g} m/s; give slip speeds, which are not negative")
    least, best = v[v > 0.0][0], np.inf
    low, high = np.log(least / REACH), np.log(v[-1] * REACH)
    for number in range(min(MOST_DECAYS, (len(v) - 2) // 2) + 1):
        logs = np.log(np.geomspace(least, v[-1], number + 2)[1:-1])
        if number:
            logs = least_squares(partial(_errors, v, mu), logs, bounds=(low, high), xtol=1e-15, gtol=1e-15).x
        factors, misfit = _misfit(v, mu, logs)
        best = min(best, off := float(np.max(np.abs(misfit))))
        if off <= within:
            parts = [f"{a:.17g}*exp(-v/{c:.17g})" for a, c in zip(factors[2:], np.exp(logs), strict=True)]
            return " + ".join([f"{factors[0]:.17g}", f"{factors[1]:.17g}*v", *parts])
    raise BadValue(_too_far("mu", within, best, f"{MOST_DECAYS} decays"))


def _misfit(v: np.ndarray, mu: np.ndarray, logs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The factors of a constant, of v and of decays with these logarithms of c, and the formula's errors (n,). Neither
    constant nor slope is negative, so that the coefficient is not at large speeds."""
    terms = np.hstack([np.ones((len(v), 1)), v[:, None], np.exp(-v[:, None] / np.exp(logs))])
    decays, fits = list(range(2, 2 + len(logs))), []
    for columns in ([0, 1, *decays], [0, *decays], [1, *decays], decays):
        factors = np.zeros(2 + len(logs))
        factors[columns] = np.linalg.lstsq(terms[:, columns], mu, rcond=INDEPENDENT)[0]
        if factors[0] >= 0.0 and factors[1] >= 0.0:
            fits.append((factors, terms @ factors - mu))
    return min(fits, key=lambda fit: float(fit[1] @ fit[1]))


def _errors(v: np.ndarray, mu: np.ndarray, logs: np.ndarray) -> np.ndarray:
    return _misfit(v, mu, logs)[1]


def _samples(*columns: tuple[str, Iterable[float]]) -> tuple[np.ndarray, np.ndarray]:
    """Two columns of the same length as arrays, the first of them increasing; raises BadValue."""
    arrays = []
    for name, column in columns:
        try:
            array = np.asarray(column, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise BadValue(f"{name} holds something other than numbers; give an array of numbers") from None
        if array.ndim != 1 or len(array) < 3 or not np.isfinite(array).all():
            raise BadValue(f"{name} has the shape {array.shape}, or holds NaN; give at least 3 finite numbers in a row")
        arrays.append(array)
    (name, _), (other, _) = columns
    if len(arrays[0]) != len(arrays[1]):
        raise BadValue(f"{name} has {len(arrays[0])} numbers, {other} {len(arrays[1])}; give as many")
    if not np.all(np.diff(arrays[0]) > 0.0):
        raise BadValue(f"{name} does not increase; give the samples in order, each once")
    return arrays[0], arrays[1]


def _too_far(what: str, within: float, best: float, terms: str) -> str:
    return (
        f"no formula is within {within:g} of {what}: with {terms} it is {best:.3g} off; give a larger within, or a "
        "shorter or smoother record"
    )


def _waves(constant: float, cosines, sines, rates, integrals: int) -> str:
    """The formula of a sum of waves, integrated so many times from 0."""
    powers, waves = {integrals: constant / (1.0, 1.0, 2.0)[integrals]}, []
    for a, b, w in zip(cosines, sines, rates, strict=True):
        if integrals == 1:  # a/w sin(wt) + b/w (1 - cos(wt))
            powers[0] = powers.get(0, 0.0) + b / w
            a, b = -b / w, a / w
        elif integrals == 2:  # a/w² (1 - cos(wt)) + b/w² (wt - sin(wt))
            powers[0], powers[1] = powers.get(0, 0.0) + a / w**2, powers.get(1, 0.0) + b / w
            a, b = -a / w**2, -b / w**2
        waves += [f"{a:.17g}*cos({w:.17g}*t)", f"{b:.17g}*sin({w:.17g}*t)"]
    return " + ".join([f"{factor:.17g}" + ("", "*t", "*t**2")[power] for power, factor in powers.items()] + waves)
