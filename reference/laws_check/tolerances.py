"""The tolerances of the check of laws: the part of a scale up to which a defect is an error of a motion.

A law is checked for being broken, not for its last digits. Over the catalogue the defects of motions at the default
tolerance are 1e-13 of their scale in the median. Where curvatures nearly agree, or the normal equation is nearly
singular, the rounding of forces is amplified to 8e-9. The error of a step of DOP853 at 1e-6 is up to 2e-5.
"""

from __future__ import annotations

import numpy as np

EPS = float(np.finfo(float).eps)
# Roundings of forces in ill-conditioned scenes, ten times what was measured.
EXACT = 1e-7
# In units of the integrator's relative tolerance, five times what was measured.
PARTS = 100.0


def part_of(rtol: float) -> float:
    """The part of a scale up to which a defect is an error of a motion with that relative accuracy."""
    return EXACT + PARTS * rtol
