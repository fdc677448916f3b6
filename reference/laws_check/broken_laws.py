"""The laws that a motion breaks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cases import BadValue, Case, Trajectory
from cases.free_plates import plates_of
from cases.moving_frame import in_track_frame, relative_case

from . import laws, penetration
from .laws import Defects
from .samples import ContactSamples, MotionSamples, of_motion
from .tolerances import EXACT, PARTS


@dataclass(frozen=True)
class BrokenLaw:
    """A law that a motion breaks: its name, between which bodies ("plate/track") or of which ("plate"), the time (s)
    at which it is broken most, by how much, in `unit`, and how much would be an error of the motion."""

    law: str
    place: str
    time: float
    size: float
    unit: str
    limit: float

    def __str__(self) -> str:
        where = self.place and f" at {self.place}"
        return f"{self.law}{where}: broken by {self.size:.3g} {self.unit} at t = {self.time:.9g} s"


def check(case: Case, motion: Trajectory, rtol: float = 1e-10) -> tuple[BrokenLaw, ...]:
    """The laws that a motion of a case breaks, the one that is broken most (in parts of its limit) first.

    `motion`: a Trajectory with dense output, from any solver; `rtol`: its relative accuracy, of which a hundredfold is
    no broken law. Of each step between two samples the laws are evaluated at five instants.
    Raises BadValue for a motion without dense output.
    """
    if not isinstance(motion, Trajectory) or motion.dense is None:
        raise BadValue(f"check was given {motion!r}; give a Trajectory with dense output, as reference.simulate does")
    relative = relative_case(case)
    seen = motion if relative is case else in_track_frame(motion)
    if len(motion.t) < 2:
        return ()
    with np.errstate(all="ignore"):
        return broken(of_motion(relative, seen), rtol)


def broken(samples: MotionSamples, rtol: float, is_proven: bool = False) -> tuple[BrokenLaw, ...]:
    """The laws that samples break; `is_proven`: curvatures exclude a second contact of plate and track."""
    results = [law for defects in _defects(samples, rtol, is_proven) for law in _broken(defects, rtol)]
    return tuple(sorted(results, key=lambda one: one.limit / one.size))


def _defects(samples: MotionSamples, rtol: float, is_proven: bool) -> Iterator[Defects]:
    reach = [plate.reach for plate in plates_of(samples.case)]
    speeds = [float((np.abs(p.velocity) + r * np.abs(p.spin)).max()) for p, r in zip(samples.plates, reach, strict=True)]
    belts = [abs(float(v)) for c in samples.contacts if c.law.belt for v in c.law.belt.at_arrays(samples.times[:, 0])]
    speed = max(*speeds, *belts, 0.0)
    for one in laws.motion_defects(samples, laws.sums(samples), reach, speed):
        yield one._replace(sizes=np.where(samples.is_straight, 0.0, one.sizes))
    for contact in _solved(samples):
        yield from laws.contact_defects(samples, contact, speed, max(reach))
    yield from laws.continuity_defects(samples, reach)
    part = EXACT + PARTS * rtol
    found = laws.jumps(samples, reach, speed, part)
    if len(found.steps):
        yield from laws.impact_defects(samples, found, reach, speed)
    yield from laws.energy_defects(samples, speed)
    size = max(float(np.abs(p.place).max()) + r for p, r in zip(samples.plates, reach, strict=True))
    for depth in penetration.depths(samples, is_proven):
        yield Defects("no overlap", depth.pair, depth.times, depth.depths, size, "m")


def _solved(samples: MotionSamples) -> Iterator[ContactSamples]:
    """The contacts in the steps that are solutions of the equations."""
    for contact in samples.contacts:
        keep = ~samples.is_straight[contact.steps]
        if keep.all():
            yield contact
        elif keep.any():
            law, *rows = contact
            yield ContactSamples(law, *(row[keep] for row in rows))


def _broken(defects: Defects, rtol: float) -> Iterable[BrokenLaw]:
    """The law, if a defect is larger than an error of the motion."""
    part = EXACT + PARTS * rtol
    limit = part * defects.scale
    if not (defects.sizes > limit).any():
        return ()
    limits = np.broadcast_to(limit, defects.sizes.shape)
    parts = np.where(defects.sizes > limits, defects.sizes / np.maximum(limits, np.finfo(float).tiny), 0.0)
    i = np.unravel_index(int(np.argmax(parts)), parts.shape)
    return (
        BrokenLaw(
            defects.law, defects.place, float(defects.times[i]), float(defects.sizes[i]), defects.unit, float(limits[i])
        ),
    )
