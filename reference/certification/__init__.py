"""Certified truth with error bars: independent solutions of a case (witnesses) and the values on which they agree."""

from .agreement import contradiction, is_within_bars
from .bars import Bar
from .certificate import PROVED, WITNESSED, Certificate, NotCertified, certify, confirmations
from .truth_file import TRUTH, DamagedTruth, read, stored_or_new, write

__all__ = [
    "TRUTH",
    "Bar",
    "Certificate",
    "DamagedTruth",
    "PROVED",
    "NotCertified",
    "WITNESSED",
    "certify",
    "confirmations",
    "contradiction",
    "is_within_bars",
    "stored_or_new",
    "read",
    "write",
]
