"""A motion, a certificate and a sweep to the last bit: what threads, processes and copies have to leave as it is."""

from __future__ import annotations

import hashlib

import numpy as np

import cases
import reference
from cases import Case, State, Trajectory


def digest(columns) -> str:
    """A digest of numbers to their last bit."""
    whole = hashlib.sha256()
    for column in columns:
        whole.update(np.ascontiguousarray(np.asarray(column, dtype=float)).tobytes())
    return whole.hexdigest()


def of_motion(motion: Trajectory) -> str:
    """Transitions, ending, samples and dense output."""
    changes = [(t.time.hex(), t.before, t.after, t.xi1, t.xi2, t.cause) for t in motion.transitions]
    samples = digest([motion.t, *(getattr(motion, name) for name in State._fields)])
    dense = digest(motion(np.linspace(motion.t[0], motion.t[-1], 101)))
    return repr((changes, motion.status, motion.reason, motion.first_mode, samples, dense))


def of_case(case: Case, method: str | None = None) -> str:
    """The motion of a case."""
    return of_motion(reference.simulate(case, method=method))


def of_label(label: str) -> str:
    """The same of a case of the catalogue, which is made for it."""
    return of_case(cases.load(label))
