"""Fixtures: `accuracy`, a cross-check printed when pytest ends, and `any_case`, every case of the catalogue."""

from __future__ import annotations

import gc
import os
import re
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import contextmanager
from functools import cache
from inspect import isfunction
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import cases
from cases import Case, CaseError, lookup
from reports.running import cache_folder

_PROPERTY = "accuracy"
_COLUMNS = ("case", "solver", "route", "quantity", "error", "tolerance")


def pytest_addoption(parser, pluginmanager):
    """--case-file=FILE (with the =, else pytest takes FILE for a test file): test its cases, and nothing else."""
    if not pluginmanager.hasplugin("slip_to_roll"):  # the installed plugin has the option
        parser.addoption("--case-file", action="append", default=[], metavar="FILE", help="test the cases of this file")


# `make test` draws the same examples everywhere and always: what fails is the change, not the draw. The slow tests,
# and whoever gives a seed, draw others.
# No test is slow by hypothesis' clock: on a busy machine any would be.
settings.register_profile("same", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("other", deadline=None)
# The default choice of pyproject.toml, and that of `make test-builds`.
QUICK = ("not slow and not timed and not builds and not style", "builds and not slow and not timed")


def pytest_configure(config):
    """Choose what is drawn; load the case files; one line says what is wrong with one."""
    os.environ.setdefault(cache_folder.VARIABLE, cache_folder.OFF)
    gc.disable()  # what is collected stays to the end: looking through it for garbage finds none and takes seconds
    quick = config.option.markexpr in QUICK and config.getoption("--hypothesis-seed", None) is None
    settings.load_profile("same" if quick else "other")
    try:
        config.own_cases = [name for file in config.getoption("--case-file") for name in lookup.load_file(file)]
    except CaseError as problem:
        raise pytest.UsageError(str(problem)) from None


def pytest_generate_tests(metafunc):
    """`any_case`: a test for each variant of each case of the catalogue (hard ones have `test_atlas`) or of files."""
    if "any_case" not in metafunc.fixturenames:
        return
    try:
        chosen = chosen_cases(tuple(metafunc.config.own_cases or cases.names(hard=False)))
    except CaseError as problem:
        raise pytest.UsageError(str(problem)) from None
    metafunc.parametrize("any_case", chosen, ids=[case.label for case in chosen])


@cache
def chosen_cases(names: tuple[str, ...]) -> list[Case]:
    """All variants of these cases; once for all tests of each."""
    return [case for name in names for case in cases.select(name)]


def pytest_ignore_collect(collection_path, config):
    """A file of which no test would run is not imported: that is half of what collecting costs each process. A file
    that the command line names is collected."""
    if collection_path.suffix != ".py":
        return None
    return holds_none(collection_path.read_text(encoding="utf-8"), config.option.markexpr) or None


def holds_none(text: str, markexpr: str) -> bool:
    """Whether a test file with that text has no test for the default marks, or for those of `make test-builds`."""
    if markexpr == QUICK[0]:
        return re.search(r"^pytestmark = \[?pytest\.mark\.(builds|style)\b", text, re.M) is not None
    return markexpr == QUICK[1] and "mark.builds" not in text


def pytest_pycollect_makeitem(collector, name, obj):
    """With the marks of the quick tests functions that are slow as a whole become no tests: with all their cases they
    were more than half of all tests, which each process made only to leave them out."""
    config = collector.config
    if not isfunction(obj) or config.option.markexpr not in QUICK or config.own_cases:
        return None
    if any("::" in argument for argument in config.args):
        return None
    others = ("slow", "timed", "builds", "style") if config.option.markexpr == QUICK[0] else ("slow", "timed")
    return [] if any(mark.name in others for mark in getattr(obj, "pytestmark", ())) else None


@pytest.hookimpl(tryfirst=True)  # before pytest leaves out the slow tests
def pytest_collection_modifyitems(config, items):
    """With --case-file only the tests of those cases run. A test that the command line names runs with all its cases;
    of the others marked `sampled` only a sample is quick."""
    if config.own_cases:
        items[:] = [item for item in items if "any_case" in getattr(item, "fixturenames", ("any_case",))]
    elif not any("::" in argument for argument in config.args):
        mark_outside_samples(items)


def mark_outside_samples(items) -> None:
    """Mark slow what is outside the samples: `sampled(every, first=0)` keeps a test's cases number `first`,
    `first + every`, …, without those that are slow anyway."""
    numbers: Counter[str] = Counter()
    for item in items:
        mark = item.get_closest_marker("sampled")
        if mark is None or item.get_closest_marker("slow"):
            continue
        name = item.nodeid.partition("[")[0]
        if numbers[name] % mark.args[0] != mark.kwargs.get("first", 0):
            item.add_marker(pytest.mark.slow)
        numbers[name] += 1


def pytest_collection_finish(session):
    gc.freeze()
    gc.enable()
    gc.set_threshold(50_000, 20, 20)  # looking after every 700 new objects takes 10 s of CPU


@pytest.fixture(autouse=True, scope="session")
def _store(tmp_path_factory):
    """The command keeps what the tests run in a folder of theirs, not where somebody works, and makes one run at a time
    where a test does not name another number: a second worker imports everything once more, 2 s of CPU, and the tests
    themselves occupy both cores."""
    from reports import options

    options.STORE = str(tmp_path_factory.mktemp("kept") / "store")
    options._OPTIONS["jobs"]["default"] = "1"


@pytest.fixture(autouse=True, scope="module")
def _default_method(request):
    """In `make test` and `make test-builds` a motion for which no method is named is DOP853's, except in files marked
    `taylor` and in other processes: the Taylor method's equations are compiled, which takes longer than most of these
    motions. The slow tests, and tests of somebody's own cases, have the default."""
    is_quick = request.config.option.markexpr in QUICK and not request.config.own_cases
    with pytest.MonkeyPatch.context() as patch:
        if is_quick and not request.node.get_closest_marker("taylor"):
            from reference import solve

            patch.setattr(solve, "METHODS", ("dop853",))
        yield


@pytest.fixture(scope="session")
def without_figures() -> Callable:
    """In `with without_figures():` a report is made without its figures, which are half of what a small one costs: for
    tests of what stands in its tables."""

    @contextmanager
    def undrawn():
        from reports.page import pictures

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(pictures, "draw", lambda *given: ([], {result.name: [] for result in given[3]}))
            yield

    return undrawn


@pytest.fixture(scope="session")
def in_process() -> Callable:
    """In `with in_process():` workers' calls are made in this process: starting workers is most of the cost of a small
    report. For tests of a command's files and words; that calls are separated is tested elsewhere."""
    from reports.running.processes import worker_process, workers

    def run(self, function, arguments, limit=60.0, skip=lambda index: None, groups=(), brief=False):
        for i, args in enumerate(arguments):
            given = skip(i)
            yield i, given or worker_process._call(function, args, Path(tempfile.mkdtemp()))

    @contextmanager
    def patched():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(workers.WorkerPool, "run", run)
            patch.setattr(workers.WorkerPool, "begin", lambda self, groups: None)
            yield

    return patched


@pytest.fixture
def accuracy(request) -> Callable[..., None]:
    """accuracy(case=, solver=, route=, quantity=, error=, tolerance=) notes the row and asserts |error| <= tolerance.

    The row is noted before the assertion, so that a failed cross-check is listed with the others. A NaN fails.
    """

    def check(*, case: str, solver: str, route: str, quantity: str, error: float, tolerance: float) -> None:
        error = float(error)
        row = (case, solver, route, quantity, error, float(tolerance))
        # User properties travel with the test report, also from the workers of pytest-xdist.
        request.node.user_properties.append((_PROPERTY, row))
        assert abs(error) <= tolerance, (
            f"{case}, {solver}/{route}: {quantity} is off by {error:.3g}, allowed {tolerance:.3g}"
        )

    return check


def pytest_terminal_summary(terminalreporter, config):
    """The worst margin of each claim, a claim being a test with all its scenes, and one verdict; with --case-file every
    number. Before it what the fuzz tried."""
    tried = sorted(row[1:] for row in _noted(terminalreporter, "fuzz"))
    if tried:  # what did neither is a failure, and reported as one
        tried.append(("all", *(sum(row[i] for row in tried) for i in (1, 2, 3, 4))))
        terminalreporter.section("fuzz")
        _write_table(terminalreporter, ("kind", "tried", "ran", "refused", "else"), [tuple(map(str, r)) for r in tried])
    rows = _noted(terminalreporter, _PROPERTY)
    if rows:
        _tell_margins(terminalreporter, rows, bool(config.own_cases))


def _noted(terminalreporter, wanted: str) -> list[tuple]:
    """What tests noted under that name, each with its test before it."""
    return [
        (report.nodeid, *value)
        for outcome in ("passed", "failed")
        for report in terminalreporter.stats.get(outcome, ())
        if getattr(report, "when", None) == "call"
        for name, value in report.user_properties
        if name == wanted
    ]


def _tell_margins(terminalreporter, rows: list[tuple], every: bool) -> None:
    terminalreporter.section("accuracy")
    if every:
        output = [(*row[1:5], f"{row[5]:.1e}", f"{row[6]:.0e}") for row in sorted(rows, key=lambda row: row[1:5])]
        _write_table(terminalreporter, _COLUMNS, output)
    worst: dict[str, tuple[float, int, tuple]] = {}
    for row in rows:
        claim = row[0].partition("[")[0].rpartition("/")[2].replace(".py::", ": ")
        margin, count, where = worst.get(claim, (float("inf"), 0, row))
        own = _margin(*row[5:])
        worst[claim] = (min(own, margin), count + 1, row if not own >= margin else where)
    else:
        claims = sorted(worst.items(), key=lambda item: item[1][0])
        output = [
            (
                claim,
                str(count),
                _times(margin),
                f"{row[5]:.1e}",
                f"{row[6]:.0e}",
                f"{row[4]}, {row[1]}, {row[2]} {row[3]}",
            )
            for claim, (margin, count, row) in claims
        ]
        _write_table(terminalreporter, ("claim", "checks", "margin", "error", "tolerance", "where it is worst"), output)
    broken = sum(not abs(row[5]) <= row[6] for row in rows)
    least, (margin, _, row) = min(worst.items(), key=lambda item: item[1][0])
    verdict = f"{broken} of {len(rows)} checks fail" if broken else f"all {len(rows)} checks are within their tolerance"
    closest = f"the closest by {_times(margin)}" if not broken else f"worst: {row[4]} of {row[1]}"
    terminalreporter.write_line(f"verdict: {verdict}, of {len(worst)} claims; {closest} ({least})")


def _margin(error: float, tolerance: float) -> float:
    """How many times the error would fit into its tolerance; 0 for what is no number."""
    if error != error:
        return 0.0
    return tolerance / abs(error) if error else float("inf")


def _times(margin: float) -> str:
    return "exact" if margin == float("inf") else f"{margin:.3g} times"


def _write_table(terminalreporter, head, rows) -> None:
    texts = [head, *rows]
    widths = [max(len(text[i]) for text in texts) for i in range(len(head))]
    for text in texts:
        line = "  ".join(cell.ljust(width) for cell, width in zip(text, widths, strict=True))
        terminalreporter.write_line(line.rstrip())
