"""What decides a run: the key under which it is kept."""

import dataclasses
import os
from copy import deepcopy
from functools import cache, partial
from importlib.metadata import EntryPoint

import numpy as np
import pytest

import cases
from adapters import Setting
from cases import Mode, Transition
from reports import studies
from reports.running import calls, experiment, tasks
from reports.running.calls import Calls
from reports.running.records import Truth
from reports.running.storage import fingerprint, source_code
from tests.style.test_architecture import imported, modules

TRUTH = Truth("taylor", (Transition(1 / 3, Mode.SLIDE, Mode.ROLL),), (1e-17,), Mode.SLIDE)


INSTALLED = fingerprint.installed_packages


def _without(package: str, other: str) -> str:
    """The version of `other` as it is installed or not, and of `package` another one."""
    return "0" if other == package else INSTALLED(other)


CASE_FILE = """
from cases import Case, CoulombFriction, Gravity, Start, Unilateral, case, disc
from cases.library import line

@case
def bowled_in_a_file(mu=0.1):
    "{docstring}"
    return Case(
        track=line({slope}), plate=disc(0.1, {mass}), effects=({effects}),
        start=Start(0.0, slip={slip}), duration={duration},
    )
"""
AS_IT_IS = dict(
    docstring="A disc.", slope=0.0, mass=1.0, slip=1.0, duration=1.0,
    effects="Gravity(9.81), CoulombFriction(mu), Unilateral()",
)  # fmt: skip
VERSIONS = {"pymunk": "7.2.0", "reference": "0.1.0"}


def written(tmp_path, **changes) -> cases.Case:
    file = tmp_path / "own.py"
    file.write_text(CASE_FILE.format(**AS_IT_IS | changes))
    os.utime(file, (1e9, 1e9))  # edits within one second, which a cache of compiled files would not notice
    cases.load_file(file)
    return cases.load("bowled_in_a_file")


def run_key(case, solver="pymunk", route="native", versions=None, truth=TRUTH, rung=1, **knobs):
    call = (case, solver, route, Setting.of(**(knobs or {"h": 0.1})), rung, truth)
    return Calls(versions=VERSIONS if versions is None else versions).key(tasks.measure, call, experiment._KEEP_RUN)


@pytest.mark.parametrize(
    "changes",
    [
        dict(slope=0.001),
        dict(mass=1.0 + 1e-15),
        dict(slip=2.0),
        dict(duration=1.5),
        dict(effects="Gravity(9.81), CoulombFriction(mu, mu_static=0.2), Unilateral()"),
        dict(effects="Gravity(9.81), CoulombFriction(mu)"),
    ],
    ids=str,
)
def test_a_case_file_edited_under_the_same_name_is_another_case(changes, tmp_path, catalogue):
    before = run_key(written(tmp_path))
    after = run_key(written(tmp_path, **changes))
    assert before["case"] == after["case"] and before != after
    assert [file.name for file in tmp_path.iterdir()] == ["own.py"]  # nothing is left beside a user's file


def test_every_case_of_the_catalogue_can_be_told_from_every_other():
    output = [fingerprint.content(case) for name in cases.names() for case in cases.select(name)]
    assert None not in output and len(set(output)) == len(output)


def test_a_key_tells_solver_route_setting_versions_and_truth():
    case = cases.load("disc_on_line")
    keys = [
        run_key(case),
        run_key(case, route="assisted"),
        run_key(case, h=0.1 + 1e-15),
        run_key(case, n=0.1),
        run_key(case, solver="reference"),
        run_key(case, versions={"pymunk": "7.3.0"}),
        run_key(case, truth=Truth(failure="none")),
        run_key(cases.load("disc_on_line", mu=0.2)),
        run_key(cases.load("disc_on_line", mu=0.1)),
    ]
    assert len({fingerprint.digest(key) for key in keys}) == len(keys)
    assert run_key(case) == run_key(cases.load("disc_on_line")) == run_key(case, rung=2)


# Every package that can change a digit of a result: the list of `fingerprint` is not asked for it.
@pytest.mark.parametrize(
    "name, value",
    [
        ("machine", lambda: "another"),
        ("processor", lambda: "another"),
        ("os", type("S", (), {"cpu_count": lambda: 1000})),
        *(
            ("installed_packages", partial(_without, package))
            for package in ("numpy", "scipy", "sympy", "mpmath", "heyoka")
        ),
        ("sys", type("S", (), {"version": "3.99.0 (main)"})),
    ],
)
def test_a_key_tells_machine_packages_and_python(name, value, monkeypatch):
    case = cases.load("disc_on_line")
    before = run_key(case)
    monkeypatch.setattr(fingerprint, name, value)
    fingerprint.surroundings.cache_clear()
    try:
        assert run_key(case) != before
    finally:
        fingerprint.surroundings.cache_clear()


@pytest.mark.parametrize(
    "one, other",
    [
        (np.zeros(4), np.zeros((2, 2))),
        (np.zeros(4), np.zeros(4, dtype=np.int64)),
        (np.array([1.0, 2.0]), np.array([1.0, 2.0 + 1e-15])),
        (Truth(samples={"t": np.zeros(3)}), Truth(samples={"x": np.zeros(3)})),
        (np.float64(1.0), np.float32(1.0)),
        (1, 1.0),
        ({"a": 1}, {"a": 2}),
        ((0.5, 1.0), (0.5, 2.0)),
        (cases.Start(0.5), cases.Gravity(0.5)),
        (cases.Curve(("s", "0"), (0.0, 1.0)), cases.Curve(("s", "0"), (0.0, 2.0))),
        ("x" * 5000, "x" * 5001),
        [dataclasses.make_dataclass(name, [("x", float)])(1.0) for name in ("Friction", "Rolling")],
    ],
)
def test_arguments_that_differ_have_other_keys(one, other):
    assert fingerprint.of_argument(one) != fingerprint.of_argument(other)
    assert fingerprint.of_argument(one) == fingerprint.of_argument(deepcopy(one)) is not None


def test_what_cannot_be_compared_has_no_key_and_is_not_kept():
    call = (cases.load("disc_on_line"), "pymunk", "native", Setting.of(h=0.1), 1, lambda: None)
    assert Calls(versions=VERSIONS).key(tasks.measure, call, experiment._KEEP_RUN) is None
    assert run_key(cases.load("disc_on_line"), versions={"pymunk": ""}) is None
    assert fingerprint.of_argument(np.array([print], dtype=object)) is None


def test_a_key_tells_adapters_code_function_and_truths(monkeypatch, tmp_path):
    """Each by what changes it; code that is apart changes nothing."""
    case = cases.load("disc_on_line")
    before = run_key(case)
    for name, changed in (("adapter_sources", "adapters"), ("sources", "code")):
        with monkeypatch.context() as patch:
            found = getattr(calls if name == "sources" else fingerprint, name)
            patch.setattr(calls if name == "sources" else fingerprint, name, lambda *given, f=found: f"{f(*given)}+")
            after = run_key(case)
        assert before != after and {k for k in before if before[k] != after[k]} == {changed}
    call = (case, "pymunk", "native", Setting.of(h=0.1), 1, TRUTH)
    made = Calls(versions=VERSIONS)
    one, other = (made.key(function, call, experiment._KEEP_RUN) for function in (tasks.measure, tasks.motion_of))
    assert {name for name in one if one[name] != other[name]} == {"function"}
    apart, whole = fingerprint.sources(tasks, experiment.TRUTHS_OWN), fingerprint.sources(tasks)
    assert apart != whole and run_key(case)["code"] == apart

    file = tmp_path / "truth.json"
    digests = []
    for text in ("{}", "{ }"):
        file.write_text(text)
        monkeypatch.setattr(fingerprint.certification, "TRUTH", file)
        fingerprint.truth_key.cache_clear()
        digests.append(fingerprint.truth_key())
    fingerprint.truth_key.cache_clear()
    assert digests[0] != digests[1]


def test_an_engine_s_key_tells_its_adapter_and_what_judges_it_and_no_other_engine():
    ours = source_code.dependency_files("adapters.pymunk", ()).keys()
    assert {"adapters.pymunk", "adapters.pymunk.native", "adapters.interface", "cases.contact"} <= ours
    assert not any("exudyn" in name or name.startswith("reference") for name in ours)
    judge = source_code.dependency_files(
        "reports.running.tasks", tuple(m.__name__ for m in experiment.TRUTHS_OWN)
    ).keys()
    assert {"reports.running.tasks", "reports.judging.slip_phases", "cases.motion.trajectory"} <= judge
    assert not any(name.startswith("reference") for name in judge)
    truth = source_code.dependency_files("reports.running.tasks", ()).keys()
    assert {"reference.solve", "reference.certification.certificate", "reference.minimal.elimination"} <= truth


@cache
def import_graph() -> dict[str, set[str]]:
    known = {name: path for room in source_code.SUITE for name, path in modules(room).items()}
    graph = {name: imported(path) & known.keys() - {name} for name, path in known.items()}
    graph["adapters.lookup"] -= {"adapters.by_process"}
    for name in known:
        if name.startswith(("cases.", "reference.")) and not name.startswith("cases.pictures"):
            graph[name] = {other for other in graph[name] if not other.startswith("cases.pictures")}
    return graph


def reached(start: str, graph: dict[str, set[str]]) -> set[str]:
    """All that a module imports, directly or not."""
    found, waiting = set(), [start]
    while waiting:
        for name in graph[waiting.pop()] - found:
            found.add(name)
            waiting.append(name)
    return found


@pytest.mark.parametrize(
    "module",
    [
        "reports.running.tasks", "reports.running.timing.clock", "reports.drawing.figures", "reports.page.pictures",
        "reference.sweeping.table", "adapters.pymunk", "adapters.exudyn", "adapters.by_process",
        *(f"reports.studies.{name}" for name in studies.names()),
    ],
)  # fmt: skip
def test_code_includes_all_that_a_module_imports(module):
    """Directly or not, except for methods that draw, and for adapters, which have keys of their own."""
    reachable = {name for name in reached(module, import_graph()) if "." in name} - {"cases.catalogue"}
    assert reachable <= source_code.dependency_files(module, ()).keys()


def test_code_is_told_apart_by_what_it_does_not_by_its_layout(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "an_engine_of_tests"
    package.mkdir()
    (package / "__init__.py").write_text("raise RuntimeError('asking must not wake it')\n")
    (package / "adapter.py").write_text("from ._knobs import h\n")
    (package / "_knobs.py").write_text("h = 0.1\n")
    point = EntryPoint("an_engine_of_tests", "an_engine_of_tests.adapter", source_code.GROUP)
    monkeypatch.setattr(source_code, "entry_points", lambda group, name=None: [point])

    def output() -> str:
        for cached in (fingerprint.adapter_sources, source_code.of, source_code.tree_of):
            cached.cache_clear()
        return fingerprint.adapter_sources("an_engine_of_tests")

    before = output()
    (package / "_knobs.py").write_text("# ten centimetres\nh   =   0.1\n")
    assert output() == before
    (package / "_knobs.py").write_text("h = 0.2\n")
    assert output() != before
