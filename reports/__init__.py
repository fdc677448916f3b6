"""Runs cases with solvers and writes tables, figures and a page: `slip-to-roll report`."""

import cases.files.keyboard_interrupt  # noqa: F401
