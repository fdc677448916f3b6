"""What every test has: fixtures, options, and the table of cross-checks that pytest prints at its end.

A motion for which no method is named is DOP853's, as it compiles nothing, but in `tests/taylor` and in files that have
its fixture; with `--thorough` it is that of the default method, and hypothesis draws other examples at each run.
"""

from __future__ import annotations

import gc
import os
import tempfile
from collections.abc import Callable
from contextlib import contextmanager
from math import inf, isnan
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import cases
from cases import CaseError, lookup, registry
from reports.running import cache_folder
from tests import own_cases

# "same": what fails is the change, not the draw. No test is slow by hypothesis' clock: on a busy machine any would be.
settings.register_profile("same", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("other", deadline=None)


def pytest_addoption(parser, pluginmanager):
    """--thorough, and --case-file=FILE (with the =, else pytest takes FILE for a test file)."""
    parser.addoption("--thorough", action="store_true", help="the default method, and other random examples each time")
    if not pluginmanager.hasplugin("slip_to_roll"):  # the installed plugin has the option
        parser.addoption("--case-file", action="append", default=[], metavar="FILE", help="test the cases of this file")


def pytest_configure(config):
    """Choose what is drawn; load the case files; one line says what is wrong with one."""
    os.environ.setdefault(cache_folder.VARIABLE, cache_folder.OFF)
    gc.set_threshold(50_000, 20, 20)  # looking for garbage after every 700 new objects takes 10 s of CPU
    settings.load_profile("other" if config.getoption("--thorough") else "same")
    files = config.getoption("--case-file")
    try:
        own_cases.CASES += own_cases.variants([name for file in files for name in lookup.load_file(file)])
    except CaseError as problem:
        raise pytest.UsageError(str(problem)) from None
    if files and config.args_source is not pytest.Config.ArgsSource.ARGS:
        config.args = [str(Path(__file__).parent / "taylor" / "test_any_case.py")]


@pytest.fixture(autouse=True, scope="session")
def _store(tmp_path_factory):
    """The command keeps what the tests run in a folder of theirs, not where somebody works, and makes one run at a time
    where a test does not name another number: a second worker imports everything once more, 2 s of CPU, and the tests
    themselves occupy both cores."""
    from reports import options

    options.STORE = str(tmp_path_factory.mktemp("kept") / "store")
    options._OPTIONS["jobs"]["default"] = "1"


@pytest.fixture(autouse=True, scope="module")
def default_method(request):
    """DOP853 where no method is named; see the module."""
    with pytest.MonkeyPatch.context() as patch:
        if not request.config.getoption("--thorough"):
            patch.setattr("reference.solve.METHODS", ("dop853",))
        yield


@pytest.fixture
def catalogue(monkeypatch) -> None:
    """A catalogue that forgets what a test adds to it."""
    cases.names()  # it is loaded when it is first asked for
    monkeypatch.setattr(registry, "_entries", dict(registry._entries))


@pytest.fixture(scope="session")
def without_figures() -> Callable:
    """In `with without_figures():` a report is made without its figures, which are half of what a small one costs: for
    tests of what stands in its tables."""

    @contextmanager
    def undrawn():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("reports.page.pictures.draw", lambda *_: [])
            yield

    return undrawn


@pytest.fixture(scope="session")
def in_process() -> Callable:
    """In `with in_process():` workers' calls are made in this process: starting workers is most of the cost of a small
    report. For tests of a command's files and words; that calls are separated is tested elsewhere."""
    from adapters.processes import pool, worker

    def run(self, function, arguments, limit=60.0, skip=lambda index: None, groups=(), brief=False):
        for i, args in enumerate(arguments):
            yield i, skip(i) or worker._call(function, args, Path(tempfile.mkdtemp()))

    @contextmanager
    def patched():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(pool.WorkerPool, "run", run)
            patch.setattr(pool.WorkerPool, "begin", lambda self, groups, preload: None)
            yield

    return patched


@pytest.fixture
def accuracy(request) -> Callable[..., None]:
    """accuracy(case=, solver=, route=, quantity=, error=, tolerance=) notes the row and asserts |error| <= tolerance.

    The row is noted before the assertion, so that a failed cross-check is listed with the others. A NaN fails.
    """

    def check(*, case: str, solver: str, route: str, quantity: str, error: float, tolerance: float) -> None:
        # User properties travel with the test report, also from the workers of pytest-xdist.
        row = (case, solver, route, quantity, float(error), float(tolerance))
        request.node.user_properties.append(("accuracy", row))
        assert abs(error) <= tolerance, (
            f"{case}, {solver}/{route}: {quantity} is off by {error:.3g}, allowed {tolerance:.3g}"
        )

    return check


def pytest_terminal_summary(terminalreporter):
    """What the fuzz tried; and the worst margin of each claim, which is a test with all its scenes, and one verdict."""
    tried = sorted(row for _, row in noted(terminalreporter, "fuzz"))
    if tried:  # what did neither is a failure, and reported as one
        tried.append(("all", *(sum(row[i] for row in tried) for i in (1, 2, 3, 4))))
        write_table(terminalreporter, "fuzz", ("kind", "tried", "ran", "refused", "else"), tried)
    claims: dict[str, list[tuple]] = {}
    for node, (*where, error, tolerance) in noted(terminalreporter, "accuracy"):
        margin = 0.0 if isnan(error) else tolerance / abs(error) if error else inf
        claim = node.partition("[")[0].rpartition("/")[2].replace(".py::", ": ")
        claims.setdefault(claim, []).append((margin, error, tolerance, *where))
    if not claims:
        return
    worst = sorted((*min(checks), claim, len(checks)) for claim, checks in claims.items())
    rows = [
        (claim, count, times(margin), f"{error:.1e}", f"{tolerance:.0e}", f"{quantity}, {case}, {solver} {route}")
        for margin, error, tolerance, case, solver, route, quantity, claim, count in worst
    ]
    head = ("claim", "checks", "margin", "error", "tolerance", "where it is worst")
    write_table(terminalreporter, "accuracy", head, rows)
    broken, number = sum(c[0] < 1.0 for checks in claims.values() for c in checks), sum(map(len, claims.values()))
    verdict = f"{broken} of {number} checks fail" if broken else f"all {number} checks are within their tolerance"
    terminalreporter.write_line(
        f"verdict: {verdict}, of {len(claims)} claims; the closest by {rows[0][2]} ({rows[0][0]})"
    )


def noted(terminalreporter, name: str) -> list[tuple[str, tuple]]:
    """What tests noted under that name, each with its test before it."""
    reports = [report for outcome in ("passed", "failed") for report in terminalreporter.stats.get(outcome, ())]
    calls = [report for report in reports if getattr(report, "when", None) == "call"]
    return [(report.nodeid, value) for report in calls for key, value in report.user_properties if key == name]


def times(margin: float) -> str:
    return "exact" if margin == inf else f"{margin:.3g} times"


def write_table(terminalreporter, title, head, rows) -> None:
    terminalreporter.section(title)
    texts = [tuple(map(str, row)) for row in (head, *rows)]
    widths = [max(len(text[i]) for text in texts) for i in range(len(head))]
    for text in texts:
        line = "  ".join(cell.ljust(width) for cell, width in zip(text, widths, strict=True))
        terminalreporter.write_line(line.rstrip())
