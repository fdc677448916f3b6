"""The paper's solver: a plate with friction on a fixed curve, by its augmented system (27)."""

from .certification.certificate import certify
from .solve import METHODS, simulate

__all__ = ["METHODS", "certify", "simulate"]
