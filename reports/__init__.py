"""Runs cases with solvers and writes tables, figures and a page: `python -m reports.build`."""

import cases.files.keyboard_interrupt  # noqa: F401
