"""`slip-to-roll cite`: the citation of the suite and of the paper whose equations it solves, as BibTeX."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import cases
from cases.files.command_line import status
from cases.version import RELEASED

from . import options

COMMAND = "reports.cite"
SUITE = """\
@software{{slip_to_roll,
  title   = {{{{slip-to-roll}}: a cross-checked benchmark of planar contact with {{Coulomb}} friction}},
  author  = {{{{the slip-to-roll authors}}}},
  year    = {{{year}}},
  version = {{{version}}},
  license = {{MIT}},
}}
"""
PAPER = """\
@article{ogaru_pandrea,
  title  = {On the motion of a plate forced to move with friction over a fixed curve},
  author = {Ogaru and Pandrea},
  note   = {The equations that the reference of slip-to-roll solves},
}
"""


def bibtex() -> str:
    """The entries of the version that runs and of the paper."""
    return f"{SUITE.format(year=RELEASED[:4], version=cases.__version__)}\n{PAPER}"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""

    def work(words: list[str]) -> None:
        options.parser(COMMAND, "Print the citation as BibTeX.").parse_args(words)
        print(bibtex(), end="")

    return status(COMMAND, work, argv)


if __name__ == "__main__":
    sys.exit(main())
