"""A check of motions by the laws of mechanics: it computes no motion, and needs none but the one that it checks."""

from .automatic_check import faults_at
from .broken_laws import BrokenLaw, check

__all__ = ["BrokenLaw", "check", "faults_at"]
