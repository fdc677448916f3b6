"""Cases for which an engine's law of impact differs from the case's. The laws' names are those of `cases.Impact`."""

from __future__ import annotations

from cases import Case, CoulombFriction, Impact, PerfectlyRough
from cases.scene.couples import couples
from cases.scene.free_plates import plates_of, size_of, start_poses
from cases.scene.start_pose import TOUCHES

from .couple_contacts import places_of

# The law of engines that solve for the velocities at a step's end.
MOREAU = "Moreau's (Newton's restitution, and Coulomb's law on the velocity after the impact)"


def has_friction(case: Case) -> bool:
    return bool(case.effect(CoulombFriction) or case.effect(PerfectlyRough))


def not_moreaus(case: Case) -> bool:
    """Whether Moreau's law gives another impact than the case's law.

    Without friction, and for a disc about its centre of mass, all laws agree.
    """
    impact = case.effect(Impact)
    return impact is not None and impact.law != "moreau" and has_friction(case) and case.plate.radius is None


def plates_touch(case: Case) -> bool:
    """Whether two of several plates touch each other at the start, so that an impact may act on several contacts."""
    if not case.others:
        return False
    poses = start_poses(case)
    least = TOUCHES * size_of(poses, tuple(plate.reach for plate in plates_of(case)))
    of_plates = [couple for couple in couples(case) if couple.base is not None]
    return any((places_of(couple, poses[None, :, :3]).gap <= least).any() for couple in of_plates)
