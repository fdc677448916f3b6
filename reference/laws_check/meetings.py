"""Places where a plate meets a curve at one instant, besides its contacts: pairs of points with a common normal, from
samples and Newton's method on both parameters (`cases.contact.pair_search`), whose pairs have (6).
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from cases import Chain, Curve, Plate
from cases.contact.nearest_samples import nearest_samples
from cases.contact.pair_search import pair_search
from cases.errors import DoesNotFit

# Of the pairs of samples that are nearer than their neighbours the nearest are refined, and nodes of the curve's
# features around them, within this part of the plate's reach.
MOST_PAIRS, MOST_NODES, NEAR = 8, 1000, 0.1


def meeting_gaps(curve: Curve, plate: Plate, place: complex, turn: complex, closed: list[float]) -> list[float] | None:
    """The gaps (m, positive) of pairs of nearest points of a curve and an outline in a pose, but for those at the
    curve's parameters `closed`; None for chains and pieces, where this is not written."""
    outline, pose = plate.outline, (place.real, place.imag, float(np.angle(turn)))
    if any(isinstance(each, Chain) or each.parts is not None for each in (curve, outline)):
        return None
    result, search = list[float](), pair_search(curve, outline)
    starts = nearest_samples(curve, outline, *pose)[:MOST_PAIRS]
    features = curve.features
    for xi1, xi2 in starts if features is not None else ():
        assert features is not None
        away, ends = NEAR * plate.reach / float(curve.speed(xi1)), curve.ends or (-np.inf, np.inf)
        nodes = np.clip(features.nodes(xi1 - away, xi1 + away)[:MOST_NODES], *ends)
        starts = [*starts, *((one, xi2) for one in nodes.tolist())]
    for near in starts:
        with suppress(DoesNotFit):  # no common normal near there
            pair = search(*pose, near)
            apart = 1e-5 * plate.reach / float(curve.speed(pair.xi1))
            if all(abs(pair.xi1 - xi1) > apart for xi1 in closed):
                result.append(abs(pair.gap))
    return result
