"""`python -m tests.benchmarks.reference_cost [--full]`: the tables of this measurement on the terminal.

The general formulation compared with a Taylor integrator on the paper's own closed form; whether its cost grows at most
in proportion to the motion; and the cost of a new process."""

import sys

import pandas as pd

from reports.page import text
from reports.running.calls import Calls
from reports.running.processes.progress import Display

from . import study

if __name__ == "__main__":
    with Display() as display, Calls(1, progress=display) as calls:
        findings = study.run(calls, full="--full" in sys.argv)
    for name, rows in study.rows(findings).items():
        print(f"{study.TABLES[name].holds}\n{text.plain(pd.DataFrame(rows))}\n")
