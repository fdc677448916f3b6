"""An independent check of proof records, which shares no code and no library with the prover.

Numbers are balls of integers, rounded outward; mpmath's intervals give values of sines, exponentials and logarithms.
A record is read as data: the checker integrates the scene again, with its own Taylor recurrences, its own parser and
another form of the equations. It confirms each claim of the record, or names the first one that it cannot confirm.
"""

from .check import check
from .steps import NotConfirmed

__all__ = ["NotConfirmed", "check"]
