"""Cases and solvers into tables, figures and a page: `python -m reports.build`."""

import cases.interrupt  # noqa: F401
