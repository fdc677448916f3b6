"""The suite's version, and whether it runs from a clone of its repository."""

from pathlib import Path

# A literal: it is read without running any code when the suite is packed.
__version__ = "0.3.0"
# Date of the last published report, for citations.
RELEASED = "2026-11-30"


def in_clone() -> bool:
    """Whether the packages are those of a clone, which has a Makefile, and not of an installed wheel."""
    return (Path(__file__).resolve().parents[1] / "Makefile").exists()
