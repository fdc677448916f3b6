"""The first formulation for any number of plates and contacts: poses as variables, modes by enumeration."""

from .columns import AllContacts, AllPlates, observe, sides
from .march import Before, simulate, start_of
from .regimes import SolverPhase, regime_of
from .touching import touching_contacts

__all__ = [
    "AllContacts",
    "AllPlates",
    "Before",
    "SolverPhase",
    "observe",
    "regime_of",
    "sides",
    "simulate",
    "start_of",
    "touching_contacts",
]
