"""A check of motions by the laws of mechanics: it computes no motion, and needs none but the one that it checks."""

from .automatic_check import BROKEN_LAW, ending_by_laws
from .broken_laws import BrokenLaw, check, overlaps

__all__ = ["BROKEN_LAW", "BrokenLaw", "check", "ending_by_laws", "overlaps"]
