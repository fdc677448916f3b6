"""Flights and impacts in the samples of an engine whose contacts leave and land by themselves. Knows no engine.

What the contact did in a step tells them apart: a flight is where nothing pushed while the gap grew beyond what an
engine's hops reach; a landing is the first push after one. There both sides of the jump are told, at one time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, nan

import numpy as np

from cases import Case
from cases.contact import Contact, find, start_motion
from cases.nearest import nearest

# What a curve may raise where its expression has no value (DoesNotFit is one of them): beyond its domain.
BEYOND = (ValueError, ArithmeticError)
NOWHERE = Contact(nan, nan, inf)


@dataclass(frozen=True)
class Samples:
    """Samples at the poses' times: arrays of one length; `aloft` where no contact is.

    `t` (s); `pose` (n, 3); `before`: velocities (n, 3) if nothing pushed since those the engine told; `rebound`,
    `resting`: the next it told, without and with the gravity since then; `rates`: means; `force` (n, 2) of the
    contact, N; contact parameters and gap (m).
    """

    t: np.ndarray
    pose: np.ndarray
    before: np.ndarray
    rebound: np.ndarray
    resting: np.ndarray
    rates: np.ndarray
    force: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray
    aloft: np.ndarray

    def __getitem__(self, places) -> Samples:
        return replace(self, **{name: getattr(self, name)[places] for name in self.__dataclass_fields__})


def follow(case: Case, poses: np.ndarray, hop: float = inf) -> list[Contact]:
    """The contacts of the poses, each found from the one before.

    Beyond `hop` (m) they are looked for over the whole track, and NOWHERE tells that there is none; without, they end
    at the first pose that has none.
    """
    start = start_motion(case)
    near, found = (start.xi1, start.xi2), list[Contact]()
    for x, y, theta in poses.tolist():
        try:
            contact = find(case, x, y, theta, near)
        except BEYOND:
            if hop == inf:
                break
            contact = NOWHERE
        if contact.gap > hop:
            contact = nearest(case, x, y, theta) or NOWHERE
        near = contact[:2] if contact is not NOWHERE else near
        found.append(contact)
    return found


def aloft(gap: np.ndarray, pressed: np.ndarray, hop: float) -> np.ndarray:
    """Where the plate flies: unpressed stretches that somewhere exceed `hop`."""
    stretch = np.cumsum(pressed)
    high = np.unique(stretch[~pressed & (gap > hop)])
    return ~pressed & np.isin(stretch, high)


def landings(samples: Samples) -> np.ndarray:
    """The places of the first samples after flights."""
    return np.flatnonzero(samples.aloft[:-1] & ~samples.aloft[1:]) + 1


def both_sides(samples: Samples) -> Samples:
    """The samples with every landing doubled: before it the plate flies, after it with the velocities it rebounds."""
    count, at = len(samples.t), landings(samples)
    order = np.sort(np.concatenate([np.arange(count), at]))
    first = np.searchsorted(order, at)
    told = samples[order]
    # Where the next sample flies, it bounced; else it stays, with a force that a step's impulse does not tell.
    bounced = samples.aloft[np.minimum(at + 1, count - 1)]
    told.rates[first] = samples.before[at]
    told.rates[first + 1] = np.where(bounced[:, None], samples.rebound[at], samples.resting[at])
    told.aloft[first], told.aloft[first + 1] = True, bounced
    told.force[first + 1] = nan
    return told
