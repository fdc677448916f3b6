"""`slip-to-roll release cite`: the citation of the suite and of the paper whose equations it solves, as BibTeX."""

from __future__ import annotations

import sys
from argparse import Namespace

import cases
from cases.version import RELEASED

from . import options

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
@misc{ogaru_pandrea,
  title        = {Asupra mișcării unei plăci obligată să se miște cu frecare peste o curbă fixă},
  titleaddon   = {On the motion of a plate forced to move with friction over a fixed curve},
  author       = {Ogaru, Sandel and Pandrea, Nicolae},
  organization = {Universitatea din Pitești},
  note         = {In Romanian. The equations that the reference of slip-to-roll solves},
}
"""


def bibtex() -> str:
    """The entries of the version that runs and of the paper."""
    return f"{SUITE.format(year=RELEASED[:4], version=cases.__version__)}\n{PAPER}"


@options.runs("reports.cite", "Print the citation as BibTeX.")
def main(arguments: Namespace, words: list[str]) -> None:
    """Print the entries."""
    print(bibtex(), end="")


if __name__ == "__main__":
    sys.exit(main())
