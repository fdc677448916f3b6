"""Where plates are near tracks, supports and each other at one instant: pairs of points with a common normal."""

from __future__ import annotations

import numpy as np

from cases import Mode
from cases.contact.element_pairs import nearest_on_elements
from cases.scene.couples import couples

from .samples import MotionSamples, PlateSamples, law_at
from .touches import TouchNow, touch

# Pairs of points that are farther apart than this part of the plate's reach do not meet.
NEAR = 1e-4


def meetings(samples: MotionSamples, plates: PlateSamples, t: float) -> list[TouchNow]:
    """The nearest points of all pairs of curves at one instant, contacts or not."""
    poses, result = np.column_stack([plates.place.real, plates.place.imag, plates.angle]).ravel(), list[TouchNow]()
    for couple in couples(samples.case):
        law, (x, y, theta) = law_at(samples.case, couple.pair_name), map(float, couple.relative_pose(poses))
        track, plate = couple.track, couple.plate
        for xi1, xi2, _ in nearest_on_elements(track, plate.outline, x, y, theta, NEAR * plate.reach):
            result.append(touch(samples.case, law, Mode.FLIGHT, plates, couple.whole_xi1(xi1), xi2, t))
    return result
