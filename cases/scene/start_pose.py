"""A start given as a pose: where the plate is and how it moves, instead of where it touches its track."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, hypot, inf, pi, sin

import numpy as np

from ..contact import geometry
from ..contact.nearest import contacts
from ..contact.overlap_search import OVERLAPS, deepest_end
from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Edge
from ..curves.line_or_circle import as_line
from ..effects import Belt, Drive, Effect, one
from ..errors import BadValue, DoesNotFit, finite
from .size_limits import check_belt, check_drive
from .start import Start

# A gap below this part of the plate's size and place is the rounding of a pose: the plate touches its track. A velocity
# along the normal below this part of the plate's speed is none.
TOUCHES = 1e-12


@dataclass(frozen=True)
class StartPose:
    """The plate's pose and velocities at time zero: centre of mass (m), angle (rad, counter-clockwise), m/s, rad/s.

    They are those of the fixed frame, also where a Belt or a Drive moves the track. A case stores it as the `Start` of
    the nearest point of the track: in contact if the gap is rounding, else off the track, which needs Flight. Raises
    BadValue for values that are no finite numbers.
    """

    x: float
    y: float
    theta: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    omega: float = 0.0

    def __post_init__(self):
        for name in ("x", "y", "theta", "vx", "vy", "omega"):
            object.__setattr__(self, name, finite(f"{name} of StartPose", getattr(self, name)))


def as_start(pose: StartPose, track: Curve, outline: Curve, effects: tuple[Effect, ...]) -> Start:
    """The same start by the contact parameters of the nearest points, with the slip relative to a track that moves by
    these effects. Raises DoesNotFit where the points are not found, BadValue for a motion without values at t = 0."""
    belt, drive, own = one(effects, Belt), one(effects, Drive), pose
    check_belt(belt)
    check_drive(drive)
    if drive is not None:
        place = drive.at(0.0)
        x, y, *velocities = place.seen_from_track(pose.x, pose.y, pose.vx, pose.vy, pose.omega)
        own = StartPose(x, y, pose.theta - place.angle, *velocities)
    where = own.x, own.y, own.theta
    depth, end = deepest_end(track, outline, *where)
    if depth > OVERLAPS * (abs(own.x) + abs(own.y) + outline.sizes[0]):
        raise DoesNotFit(
            f"the plate overlaps the end of its track at xi1 = {end:.6g} by {depth:.6g} m in the StartPose; give "
            "another one"
        )
    contact = min(contacts(track, outline, *where), key=lambda contact: contact.gap, default=None)
    if contact is None:
        raise DoesNotFit(
            "no point of the track is nearest to the StartPose, but perhaps its end; give a longer track, a Chain with "
            "a corner there, or a Start"
        )
    slip, rate = _velocities(own, track, contact)
    slip, gap = slip - (belt.at(0.0)[0] if belt else 0.0), contact.gap
    # What is left of larger numbers that cancel is rounding.
    size, both = outline.sizes[0], (pose, own)
    extent = max(abs(p.x) + abs(p.y) for p in both) + size
    if -OVERLAPS * extent <= gap <= TOUCHES * extent:
        gap = 0.0
    fastest = max(hypot(p.vx, p.vy) + size * abs(p.omega) for p in both)
    slip, rate = (0.0 if abs(speed) <= TOUCHES * fastest else speed for speed in (slip, rate))
    angle = float(geometry.pose(track, outline, contact.xi1, contact.xi2)[2]) - own.theta
    rounds = round(angle / (2.0 * pi)) * (outline.period or 0.0)  # so that the angle is the given one
    if gap < 0.0:
        raise DoesNotFit(f"the plate overlaps its track by {-gap:.6g} m in the StartPose; give another one")
    return Start(contact.xi1, contact.xi2 + rounds, slip, pose.omega, gap, rate)


def _velocities(pose: StartPose, track: Curve, contact: geometry.Contact) -> tuple[float, float]:
    """The velocities of the outline's point along the track and away from it (m/s)."""
    place, (tx, ty) = track.point(contact.xi1), track.tangent(contact.xi1)
    px, py = place[0] - contact.gap * ty, place[1] + contact.gap * tx
    vx, vy = pose.vx - pose.omega * (py - pose.y), pose.vy + pose.omega * (px - pose.x)
    return float(vx * tx + vy * ty), float(vy * tx - vx * ty)


def from_flat_side(start: Start, track: Curve, outline: Curve, effects: tuple[Effect, ...]) -> Start:
    """A start on a straight edge of the outline along a straight track, or a straight piece of one, as the same one at
    a corner; without xi2, one with θ = 0 on such an edge is in its middle. Other starts are returned as they are.

    Raises BadValue for a plate that lies on the edge and turns otherwise than a track that turns by these effects.
    """
    if not isinstance(outline, Chain) or not _is_straight(track, start.xi1):
        return start
    xi2 = _middle_of_level_edge(float(track.tangent_angle(start.xi1)), outline) if start.xi2 is None else start.xi2
    if xi2 is None:
        return start
    element = outline.element_at(xi2)
    end = element.start + element.piece.span[1] - element.piece.span[0]
    if not isinstance(element.piece, Edge) or xi2 >= end:
        return start
    drive = one(effects, Drive)
    check_drive(drive)
    spin = drive.at(0.0).spin if drive is not None else 0.0
    if start.in_contact and start.omega not in (0.0, spin):
        raise BadValue(
            f"a plate that lies on a flat side {'turns with its track' if spin else 'does not turn'}; give "
            f"omega={spin:g} in Start, not {start.omega:g}, or the xi2 of a corner"
        )
    if isinstance(track, Chain):  # the corner may be on another piece
        own = as_start(_on_side(start, xi2, spin, track, outline), track, outline, ())
        return replace(own, omega=start.omega)
    away, speed = end - xi2, float(track.speed(start.xi1))
    rate = start.gap_rate + (0.0 if start.in_contact else (start.omega - spin) * away)
    # A joint belongs to the element before it.
    return replace(start, xi1=start.xi1 + away / speed, xi2=float(np.nextafter(end, inf)), gap_rate=rate)


def _is_straight(track: Curve, xi1: float) -> bool:
    """Whether a track is an evenly parametrized line, or of a chain the piece there an edge."""
    if isinstance(track, Chain):
        return isinstance(track.element_at(xi1).piece, Edge)
    speeds = track.speed(np.linspace(*track.span, 17))
    return as_line(track) is not None and bool(np.allclose(speeds, track.speed(xi1), rtol=TOUCHES))


def _on_side(start: Start, xi2: float, spin: float, track: Curve, outline: Curve) -> StartPose:
    """A start whose tangents are parallel at xi2, as a pose, with velocities against a track of that spin (rad/s)."""
    (tx, ty), place, (u, v) = track.tangent(start.xi1), track.point(start.xi1), outline.point(xi2)
    theta = float(track.tangent_angle(start.xi1) - outline.tangent_angle(xi2))
    arm = np.array([cos(theta) * u - sin(theta) * v, sin(theta) * u + cos(theta) * v])
    centre = place + start.gap * np.array([-ty, tx]) - arm
    turning = 0.0 if start.in_contact else start.omega - spin
    vx, vy = start.slip * tx - start.gap_rate * ty, start.slip * ty + start.gap_rate * tx
    return StartPose(float(centre[0]), float(centre[1]), theta, vx + turning * arm[1], vy - turning * arm[0], turning)


def _middle_of_level_edge(direction: float, outline: Chain) -> float | None:
    """The middle of the outline's only edge with a direction (rad), in the round in which that angle is θ = 0."""
    middles = []
    for element in outline.elements:
        middle = element.start + 0.5 * (element.piece.span[1] - element.piece.span[0])
        turns = (float(outline.tangent_angle(middle)) - direction) / (2.0 * pi)
        if isinstance(element.piece, Edge) and abs(turns - round(turns)) <= TOUCHES:
            middles.append(middle - round(turns) * (outline.period or 0.0))
    return middles[0] if len(middles) == 1 else None
