"""An independent check of proof records, which shares no code and no library with the prover.

Interval arithmetic is mpmath's (`mpmath.iv`), which rounds outward. A record is read as data: the checker integrates
the scene again, with its own Taylor recurrences, its own parser and another form of the equations. It confirms each
claim of the record, or names the first one that it cannot confirm. It covers discs.
"""

from .check import NotConfirmed, check

__all__ = ["NotConfirmed", "check"]
