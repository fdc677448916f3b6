"""The suite's version."""

# A literal: it is read without running any code when the suite is packed.
__version__ = "0.3.0"
# Date of the last published report, for citations.
RELEASED = "2026-11-28"
