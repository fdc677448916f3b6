"""Converts the values that an adapter returns into plain numbers and words of limited size, or reports what is wrong.

An adapter is third-party code: its values may have any type, and reading them may run code. They are read once, in the
process in which the adapter runs; all other code uses the plain values.
"""

from __future__ import annotations

from itertools import islice
from math import isfinite, isnan
from typing import Any

import numpy as np

from cases import Case, Cost, Mode, State, Trajectory, Transition
from cases.errors import describe
from cases.motion.sampled_contacts import SampledContacts, SampledPlates
from cases.motion.trajectory import ContactColumns
from cases.scene.free_plates import names_of

from .interface import EngineFailure, Setting

# A motion of so many samples takes 200 MB; the finest rung of the suite's engines has 60,000.
MOST_SAMPLES = 2_000_000
MOST_TRANSITIONS = 100_000
MOST_CONTACTS = 100
# Seconds, steps and knobs beyond these are no measurement: 30 years, and the largest exact integers of a float.
MOST_SECONDS, MOST_STEPS, MOST_KNOB = 1e9, 2**53, 1e100
# Characters of a word, such as a status, and of a sentence.
MOST_WORD, MOST_SENTENCE = 100, 2000


def motion(raw: Any, case: Case) -> Trajectory:
    """The motion that an adapter returned for a case, as plain arrays, numbers and words.

    Other code judges whether it is a motion of the case. The columns of each contact and plate are read once, at the
    samples; its `dense` output and the passages between pieces are left out: nothing calls back into an adapter.
    Raises EngineFailure in one sentence that names a value of the wrong type or size.
    """
    if not isinstance(raw, Trajectory):
        raise EngineFailure(f"it returned {_short_text(raw)} in place of a Trajectory")
    try:
        columns: dict[str, Any] = {name: _column(name, getattr(raw, name)) for name in ("t", *State._fields)}
        length = len(columns["t"])
        for name, column in columns.items():
            if len(column) != length:
                raise EngineFailure(f"its {name} has {len(column)} samples and its t has {length}; give as many")
        return Trajectory(
            **columns,
            transitions=_transitions(raw.transitions),
            status=_text("status", raw.status, MOST_WORD),
            reason=_text("reason", raw.reason, MOST_SENTENCE),
            cost=cost(raw.cost),
            slip_resolution=_number("slip_resolution", raw.slip_resolution, 0.0, MOST_KNOB),
            first_mode=None if raw.first_mode is None else _mode("first_mode", raw.first_mode),
            case=case,
            **_contacts(raw, columns["t"]),
            **_plates(raw, columns, case),
        )
    except EngineFailure:
        raise
    except Exception as problem:  # reading the values may run any code
        raise EngineFailure(f"its motion cannot be read: {describe(problem)}") from problem


def _contacts(raw: Trajectory, t: np.ndarray) -> dict[str, Any]:
    """Names and columns of the contacts of a motion that has several."""
    if raw.contact_columns is None:
        return {}
    names = tuple(_text("name of a contact", name, MOST_WORD) for name in islice(raw.contact_names, MOST_CONTACTS + 1))
    if not 1 <= len(names) <= MOST_CONTACTS or len(set(names)) < len(names):
        raise EngineFailure(f"it names {len(names)} contacts; give 1 to {MOST_CONTACTS} different names")
    return {"contact_names": names, "contact_columns": SampledContacts(t, {n: _contact(raw, n, len(t)) for n in names})}


def _contact(raw: Trajectory, name: str, length: int) -> ContactColumns:
    """The columns of one contact as plain arrays."""
    given = raw.contact_columns(name, None) if raw.contact_columns else None
    columns = dict[str, np.ndarray]()
    for field in ContactColumns._fields:
        value = getattr(given, field)
        if field.endswith("_range"):
            columns[field] = np.array([_column(f"{field} of {name}", row) for row in value])
        else:
            columns[field] = _column(f"{field} of {name}", value)
        if columns[field].shape not in ((length,), (2, length)):
            raise EngineFailure(f"its {field} of {name} has {columns[field].shape[-1]} samples and its t has {length}")
    return ContactColumns(**columns)


def _plates(raw: Trajectory, columns: dict[str, np.ndarray], case: Case) -> dict[str, Any]:
    """Names and columns of the plates of a case that has several."""
    names, read = names_of(case), raw.plate_columns
    if len(names) == 1:
        return {}
    given = tuple(_text("name of a plate", name, MOST_WORD) for name in islice(raw.plate_names, len(names) + 1))
    if given != names or read is None:
        raise EngineFailure(f"it gives the plates {', '.join(given)}; give {', '.join(names)}")
    t, fields = columns["t"], ("x", "y", "theta", "vx", "vy", "omega")
    plates = {names[0]: np.array([columns[name] for name in fields])}
    for name in names[1:]:
        now = read(name, None)
        plates[name] = np.array([_column(f"{field} of {name}", getattr(now, field)) for field in fields])
        if plates[name].shape[1] != len(t):
            raise EngineFailure(f"its {name} has {plates[name].shape[1]} samples and its t has {len(t)}")
    return {"plate_names": names, "plate_columns": SampledPlates(t, plates)}


def cost(raw: Any) -> Cost:
    """The cost of a run as plain numbers; raises EngineFailure."""
    if not isinstance(raw, Cost):
        raise EngineFailure(f"its cost is {_short_text(raw)}; give a Cost")
    seconds: dict[str, Any] = {
        name: _number(f"cost.{name}", getattr(raw, name), 0.0, MOST_SECONDS, may_be_nan=True)
        for name in ("cpu_s", "wall_s", "setup_s")
    }
    counts = {name: _whole(f"cost.{name}", getattr(raw, name)) for name in ("steps", "evaluations")}
    return Cost(**seconds, **counts)


def routes(raw: Any) -> tuple[str, ...]:
    """An adapter's routes; raises TypeError unless it is a tuple or a list of at least one name."""
    if not isinstance(raw, tuple | list) or not raw:
        raise TypeError(f'routes is {_short_text(raw)}; give a tuple of names, as ("native",)')
    return tuple(map(str, raw))


def setting(raw: Any) -> Setting:
    """A setting of a ladder or a grid, with knobs that are finite numbers and words; raises TypeError or ValueError."""
    if type(raw) is not Setting:
        raise TypeError(f"{_short_text(raw)} is no Setting")
    for name, value in raw.values:
        if type(name) is not str or type(value) not in (int, float, str, bool):
            raise TypeError(
                f"the knob {_short_text(name)} of a setting is {_short_text(value)}; give a number or a word"
            )
        if isinstance(value, int | float) and not abs(value) <= MOST_KNOB:  # NaN is not
            raise ValueError(f"the knob {name} of a setting is {_short_text(value)}; give a finite number")
    return raw


def _column(name: str, raw: Any) -> np.ndarray:
    """A column as a new array (n,) that shares nothing with the adapter."""
    if not isinstance(raw, np.ndarray | list | tuple):
        raise EngineFailure(f"its {name} is {_short_text(raw)}; give an array")
    if len(raw) > MOST_SAMPLES:
        raise EngineFailure(f"its {name} has more than {MOST_SAMPLES:,} samples; give fewer")
    values = np.array(raw, subok=False)
    if values.dtype.kind not in "iuf":
        raise EngineFailure(f"its {name} is an array of {values.dtype}; give numbers")
    if values.ndim != 1:
        raise EngineFailure(f"its {name} has shape {values.shape}; give an array of shape (n,)")
    return values.astype(np.float64)


def _transitions(raw: Any) -> tuple[Transition, ...]:
    if not isinstance(raw, tuple | list) or len(raw) > MOST_TRANSITIONS:
        raise EngineFailure(f"its transitions are {_short_text(raw)}; give a tuple of at most {MOST_TRANSITIONS:,}")
    return tuple(map(_transition, raw))


def _transition(raw: Any) -> Transition:
    if not isinstance(raw, Transition):
        raise EngineFailure(f"a transition is {_short_text(raw)}; give a Transition")
    return Transition(
        time=_number("transition's time", raw.time, -MOST_SECONDS, MOST_SECONDS),
        before=_mode("transition's before", raw.before),
        after=_mode("transition's after", raw.after),
        xi1=_number("transition's xi1", raw.xi1, -MOST_KNOB, MOST_KNOB, may_be_nan=True),
        xi2=_number("transition's xi2", raw.xi2, -MOST_KNOB, MOST_KNOB, may_be_nan=True),
        cause=_text("transition's cause", raw.cause, MOST_WORD),
        contact=_text("transition's contact", raw.contact, MOST_WORD),
    )


def _mode(what: str, raw: Any) -> Mode:
    if type(raw) is not Mode:
        raise EngineFailure(f"its {what} is {_short_text(raw)}; give a Mode")
    return raw


def _number(what: str, raw: Any, least: float, most: float, may_be_nan: bool = False) -> float:
    """A number between two bounds; NaN is accepted with `may_be_nan`."""
    if isinstance(raw, bool | np.bool_) or not isinstance(raw, int | float | np.integer | np.floating):
        raise EngineFailure(f"its {what} is {_short_text(raw)}; give a number")
    try:
        value = float(raw)
    except OverflowError:
        value = float("inf")
    if not (may_be_nan and isnan(value)) and not (isfinite(value) and least <= value <= most):
        raise EngineFailure(f"its {what} is {_short_text(raw)}; give a number from {least:g} to {most:g}")
    return value


def _whole(what: str, raw: Any) -> int:
    value = _number(what, raw, 0, MOST_STEPS)
    if value != int(value):
        raise EngineFailure(f"its {what} is {value:g}; give a whole number")
    return int(value)


def _text(what: str, raw: Any, most: int) -> str:
    if not isinstance(raw, str):
        raise EngineFailure(f"its {what} is {_short_text(raw)}; give a text")
    return str.__str__(raw)[:most]


def _short_text(raw: Any) -> str:
    """A short description for a message; the value's own text only for Python's built-in types."""
    if type(raw) in (int, float, str, bool, bytes, type(None)):
        text = repr(raw) if type(raw) is not int or abs(raw) < MOST_STEPS else f"a number of {raw.bit_length()} bits"
        return text if len(text) <= MOST_WORD else f"{text[:MOST_WORD]}…"
    return f"a {type(raw).__name__}"
