"""Where plates are near tracks, supports and each other at one instant: pairs of points with a common normal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from cases import Chain, Curve, Mode, Plate
from cases.contact.nearest import contacts
from cases.contact.nearest_samples import nearest_samples
from cases.contact.pair_search import pair_search
from cases.errors import DoesNotFit
from cases.scene.couples import couples

from .samples import MotionSamples, law_at
from .touches import PlatesNow, TouchNow, touch

# Of the pairs of samples that are nearer than their neighbours the nearest are refined, and nodes of the curve's
# features around them, within this part of the plate's reach.
MOST_PAIRS, MOST_NODES, NEAR = 8, 1000, 0.1


def meetings(samples: MotionSamples, plates: PlatesNow, t: float) -> list[TouchNow]:
    """The nearest points of all pairs of curves at one instant, contacts or not."""
    poses, result = np.column_stack([plates.place.real, plates.place.imag, plates.angle]).ravel(), list[TouchNow]()
    for couple in couples(samples.case):
        law, (x, y, theta) = law_at(samples.case, couple.pair_name), map(float, couple.relative_pose(poses))
        for xi1, xi2 in _pairs(couple.track, couple.plate, (x, y, theta)):
            result.append(touch(samples.case, law, Mode.FLIGHT, plates, couple.whole_xi1(xi1), xi2, t))
    return result


def _pairs(curve: Curve, plate: Plate, pose: tuple[float, float, float]) -> Iterator[tuple[float, float]]:
    """The parameters of nearest points: of smooth curves by Newton's method from samples, with (6)."""
    outline = plate.outline
    if any(isinstance(each, Chain) or each.parts is not None for each in (curve, outline)):
        yield from ((one.xi1, one.xi2) for one in contacts(curve, outline, *pose))
        return
    search, features = pair_search(curve, outline), curve.features
    starts = nearest_samples(curve, outline, *pose)[:MOST_PAIRS]
    for xi1, xi2 in starts if features is not None else ():
        assert features is not None
        away, ends = NEAR * plate.reach / float(curve.speed(xi1)), curve.ends or (-np.inf, np.inf)
        nodes = np.clip(features.nodes(xi1 - away, xi1 + away)[:MOST_NODES], *ends)
        starts = [*starts, *((one, xi2) for one in nodes.tolist())]
    for near in starts:
        with suppress(DoesNotFit):  # no common normal near there
            pair = search(*pose, near)
            yield pair.xi1, pair.xi2
