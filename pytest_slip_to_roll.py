"""The pytest plugin of slip-to-roll: options, and tests of an engine from `reports.engine_tests`.

    pytest --slip-to-roll-engine ./my_engine                           # an engine's phenomena of friction and contact
    pytest --slip-to-roll-engine ./my_engine --case-file=my_valley.py  # the cases of a file instead

pytest loads this module at every start, so it is outside the packages and imports nothing of them before it is used.
"""

from __future__ import annotations

import pytest

# Option, default, name of its value, help.
OPTIONS = (
    ("--slip-to-roll-engine", [], "FILE", "test this engine, an executable or an installed adapter; can be repeated"),
    ("--slip-to-roll-step", "1e-3", "H", "step of an executable in s; an adapter takes its finest setting but one"),
    ("--slip-to-roll-grade", "good", "GRADE", "worst grade that passes: excellent, very good, good, rough or poor"),
    ("--case-file", [], "FILE", "test the cases of this file; write --case-file=FILE"),
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("slip-to-roll", "comparison of engines with certified motions")
    for name, default, metavar, text in OPTIONS:
        action = "append" if isinstance(default, list) else "store"
        group.addoption(name, action=action, default=default, metavar=metavar, help=text)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the tests of the engines to those that pytest collected."""
    if config.getoption("--slip-to-roll-engine"):
        from reports.engine_tests import tests

        items += tests(session, config)
    elif config.getoption("--case-file") and not items:
        raise pytest.UsageError(
            "--case-file has no test here: add --slip-to-roll-engine ENGINE, or run its acceptance tests in a clone"
        )


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail the session if an engine supported none of its cases: nothing of it was tested."""
    if _refusing(session.config) and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Name the engines that supported none of their cases."""
    for engine in _refusing(config):
        terminalreporter.write_line(f"slip-to-roll: {engine} supports none of the cases that were run", red=True)


def _refusing(config: pytest.Config) -> list[str]:
    """The engines that supported none of their cases."""
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    if not config.getoption("--slip-to-roll-engine") or terminal is None:
        return []
    from reports.engine_tests import refusing

    reports = (report for those in terminal.stats.values() for report in those)
    return refusing(report for report in reports if isinstance(report, pytest.TestReport))
