"""A check of motions by the laws of mechanics: it computes no motion, and needs none but the one that it checks."""

from .automatic_check import BROKEN_LAW, faults_at
from .broken_laws import BrokenLaw, check, overlaps

__all__ = ["BROKEN_LAW", "BrokenLaw", "check", "faults_at", "overlaps"]
