"""`python -m tests.benchmarks NAME`: measurements of the suite itself, and of what no engine changes.

Tables go to the terminal.
"""

import argparse
from importlib import import_module

import pandas as pd

import cases
from reports import options
from reports.page import text
from reports.running.calls import Calls
from reports.running.progress import Display
from reports.studies import MOVED, Request


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("NAME", choices=sorted(MOVED))
    parser.add_argument("--case", nargs="+", default=[], help="cases, where the measurement has none of its own")
    parser.add_argument("--solver", nargs="+", default=options.solvers(), help="solvers (default: all)")
    parser.add_argument("--full", action="store_true", help="more sizes and tolerances, and more precise times")
    arguments = parser.parse_args()
    study = import_module(MOVED[arguments.NAME])
    chosen = tuple(case for name in arguments.case for case in cases.select(name))
    with Display() as display, Calls(1, progress=display) as calls:
        request = Request(chosen, calls.present(arguments.solver), arguments.full)
        findings = study.run(request, calls)
    tables = study.rows(findings) if hasattr(study, "rows") else findings
    for name, rows in tables.items():
        print(f"{name}\n{text.plain(pd.DataFrame(rows))}\n")


if __name__ == "__main__":
    main()
