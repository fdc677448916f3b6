"""What an adapter returns passes a gate: plain values of ordinary size come out of it, or a sentence."""

from dataclasses import fields, replace
from math import isnan, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cases
from adapters import EngineFailure, Setting, gate
from cases import Cost, Mode, State, Trajectory, Transition

from ..fake_adapter import bowled

CASE = cases.load("disc_on_line[mu=0.1]")
MOTION = bowled(CASE, np.linspace(0.0, CASE.duration, 61))


class Refuses(float):
    """A number that fails when it is asked for its value."""

    def __float__(self):
        raise RuntimeError("no")

    __repr__ = __str__ = __float__  # type: ignore[assignment]


class Numberless:
    """An object that fails at whatever it is asked."""

    def __getattr__(self, name):
        raise RuntimeError(name)

    __float__ = __int__ = __index__ = __array__ = __len__ = __iter__ = __repr__ = __bool__ = __getattr__  # type: ignore


class Own(np.ndarray):
    """An array whose arithmetic is its author's."""


def is_nan(value) -> bool:
    return type(value) is float and isnan(value)


MINUS = -1
ODD = [
    "12", b"12", None, True, 10**400, MINUS, nan, np.array([1, 2]), np.array(1.0), [1.0], Numberless(), Refuses(1.0),
    1j, object, lambda: 1.0, 1e300, Mode.ROLL,
]  # fmt: skip


# Fields that the gate does not read: the suite has the case, and nothing calls back into an adapter.
LEFT_OUT = ("case", "dense", "passages", "contact_names", "contact_columns", "plate_names", "plate_columns",
            "impulses")  # fmt: skip


def plain(motion: Trajectory) -> bool:
    """Whether all of it is of the types that the suite computes with."""
    columns = [getattr(motion, name) for name in ("t", *State._fields)]
    cost, words = motion.cost, (motion.status, motion.reason)
    return (
        all(type(column) is np.ndarray and column.dtype == float for column in columns)
        and all(type(value) is float for value in (cost.cpu_s, cost.wall_s, cost.setup_s, motion.slip_resolution))
        and all(type(value) is int for value in (cost.steps, cost.evaluations))
        and all(type(value) is str for value in words)
        and motion.dense is None
        and motion.contact_columns is None
        and motion.passages == ()
    )


def passes(motion) -> bool:
    try:
        found = gate.motion(motion, CASE)
    except EngineFailure as problem:
        assert str(problem) and "\n" not in str(problem) and len(str(problem)) < 1000
        return False
    assert plain(found)
    return True


def test_a_motion_comes_out_as_it_went_in_and_shares_nothing():
    motion = replace(MOTION, cost=Cost(steps=np.int64(300), cpu_s=np.float32(0.5)), slip_resolution=1)
    found = gate.motion(motion, CASE)
    assert plain(found) and (found.cost.cpu_s, found.cost.steps, found.slip_resolution) == (0.5, 300, 1.0)
    for name in ("t", *State._fields):
        np.testing.assert_array_equal(getattr(found, name), getattr(motion, name))
        assert not np.shares_memory(getattr(found, name), getattr(motion, name))


@pytest.mark.parametrize("value", ODD, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("field", [f.name for f in fields(Cost)])
def test_a_cost_of_another_type_or_size_is_a_failure_of_the_engine(field, value):
    allowed = is_nan(value) and field.endswith("_s")
    assert passes(replace(MOTION, cost=Cost(**{field: value}))) == allowed


@pytest.mark.parametrize("value", ODD, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("field", [f.name for f in fields(Trajectory) if f.name not in LEFT_OUT])
def test_a_field_of_another_type_is_a_failure_of_the_engine(field, value):
    motion = object.__new__(Trajectory)  # as an adapter might that gets around the checks of the class
    vars(motion).update({f.name: getattr(MOTION, f.name) for f in fields(Trajectory)} | {field: value})
    allowed = (field in ("status", "reason") and isinstance(value, str)) or (
        field == "first_mode" and (value is None or isinstance(value, Mode))
    )
    assert passes(motion) == allowed, field


@pytest.mark.parametrize("value", ODD, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("field", [f.name for f in fields(Transition)])
def test_a_transition_of_another_type_is_a_failure_of_the_engine(field, value):
    good = dict(time=0.1, before=Mode.ROLL, after=Mode.FLIGHT, xi1=0.0, xi2=nan, cause="it left")
    event = Transition(**(good | {field: value}))
    allowed = (
        (field in ("before", "after") and isinstance(value, Mode))
        or (field in ("cause", "contact") and isinstance(value, str))
        or (field in ("xi1", "xi2") and (is_nan(value) or value is MINUS))
        or (field == "time" and value is MINUS)
    )
    assert passes(replace(MOTION, transitions=(event,))) == allowed


@pytest.mark.parametrize(
    "column",
    [
        MOTION.x.astype(object), MOTION.x.astype(str), MOTION.x.astype(complex), MOTION.x[:, None], MOTION.x[:-1],
        MOTION.x > 0, [*MOTION.x[:-1], Refuses(0.0)], [*MOTION.x[:-1], 10**400], np.zeros(gate.MOST_SAMPLES + 1),
        [[0.0], [0.0, 1.0]],
    ],
    ids=["objects", "texts", "complex", "matrix", "short", "booleans", "refuses", "huge", "many", "ragged"],
)  # fmt: skip
def test_a_column_that_is_none_is_a_failure_of_the_engine(column):
    motion = object.__new__(Trajectory)
    vars(motion).update({f.name: getattr(MOTION, f.name) for f in fields(Trajectory)} | {"x": column})
    assert not passes(motion)


def test_a_column_of_a_class_of_its_own_comes_out_plain():
    assert passes(replace(MOTION, x=MOTION.x.view(Own), y=MOTION.y.astype(np.float32), theta=np.zeros(61, dtype=int)))


@pytest.mark.parametrize("value", [None, "motion", 1.0, {}, Numberless()], ids=lambda value: type(value).__name__)
def test_what_is_no_motion_at_all_is_a_failure_of_the_engine(value):
    assert not passes(value)


@pytest.mark.parametrize(
    "value", [*ODD, 1e101, -1e101, float("inf")], ids=repr if False else lambda v: type(v).__name__
)
def test_a_setting_holds_finite_numbers_and_words(value):
    allowed = type(value) in (int, float, str, bool) and (isinstance(value, str) or abs(value) <= gate.MOST_KNOB)
    try:
        gate.setting(Setting((("h", value),)))
    except (TypeError, ValueError):
        assert not allowed
    else:
        assert allowed


@given(
    st.recursive(st.none() | st.booleans() | st.integers() | st.floats() | st.text(), lambda s: st.lists(s, max_size=3))
)
def test_whatever_stands_in_a_field_comes_out_plain_or_as_a_sentence(value):
    for field in ("x", "status", "cost", "transitions", "slip_resolution", "first_mode"):
        motion = object.__new__(Trajectory)
        vars(motion).update({f.name: getattr(MOTION, f.name) for f in fields(Trajectory)} | {field: value})
        passes(motion)


@pytest.mark.parametrize("raw", ["native", (), [], None, 3, {"native"}])
def test_routes_are_a_tuple_of_names(raw):
    """A text was a route for each of its letters, and no route was no row."""
    assert gate.routes(("native",)) == ("native",)
    with pytest.raises(TypeError, match="give a tuple of names"):
        gate.routes(raw)
