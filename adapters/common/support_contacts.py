"""Contacts of a plate on supports, from the poses and velocities of a motion alone.

Each pair of a support and a feature of the outline (a corner, an arc, a whole circle) has one gap in every pose. It is
closed while the gap is below what the engine's step leaves, and, where other contacts of the same motion are closed
too, while these alone could not give the plate its change of momentum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np
from scipy.optimize import nnls

from cases import Belt, Case, CoulombFriction, Curve, DoesNotFit, PerfectlyRough, Trajectory
from cases.contact import belt_speed
from cases.curves.corner import Corner, Edge, turning
from cases.curves.curve_samples import SampleStretches
from cases.curves.line_or_circle import as_circle, as_line
from cases.motion.sampled_contacts import SampledContacts
from cases.motion.trajectory import ContactColumns
from cases.scene.contact_limits import touches_by_features
from cases.scene.contact_names import FIRST, contact_name
from cases.scene.contact_pairs import PairCase, pairs
from cases.scene.supports import is_straight

from . import several_contacts
from .closed_samples import by_gap, from_first_to_last

# A contact force below this part of the whole is none: noise of a step's momentum in engines of single precision.
UNNEEDED = 1e-3
# A contact that is faster than this part of the fastest slip is no creep of an engine's stick.
SURE_SLIP = 0.1
# The error of a closed contact's gap, for coordinates of size 1, in a motion whose solver keeps it closed: that of an
# integrator between its steps at a tolerance of 1e-10 (DOP853: 1.2e-12 m in a groove), and of files with ten digits.
ROUNDING = 1e-10
# Samples of a curved support, and Newton's steps from the nearest of them: each squares the error.
TRACK_SAMPLES, FOOT_STEPS = 4_001, 6
# The angle of a cone that no force leaves.
ROUGH = 1e6


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


def refuses_several(case: Case) -> str | None:
    """Why the several contacts of a case, on supports or on its track, do not follow from its poses, or None."""
    return refuses(case, True) if touches_by_features(case) else several_contacts.supports(case)


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


@dataclass(frozen=True)
class _Contact:
    """One pair along a motion, arrays of n samples: gap (m), contact point relative to the centre of mass, (2, n), the
    parameter of the support's curve, and unit tangent and normal of the support, (2, n)."""

    pair: PairCase
    gap: np.ndarray
    lever: np.ndarray
    xi1: np.ndarray
    tangent: np.ndarray
    normal: np.ndarray

    def slip(self, motion: Trajectory) -> np.ndarray:
        """The slip velocity relative to the support's surface, m/s."""
        u = motion.vx - motion.omega * self.lever[1]
        v = motion.vy + motion.omega * self.lever[0]
        return self.tangent[0] * u + self.tangent[1] * v - belt_speed(self.pair, motion.t)

    def cone(self, sample: int) -> np.ndarray:
        """The two edges of the friction cone at a sample, shape (2, 2)."""
        friction = self.pair.effect(CoulombFriction)
        mu = ROUGH if self.pair.effect(PerfectlyRough) else friction.at_rest if friction else 0.0
        normal, tangent = self.normal[:, sample], self.tangent[:, sample]
        return np.array([normal + mu * tangent, normal - mu * tangent]) / np.hypot(1.0, mu)


def with_supports(
    case: Case, motion: Trajectory, clear: float, torsor: np.ndarray | None = None, slip_lever: float = 0.0
) -> Trajectory:
    """The motion with the columns of each contact that closes at some time, in the order in which they first do.

    `clear`: the gap (m) below which a contact is closed. `torsor`: force (N) and moment (N m) of all contacts at the
    samples, shape (n, 3); with it, contacts that do not push are open, and the only closed contact has its force;
    without it, a contact that opens slowly is open as soon as its gap grows. The engine's friction acts at the share
    `slip_lever` of the gap from the plate.
    """
    every = [_contact(pair, motion, slip_lever) for pair in pairs(case)]
    closed = [one.gap <= clear for one in every]
    first_ones = [i for i in range(len(every)) if closed[i].any()]
    order = sorted(first_ones, key=lambda i: (int(np.argmax(closed[i])), i))
    if not order:
        return motion
    contacts, is_closed = [every[i] for i in order], [closed[i] for i in order]
    if torsor is not None:
        is_closed = _pushing(contacts, is_closed, torsor, motion, case.plate.reach)
    else:
        rounding = rounding_of(case, motion)
        is_closed = [by_gap(one.gap, shut, rounding) for one, shut in zip(contacts, is_closed, strict=True)]
    columns, names = dict[str, ContactColumns](), list[str]()
    count = np.sum(is_closed, axis=0)
    for one, shut in zip(contacts, is_closed, strict=True):
        number = 1 + sum(name.split()[0] == contact_name(FIRST, one.pair.support, 1) for name in names)
        names.append(contact_name(FIRST, one.pair.support, number))
        columns[names[-1]] = _columns(one, motion, shut, count, torsor)
    by_name = dict(zip(names, is_closed, strict=True))
    return _with_columns(motion, columns, by_name)


def rounding_of(case: Case, motion: Trajectory) -> float:
    """The gap (m) that rounding may leave at a closed contact of a motion."""
    return ROUNDING * (case.plate.reach + float(np.max(np.hypot(motion.x, motion.y))))


def _with_columns(motion: Trajectory, columns: dict[str, ContactColumns], closed: dict[str, np.ndarray]) -> Trajectory:
    return replace(
        motion,
        **several_contacts.first_closed(motion, columns, closed),
        contact_names=tuple(columns),
        contact_columns=SampledContacts(motion.t, columns),
    )


def _contact(pair: PairCase, motion: Trajectory, slip_lever: float) -> _Contact:
    feature = pair.plate.outline
    circle = None if isinstance(feature, Corner) else as_circle(feature)
    radius = circle.radius if circle else 0.0
    if circle:
        u, v = circle.centre
    elif isinstance(feature, Corner):
        u, v = feature.x, feature.y
    else:
        u, v = feature.point(_parallel(feature, _direction(pair.track) - motion.theta))
    c, s = np.cos(motion.theta), np.sin(motion.theta)
    arm = np.array([c * u - s * v, s * u + c * v])
    place = arm + np.array([motion.x, motion.y])
    xi1, away, tangent = (_on_line if is_straight(pair.track) else _on_curve)(pair.track, place)
    gap, normal = away - radius, np.array([-tangent[1], tangent[0]])
    return _Contact(pair, gap, arm - normal * (radius + slip_lever * gap), xi1, tangent, normal)


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
    """The same for a curve, by Newton's method from the nearest sample; next to an end the distance is infinite."""
    parameters = np.linspace(*track.span, TRACK_SAMPLES)
    near = SampleStretches.of(track.point(parameters).T).nearest(place.T)
    xi1 = start = parameters[near]
    width = parameters[1] - parameters[0]
    for _ in range(FOOT_STEPS):
        x, y, xp, yp, xs, ys, *_ = track.jets(xi1)
        dx, dy = place[0] - x, place[1] - y
        slope = dx * xs + dy * ys - xp * xp - yp * yp
        step = np.divide(dx * xp + dy * yp, slope, out=np.zeros_like(slope), where=slope < 0.0)
        xi1 = np.clip(xi1 - step, start - width, start + width)
    tangent, off = track.tangent(xi1), place - track.point(xi1)
    away = tangent[0] * off[1] - tangent[1] * off[0]
    if track.domain is not None and not track.period:
        away = np.where((xi1 > track.domain[0]) & (xi1 < track.domain[1]), away, np.inf)
    return xi1, away, tangent


def _columns(
    one: _Contact, motion: Trajectory, closed: np.ndarray, count: np.ndarray, torsor: np.ndarray | None
) -> ContactColumns:
    alone = closed & (count == 1)
    forces = []
    for axis in (one.normal, one.tangent):
        force = np.where(closed, np.nan, 0.0)
        if torsor is not None:
            force[alone] = (torsor[alone, :2] * axis[:, alone].T).sum(axis=1)
        forces.append(force)
    return ContactColumns(
        gap=one.gap,
        slip=np.where(closed, one.slip(motion), np.nan),
        normal_force=forces[0],
        friction_force=forces[1],
        xi1=one.xi1,
        xi2=_outline_parameter(one, motion.theta),
        normal_range=np.array([forces[0], forces[0]]),
        friction_range=np.array([forces[1], forces[1]]),
    )


def _outline_parameter(one: _Contact, theta: np.ndarray) -> np.ndarray:
    """The whole outline's parameter where its tangent is the support's, by (6); a circle's is its angle."""
    feature, direction = one.pair.plate.outline, np.arctan2(one.tangent[1], one.tangent[0])
    if not isinstance(feature, Corner) and as_circle(feature) is None:
        return _parallel(feature, direction - theta)
    middle = 0.5 * sum(feature.span)
    rate = turning(feature, middle)
    turn = direction - theta - float(feature.tangent_angle(middle))
    part = turn - 2.0 * pi * np.round(turn / (2.0 * pi))
    return np.asarray(one.pair.whole_xi2(middle + part / rate))


def _pushing(
    contacts: Sequence[_Contact], closed: list[np.ndarray], torsor: np.ndarray, motion: Trajectory, size: float
) -> list[np.ndarray]:
    """Which of the contacts with small gaps are closed: from their first push to their last one.

    A contact pushes unless the others alone give the torsor, with forces in their cones, or on the edge of the cone
    where they slip; moments are divided by the plate's `size` (m). Where several contacts can give what is missing, all
    of them push. In between a contact that is detected by its overlap may push in some steps only.
    """
    torsors = torsor / np.array([1.0, 1.0, size])
    usual = float(np.median(np.linalg.norm(torsors, axis=1)))
    slips = np.array([one.slip(motion) for one in contacts])
    way = np.sign(np.where(np.abs(slips) > SURE_SLIP * np.abs(slips).max(), slips, 0.0))
    pushing = [shut.copy() for shut in closed]
    for i in np.flatnonzero(np.sum(closed, axis=0) > 1):
        target = torsors[i]
        least = UNNEEDED * max(usual, float(np.linalg.norm(target)))
        here = [k for k in range(len(contacts)) if closed[k][i]]
        edges = {k: _edges(contacts[k], int(i), size, int(way[k, i])) for k in here}
        for k in here:
            others = np.hstack([edges[other] for other in here if other != k])
            pushing[k][i] = nnls(others, target)[1] > least
        core = [edges[k] for k in here if pushing[k][i]]
        if not core or nnls(np.hstack(core), target)[1] > least:
            for k in here:
                pushing[k][i] = True
    return [from_first_to_last(*each) for each in zip(closed, pushing, strict=True)]


def _edges(contact: _Contact, sample: int, size: float, way: int) -> np.ndarray:
    """The edges of a contact's friction cone as torsors, columns of shape (3, 2), or the one of a contact that slips
    forwards (`way` 1) or backwards (−1)."""
    lever, both = contact.lever[:, sample], contact.cone(sample)
    cone = {0: both, 1: both[1:], -1: both[:1]}[way]
    return np.array([[fx, fy, (lever[0] * fy - lever[1] * fx) / size] for fx, fy in cone]).T
