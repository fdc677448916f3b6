"""Truth with error bars: witnesses that solve a case in independent ways, and what they agree on."""

from .agreement import contradiction
from .bars import Bar
from .certificate import Certificate, NotCertified, certify
from .truth_file import TRUTH, DamagedTruth, read, stored_or_new, write

__all__ = [
    "TRUTH",
    "Bar",
    "Certificate",
    "DamagedTruth",
    "NotCertified",
    "certify",
    "contradiction",
    "stored_or_new",
    "read",
    "write",
]
