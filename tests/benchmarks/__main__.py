"""`python -m tests.benchmarks NAME [--full]`: the tables of a measurement of the suite itself on the terminal."""

import argparse
from importlib import import_module

import pandas as pd

from reports.page import text
from reports.running.calls import Calls
from reports.running.processes.progress import Display

NAMES = ("formulations", "reference_cost")


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("NAME", choices=NAMES)
    parser.add_argument("--full", action="store_true", help="more sizes and tolerances, and more precise times")
    arguments = parser.parse_args()
    study = import_module(f"tests.benchmarks.{arguments.NAME}.study")
    with Display() as display, Calls(1, progress=display) as calls:
        findings = study.run(calls, arguments.full)
    for name, rows in study.rows(findings).items():
        print(f"{study.TABLES[name].holds}\n{text.plain(pd.DataFrame(rows))}\n")


if __name__ == "__main__":
    main()
