"""The tolerances of the check of laws: the part of a scale up to which a defect is an error of a motion.

The check of every motion (`part_of`) is for laws that are broken, not for their last digits. Over the catalogue the
defects of motions at the default tolerance are 1e-13 of their scale in the median. Where curvatures nearly agree, or
the normal equation is nearly singular, the rounding of forces is amplified to 8e-9. The error of a step of DOP853 at
1e-6 is up to 2e-5.
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


# The check with all laws goes down to roundings: for each law what they leave of its scale, some ten times the largest
# of the catalogue's motions at 1e-12. Where a factor of conditioning is known, it multiplies them.
MOMENTUM, POSE, CLOSED, TANGENT, SLIP, FORCE, FRICTION = 1e-11, 1e-13, 1e-12, 1e-11, 1e-12, 1e-12, 4e-15
# Roundings that each unit of a factor of conditioning amplifies.
AMPLIFICATION = 100 * EPS
# Overlaps, in parts of the scene's size: where plates meet again after hops of roundings, 1.2e-10 in random scenes.
OVERLAPS = 3e-10
# Poses that a moving track turns back: roundings of its own place and angle, ten times those of the case's frame.
DRIVEN = 3e-12
# A gap that is none, in parts of the scene's size, and a velocity that is none, in parts of the speed.
TOUCHES, STILL = 1e-9, 1e-9
# What is left of a series of impacts where it ends: a hop of roundings.
SERIES = 1e-9
