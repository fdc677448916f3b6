"""The curves as geometry of MJCF (MuJoCo) and SDF (Gazebo, Drake), as text: a plane scene, thin in Z.

The track is boxes behind its chords; the plate a cylinder where it is a disc, else the prism over its outline: of MJCF
a mesh, whose hull MuJoCo takes, of SDF a polyline. Readers set contact parameters: they differ between engines.
"""

from __future__ import annotations

from math import atan2
from xml.etree import ElementTree as xml

import numpy as np

from cases import Case, Chain, Plate
from cases.motion.mechanics import gravity
from cases.scene.contact_names import FIRST
from cases.scene.free_plates import names_of, plates_of, start_poses

from ..common.facets import chain_vertices, visible_span

# Chords of the track, corners of the outline; and of boxes and prisms half the thickness in Z, in plate sizes.
CHORDS, CORNERS, THIN = 400, 200, 0.25


def mjcf(case: Case) -> str:
    """A model with all plates free in the plane, at their starts."""
    depth, (gx, gy) = THIN * case.plate.reach, gravity(case)
    root = xml.Element("mujoco", model=case.name)
    xml.SubElement(root, "compiler", angle="radian")
    xml.SubElement(root, "option", gravity=_text(gx, gy, 0))
    assets, world = xml.SubElement(root, "asset"), xml.SubElement(root, "worldbody")
    for x, y, angle, half_length, half_height in _boxes(case, depth):
        size, euler = _text(half_length, half_height, 2 * depth), _text(0, 0, angle)
        xml.SubElement(world, "geom", type="box", pos=_text(x, y, 0), euler=euler, size=size)
    for name, plate, (x, y, theta, *_) in _plates(case):
        body = xml.SubElement(world, "body", name=name, pos=_text(x, y, 0), euler=_text(0, 0, theta))
        joints = [("x", "slide", (1, 0, 0)), ("y", "slide", (0, 1, 0)), ("theta", "hinge", (0, 0, 1))]
        for joint, kind, axis in joints if plate.turns else joints[:2]:
            # A body's joint axes are in its own frame, which is rotated by theta.
            axis_in_body, own = _turn(axis, -theta), joint if name == FIRST else f"{joint} of {name}"
            xml.SubElement(body, "joint", name=own, type=kind, axis=_text(*axis_in_body))
        inertia = _text(*[_finite_inertia(plate)] * 3)
        xml.SubElement(body, "inertial", pos=_text(0, 0, 0), mass=repr(plate.mass), diaginertia=inertia)
        if plate.radius:
            xml.SubElement(body, "geom", type="cylinder", size=_text(plate.radius, depth))
        else:
            corners = [(x, y, z) for z in (-depth, depth) for x, y in _corners(plate)]
            xml.SubElement(assets, "mesh", name=name, vertex=_text(*np.ravel(corners)))
            xml.SubElement(body, "geom", type="mesh", mesh=name)
    return xml.tostring(root, encoding="unicode")


def _plates(case: Case):
    """Name, plate and start (x, y, θ, vx, vy, ω) of every plate."""
    return zip(names_of(case), plates_of(case), start_poses(case).tolist(), strict=True)


def _finite_inertia(plate: Plate) -> float:
    """The plate's inertia; of one that does not turn, which these formats cannot say, that of a body of its size. The
    model for MuJoCo has no hinge then; the scene's own `inertia` is null."""
    return plate.inertia if plate.turns else plate.mass * plate.reach**2


def sdf(case: Case) -> str:
    """A world with the track as a static model and each plate as another."""
    depth, (gx, gy) = THIN * case.plate.reach, gravity(case)
    root = xml.Element("sdf", version="1.9")
    world = xml.SubElement(root, "world", name=case.name)
    xml.SubElement(world, "gravity").text = _text(gx, gy, 0)
    track = xml.SubElement(world, "model", name="track")
    xml.SubElement(track, "static").text = "true"
    link = xml.SubElement(track, "link", name="track")
    for number, (x, y, angle, half_length, half_height) in enumerate(_boxes(case, depth)):
        box = _collision(link, f"chord_{number}", (x, y, 0, 0, 0, angle), "box")
        xml.SubElement(box, "size").text = _text(2 * half_length, 2 * half_height, 4 * depth)
    for name, plate, (x, y, theta, *_) in _plates(case):
        model = xml.SubElement(world, "model", name=name)
        xml.SubElement(model, "pose").text = _text(x, y, 0, 0, 0, theta)
        link = xml.SubElement(model, "link", name=name)
        inertial = xml.SubElement(link, "inertial")
        xml.SubElement(inertial, "mass").text = repr(plate.mass)
        inertia = xml.SubElement(inertial, "inertia")
        for moment in ("ixx", "iyy", "izz"):
            xml.SubElement(inertia, moment).text = repr(_finite_inertia(plate))
        if plate.radius:
            cylinder = _collision(link, name, (0,) * 6, "cylinder")
            xml.SubElement(cylinder, "radius").text = repr(plate.radius)
            xml.SubElement(cylinder, "length").text = repr(2 * depth)
        else:
            prism = _collision(link, name, (0, 0, -depth, 0, 0, 0), "polyline")
            xml.SubElement(prism, "height").text = repr(2 * depth)
            for corner in _corners(plate):
                xml.SubElement(prism, "point").text = _text(*corner)
    return xml.tostring(root, encoding="unicode")


def _collision(link: xml.Element, name: str, pose, kind: str) -> xml.Element:
    collision = xml.SubElement(link, "collision", name=name)
    xml.SubElement(collision, "pose").text = _text(*pose)
    return xml.SubElement(xml.SubElement(collision, "geometry"), kind)


def _boxes(case: Case, depth: float):
    """(x, y, angle, half length, half height) of boxes whose left faces are the track's chords."""
    if isinstance(case.track, Chain):
        corners = chain_vertices(case.track, CHORDS).T
    else:
        corners = np.array(case.track.point(np.linspace(*visible_span(case), CHORDS + 1))).T
    for (ax, ay), (bx, by) in zip(corners[:-1], corners[1:], strict=True):
        along = np.array([bx - ax, by - ay])
        length = float(np.hypot(*along))
        normal = np.array([-along[1], along[0]]) / length
        x, y = 0.5 * np.array([ax + bx, ay + by]) - 0.5 * depth * normal
        yield float(x), float(y), atan2(along[1], along[0]), 0.5 * length, 0.5 * depth


def _corners(plate: Plate) -> np.ndarray:
    outline = plate.outline
    if isinstance(outline, Chain):
        return chain_vertices(outline, CORNERS)[:, :-1].T
    return np.array(outline.point(np.linspace(*outline.span, CORNERS, endpoint=not outline.period))).T


def _turn(axis, angle: float):
    c, s = np.cos(angle), np.sin(angle)
    return c * axis[0] - s * axis[1], s * axis[0] + c * axis[1], axis[2]


def _text(*numbers) -> str:
    return " ".join(repr(float(number)) for number in numbers)
