"""The first formulation for a plate that touches its track in several places: modes by enumeration, Taylor's method."""

from .motion_start import from_flat_side, from_start, touches_at_start, until_end
from .output import AllContacts, observe
from .regimes import SeveralPhase, regime_of

__all__ = [
    "AllContacts",
    "SeveralPhase",
    "from_flat_side",
    "from_start",
    "observe",
    "regime_of",
    "touches_at_start",
    "until_end",
]
