"""Tests of an engine for pytest: the engine's motions are compared with the kept truth (`pytest_slip_to_roll`).

Each test runs one case at one step and passes if the grade of its motion is at least `--slip-to-roll-grade`. It is
skipped, with the reason, if the samples do not decide that, or if the engine does not support the case. A case without
truth is an error of the suite: its test ends as an error, not as a failure of the engine. An engine that supports none
of its cases fails the session.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from math import inf, isfinite
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import adapters
import cases
from adapters import Setting
from cases import BadValue, Case, CaseError, lookup
from cases.errors import unknown_name

from .judging.grades import LIMITS, Grade, is_within, summary
from .judging.ledger import LedgerRow
from .running.records import Run
from .running.tasks import attempt, find_truth, measure, survey

# What an engine with friction has to get right, and a case for each: short motions with a kept truth.
PHENOMENA = {
    "slide_to_roll": "disc_on_line[mu=0.1]",
    "cone_holds": "disc_on_incline[slope=0.2]",
    "cone_slips": "disc_on_incline[slope=0.4]",
    "slip_reversal": "disc_in_circle[mu=0.2]",
    "restitution": "bouncing_disc[e=0.5,slip=0]",
    "rolling_resistance": "disc_rolling_to_rest",
}
# The case in which rolling has to be free of creep: the contact point of a disc that rolls down an incline.
CREEP = "disc_on_incline[slope=0.2]"
# The engine of a test, in the properties of its report: reports also come from the processes of pytest-xdist.
ENGINE = "slip-to-roll engine"
# Creep above this part of the disc's speed is an error: it is then visible in the motion.
MOST_CREEP = 0.01


class _Check(NamedTuple):
    """A test: its name, the engine and its route, the case, and whether the creep is checked instead of the grade."""

    name: str
    engine: str
    route: str
    case: Case
    of_creep: bool = False


def tests(session: pytest.Session, config: pytest.Config) -> list[pytest.Item]:
    """The tests of the engines that the options name; raises UsageError for invalid options."""
    try:
        _check_options(config)
        engines = config.getoption("--slip-to-roll-engine")
        checks = [check for engine in engines for check in _checks(engine, config.getoption("--case-file"))]
    except (CaseError, ImportError) as problem:
        raise pytest.UsageError(str(problem)) from None
    names = [f"{check.engine}-{check.name}" for check in checks]
    # The part before the colons is the class in JUnit's XML, by which dashboards group tests.
    return [
        EngineTest.from_parent(session, name=name, nodeid=f"slip-to-roll::{name}", check=check)
        for name, check in zip(names, checks, strict=True)
    ]


def _check_options(config: pytest.Config) -> None:
    """Raise BadValue for an invalid step or grade."""
    text = config.getoption("--slip-to-roll-step")
    try:
        step = float(text)
    except ValueError:
        step = 0.0
    if not 0.0 < step < inf:
        raise BadValue(f"--slip-to-roll-step is {text!r}; give a step in s, for example 1e-3")
    grades = [str(grade) for grade in LIMITS]
    if config.getoption("--slip-to-roll-grade") not in grades:
        raise unknown_name("grade", config.getoption("--slip-to-roll-grade"), grades)


def _checks(engine: str, files: list[str]) -> Iterator[_Check]:
    """The tests of an engine: those of the cases in the files, or of all phenomena."""
    name = engine if engine in adapters.engines() else _registered(engine)
    own = [case for file in files for one in lookup.load_file(file) for case in lookup.case_name(one).every()]
    for route in adapters.engine(name).routes:
        suffix = "" if route == "process" else f"-{route}"
        if own:
            yield from (_Check(f"{case.label}{suffix}", name, route, case) for case in own)
            continue
        for phenomenon, label in PHENOMENA.items():
            yield _Check(f"{phenomenon}{suffix}", name, route, cases.select(label)[0])
        yield _Check(f"creep{suffix}", name, route, cases.load(CREEP), of_creep=True)


def _registered(engine: str) -> str:
    """The name of an executable, registered as an engine; raises UnknownName for a word that is near an adapter's."""
    names = adapters.engines()
    if Path(engine).name == engine and not Path(engine).exists() and get_close_matches(engine, names):
        raise unknown_name("engine", engine, names)
    return adapters.lookup.register(engine)


class EngineTest(pytest.Item):
    """The comparison of one engine with the truth of one case."""

    def __init__(self, *, check: _Check, **how: Any):
        super().__init__(**how)
        self.check = check
        self.user_properties.append((ENGINE, check.engine))

    def setup(self) -> None:
        """Run the engine; skipped if the engine does not support the case, an error if the suite has no truth of it."""
        self.run = self._run()
        if self.run.outcome == "unsupported":
            pytest.skip(f"unsupported: {self.run.reason}")

    def runtest(self) -> None:
        """Fail with the diagnosis of the motion if it is not good enough."""
        run = self.run
        if run.outcome != "answered" or run.score is None:
            pytest.fail(f"{self.check.case.label}, {run.setting}: {run.outcome}: {run.reason}", pytrace=False)
        if self.check.of_creep:
            self._check_creep(run)
        else:
            self._check_grade(run)

    def reportinfo(self) -> tuple[Any, int | None, str]:
        """Where the test is, for pytest's reports."""
        return self.path, None, f"slip-to-roll: {self.name}"

    def _run(self) -> Run:
        """The engine's judged motion; the truth is the kept one for a case of the catalogue."""
        check = self.check
        if check.route == "process":
            setting = Setting.of(h=float(self.config.getoption("--slip-to-roll-step")))
        else:
            (offer,) = (one for one in survey(check.case, check.engine) if one.route == check.route)
            if offer.outcome == "unsupported":
                pytest.skip(f"unsupported: {offer.reason}")
            if offer.outcome or not offer.settings:
                pytest.fail(f"{check.case.label}: {offer.reason or 'the ladder has no setting for it'}", pytrace=False)
            setting = offer.settings[-2:][0]
        self.truth = truth = find_truth(check.case)
        if not truth.failure:
            return measure(check.case, check.engine, check.route, setting, 1, truth)
        row = Run(check.case.label, check.engine, check.route, setting, 1, outcome="")
        run, motion = attempt(row, check.case)
        if motion is not None:
            pytest.fail(
                f"slip-to-roll has no truth of this case, which is no fault of the engine: {truth.failure}", False
            )
        return run

    def _check_grade(self, run: Run) -> None:
        assert run.score is not None, "an answered run has a score"
        worst = Grade(self.config.getoption("--slip-to-roll-grade"))
        is_right = is_within(run.score, LIMITS[worst])
        words = f"{run.case}, {run.setting}: {summary(run.score, run.friction_factor, run.reason)}"
        if is_right is None:
            pytest.skip(f"not decided by its samples: {words}")
        if not is_right:
            off, limit = apart(100.0 * run.score.off, 100.0 * LIMITS[worst])
            pytest.fail(
                f"{words}; off is {off} %, and {worst} is at most {limit} % of the error of ignoring friction\n"
                f"{_transitions(run)}",
                pytrace=False,
            )

    def _check_creep(self, run: Run) -> None:
        assert run.score is not None, "an answered run has a score"
        case = self.check.case
        # The disc ends faster than anywhere before; its creep is compared with that speed.
        speed = abs(float(self.truth.samples["x"][-1] + run.off["x"][-1] - self.truth.samples["x"][0])) / case.duration
        if not isfinite(run.score.creep):
            pytest.fail(f"{run.case}: the creep is not known: too few samples where the truth rolls", pytrace=False)
        if run.score.creep > MOST_CREEP * speed:
            creep, limit = apart(run.score.creep, MOST_CREEP * speed)
            pytest.fail(
                f"{run.case}, {run.setting}: the contact creeps at {creep} m/s, and at most {limit} m/s is right, "
                f"{MOST_CREEP:.0%} of the disc's mean speed of {speed:.2g} m/s",
                pytrace=False,
            )


def refusing(reports: Iterable[pytest.TestReport]) -> list[str]:
    """The engines that supported none of the cases of these reports, in the order of their first report."""
    outcomes: dict[str, set[str]] = {}
    for report in reports:
        for name, engine in report.user_properties:
            if name == ENGINE:
                outcomes.setdefault(str(engine), set()).add("skipped" if report.skipped else report.when or "")
    # Each test also has a report of its end.
    return [engine for engine, those in outcomes.items() if those <= {"skipped", "teardown"}]


def apart(value: float, limit: float) -> tuple[str, str]:
    """Both numbers with so many digits, at least two, that they differ as texts."""
    for digits in range(2, 17):
        own, other = (f"{float(f'{x:.{digits}g}'):.{max(digits, 6)}g}" for x in (value, limit))
        if own != other:
            break
    return own, other


def _transitions(run: Run) -> str:
    """The transitions of a motion next to the truth's, in lines."""
    rows = [f"  {row.pairing}: {row.before} -> {row.after} {_times(row)}" for row in run.ledger]
    return "\n".join(["transitions:", *rows]) if rows else "no transitions"


def _times(row: LedgerRow) -> str:
    """The times of a transition, that of the engine and the true one; "missing" for one that there is not."""
    own = f"at {row.time:.6g} s" if isfinite(row.time) else "missing"
    return f"{own}, truth {f'{row.reference_time:.6g} s' if row.is_true else 'missing'}"
