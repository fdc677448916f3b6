"""Every type of answer that goes to the store comes back from it, whichever study or step keeps it."""

import ast
import dataclasses
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, get_type_hints

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as of_numpy

import cases
import cases.motion.trajectory
import reports
from cases import Trajectory
from cases.motion.trajectory import State
from reports.running import calls
from reports.running.storage.result_store import Store
from reports.studies.stability import study as stability

from .identical import identical

ROOT = Path(reports.__file__).parent
# The methods of `Calls` that keep answers, the modules that pass on what they are given to keep, and a function whose
# first argument has the answers that are kept.
KEEPING, PASSING, KEEPS_FIRST = {"all", "each"}, {"reports.running.calls"}, "together"


def modules() -> list[str]:
    files = sorted(ROOT.rglob("*.py"))
    return [".".join(file.relative_to(ROOT.parent).with_suffix("").parts).removesuffix(".__init__") for file in files]


def kept_by(module: str) -> list[str]:
    """The functions whose answers a module has kept, by their names there; the calls are found in its code."""
    source = Path(ROOT.parent, *module.split(".")).with_suffix(".py")
    source = source if source.exists() else source.with_suffix("") / "__init__.py"
    text, found = source.read_text(), []
    for node in ast.walk(ast.parse(text)) if "keep=" in text else ():  # parsing is slow
        if isinstance(node, ast.Call) and any(word.arg == "keep" for word in node.keywords) and module not in PASSING:
            if isinstance(node.func, ast.Attribute) and node.func.attr in KEEPING:
                found.append(ast.unparse(node.args[1]))
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == KEEPS_FIRST:
            found.append(ast.unparse(node.args[0]))
    return [name for name in found if name != "function"]  # an argument of `together`


FUNCTIONS = [(module, name) for module in modules() for name in kept_by(module)]


def answer_of(module: str, name: str) -> Any:
    """What a function says that it returns."""
    function = import_module(module)
    for part in name.split("."):
        function = getattr(function, part)
    return get_type_hints(function)["return"]


# --- answers of every type --------------------------------------------------------------------------------------------

NUMBERS = st.floats() | st.sampled_from([-0.0, 5e-324, 1 / 3])  # NaN, infinities
TEXTS = st.text(max_size=8)
ARRAYS = of_numpy.arrays(
    st.sampled_from([np.float64, np.uint8, np.int64]), st.sampled_from([(0,), (3,), (2, 2)]), fill=st.nothing()
)


@st.composite
def motions(draw) -> Trajectory:
    """A motion as it travels: without a dense output, without its case, and with one contact and one plate."""
    length = draw(st.integers(0, 4))
    columns = {name: draw(of_numpy.arrays(np.float64, (length,), fill=st.nothing())) for name in ("t", *State._fields)}
    rest = {
        f.name: draw(st.from_type(hints[f.name]))
        for hints in [get_type_hints(Trajectory, vars(cases.motion.trajectory), vars(cases) | {"Case": cases.Case})]
        for f in dataclasses.fields(Trajectory)
        if f.name not in (*columns, "dense", "case", "contact_columns", "plate_columns", "impulses")
    }
    return Trajectory(**columns, **rest)


st.register_type_strategy(float, NUMBERS)
st.register_type_strategy(int, st.integers(-(2**70), 2**70))
st.register_type_strategy(str, TEXTS)
st.register_type_strategy(np.ndarray, ARRAYS)
st.register_type_strategy(Trajectory, motions())


def came_back(kind: Any, answer: Any) -> bool:
    with TemporaryDirectory() as folder:
        Store(Path(folder)).put("trial", {"key": 1}, answer, kind)
        store = Store(Path(folder))
        found = store.get("trial", {"key": 1}, kind)
        assert store.trouble() == []
    return identical(found, answer)


def test_the_functions_whose_answers_are_kept_are_found():
    """Those of every step and study that has some; a new one is found by its `keep=`."""
    assert {name for _, name in FUNCTIONS} >= {
        "clock.time_all", "cold_start.first_calls", "time_breakdown.parts_of_all", "find_truth", "measure",
        "scene_of",
    }  # fmt: skip


@pytest.mark.parametrize(("module", "name"), FUNCTIONS, ids=[f"{m.split('.')[-1]}-{n}" for m, n in FUNCTIONS])
@settings(max_examples=10, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_an_answer_of_every_kept_type_comes_back_to_the_last_bit(module, name, data):
    kind = answer_of(module, name)
    answer = data.draw(st.from_type(kind))
    assert came_back(kind, answer)


@given(st.from_type(calls._Failure))
def test_a_failure_comes_back(failure):
    assert came_back(calls._Failure, failure)


def test_a_hard_scene_comes_back():
    scene = stability.scene_of(cases.select("incline_at_the_cone")[-1])
    assert not scene.truth.failure and came_back(stability.HardScene, scene)
