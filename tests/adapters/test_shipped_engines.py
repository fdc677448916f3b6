"""The engines that come as executables: named, refusing, and as good as was measured."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

import cases
import reference
from adapters import Setting, by_process, lookup
from adapters.by_process.bundle import (
    OWN_STEPS,
    version_of,
)
from adapters.processes.pool import WorkerPool
from cases import Belt, Case, CoulombFriction, Drive, Gravity, Start, Unilateral, disc
from cases.library import circle, hill, line
from reports.running import solvers
from reports.running.records import Run
from reports.running.tasks import find_truth, measure
from reports.running.time_limits import RUN_SECONDS

from .test_motions import SCENES

PAPER = "disc_in_circle[mu=0.2]"
NAMES = sorted(by_process.bundled_engines())
# The first transition of the paper's application with h = 1 ms, s: twice what was measured (see the README there).
MOST_OFF = {
    "dartpy": 2e-3,
    "drake": 3e-3,
    "jolt": 3e-2,
    "mujoco": 2e-3,
    "newton": 4e-4,
    "physx": 8e-4,
    "planck": 8e-4,
    "rapier": 1e-2,
    "siconos": 7e-4,
}
# Engines whose friction is another law, by their source: no setting makes a disc slide as it should.
OTHER_FRICTION = {"cannon", "matter"}
RIGHT = sorted(set(NAMES) - OTHER_FRICTION)
RUN_SUPPORTS = ("drake", "mujoco", "siconos")


_ABSENT: dict[str, str] = {}


@pytest.fixture
def engine(request, monkeypatch):
    """The engine of that name, or a skip that tells what to install; an absent one is asked for once."""
    monkeypatch.setenv(lookup.EXECUTABLES, "")
    if request.param not in _ABSENT:
        try:
            return lookup.register(request.param)
        except ImportError as problem:
            _ABSENT[request.param] = str(problem)
    pytest.skip(_ABSENT[request.param])


@pytest.fixture(scope="module")
def pool():
    workers = solvers.pool(1)
    yield workers
    workers.close()


def row(pool: WorkerPool, name: str, label: str, h: float = 1e-3, **knobs) -> Run:
    """The row of a run with steps of at most h, made by a worker as in a build: in its limits and its environment."""
    case = cases.load(label)
    ladder = lookup.engine(name).ladder(case, "process")
    setting = next(each for each in ladder if not each.is_default and each["h"] <= h).but(**knobs)
    # The time limit of a full report: a run takes seconds, on a machine under load minutes.
    call = case, name, "process", setting, 4, find_truth(case)
    ((_, answer),) = pool.run(measure, [call], limit=RUN_SECONDS["full"])
    assert answer.outcome == "done", answer.failure
    return answer.value


every_engine = pytest.mark.parametrize("engine", NAMES, indirect=True)
every_right_engine = pytest.mark.parametrize("engine", RIGHT, indirect=True)


@every_right_engine
def test_the_first_transition_of_the_paper_is_where_it_was_measured(engine, pool):
    found = row(pool, engine, PAPER)
    assert found.outcome == "answered", found.reason
    assert 0.0 < abs(found.ledger[0].error) < MOST_OFF[engine]


@every_right_engine
def test_a_disc_on_a_line_rolls_from_where_it_is_known_to(engine, pool):
    found = row(pool, engine, "disc_on_line[mu=0.1]")
    # MuJoCo's contacts are soft: 3.6 ms at this step with its Runge-Kutta method, and off is 1.06 %.
    good = ("excellent", "very good", "good", *(["rough"] if engine == "mujoco" else []))
    assert found.outcome == "answered" and found.grade in good, found.reason
    assert abs(found.ledger[0].error) < 5e-3


# The greatest and least v_n after an impact over that before, with e = 0.8 and h = 0.2 ms, are within this of e: of the
# gap's change in a step; cannon-es's contacts are soft, and matter-js takes what its displacement was a step before.
OFF_RESTITUTION = {"planck": 2e-3, "rapier": 2e-3, "jolt": 2e-3, "dartpy": 2e-3, "cannon": 0.05, "siconos": 2e-3}


@pytest.mark.parametrize("engine", sorted(OFF_RESTITUTION), indirect=True)
def test_a_disc_rebounds_by_newtons_restitution(engine):
    """Thrown down at 2 m/s it leaves at e times that, less the error of a step."""
    case = cases.load("rebound_with_spin[e=0.8]")
    motion = motion_by(engine, case, 2e-4)
    heights = np.asarray(motion.y) - case.plate.radius
    first = int(np.argmax(np.diff(heights) > 0.0))
    rates = np.diff(heights) / 2e-4
    assert -rates[first + 2] / rates[first - 2] == pytest.approx(0.8, abs=OFF_RESTITUTION[engine])


@pytest.mark.parametrize("e", [0.3, 0.8])
@pytest.mark.parametrize("engine", ["mujoco"], indirect=True)
def test_a_spring_and_a_damper_that_do_not_pull_have_the_restitution_of_their_ratio(engine, e):
    """Without friction. The first step in contact finds an overlap of up to v h, in a spring with k = 1/(2 h)^2: at
    most a quarter of the energy more, and 12 % of the speed."""
    case, adapter = cases.load("rebound_with_spin", e=e, mu=0.0), lookup.engine(engine)
    model = adapter.build(case, "process", Setting.of(h=2e-4))
    adapter.run(model)
    rates = np.asarray(adapter.read(model).vy)
    assert -rates.max() / rates[: int(rates.argmax())].min() == pytest.approx(e, rel=0.12)


@pytest.mark.parametrize("engine", ["cannon", "matter"], indirect=True)
def test_friction_of_another_law_is_a_row_that_is_unusable(engine, pool):
    """Within a step, or a few, the disc rolls: friction does not depend on the normal force there (see the files)."""
    found = row(pool, engine, "disc_on_line[mu=0.1]")
    assert found.outcome == "answered" and found.grade == "unusable", found.reason
    assert found.score.off > 0.5


@pytest.mark.parametrize("engine", ["cannon"], indirect=True)
def test_cannons_friction_is_divided_by_its_step(engine):
    """mu |g| m is the bound of an impulse, not of a force: the first step stops a slip of up to 3 mu g h / h."""
    for h in (4e-3, 1e-3):
        motion = motion_by(engine, cases.load("disc_on_line[mu=0.1]"), h)
        # Coulomb's friction would take mu g h of 1 m/s.
        assert motion.vx[0] - motion.vx[1] > 50 * 0.1 * 9.81 * h


def rolled(name: str):
    """What an engine tells of a disc that rolls all along."""
    return motion_by(name, cases.load("disc_on_incline"), 1e-3)


@every_right_engine
def test_what_rolls_creeps_no_faster_than_is_declared_and_forces_are_told(engine):
    motion = rolled(engine)
    late = motion.t > 0.1
    assert np.abs(motion.slip[late]).max() <= float(motion.slip_resolution)
    # Rolling down an incline of angle a takes a third of the pull, and the track bears m g cos a.
    normal, friction = motion.normal_force[late].mean(), motion.friction_force[late].mean()
    assert normal == pytest.approx(9.81 * np.cos(0.2), rel=2e-2)
    assert friction == pytest.approx(-9.81 * np.sin(0.2) / 3, rel=2e-2)


@pytest.mark.parametrize(
    ("engine", "rounding"), [("physx", 2.0**-23), ("planck", 2.0**-52), ("rapier", 2.0**-23)], indirect=["engine"]
)
def test_rigid_friction_leaves_roundings_alone(engine, rounding):
    motion = rolled(engine)
    assert abs(np.median(motion.slip[len(motion.t) // 2 :])) < 10 * rounding * np.abs(motion.vx).max()


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["siconos"], indirect=True)
def test_siconos_has_the_suites_law_exact_on_a_line_and_of_first_order_in_a_circle(engine, pool):
    assert abs(row(pool, engine, "disc_on_line[mu=0.1]").ledger[0].error) < 1e-14
    coarse, fine = (row(pool, engine, PAPER, h) for h in (2e-3, 1e-3))
    assert [event.pairing for event in fine.ledger] == 4 * ["paired"]
    # Half the step, half the error: the measured ratio is 1.99.
    assert fine.score.off == pytest.approx(coarse.score.off / 2, rel=0.05)


@every_engine
def test_the_engine_as_it_comes_is_the_first_rung_with_its_own_step(engine):
    first = lookup.engine(engine).ladder(cases.load(PAPER), "process")[0]
    assert first.is_default and first["h"] == OWN_STEPS.get(engine, 1 / 60)


@every_engine
def test_what_it_was_not_told_is_refused_in_a_sentence(engine, pool):
    one = row(pool, engine, "disc_rolling_to_rest")
    assert one.outcome == "unsupported" and "RollingResistance" in one.reason and one.reason.endswith(".")


@every_engine
def test_its_version_is_the_engine_s_own_and_the_file_s(engine):
    output = lookup.engine(engine).version()
    assert engine in output and "sha256" in output


def test_an_engine_that_is_not_there_says_what_to_install(monkeypatch, tmp_path):
    # Without node and python3 on the path, none of them starts; Siconos' first line names Debian's own Python.
    monkeypatch.setenv("PATH", str(tmp_path))
    version_of.cache_clear()
    try:
        for name in sorted({*NAMES} - {"siconos"}):
            with pytest.raises(ImportError):
                lookup.register(name)
    finally:
        version_of.cache_clear()


def test_all_are_named():
    assert NAMES == "cannon dartpy drake jolt matter mujoco newton physx planck rapier siconos".split()


@pytest.mark.slow
def test_the_first_line_on_standard_error_of_an_engine_that_fails_in_a_worker_is_in_its_row(tmp_path, monkeypatch):
    engine = tmp_path / "failing"
    engine.write_text(
        "#!/bin/sh\n"
        'case "$1" in --version) echo 1.0; exit;; esac\n'
        "printf 'RangeError: no memory\\n  at line 1\\n  at line 2\\n' >&2\nexit 1\n"
    )
    engine.chmod(0o755)
    monkeypatch.setenv(lookup.EXECUTABLES, "")
    lookup.register(engine)
    workers = solvers.pool(1)  # a worker knows the engines of its start
    try:
        found = row(workers, "failing", "disc_on_line[mu=0.1]")
    finally:
        workers.close()
    assert found.outcome == "crashed" and "RangeError: no memory" in found.reason


# --- scenes beside a disc on a track ----------------------------------------------------------------------------------

GRIP = (Gravity(9.81), CoulombFriction(0.2), Unilateral())
SHAKE = Drive(x="0.05*sin(7*t)")
VARYING = Belt("0.6*t + 0.1*sin(6*t)")
HERE = {
    "belt on a line": lambda: Case(line(0.2), disc(0.1, 1.0), (*GRIP, Belt(-0.9)), Start(0.0, slip=0.9), 0.4),
    "belt on a hill": lambda: Case(hill(1.0), disc(0.1, 1.0), (*GRIP, Belt(0.5)), Start(0.05, slip=-0.5), 0.5),
    "belt on chords": lambda: Case(circle(1.0), disc(0.1, 1.0), (*GRIP, Belt(1.0)), Start(-1.5, slip=-1.0), 0.5),
    "varying belt": lambda: Case(line(), disc(0.1, 2.0), (*GRIP, VARYING), Start(0.0), 1.5),
    "shaken line": lambda: Case(line(), disc(0.1, 2.0), (*GRIP, SHAKE), Start(0.0), 1.0),
    "shaken hill": lambda: Case(hill(1.0), disc(0.1, 2.0), (*GRIP, SHAKE), Start(0.0), 0.5),
    **{name: SCENES[name] for name in ("groove", "Reuleaux wheel", "block on a hill")},
}


def scene_of(label: str) -> Case:
    """The scene of that name, or the case of the catalogue."""
    return HERE[label]() if label in HERE else cases.load(label)


def motion_by(name: str, case: Case, h: float):
    """The motion of a case by an executable with a step of h (s)."""
    adapter = lookup.engine(name)
    model = adapter.build(case, "process", Setting.of(h=h))
    adapter.run(model)
    return adapter.read(model)


# Engine, scene, the largest distance (m) of the centre from the reference's at the finer step (twice what was measured;
# of corners 1.5 times), steps (s), and the share of the distance at the coarser one that it has to be below. Without
# its belt or its drive a disc would be centimetres away; MuJoCo's soft contacts are off by 4e-4 m without a belt too.
ROWS = [
    ("mujoco", "belt on a line", 2e-3, 1e-3), ("planck", "belt on a line", 2e-3, 1e-3),
    ("mujoco", "belt on a hill", 2e-3, 1e-3), ("planck", "belt on a hill", 2e-3, 1e-3),
    ("mujoco", "belt on chords", 2e-3, 1e-3), ("planck", "belt on chords", 2e-3, 1e-3),
    ("mujoco", "varying belt", 6e-4, 1e-3, 4e-3, 0.4),
    ("mujoco", "shaken line", 6e-4, 1e-3, 4e-3, 0.4), ("drake", "shaken line", 6e-4, 1e-3),
    ("mujoco", "shaken hill", 6e-4, 1e-3, 4e-3, 0.4), ("drake", "shaken hill", 6e-4, 1e-3),
    ("drake", "disc_spinning_in_v", 4e-5, 1e-3), ("drake", "groove", 6e-3, 1e-3), ("mujoco", "groove", 6e-3, 1e-3),
    ("mujoco", "rocking_block", 6e-3, 1e-3), ("mujoco", "ladder_at_wall[mu=0.1,mu_wall=0.2]", 4e-2, 1e-3),
    ("mujoco", "Reuleaux wheel", 5.4e-3, 1e-3), ("mujoco", "block on a hill", inf, 1e-3, 4e-3, 0.3),
    # The suite's law at both planes: exact to rounding while both slip, of first order where impacts hand over.
    ("siconos", "disc_spinning_in_v", 1e-11, 4e-3), ("siconos", "groove", 1.4e-2, 2e-3, 8e-3, 0.4),
]  # fmt: skip


@pytest.mark.parametrize(
    ("engine", "label", "most", "h", "coarse", "share"),
    [(*row, *(0.0, 1.0)[len(row) - 4 :]) if len(row) == 4 else row for row in ROWS],
    indirect=["engine"],
)
def test_engines_run_the_scenes_that_they_support(engine, label, most, h, coarse, share):
    case = scene_of(label)

    def off(moved) -> float:
        exact = reference.simulate(case)(moved.t)
        return float(np.hypot(moved.x - exact.x, moved.y - exact.y).max())

    moved = motion_by(engine, case, h)
    assert off(moved) < most and (not coarse or off(moved) < share * off(motion_by(engine, case, coarse)))
    if "belt" in label:
        assert np.median(np.abs(moved.slip - reference.simulate(case)(moved.t).slip)) < 1e-2
    if case.supports:
        assert set(reference.simulate(case).contact_names) <= set(moved.contact_names)


def belt_of_a_support() -> Case:
    case = cases.load("disc_spinning_in_v")
    (support,) = case.supports
    return replace(case, supports=(replace(support, effects=(CoulombFriction(0.3), Belt(1.0))),))


ON_BELT = Case(line(), disc(0.1, 1.0), (*GRIP, Belt("t")), Start(0.0), 0.4)
REJECTS = [
    ("drake", ON_BELT, "no surface velocity"), ("dartpy", ON_BELT, "not among the bindings"),
    ("planck", ON_BELT, "belts of constant speed here"), ("rapier", ON_BELT, "no implementation here of Belt"),
    ("drake", belt_of_a_support(), "no surface velocity"), ("siconos", belt_of_a_support(), "of Belt"),
    ("mujoco", cases.load("stribeck_disc"), "no implementation here of friction that depends on the slip"),
    ("rapier", cases.load("stribeck_disc"), "no implementation here of friction that depends on the slip"),
    *((name, HERE["shaken line"](), "Drive") for name in NAMES if name not in ("drake", "mujoco")),
    *((name, cases.load("disc_spinning_in_v"), "Supports") for name in NAMES if name not in RUN_SUPPORTS),
    *((name, cases.load("disc_on_free_disc"), "FreePlates") for name in NAMES if name not in ("drake", "mujoco")),
]  # fmt: skip


@pytest.mark.parametrize(
    ("engine", "case", "words"), REJECTS, ids=[f"{n}-{w}" for n, _, w in REJECTS], indirect=["engine"]
)
def test_what_an_engine_cannot_run_is_rejected_in_a_sentence_with_the_reason(engine, case, words):
    with pytest.raises(cases.NotSupported, match=words) as problem:
        motion_by(engine, case, 1e-2)
    assert str(problem.value).endswith(".")
