"""The first formulation for several plates: each plate's pose as variables, modes by enumeration, Taylor's method."""

from .plate_columns import AllPlateContacts, AllPlates, observe
from .plates_phase import PlatesPhase, regime_of
from .plates_simulation import simulate

__all__ = ["AllPlateContacts", "AllPlates", "PlatesPhase", "observe", "regime_of", "simulate"]
