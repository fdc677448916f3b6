"""The first formulation for any number of plates and contacts: poses as variables, modes by enumeration."""

from .columns import AllContacts, AllPlates, evaluate, observe, sides
from .contact_chart import first_regime
from .march import begins_alone, simulate
from .regimes import SolverPhase, regime_of

__all__ = [
    "AllContacts",
    "AllPlates",
    "SolverPhase",
    "begins_alone",
    "evaluate",
    "first_regime",
    "observe",
    "regime_of",
    "sides",
    "simulate",
]
