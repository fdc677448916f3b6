"""The engines that come as executables: named, refusing, and as good as was measured."""

import pytest

import cases
from adapters import by_process, interface
from adapters.by_process.shipped import told
from cases.errors import UnknownName
from reports.running.tasks import find_truth, perform

PAPER = "disc_in_circle[mu=0.2]"
NAMES = sorted(by_process.shipped())
# The first transition of the paper's application with h = 1 ms, s: twice what was measured (see the README there).
MOST_OFF = {"drake": 3e-3, "mujoco": 1e-2, "planck": 2e-4, "rapier": 1e-2}


@pytest.fixture
def engine(request, monkeypatch):
    """The engine of that name, or a skip that tells what to install."""
    monkeypatch.setenv(interface.EXECUTABLES, "")
    try:
        return interface.register(request.param)
    except ImportError as problem:
        pytest.skip(str(problem))


def row(name: str, label: str, h: float = 1e-3):
    case = cases.load(label)
    setting = next(each for each in interface.engine(name).ladder(case, "process") if each["h"] <= h)
    return perform(case, name, "process", setting, 4, find_truth(case))


every_engine = pytest.mark.parametrize("engine", NAMES, indirect=True)


@every_engine
def test_the_first_transition_of_the_paper_is_where_it_was_measured(engine):
    found = row(engine, PAPER)
    assert found.outcome in ("right", "wrong"), found.reason
    assert 0.0 < abs(found.ledger[0].error) < MOST_OFF[engine]


@every_engine
def test_a_disc_on_a_line_rolls_from_where_it_is_known_to(engine):
    found = row(engine, "disc_on_line[mu=0.1]")
    assert (found.outcome, found.reason) == ("right", "")
    # MuJoCo's and Rapier's contacts are soft: 1 ms and some at this step.
    assert abs(found.ledger[0].error) < 5e-3


@every_engine
def test_what_it_was_not_told_is_refused_in_a_sentence(engine):
    found = row(engine, "bouncing_disc")
    assert found.outcome == "refused" and "Impact" in found.reason and found.reason.endswith(".")


@every_engine
def test_its_version_is_the_engine_s_own_and_the_file_s(engine):
    told = interface.engine(engine).version()
    assert engine in told and "sha256" in told


def test_an_engine_that_is_not_there_says_what_to_install(monkeypatch, tmp_path):
    # Without node and python3 on the path, none of them starts.
    monkeypatch.setenv("PATH", str(tmp_path))
    told.cache_clear()
    try:
        for name in NAMES:
            with pytest.raises(ImportError):
                interface.register(name)
    finally:
        told.cache_clear()


def test_all_are_named_and_an_unknown_name_is_none():
    assert NAMES == ["drake", "mujoco", "planck", "rapier"]
    with pytest.raises(UnknownName):
        interface.find("no_such_engine")
