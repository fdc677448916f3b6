"""Exudyn's constraints: a disc that cannot slip on a straight line, or cannot leave a frictionless guide.

Pure rolling is ObjectJointRollingDisc, which also guides a disc without friction if its tangential part is left out; a
guide along a circle is a rod from its centre to the disc's (ObjectConnectorDistance). There is neither creep nor
deflection: the step is the only error. The rod's output is not the contact force, so for both the forces are computed
from the accelerations.
"""

from __future__ import annotations

import exudyn as exu
import exudyn.itemInterface as item

from cases import Case, CoulombFriction, Flight, Gravity, Load, PerfectlyRough, Unilateral
from cases.contact import start_motion
from cases.curves.line_or_circle import as_circle, as_line

from ..common.one_contact import ContactAlong, with_forces
from ..interface import Refusal, Setting
from .bodies import add_load, add_plate, ground, marker, node_sensors
from .system import ExudynSystem, HasEffects, SensorData, disc_circle, external_forces


def suits(acting: HasEffects) -> bool:
    """Whether the engine models a disc on a line or a circle, where these effects act, by a constraint."""
    rough, bilateral = acting.effect(PerfectlyRough) is not None, acting.effect(Unilateral) is None
    return rough or (bilateral and acting.effect(CoulombFriction) is None)


def refuses(case: Case) -> Refusal | None:
    """The reason, in one sentence, why no constraint of the engine models the case, or None."""
    if case.effect(Flight):
        return Refusal(
            "Exudyn's rolling joint never opens; it has no perfectly rough contact for a plate that may fly.",
            "ObjectJointRollingDisc is a constraint",
        )
    if case.effect(PerfectlyRough) and as_line(case.track) is None:
        return Refusal(
            "Exudyn's rolling joint is for straight lines only, and this perfectly rough track is none.",
            "ObjectJointRollingDisc rolls on a plane",
        )
    return None


def build(case: Case, setting: Setting) -> ExudynSystem:
    """Build the disc with its constraint; the reader ends a unilateral contact where the joint would have to pull."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    node, body = add_plate(system, case.plate, start_motion(case), case.effect(Gravity))
    if load := case.effect(Load):
        add_load(system, body, load)
    line, circle, own = as_line(case.track), as_circle(case.track), disc_circle(case)
    radius = own.radius
    disc = marker(system, body, *own.centre.tolist())
    if line:
        # Tangential along the axis, tangential along the track, normal.
        axes = [0, 1, 1] if case.effect(PerfectlyRough) else [0, 0, 1]
        normal = [-line.direction[1], line.direction[0], 0.0]
        system.AddObject(
            item.ObjectJointRollingDisc(
                markerNumbers=[ground(system, line.point), disc],
                constrainedAxes=axes,
                discRadius=radius,
                discAxis=[0.0, 0.0, 1.0],
                planeNormal=normal,
            )
        )
    else:
        assert circle is not None, "refuses() accepts only lines and circles"
        distance = circle.radius - radius if circle.left else circle.radius + radius
        system.AddObject(
            item.ObjectConnectorDistance(markerNumbers=[ground(system, circle.centre), disc], distance=distance)
        )
    motion = node_sensors(system, node)
    kind = exu.OutputVariableType.Coordinates_tt
    acceleration = system.AddSensor(item.SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True))
    system.Assemble()
    return ExudynSystem(container, system, (motion,), (acceleration,), lambda data: _read(case, data))


def _read(case: Case, data: SensorData) -> ContactAlong:
    """The contact; its forces are mass times acceleration minus gravity and load."""
    force = case.plate.mass * data.force[:, :2] - external_forces(case, data)
    return with_forces(case, data.t, data.pose, data.velocity, force, lever=1.0)
