"""The fixture `accuracy`: a cross-check that asserts its bound and is listed when pytest ends."""

from __future__ import annotations

from collections.abc import Callable

import pytest

_PROPERTY = "accuracy"
_COLUMNS = ("case", "solver", "route", "quantity", "error", "tolerance")


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
    """Print every accuracy row of the session as one table."""
    rows = [
        tuple(value)
        for outcome in ("passed", "failed")
        for report in terminalreporter.stats.get(outcome, ())
        if getattr(report, "when", None) == "call"
        for name, value in report.user_properties
        if name == _PROPERTY
    ]
    if not rows:
        return
    texts = [_COLUMNS] + [(*row[:4], f"{row[4]:.1e}", f"{row[5]:.0e}") for row in sorted(rows, key=lambda row: row[:4])]
    widths = [max(len(text[i]) for text in texts) for i in range(len(_COLUMNS))]
    terminalreporter.section("accuracy")
    for text in texts:
        terminalreporter.write_line("  ".join(cell.ljust(width) for cell, width in zip(text, widths, strict=True)))
