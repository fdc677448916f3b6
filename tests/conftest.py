"""Fixtures: `accuracy`, a cross-check listed when pytest ends, and `any_case`, every case of the catalogue."""

from __future__ import annotations

import os
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, settings

import cases
from cases import CaseError, kept

_PROPERTY = "accuracy"
_COLUMNS = ("case", "solver", "route", "quantity", "error", "tolerance")


def pytest_addoption(parser):
    """--case-file=FILE (with the =, else pytest takes FILE for a test file): test its cases, and nothing else."""
    parser.addoption("--case-file", action="append", default=[], metavar="FILE", help="test the cases of this file")


# `make test` draws the same examples everywhere and always: what fails is the change, not the draw. The slow tests,
# and whoever gives a seed, draw others.
settings.register_profile("same", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def pytest_configure(config):
    """Choose what is drawn; load the case files, and tell in one line what is wrong with one.

    What was compiled is taken from disk only where the environment names a folder, as `make test` does.
    """
    os.environ.setdefault(kept.VARIABLE, kept.OFF)
    if config.option.markexpr == "not slow" and config.getoption("--hypothesis-seed", None) is None:
        settings.load_profile("same")
    try:
        config.own_cases = [name for file in config.getoption("--case-file") for name in cases.load_file(file)]
    except CaseError as problem:
        raise pytest.UsageError(str(problem)) from None


def pytest_generate_tests(metafunc):
    """`any_case`: a test for each variant of each case of the catalogue (hard ones have `test_atlas`) or of files."""
    if "any_case" not in metafunc.fixturenames:
        return
    try:
        chosen = [case for name in metafunc.config.own_cases or cases.names(hard=False) for case in cases.select(name)]
    except CaseError as problem:
        raise pytest.UsageError(str(problem)) from None
    metafunc.parametrize("any_case", chosen, ids=[case.label for case in chosen])


def pytest_collection_modifyitems(config, items):
    """With --case-file only the tests of those cases run."""
    if config.own_cases:
        items[:] = [item for item in items if "any_case" in item.fixturenames]


@pytest.fixture(autouse=True, scope="session")
def _store(tmp_path_factory):
    """The command keeps what the tests run in a folder of theirs, not where somebody works."""
    from reports import options

    options.STORE = str(tmp_path_factory.mktemp("kept") / "store")


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


def pytest_terminal_summary(terminalreporter):
    """Print every accuracy row of the session as one table, and what the fuzz tried."""
    rows = sorted(_noted(terminalreporter, _PROPERTY), key=lambda row: row[:4])
    _print_table(terminalreporter, "accuracy", _COLUMNS, [(*row[:4], f"{row[4]:.1e}", f"{row[5]:.0e}") for row in rows])
    rows = sorted(_noted(terminalreporter, "fuzz"))
    if rows:  # what did neither is a failure, and told as one
        rows.append(("all", *(sum(row[i] for row in rows) for i in (1, 2, 3, 4))))
    texts = [(row[0], *map(str, row[1:])) for row in rows]
    _print_table(terminalreporter, "fuzz", ("kind", "tried", "ran", "refused", "else"), texts)


def _noted(terminalreporter, wanted: str) -> list[tuple]:
    return [
        tuple(value)
        for outcome in ("passed", "failed")
        for report in terminalreporter.stats.get(outcome, ())
        if getattr(report, "when", None) == "call"
        for name, value in report.user_properties
        if name == wanted
    ]


def _print_table(terminalreporter, title: str, heading: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
    if not rows:
        return
    widths = [max(len(text[i]) for text in (heading, *rows)) for i in range(len(heading))]
    terminalreporter.section(title)
    for text in (heading, *rows):
        terminalreporter.write_line("  ".join(cell.ljust(width) for cell, width in zip(text, widths, strict=True)))
