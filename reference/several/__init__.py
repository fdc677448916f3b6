"""The first formulation for a plate that touches its track in several places: modes by enumeration, Taylor's method."""

from .march import CONTACT, supports, until_end
from .output import ContactStates, observe
from .regimes import SeveralPhase

__all__ = ["CONTACT", "ContactStates", "SeveralPhase", "observe", "supports", "until_end"]
