"""Contacts of one or several plates from the poses and velocities of a motion alone, where pairs of features touch.

Each pair of a support and a feature of an outline (a corner, an arc, a whole circle), and each pair of plates, has one
gap in every pose. It is closed while the gap is below what the engine's step leaves and, where the change of momentum
is known, while that needs it. (`several_contacts` finds the contacts of a disc with one curve.)
"""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from cases import Belt, Case, Curve, DoesNotFit, State, Trajectory
from cases.contact import belt_speed
from cases.contact.polygon_features import local_centre, places_in_regions
from cases.curves.corner import Corner, Edge, turning
from cases.curves.line_or_circle import as_circle, as_line
from cases.motion.sampled_contacts import SampledPlates
from cases.scene.contact_names import FIRST, contact_name
from cases.scene.contact_pairs import PairCase, pairs
from cases.scene.free_plates import PlateContact, names_of, parameter, plate_contacts, plates_of, why_not_closed_forms
from cases.scene.supports import is_straight

from .closed_samples import by_gap, from_first_to_last, ranges, touching
from .couple_contacts import FOOT_STEPS, couple_contacts, feet
from .pose_contact import ROUNDING, PoseContact, cone_slope, forces_of, pushing, with_columns

# Samples of a curved support.
TRACK_SAMPLES = 4_001


def has_closed_forms(case: Case) -> bool:
    """Whether all contacts that plates may have are pairs with one gap in every pose."""
    return not why_not_closed_forms(case) if case.others else refuses(case, with_curves=True) is None


def refuses(case: Case, with_curves: bool = False) -> str | None:
    """Why the contacts of a case with supports do not follow from its poses here, in one sentence, or None.
    `with_curves`: whether the engine has supports that are no straight lines."""
    for pair in pairs(case):
        if not is_straight(pair.track) and (problem := _refuses_curve(pair, with_curves)):
            return problem
        if isinstance(pair.plate.outline, Edge):
            return f"A flat side may touch the hill {pair.support!r}, which contacts from poses do not support."
        if not isinstance(pair.plate.outline, Corner) and as_circle(pair.plate.outline) is None:
            return "A plate on supports is round or has corners here, and this outline is another."
        if pair.arc_range is not None:
            return "An arc ends at a corner or bends beyond the plate's hull, which contacts from poses do not support."
    return None


def _refuses_curve(pair: PairCase, with_curves: bool) -> str | None:
    """Why a pair on a support that is no straight line without ends does not follow from its poses, or None."""
    curve, name = pair.track, pair.support
    if not with_curves:
        return f"Supports are straight lines without ends here, and {name!r} is none."
    if not curve.period and curve.domain is None:
        return f"Curved supports have ends or are closed here, and {name!r} is neither."
    if pair.effect(Belt) is not None:
        return f"Belts run on straight supports only here, and {name!r} is none."
    bend = np.asarray(curve.curvature(np.linspace(*curve.span, TRACK_SAMPLES)))
    circle = None if isinstance(pair.plate.outline, Corner) else as_circle(pair.plate.outline)
    # A disc that fits into a hollow curve everywhere, or lies on a hill, touches it in one place (Blaschke).
    if not np.all(bend <= 0.0) and (bend.min() < 0.0 or (circle and bend.max() * circle.radius >= 1.0)):
        return f"A plate may touch the support {name!r} in several places, which are not distinguished here."
    return None


def with_plates(
    case: Case,
    t: np.ndarray,
    poses: np.ndarray,
    rates: np.ndarray,
    clear: float,
    torsor: np.ndarray | None = None,
    slip_lever: float = 0.0,
    impact: float = 0.0,
) -> Trajectory:
    """`with_contacts` for `motion_of` the plates of a case."""
    return with_contacts(case, motion_of(case, t, poses, rates), clear, torsor, slip_lever, impact)


def motion_of(case: Case, t: np.ndarray, poses: np.ndarray, rates: np.ndarray) -> Trajectory:
    """A motion without contacts from (x, y, θ) and (vx, vy, ω) of all plates at the times `t`, shape (n, plates, 3)."""
    plates = {name: np.vstack([poses[:, i].T, rates[:, i].T]) for i, name in enumerate(names_of(case))}
    columns: dict[str, Any] = dict(zip(State._fields, [*plates[FIRST], *np.full((5, len(t)), np.nan)], strict=True))
    if case.others:
        columns |= {"plate_names": names_of(case), "plate_columns": SampledPlates(t, plates)}
    return Trajectory(t=t, **columns, case=case)


def with_contacts(
    case: Case,
    motion: Trajectory,
    clear: float,
    torsor: np.ndarray | None = None,
    slip_lever: float = 0.0,
    impact: float = 0.0,
) -> Trajectory:
    """The motion with the columns of each contact that closes at some time; of one plate in the order in which they
    first do.

    `clear`: the gap (m) below which a contact is closed. `torsor`: force (N) and moment (N m) of all contacts on each
    plate at the samples, shape (n, plates, 3); without it a contact is open as soon as its gap grows, and forces are
    not known. The engine's friction acts at the share `slip_lever` of the gap from the plate that is named first. A
    contact between two flights that does not last longer than `impact` (s) is an impact, closed at its first sample
    only.
    """
    plates = plates_of(case)
    poses, rates = poses_and_rates(motion)
    if has_closed_forms(case):
        some = [one for one in _contacts(case, motion.t, poses, rates, slip_lever) if (one.gap <= clear).any()]
        some = some if case.others else _in_order(some, clear)
    else:
        some = couple_contacts(case, motion.t, poses, rates, lambda xi1: np.full(len(xi1), clear), slip_lever)
    if not some and not case.others:
        return motion
    closed, rounding = [one.gap <= clear for one in some], rounding_of(case, motion)
    if torsor is None:
        closed = [by_gap(one.gap, shut, rounding) for one, shut in zip(some, closed, strict=True)]
    else:
        turning, lengths = (np.array([getattr(p, name) for p in plates], dtype=float) for name in ("turns", "reach"))
        momenta = (torsor.reshape(poses.shape) / [(1.0, 1.0, length) for length in lengths]).reshape(len(poses), -1)
        steady = [touching(one.gap, shut, rounding) for one, shut in zip(some, closed, strict=True)]
        steady = pushing(some, closed, steady, momenta, lengths, turning)
        closed = [from_first_to_last(shut, holds) for shut, holds in zip(closed, steady, strict=True)]
    closed = [_with_instants(motion.t, shut, impact) for shut in closed]
    forces = np.full((len(some), 2, len(motion.t)), np.nan)
    if torsor is not None:
        forces = forces_of(some, closed, momenta, lengths, turning)
    return with_columns(motion, some, closed, forces)


def poses_and_rates(motion: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """(x, y, θ) and (vx, vy, ω) of all plates of a sampled motion, shape (n, plates, 3)."""
    own = [motion.x, motion.y, motion.theta, motion.vx, motion.vy, motion.omega]
    each = [motion.plate_columns(name, None)[:6] for name in motion.plate_names] if motion.plate_columns else [own]
    states = np.array(each).transpose(2, 0, 1)
    return states[..., :3], states[..., 3:]


def rounding_of(case: Case, motion: Trajectory) -> float:
    """The gap (m) that rounding may leave at a closed contact of a motion."""
    poses, _ = poses_and_rates(motion)
    return ROUNDING * (
        max(plate.reach for plate in plates_of(case)) + float(np.max(np.hypot(poses[..., 0], poses[..., 1])))
    )


def _in_order(some: list[PoseContact], clear: float) -> list[PoseContact]:
    """The contacts in the order in which they first close, those of one support numbered in it."""
    result, count = list[PoseContact](), dict[str, int]()
    for one in sorted(some, key=lambda one: int(np.argmax(one.gap <= clear))):
        count[one.name] = count.get(one.name, 0) + 1
        result.append(replace(one, name=contact_name(FIRST, one.name, count[one.name])))
    return result


def _with_instants(t: np.ndarray, closed: np.ndarray, impact: float) -> np.ndarray:
    """The closed samples, of contacts between two flights that last at most `impact` (s) only the first one."""
    result = closed.copy()
    for start, stop in ranges(closed):
        if 0 < start and stop < len(t) and t[stop - 1] - t[start] <= impact:
            result[start + 1 : stop] = False
    return result


# --- the geometry of a pair ------------------------------------------------------------------------------------------


def _contacts(case: Case, t: np.ndarray, poses: np.ndarray, rates: np.ndarray, slip_lever: float) -> list[PoseContact]:
    """All contacts that the plates of a case may have, along a motion; of one plate named by their supports."""
    if case.others:
        return [_of_plates(case, contact, poses, rates, slip_lever) for contact in plate_contacts(case)]
    return [of_pair(pair, t, poses, rates, slip_lever) for pair in pairs(case)]


def of_pair(pair: PairCase, t: np.ndarray, poses: np.ndarray, rates: np.ndarray, slip_lever: float) -> PoseContact:
    """The contact of a pair of a support and a feature along a motion."""
    feature, theta = pair.plate.outline, poses[:, 0, 2]
    circle = None if isinstance(feature, Corner) else as_circle(feature)
    if circle:
        u, v = circle.centre
    elif isinstance(feature, Corner):
        u, v = feature.x, feature.y
    else:
        u, v = feature.point(_parallel(feature, _direction(pair.track) - theta))
    centre = _moved(poses[:, 0], u, v)
    xi1, away, tangent = (_on_line if is_straight(pair.track) else _on_curve)(pair.track, centre)
    radius = circle.radius if circle else 0.0
    gap, normal = away - radius, np.array([-tangent[1], tangent[0]])
    overlap = np.where(np.isfinite(gap), gap, 0.0)  # infinite next to an end
    arm = centre - poses[:, 0, :2].T - normal * (radius + slip_lever * overlap)
    slip = np.sum(tangent * _velocity(rates[:, 0], arm), axis=0) - belt_speed(pair, t)
    xi2 = _outline_parameter(pair, tangent, theta)
    return PoseContact(
        pair.support, 0, None, cone_slope(pair.effect), gap, slip, tangent, normal, xi1, xi2, arm, np.zeros_like(arm)
    )


def _of_plates(
    case: Case, contact: PlateContact, poses: np.ndarray, rates: np.ndarray, slip_lever: float
) -> PoseContact:
    body, base, circle, theta = contact.body, contact.base, contact.circle, poses[:, contact.body, 2]
    centre = _moved(poses[:, body], circle.x, circle.y)
    if base is None:
        assert contact.curve is not None, "checked by the case"
        xi1, away, tangent = _on_line(contact.curve, centre)
        gap, normal = away - circle.radius, np.array([-tangent[1], tangent[0]])
    else:
        gap, normal, xi1 = _on_plate(case, contact, centre, poses[:, base])
        tangent = np.array([normal[1], -normal[0]])
    place = centre - (circle.radius + slip_lever * gap) * normal
    arm = place - poses[:, body, :2].T
    velocity, base_arm = _velocity(rates[:, body], arm), np.zeros_like(arm)
    if base is not None:
        base_arm = place - poses[:, base, :2].T
        velocity = velocity - _velocity(rates[:, base], base_arm)
    if circle.radius == 0.0:
        xi2 = circle.outline_parameter(np.arctan2(tangent[1], tangent[0]) - theta)
    else:
        inwards = np.unwrap(np.arctan2(-normal[1], -normal[0]))
        xi2 = np.asarray(parameter(plates_of(case)[body].outline, inwards - theta))
    slip, mu = np.sum(velocity * tangent, axis=0), cone_slope(contact.effect)
    return PoseContact(contact.name, body, base, mu, gap, slip, tangent, normal, xi1, xi2, arm, base_arm)


def _moved(poses: np.ndarray, u, v) -> np.ndarray:
    """Where the point (u, v) of a plate is in its poses (n, 3), shape (2, n), m."""
    x, y, theta = poses.T
    c, s = np.cos(theta), np.sin(theta)
    return np.array([x + c * u - s * v, y + s * u + c * v])


def _on_plate(
    case: Case, contact: PlateContact, centre: np.ndarray, pose: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gap (m), normal and parameter of a contact with another plate, of poses (n, 3)."""
    if contact.around:
        u, v = local_centre(pose.T, *centre)
        gap, a, b, xi1 = places_in_regions(contact.around, u, v, contact.circle.radius)
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        return gap, np.array([c * a - s * b, s * a + c * b]), xi1
    off = centre - pose[:, :2].T
    far = np.hypot(*off)
    assert contact.base is not None
    polar = np.unwrap(np.arctan2(off[1], off[0]))
    xi1 = np.asarray(parameter(plates_of(case)[contact.base].outline, polar - pose[:, 2]))
    return far - contact.circle.radius - contact.base_radius, off / far, xi1


def _velocity(rates: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The velocity (2, n) of a plate's point at `arm` (2, n) from its origin, of rates (n, 3)."""
    vx, vy, omega = rates.T
    return np.array([vx - omega * arm[1], vy + omega * arm[0]])


def _direction(track: Curve) -> float:
    """The angle of a straight support, rad."""
    line = as_line(track)
    if line is None:
        raise DoesNotFit(
            "a plate that is neither round nor has corners is followed on straight tracks and supports only"
        )
    return float(np.arctan2(line.direction[1], line.direction[0]))


def _parallel(outline: Curve, angle: np.ndarray) -> np.ndarray:
    """The parameters (n,) at which the tangent of a closed convex outline has these angles, rad: there a line of that
    angle touches it, by (6). Newton's method from the nearest of its samples."""
    samples = np.linspace(*outline.span, TRACK_SAMPLES)
    angles = np.unwrap(np.asarray(outline.tangent_angle(samples)))
    way = np.sign(angles[-1] - angles[0])
    low = min(angles[0], angles[-1])
    target = low + (angle - low) % (2.0 * pi)
    xi2 = np.interp(way * target, way * angles, samples)
    for _ in range(FOOT_STEPS):
        off = target - np.asarray(outline.tangent_angle(xi2))
        off -= 2.0 * pi * np.round(off / (2.0 * pi))
        xi2 = xi2 + off / (np.asarray(outline.curvature(xi2)) * np.asarray(outline.speed(xi2)))
    return xi2


def _on_line(track: Curve, place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where points (2, n) are nearest to a straight support: its parameter, their distance (m), its tangent (2, n)."""
    line = as_line(track)
    assert line is not None
    tangent, off = line.direction, place - np.asarray(line.point)[:, None]
    low = float(track.span[0])
    start = np.asarray(track.point(low)) - line.point
    xi1 = low + (tangent @ (off - start[:, None])) / float(track.speed(low))
    return xi1, np.array([-tangent[1], tangent[0]]) @ off, np.broadcast_to(tangent[:, None], off.shape)


def _on_curve(track: Curve, place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same for a curve, from the nearest sample; next to an end the distance is infinite."""
    parameters = np.linspace(*track.span, TRACK_SAMPLES)
    near = cKDTree(track.point(parameters).T).query(place.T)[1]
    xi1 = feet(track, place, parameters[near], parameters[1] - parameters[0])
    tangent, off = track.tangent(xi1), place - track.point(xi1)
    away = tangent[0] * off[1] - tangent[1] * off[0]
    if track.domain is not None and not track.period:
        away = np.where((xi1 > track.domain[0]) & (xi1 < track.domain[1]), away, np.inf)
    return xi1, away, tangent


def _outline_parameter(pair: PairCase, tangent: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """The whole outline's parameter where its tangent is the support's, by (6); a circle's is its angle."""
    feature, direction = pair.plate.outline, np.arctan2(tangent[1], tangent[0])
    if not isinstance(feature, Corner) and as_circle(feature) is None:
        return _parallel(feature, direction - theta)
    middle = 0.5 * sum(feature.span)
    rate = turning(feature, middle)
    turn = direction - theta - float(feature.tangent_angle(middle))
    part = turn - 2.0 * pi * np.round(turn / (2.0 * pi))
    return np.asarray(pair.whole_xi2(middle + part / rate))
