"""Curves as polygons, for engines with straight shapes: the reachable part of a track, and the best polygon.

Independent of any engine. Lengths in metres.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import NamedTuple

import numpy as np

from cases import Belt, Case, Chain, Curve, Drive, Flight, Load
from cases.contact import pose, start_motion
from cases.curves.line_or_circle import Circle, Line, as_circle, as_line
from cases.motion.mechanics import gravity, kinetic_energy
from cases.moving_frame import relative_case
from cases.scene.free_plates import plates_of, start_poses


class Stretch(NamedTuple):
    """The part of a track the plate can reach: parameters, arc length (m), whether closed, top speed (m/s) on it."""

    low: float
    high: float
    length: float
    closed: bool
    top_speed: float


def track_kind(case: Case) -> str:
    """The track's shape for an engine with few shapes: "line", "hill" (a whole circle, from outside) or "chain"."""
    if as_line(case.track):
        return "line"
    return "hill" if is_round_hill(case.track) else "chain"


def is_round_hill(curve: Curve) -> bool:
    """Whether a curve is a whole circle, from outside."""
    circle = as_circle(curve)
    return bool(circle and not circle.left and curve.period)


def in_facets(case: Case) -> list[Curve]:
    """The supports that engines with few shapes have as facets: neither lines nor whole circles from outside."""
    return [s.curve for s in case.supports if not as_line(s.curve) and not is_round_hill(s.curve)]


def longest_in_facets(case: Case) -> float:
    """The length (m) of the longest curve in facets: the reachable part of the track, or a support; 0 without any."""
    lengths = [curve.length(*curve.span) for curve in in_facets(case)]
    return max([*lengths, stretch(case).length if track_kind(case) == "chain" else 0.0])


# Facets of a curve that a person would type in.
MODEST = 64


def facets_for(case: Case, h: float | None) -> int:
    """The number of facets of the longest curve for the step h (s): each as long as a step's displacement at top speed,
    as shorter ones only cost time; without a step those of a first-time user."""
    way = stretch(case).top_speed * h if h else 0.0
    return max(MODEST, round(longest_in_facets(case) / way)) if way else MODEST


def share_of_facets(case: Case, length: float, count: int) -> int:
    """The number of facets of a curve of that length (m) where the longest one has `count`."""
    return max(1, round(count * length / longest_in_facets(case)))


def fixed_chain(case: Case, curve: Curve, count: int, behind: float = 0.0) -> tuple[np.ndarray, bool]:
    """Corners, shape (2, n), of the facets of the track or a support, where the longest curve has `count`, and whether
    they are closed; `behind` as of `chain`."""
    if curve is case.track:
        return chain(case, count, behind), stretch(case).closed
    share = share_of_facets(case, curve.length(*curve.span), count)
    return _facets(curve, *curve.span, share, behind), curve.period is not None


def round_plate(case: Case) -> Circle | None:
    """The outline as a circle, about the centre of mass or not; None if it is no circle."""
    return whole_circle(case.plate.outline)


def whole_circle(outline: Curve) -> Circle | None:
    """A closed curve as a circle; None if it is no circle."""
    return as_circle(outline) if outline.period else None


@lru_cache(maxsize=64)
def sway(outline: Curve) -> float:
    """The largest distance (m) of the outline's centres of curvature from the centre of mass along its normals.

    At most the outline's reach. Times the spin squared, it is the normal force per mass that a plate rolling on a level
    line needs in addition to its weight.
    """
    s = np.linspace(*outline.span, 721)
    point, inwards, bend = outline.point(s), outline.normal(s), outline.curvature(s)
    reach = float(np.hypot(*point).max())
    with np.errstate(divide="ignore"):
        off = np.abs(1.0 / bend + np.sum(point * inwards, axis=0))
    return float(np.minimum(off, reach).max())


@lru_cache(maxsize=16)
def stretch(case: Case) -> Stretch:
    """The part of the track that the plate can reach, by its energy and within the case's duration.

    Only a Load, a Belt or a Drive adds energy, so the plate stays where its potential is below its initial energy; and
    its speed cannot grow faster than g. A margin of the plate's size is added at both ends.
    """
    if case.effect(Drive):  # in the frame of the track, where gravity may be a load
        relative = _everywhere(relative_case(case))
        return relative._replace(top_speed=relative.top_speed + float(np.hypot(*gravity(case))) * case.duration)
    start, plate, pull = start_motion(case), case.plate, gravity(case)
    if case.effect(Load) or case.effect(Belt) or isinstance(case.track, Chain):
        return _everywhere(case)
    kinetic_start = energy = float(kinetic_energy(case, start)) / plate.mass
    # A start off the track is higher, or lower, than the pose of contact there.
    on_track = np.array(pose(case, start.xi1, start.xi2)[:2])
    energy += float(pull @ (on_track - (start.x, start.y)))
    # The centre of a plate that is no disc may be lower than `_walk` assumes, by this length.
    energy += float(np.hypot(*pull)) * (plate.reach - plate.inner)
    longest = (np.sqrt(2 * max(energy, kinetic_start)) + np.hypot(*pull) * case.duration) * case.duration
    ways = [_walk(case, start.xi1, way, energy, longest, plate.reach) for way in (-1, 1)]
    (low, back, fast), (high, ahead, faster) = ways
    period = case.track.period
    if period and high - low >= period:
        low, high = start.xi1 - period / 2, start.xi1 + period / 2
        length = float(np.mean(case.track.speed(np.linspace(low, high, 721)[:-1]))) * period
        return Stretch(low, high, length, True, max(fast, faster))
    return Stretch(low, high, back + ahead, False, max(fast, faster))


# How far from its start a plate with a load is followed on a track without ends, in sizes of the plate.
FAR = 1e4
# A walk along a track without ends begins with this many sizes of the plate, and doubles at most this often: a track
# with an unlimited parameter may still end (tanh s, 0).
FIRST, DOUBLINGS = 10.0, 100


def _everywhere(case: Case) -> Stretch:
    """The whole track: a load or a belt may take the plate anywhere. The top speed is what gravity gives within the
    duration, and the belt's."""
    track = case.track
    if track.domain is not None:
        low, high = track.domain
    else:  # a chain, whose speed is zero at its corners, has ends or a period
        half = track.period / 2 if track.period else FAR * case.plate.reach / float(track.speed(case.start.xi1))
        low, high = case.start.xi1 - half, case.start.xi1 + half
    length = float(np.mean(track.speed(np.linspace(low, high, 2001)))) * (high - low)
    start, belt = start_motion(case), case.effect(Belt)
    fast = float(np.hypot(start.vx, start.vy) + np.hypot(*gravity(case)) * case.duration)
    if belt:
        fast += float(np.max(np.abs(belt.at_arrays(np.linspace(0.0, case.duration, 2001)))))
    return Stretch(low, high, length, track.period is not None, fast)


def _walk(case: Case, xi1: float, way: int, energy: float, longest: float, margin: float) -> tuple[float, float, float]:
    """Farthest parameter reached in one direction, the arc length to it, and the top speed on the way."""
    track, flies = case.track, case.effect(Flight) is not None
    far = FIRST * case.plate.reach / float(track.speed(xi1))
    has_end = track.period is not None or track.domain is not None
    if track.period:
        far = track.period
    elif track.domain:
        far = track.domain[1] - xi1 if way > 0 else xi1 - track.domain[0]
    for _ in range(DOUBLINGS):
        # 2000 steps per walk resolve every curve that an author could draw.
        s = xi1 + way * np.linspace(0.0, far, 2001)
        with np.errstate(all="ignore"):
            point, speed = track.point(s), track.speed(s)
            is_track = np.isfinite(point).all(axis=0) & np.isfinite(speed) & (speed > 0.0)
        if not is_track.all():  # beyond the range of doubles: stop before
            far, has_end = far * max(int(np.argmin(is_track)) - 1, 1) / 2000, True
            continue
        run = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) * far / 2000
        away = np.hypot(*(point - point[:, :1])) if flies else run
        if has_end or away[-1] > longest + margin:
            break
        far *= 2.0
    centre = point + case.plate.radius * track.normal(s) if case.plate.radius else point
    kinetic = energy + gravity(case) @ (centre - centre[:, :1])
    reachable = (kinetic >= 0.0) & (away <= longest)
    if flies:
        # A plate in flight may pass places that are too high: up to the last reachable one.
        last = int(np.max(np.flatnonzero(reachable), initial=0))
    else:
        last = (len(s) if reachable.all() else max(int(np.argmin(reachable)), 1)) - 1
    # Interpolate between two samples, so that the result does not depend on their positions.
    part = min(_positive_share(kinetic[last : last + 2]), _positive_share(longest - away[last : last + 2]))
    stop = last + part
    run_end = min(float(np.interp(stop, np.arange(len(s)), run)) + margin, float(run[-1]))
    fastest = max(float(np.max(kinetic[: last + 1])), float(np.interp(stop, np.arange(len(s)), kinetic)), 0.0)
    return float(np.interp(run_end, run, s)), run_end, float(np.sqrt(2 * fastest))


def _positive_share(values: np.ndarray) -> float:
    """The fraction of the interval between two samples on which a linear function stays positive.

    1 if it is positive at both, or if there is no second sample.
    """
    if len(values) < 2 or values[1] >= 0.0:
        return 1.0
    first, second = max(float(values[0]), 0.0), float(values[1])
    return first / (first - second) if np.isfinite(second) else 0.0


def visible_span(case: Case) -> tuple[float, float]:
    """The parameter range of the track that an exported scene contains.

    The whole track if it has ends or a period, else the part that the plate can reach, at most `FAR` of its sizes to
    either side, where positions still have enough digits. Of several plates, what any of them may reach.
    """
    track, xi1 = case.track, case.start.xi1
    if track.domain is not None or track.period:
        return track.span
    if case.others and (line := as_line(track)):
        first, last = ends(case, line)
        half = 0.5 * float(np.hypot(*(last - first))) / float(track.speed(xi1))
        return xi1 - half, xi1 + half
    part, far = stretch(case), FAR * case.plate.reach / float(track.speed(xi1))
    return max(part.low, xi1 - far), min(part.high, xi1 + far)


def visible_chain(case: Case, count: int) -> np.ndarray:
    """Corners, shape (2, n), of `count` facets of the track that an exported scene contains, even in its parameter."""
    if isinstance(case.track, Chain):
        return chain_vertices(case.track, count)
    s, step = np.linspace(*visible_span(case), count + 1, retstep=True)
    return _outside(case.track, s, step * case.track.speed(s), 0.0)


def sharpest_bend(case: Case) -> float:
    """The largest curvature (1/m) of the part of the track that an exported scene contains, without its corners."""
    bends = np.abs(case.track.curvature(np.linspace(*visible_span(case), 721)))
    return float(np.max(bends, initial=0.0, where=np.isfinite(bends)))


def ends(case: Case, line: Line) -> np.ndarray:
    """Two points (m) of a straight support, shape (2, 2), beyond what any plate reaches within the duration.

    In the norm of the kinetic energy the velocity of all plates grows by at most that norm of gravity.
    """
    start, pull = start_motion(case), float(np.hypot(*gravity(case)))
    poses, plates = start_poses(case), plates_of(case)
    masses, sizes = np.array([plate.mass for plate in plates]), np.array([plate.reach for plate in plates])
    speeds = np.hypot(poses[:, 3], poses[:, 4]) + np.abs(poses[:, 5]) * sizes
    share = np.sqrt(masses.sum() / masses.min())
    spread = float(np.hypot(poses[:, 0] - start.x, poses[:, 1] - start.y).max())
    fastest = share * float(speeds.max())
    way = 2.0 * (spread + sizes.max() + fastest * case.duration + 0.5 * share * pull * case.duration**2)
    middle = line.point + line.direction * float(line.direction @ ((start.x, start.y) - line.point))
    return np.array([middle - way * line.direction, middle + way * line.direction])


def chain(case: Case, count: int, behind: float = 0.0) -> np.ndarray:
    """Corners, shape (2, count + 1), of `count` equally long facets along the stretch, `behind` (m) the track: facets
    of that radius touch it."""
    part = stretch(case)
    if isinstance(case.track, Chain):
        return chain_vertices(case.track, count)
    count = share_of_facets(case, part.length, count) if case.supports else count
    return _facets(case.track, part.low, part.high, count, behind)


def chain_vertices(curve: Chain, count: int) -> np.ndarray:
    """Corners of a chain's polygon, shape (2, n): its own corners and joints, and on bent pieces as many as a circle of
    `count` corners has on the same turn. They lie on the curve."""
    points = curve.point(curve.vertices(2 * pi / count))
    return points[:, np.insert(np.hypot(*np.diff(points, axis=1)) > 0.0, 0, True)]


def rim(outline: Curve, count: int, inside: float = 0.0) -> np.ndarray:
    """Corners, shape (2, count + 1), of `count` equally long facets along an outline of any shape, closed or open,
    `inside` (m) the outline: facets of that radius touch it."""
    return _facets(outline, *outline.span, count, -inside)


def _facets(curve: Curve, low: float, high: float, count: int, behind: float) -> np.ndarray:
    """Corners of equally long facets, to the right of the curve by `behind` (m).

    They lie outside a bend by κ L²/12, the mean of the sagitta, so that the facets' mean distance is right.
    """
    s, length = _even(curve, low, high, count)
    return _outside(curve, s, length / count, behind)


def _outside(curve: Curve, s: np.ndarray, length: float | np.ndarray, behind: float) -> np.ndarray:
    """Corners at these parameters of facets of that length (m), to the right of the curve."""
    return curve.point(s) - (behind + curve.curvature(s) * length**2 / 12) * curve.normal(s)


def _even(curve: Curve, low: float, high: float, count: int) -> tuple[np.ndarray, float]:
    """Parameters at equal distances along a curve, and its length (m)."""
    fine = np.linspace(low, high, max(4 * count, 4000) + 1)
    speed = curve.speed(fine)
    run = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])
    return np.interp(np.linspace(0.0, run[-1], count + 1), run, fine), float(run[-1])


def polygon(outline: Curve, count: int) -> np.ndarray:
    """Corners, shape (2, count), at equal turns of a convex outline's tangent, scaled to the area of the outline.

    Equal turns put the corners where the outline bends most, so that every corner loses the same energy.
    """
    if isinstance(outline, Chain):
        return chain_vertices(outline, count)[:, :-1]
    s = np.linspace(*outline.span, 64 * 721)
    # On straight parts of the outline rounding makes the tangent's angle decrease in places.
    angle = np.maximum.accumulate(outline.tangent_angle(s))
    corners = outline.point(np.interp(angle[0] + 2 * pi * np.arange(count) / count, angle, s))
    return np.sqrt(_area(*outline.point(s[:-1])) / _area(*corners)) * corners


def _area(x: np.ndarray, y: np.ndarray) -> float:
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


# The rounding of a curvature of zero, relative to the outline's largest curvature.
_FLAT = 1e-9


def is_convex(outline: Curve) -> bool:
    """Whether the outline is closed and nowhere bends inwards, as an engine's polygons require."""
    if isinstance(outline, Chain):
        bends = [piece.curvature(np.linspace(*piece.span, 65)) for piece in outline.pieces]
        least, most = min(float(np.min(b)) for b in bends), max(float(np.max(b)) for b in bends)
        return (
            bool(outline.period)
            and not has_hollow_corners(outline)
            and least >= -_FLAT * max(most, 1.0 / outline.sizes[0])
        )
    bend = outline.curvature(np.linspace(*outline.span, 721))
    return bool(outline.period) and bool(bend.min() >= -_FLAT * bend.max())


def has_hollow_corners(outline: Curve) -> bool:
    """Whether an outline has corners that point inwards."""
    return isinstance(outline, Chain) and any(corner.turn < 0.0 for corner in outline.corners)


def sees_all(outline: Curve) -> bool:
    """Whether every point of the outline is visible from the centre of mass, as a fan of triangles requires."""
    s = np.linspace(*outline.span, 721)
    return bool(np.all(np.sum(outline.point(s) * outline.normal(s), axis=0) < 0.0))


def _chain_sagitta(curve: Chain, count: int | None) -> float:
    """The largest distance (m) of a chain from its polygon with that many corners on a full turn."""
    bent = [piece for piece in curve.pieces if piece.features is not None]
    if not count or not bent:
        return 0.0
    radius = max(float(1.0 / np.abs(piece.curvature(np.linspace(*piece.span, 65))).min()) for piece in bent)
    return radius * (2 * pi / count) ** 2 / 8


def sagitta(case: Case, facets: int | None, vertices: int | None) -> float:
    """The distance (m) of the track's facets and the outline's polygon from the curves; None: the shape is exact."""
    off = 0.0
    if isinstance(case.track, Chain):
        off, facets = _chain_sagitta(case.track, facets), None
    if isinstance(case.plate.outline, Chain):
        off, vertices = off + _chain_sagitta(case.plate.outline, vertices), None
    if facets:
        part = stretch(case)
        bends = [case.track.curvature(np.linspace(part.low, part.high, 721))]
        bends += [curve.curvature(np.linspace(*curve.span, 721)) for curve in in_facets(case)]
        length = longest_in_facets(case) if case.supports else part.length
        off += float(np.abs(bends).max()) * (length / facets) ** 2 / 8
    if vertices and is_convex(case.plate.outline):
        # A chord of length L over a turn of δ has the sagitta L δ/8.
        corners = polygon(case.plate.outline, vertices)
        longest = float(np.hypot(*(np.roll(corners, -1, axis=1) - corners)).max())
        off += longest * (2 * pi / vertices) / 8
    elif vertices:
        outline = case.plate.outline
        s, length = _even(outline, *outline.span, vertices)
        off += float(np.abs(outline.curvature(s)).max()) * (length / vertices) ** 2 / 8
    return off
