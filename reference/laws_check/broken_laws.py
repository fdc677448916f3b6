"""What the check of laws returns: a law that a motion breaks, and where it is broken most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .laws import Defects

OVERLAP = "no overlap"


@dataclass(frozen=True)
class BrokenLaw:
    """A law that a motion breaks: its name, between which bodies ("plate/track") or of which ("plate"), the time (s)
    at which it is broken most, by how much, in `unit`, and how much would be an error of the motion.
    `part_of_friction`: the same in units of μ N, for Coulomb's law in slip."""

    law: str
    place: str
    time: float
    size: float
    unit: str
    limit: float
    part_of_friction: float | None = None

    def __str__(self) -> str:
        where = self.place and f" at {self.place}"
        part = "" if self.part_of_friction is None else f" ({self.part_of_friction:.2g} μN)"
        return f"{self.law}{where}: broken by {self.size:.3g} {self.unit}{part} at t = {self.time:.9g} s"


def worst_first(laws: list[BrokenLaw]) -> tuple[BrokenLaw, ...]:
    """Overlaps first, then the law that is broken most, in parts of its limit."""
    return tuple(sorted(laws, key=lambda one: (one.law != OVERLAP, one.limit / one.size)))


def worst(defects: Defects, rtol: float) -> BrokenLaw | None:
    """The law where it is broken most, if a defect is larger than an error of the motion."""
    sizes, limits = defects.sizes, defects.limit(rtol)
    if sizes.dtype.kind == "c":
        sizes = np.abs(sizes)
    if not np.count_nonzero(sizes > limits):
        return None
    parts = np.where(sizes > limits, sizes / np.maximum(limits, np.finfo(float).tiny), 0.0)
    i = np.unravel_index(int(np.argmax(parts)), parts.shape)
    time, size = float(defects.times[i]), float(sizes[i])
    part = size / float(defects.friction[i]) if defects.friction is not None and defects.friction[i] else None
    return BrokenLaw(defects.law, defects.place, time, size, defects.unit, float(limits[i]), part)
