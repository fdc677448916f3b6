"""Truth with error bars: witnesses that solve a case in independent ways, and what they agree on."""

from .certificate import TRUTH, Bar, Certificate, NotCertified, certify, kept_or_new, read, write

__all__ = ["TRUTH", "Bar", "Certificate", "NotCertified", "certify", "kept_or_new", "read", "write"]
