"""Motions as the page's player takes them: the true motion, and of every route its distance from it, as numbers that
a browser can play. Small: 32 bits a number of which 16 are its mantissa's (five digits), compressed."""

from __future__ import annotations

import inspect
import zlib
from base64 import b64encode
from collections.abc import Mapping
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

import cases
from cases import Case
from cases.pictures.layout import visible

from ..running import per_solver
from ..running.per_solver import LeftOut
from ..running.records import REFERENCE, Experiment, Run, Truth, finest, routes

# Samples of a motion, transitions among them: a player 800 points wide shows no more.
SAMPLES = 401
# Of so many transitions, spread over all, the samples hold the very time.
_EXACT = 120
TRUE = ("x", "y", "theta", "slip", "xi1", "xi2", "lambda", "normal_force", "friction_force")
# Solver minus truth, by names of `distances.differences`; the force of friction as the solver tells it.
OFF = ("x", "y", "angle", "slip", "xi1", "xi2", "lambda")


def motions(experiment: Experiment) -> tuple[list[dict[str, Any]], list[LeftOut]]:
    """What the player of each case shows, and the solvers without whose motion it shows a case, since with it it
    fails."""
    found, left = [], []
    for case in experiment.cases:
        solvers = [run.solver for run in experiment.runs if run.case == case.label]
        make = partial(lambda case, some: motion(some, case), case)
        told, without = per_solver.made(make, (experiment,), solvers, f"player of {case.label}")
        found += [told] if told else []
        left += without
    return found, left


def motion(experiment: Experiment, case: Case) -> dict[str, Any] | None:
    """What the player of a case shows, for JSON; None for a case without a truth."""
    truth = experiment.truths[case.label]
    if truth.failure or not truth.samples:
        return None
    times = _times(truth)
    x, y, xi1 = (truth.samples[name] for name in ("x", "y", "xi1"))
    shown_track = visible(case.scene, np.array([x, y]), xi1)
    return {
        "label": case.label,
        "down": case.scene.down,
        "t": packed(times, whole=True),
        "start": float(times[0]),
        "end": float(times[-1]),
        "modes": _modes(truth),
        "track": {
            "low": float(shown_track[0]),
            "high": float(shown_track[-1]),
            "period": bool(case.track.period),
            "points": packed(case.track.point(shown_track)),
        },
        "outline": packed(case.scene.corners()),
        "truth": packed(np.array([_at(times, truth.samples, name) for name in TRUE])),
        "runs": [_run(run, times) for run in shown(experiment, case.label)],
    }


def shown(experiment: Experiment, label: str) -> list[Run]:
    """The finest motion of every route but the reference's: those lie on the truth."""
    found = map(finest, routes(run for run in experiment.runs if run.case == label).values())
    return [run for run in found if run and run.solver != REFERENCE and len(run.samples.get("t", ())) > 1]


def family(case: Case) -> str:
    """The family of a case: the file of the catalogue it stands in, in words; of another case "Your own"."""
    if case.name not in cases.names():
        return "Your own"
    module = inspect.getmodule(cases.entry(case.name).function)
    name = module.__name__ if module else ""
    return name.rpartition(".")[2].replace("_", " ").capitalize() if ".catalogue." in f".{name}" else "Your own"


def _run(run: Run, times: np.ndarray) -> dict[str, Any]:
    off = {"t": run.off["t"], **{name: run.off[name] for name in OFF}}
    columns = [_at(times, off, name) for name in OFF] + [_at(times, run.samples, "friction_force")]
    events = [row.time for row in run.ledger if isfinite(row.time)]
    told = {"solver": run.solver, "route": run.route, "setting": str(run.setting), "outcome": run.outcome}
    return told | {"events": events[:_EXACT], "data": packed(np.array(columns))}


def _times(truth: Truth) -> np.ndarray:
    """Even times, and the transitions' own."""
    t, events = truth.samples["t"], np.array([event.time for event in truth.transitions])
    if len(events) > _EXACT:
        events = events[np.linspace(0, len(events) - 1, _EXACT).astype(int)]
    return np.union1d(np.linspace(t[0], t[-1], SAMPLES - len(events)), events)


def _at(times: np.ndarray, samples: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """A quantity at these times, NaN beyond its motion's end."""
    t, values = samples["t"], samples[name]
    if not len(t):
        return np.full(len(times), np.nan)
    return np.interp(times, t, values, left=np.nan, right=np.nan)


def _modes(truth: Truth) -> list[tuple[float, str, str]]:
    """When each mode begins, which, and what caused it."""
    first = (float(truth.samples["t"][0]), str(truth.first_mode), "")
    return [first, *((event.time, str(event.after), event.cause) for event in truth.transitions)]


def packed(values: np.ndarray, whole: bool = False) -> str:
    """Numbers as text: 32-bit floats, of their mantissa 16 bits if not the `whole`, first bytes first, compressed, in
    base64. Times are whole: a transition is looked at closely."""
    bits = np.ascontiguousarray(values, dtype="<f4").view("<u4").ravel()
    if not whole:
        bits = ((bits.astype(np.uint64) + 0x40) & 0xFFFFFF80).astype("<u4")
    bits = np.where(np.isfinite(np.ravel(values)), bits, 0x7FC00000).astype("<u4")
    return b64encode(zlib.compress(bits.view(np.uint8).reshape(-1, 4).T.tobytes(), 9)).decode()
