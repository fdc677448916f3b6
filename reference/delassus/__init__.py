"""The second formulation for several contacts: gaps and slips in the contacts' frames, modes by complementarity.

It shares no code with `solver`: accelerations from the Delassus matrix with curvatures only, decisions and impacts as
linear complementarity problems (Lemke's method) without enumeration of modes, SciPy's DOP853.
"""

from .bodies_motion import PlatesMotion, bodies_motion
from .first_state import SeveralMotion, continue_motion, from_start, mode_of, touches_at_start

__all__ = [
    "PlatesMotion",
    "SeveralMotion",
    "bodies_motion",
    "continue_motion",
    "from_start",
    "mode_of",
    "touches_at_start",
]
