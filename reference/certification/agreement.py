"""Comparison of a motion with the certificate of its case: they must agree within the errors of both."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import NamedTuple

import numpy as np

from cases import Case, Trajectory

from .bars import METHOD_ULPS, Bar
from .certificate import Certificate
from .witnesses import EPS, states_of


class _ValuePair(NamedTuple):
    """A value in both certificate and motion, and in `coarser`, the same motion at a larger tolerance; `what` names
    it."""

    kind: str
    what: str
    unit: str
    certified: Bar
    motion: float
    coarser: float


def contradiction(case: Case, certificate: Certificate, motion: Trajectory, coarser: Trajectory, method: str) -> str:
    """The first contradiction between a motion by that method and a certificate, in a phrase; "" if there is none.

    Modes and status must be the same. A time, a place or a sample may be off by the certificate's error bar plus the
    motion's own error. That error is estimated from `coarser`, the same motion at ten times the tolerance: the largest
    difference between the two in values of that kind, plus the method's own error (`METHOD_ULPS`) of the largest of
    these values.
    """
    events, certified = _events(motion), (certificate.status, [row[:2] for row in certificate.transitions])
    if events != certified:
        return f"the certificate has {_in_words(*certified)}, the motion {_in_words(*events)}"
    if _events(coarser) != events:
        return ""  # the events depend on the tolerance, so this motion's error is unknown
    pairs = list(_value_pairs(case, certificate, motion, coarser))
    for kind in dict.fromkeys(each.kind for each in pairs):
        same = [each for each in pairs if each.kind == kind]
        error = max(abs(each.motion - each.coarser) for each in same)
        error += METHOD_ULPS[method] * EPS * max(abs(each.motion) for each in same)
        for each in same:
            value, bar = each.certified
            if abs(each.motion - value) > bar + error:
                return (
                    f"{each.what} is {value:.15g} ± {bar:.1e}{each.unit} by the certificate, "
                    f"{each.motion:.15g} ± {error:.1e}{each.unit} by the motion"
                )
    return ""


def is_within_bars(case: Case, certificate: Certificate, motion: Trajectory) -> bool:
    """Whether the motion has the certificate's events, and all values within its error bars: then they agree whatever
    the motion's own error is."""
    events, certified = _events(motion), (certificate.status, [row[:2] for row in certificate.transitions])
    return events == certified and all(
        abs(each.motion - each.certified.value) <= each.certified.bar
        for each in _value_pairs(case, certificate, motion, motion)
    )


def _events(motion: Trajectory) -> tuple[str, list]:
    return motion.status, [(event.before, event.after) for event in motion.transitions]


def _in_words(status: str, changes: list) -> str:
    count = len(changes)
    return f"{count} transition{'' if count == 1 else 's'} and the status {status}"


def _value_pairs(case: Case, certificate: Certificate, motion: Trajectory, coarser: Trajectory) -> Iterator[_ValuePair]:
    """All values that are finite in both. In flight slip and contact parameters are NaN."""
    for each in _all(case, certificate, motion, coarser):
        if all(map(isfinite, (each.certified.value, each.motion, each.coarser))):
            yield each


def _all(case: Case, certificate: Certificate, motion: Trajectory, coarser: Trajectory) -> Iterator[_ValuePair]:
    period = case.track.period

    def near(value: float, centre: float) -> float:
        """A parameter of a closed track, shifted by whole periods next to another one."""
        return value - period * np.round((value - centre) / period) if period else value

    rows = zip(certificate.transitions, motion.transitions, coarser.transitions, strict=True)
    for number, ((_, after, time, xi1), event, other) in enumerate(rows, start=1):
        which = f"of transition {number} (to {after})"
        yield _ValuePair("time", f"the time {which}", " s", time, event.time, other.time)
        yield _ValuePair("xi1", f"xi1 {which}", "", xi1, near(event.xi1, xi1.value), near(other.xi1, xi1.value))
    yield _ValuePair("end", "the end", " s", certificate.end, float(motion.t[-1]), float(coarser.t[-1]))
    here, there = (states_of(each, np.minimum(certificate.times, each.t[-1])) for each in (motion, coarser))
    for quantity, bars in certificate.samples.items():
        columns = (each[quantity].tolist() for each in (here, there))
        for time, *values in zip(certificate.times, bars, *columns, strict=True):
            yield _ValuePair(quantity, f"{quantity} at {time:.6g} s", "", *values)
