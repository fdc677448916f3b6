"""A second place in which a plate that lies on its track meets it, for the second formulation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cases import Case

from .moving import Motion, limits
from .pairs import Touch
from .record import bodies_in_contact
from .stretches import Stretches
from .surroundings import Surroundings

# A step in which the contact moves too far to be alone around it is halved so many times at most.
HALVINGS = 10
# Where the contact is looked at in a step, and how far it may go beyond, in parts of what it covers.
PLACES, BEYOND = np.linspace(0.0, 1.0, 5), 0.1

States = Callable[[np.ndarray], np.ndarray]


def first_elsewhere(case: Case, around: Surroundings, steps: np.ndarray, z_at: States, turns: int) -> Touch | None:
    """The first touch away from the contact in a phase of it; None if there is none. Raises TooManyRounds.

    `z_at` maps times to (ξ₁, ξ₂, ω, v), shape (4, n), between the ends `steps` of an integration's steps.
    """

    def bodies(times: np.ndarray) -> np.ndarray:
        return bodies_in_contact(case, z_at(times), turns)

    todo = [(float(start), float(end), 0) for start, end in zip(steps[:-1], steps[1:], strict=True)][::-1]
    while todo:
        start, end, halved = todo.pop()
        places = z_at(start + (end - start) * PLACES)[:2]
        low, high = places.min(axis=1), places.max(axis=1)
        more = BEYOND * (high - low)
        own = around.own(
            (low - more)[0:1].tolist() + (high + more)[0:1].tolist(), [low[1] - more[1], high[1] + more[1]]
        )
        if own is None and halved < HALVINGS:
            middle = 0.5 * (start + end)
            todo += [(middle, end, halved + 1), (start, middle, halved + 1)]
            continue
        motion = Motion(bodies, np.array([start, end]))
        x, y = bodies(np.array([start]))[:2, 0].tolist()
        some = around.near(x, y, around.reach + limits(motion, start, end).speed * (end - start))
        if _fits(around, some):
            continue
        some, inside = around.inside(some, own or around.at(low[0], high[0]))
        rest = some.some(~inside)
        touch = around.search.first(motion, end, rest, np.full(rest.number, start))
        if touch is not None:
            return touch
    return None


def _fits(around: Surroundings, some: Stretches) -> bool:
    """Whether the curvatures alone exclude a second touch: the outline bends more everywhere than what is near of the
    track, and that is the graph of a function, or all of a convex closed curve."""
    if not some.number or not around.distance.bluntest > max(float(some.valley.max()), 0.0):
        return not some.number
    if around.convex:
        return True
    one_piece = bool(np.all(some.low[1:] == some.high[:-1]))
    angles = np.arctan2(some.ty, some.tx)
    turned = np.angle(np.exp(1j * (angles - angles[0])))
    return one_piece and float(np.ptp(turned)) + 2.0 * float((some.bend * some.half).max()) < 0.9 * np.pi
