"""Contact geometry of two curves, a track and the outline of a plate: contact points, gaps, slip.

Independent of cases and solvers; `cases.contact` has the same functions for a case. Positions in metres, angles in
radians; (5), (6), (11), (12) are the paper's equations.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, hypot, inf, nan, pi, sin
from typing import NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Piece, turning
from ..errors import DoesNotFit
from .pair_search import Contact, pair_search

EPS = float(np.finfo(float).eps)

# Two parameters of an outline closer than this, in units of a period over 2π, are the same one, found from both sides
# of the seam: Newton's method leaves roundings.
SAME = 1e-9
# From this angle (rad) on, its cosine and sine come from the tangents: the angle's own rounding would turn the plate by
# more than 1e-10. (A load may spin a disc to 1e14 rad.)
MANY_TURNS = 1e6
# Newton's method for the foot of a point on a piece: quadratic near the foot, so that these are many.
MOST_STEPS = 50
# Samples at which the bend of a piece is looked at.
BEND_SAMPLES = 2_001


class MotionPoint(NamedTuple):
    """Pose, velocities and contact parameters with their rates (NaN off the track) at one instant."""

    x: float
    y: float
    theta: float
    vx: float
    vy: float
    omega: float
    xi1: float
    xi2: float
    xi1_dot: float
    xi2_dot: float
    slip: float


def pose(track: Curve, outline: Curve, xi1, xi2):
    """(x, y, theta) of the plate that touches at (xi1, xi2): (6) gives θ, (5) gives R₀. Numbers or arrays."""
    ((X, Y), along_track), ((x, y), along_outline) = track.place(xi1), outline.place(xi2)
    theta = along_track - along_outline
    c, s = np.cos(theta), np.sin(theta)
    many = np.abs(theta) > MANY_TURNS
    if np.any(many):
        (T, S), (t, u) = track.tangent(xi1), outline.tangent(xi2)
        c, s = np.where(many, T * t + S * u, c), np.where(many, S * t - T * u, s)
    return X - (c * x - s * y), Y - (s * x + c * y), theta


def velocity(track: Curve, outline: Curve, xi1: float, xi2: float, slip: float, omega: float) -> MotionPoint:
    """The plate's motion in contact with slip velocity `slip` (m/s, along the track's tangent) and spin `omega`. Raises
    DoesNotFit where plate and track have the same curvature."""
    if isinstance(track, Chain | Corner) or isinstance(outline, Chain | Corner):
        return _velocity_on_pieces(track, outline, xi1, xi2, slip, omega)
    P, p = float(track.speed(xi1)), float(outline.speed(xi2))
    bend_track, bend_outline = float(track.curvature(xi1)), float(outline.curvature(xi2))
    # The tangents turn together: κ_track ṡ_track = ω + κ_outline ṡ_outline, and slip = ṡ_track − ṡ_outline by (12).
    if bend_track == bend_outline:
        raise DoesNotFit(
            f"the plate does not fit its track at xi1 = {xi1:g}: both have the curvature {bend_track:.4g} 1/m; give a "
            "smaller plate or a wider track"
        )
    along_track = (omega - bend_outline * slip) / (bend_track - bend_outline)
    along_outline = along_track - slip
    return _moving(track, outline, (xi1, xi2), (along_track / P, along_outline / p), slip, omega)


def _moving(
    track: Curve, outline: Curve, places: tuple[float, float], rates: tuple[float, float], slip: float, omega: float,
    gap: float = 0.0, gap_rate: float = 0.0,
) -> MotionPoint:  # fmt: skip
    """The plate's motion with that slip velocity and spin; `rates` are those of the contact parameters, `gap` and
    `gap_rate` as for `velocity_apart`."""
    xi1, xi2 = places
    x, y, theta = (float(value) for value in pose(track, outline, xi1, xi2))
    (tx, ty), contact = track.tangent(xi1), track.point(xi1)
    # (11) solved for the velocity of the centre of mass: v = Ṙ₀ + ω U (R − R₀).
    vx = slip * tx - gap_rate * ty + omega * (contact[1] - y)
    vy = slip * ty + gap_rate * tx - omega * (contact[0] - x)
    x, y = float(x - gap * ty), float(y + gap * tx)
    return MotionPoint(x, y, theta, float(vx), float(vy), omega, xi1, xi2, *rates, slip)


def piece_at(curve: Curve, s: float) -> tuple[Piece, float]:
    """The smooth piece or corner of a curve at a parameter, and its own parameter there."""
    element = curve.element_at(s)
    return element.piece, s - element.shift


def _velocity_on_pieces(track: Curve, outline: Curve, xi1: float, xi2: float, slip: float, omega: float) -> MotionPoint:
    """`velocity` where a curve has pieces: ω = k₁ ξ̇₁ − k₂ ξ̇₂ and v = ρ₁ ξ̇₁ − ρ₂ ξ̇₂, solved for the rates."""
    (first, s1), (second, s2) = piece_at(track, xi1), piece_at(outline, xi2)
    if isinstance(first, Curve) and isinstance(second, Curve):
        on_pieces = velocity(first, second, s1, s2, slip, omega)
        return _moving(track, outline, (xi1, xi2), (on_pieces.xi1_dot, on_pieces.xi2_dot), slip, omega)
    k1, k2 = turning(first, s1), turning(second, s2)
    rho1, rho2 = float(first.speed(s1)), float(second.speed(s2))
    determinant = k1 * rho2 - k2 * rho1
    if determinant >= 0.0:
        raise DoesNotFit(
            f"the plate does not fit its track at xi1 = {xi1:g}: a corner there points away from the other curve; "
            "give another start"
        )
    rates = (omega * rho2 - slip * k2) / determinant, (omega * rho1 - slip * k1) / determinant
    return _moving(track, outline, (xi1, xi2), rates, slip, omega)


def velocity_apart(
    track: Curve, outline: Curve, xi1: float, xi2: float, slip: float, omega: float, gap: float, gap_rate: float
) -> MotionPoint:
    """The motion of a plate off its track, or about to hit or leave it.

    Its outline's point lies `gap` (m) away along the track's normal, tangents parallel, and has the velocity
    slip·t + gap_rate·n.
    """
    return _moving(track, outline, (xi1, xi2), (nan, nan), slip, omega, gap, gap_rate)


def level_parameter(track: Curve, outline: Curve, xi1: float) -> float:
    """The outline parameter whose tangent is parallel to the track's at `xi1` while θ = 0.

    Raises DoesNotFit if there is none or more than one (an outline that is not convex); the start then needs xi2.
    """
    direction = track.tangent_angle(xi1)
    low, high = outline.span
    grid = np.linspace(low, high, 721)
    if isinstance(outline, Chain):
        grid = np.union1d(grid, outline.vertices(0.1))
    # Whole turns between the two tangents, as a continuous function of the outline's parameter: solve for zero mod 1.
    turns = (outline.tangent_angle(grid) - direction) / (2 * pi)
    lowest, highest = np.ceil(np.minimum(turns[:-1], turns[1:])), np.floor(np.maximum(turns[:-1], turns[1:]))
    parameters = []
    for i in np.flatnonzero(lowest <= highest).tolist():
        for whole in range(int(lowest[i]), int(highest[i]) + 1):
            if turns[i + 1] != whole or i == len(grid) - 2:
                root = _level(outline, direction + 2 * pi * whole, *grid[i : i + 2].tolist())
                # Whole turns of a closed outline are taken back, so that θ is zero and not a multiple of 2π.
                parameters.append(root - whole * outline.period if outline.period else root)
    if outline.period:
        apart = SAME * outline.unit
        parameters = [s for i, s in enumerate(parameters) if all(abs(s - other) > apart for other in parameters[:i])]
    if len(parameters) != 1:
        raise DoesNotFit(
            f"{len(parameters)} points of the outline fit the track's direction with theta = 0; give xi2 in Start"
        )
    return parameters[0]


def _level(outline: Curve, angle: float, low: float, high: float) -> float:
    """The parameter between two at which the outline's tangent has that angle: Newton's method, kept between the two.

    (SciPy's root finders take a quarter of a second to import, as long as everything else a first motion needs.)
    """
    off_low, off_high = (outline.tangent_angle(end) - angle for end in (low, high))
    if off_low == 0.0 or off_high == 0.0:
        return low if off_low == 0.0 else high
    s = low + (high - low) * off_low / (off_low - off_high)
    for _ in range(100):  # by halves alone it would take 60
        off = outline.tangent_angle(s) - angle
        low, high = (s, high) if (off < 0.0) == (off_low < 0.0) else (low, s)
        slope = float(outline.curvature(s) * outline.speed(s))
        following = s - off / slope if slope else inf
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - s) <= 4 * EPS * abs(s):
            return following
        s = following
    return s


def find(track: Piece, outline: Piece, x: float, y: float, theta: float, near: tuple[float, float]) -> Contact:
    """The pair of points where outline and track come closest, starting from the pair `near`, also beyond the ends of
    open curves. At a corner the parameter is where both tangents agree, in the round of `near`.

    Newton's method on: the tangents are parallel (6), and the gap vector is normal to the track. Steps are measured
    in metres along the curves, so that the unit of a parameter changes nothing. Raises DoesNotFit if it does not
    converge, which a plate far from its track may cause, and where a corner touches a corner.
    """
    if not isinstance(track, Corner) and not isinstance(outline, Corner):
        return pair_search(track, outline)(x, y, theta, near)
    c, s = cos(theta), sin(theta)
    if not isinstance(track, Corner):
        assert isinstance(outline, Corner)
        xi1, gap = _foot(track, (x + c * outline.x - s * outline.y, y + s * outline.x + c * outline.y), near[0])
        return Contact(xi1, angle_on(outline, float(track.tangent_angle(xi1)) - theta, near[1]), gap)
    if isinstance(outline, Corner):
        raise DoesNotFit("a corner touches a corner there; their gap has no direction")
    u, v = track.x - x, track.y - y
    xi2, gap = _foot(outline, (c * u + s * v, c * v - s * u), near[1])
    return Contact(angle_on(track, float(outline.tangent_angle(xi2)) + theta, near[0]), xi2, -gap)


def angle_on(corner: Corner, direction: float, near: float) -> float:
    """The parameter of a corner whose tangent has a direction (rad), next to a parameter."""
    angle = corner.sign * (direction - corner.start)
    return angle + 2.0 * pi * round((near - angle) / (2.0 * pi))


def _foot(piece: Curve, point: tuple[float, float], s: float) -> tuple[float, float]:
    """The parameter of a piece whose normal goes through a point, and how far the point is to its left, m."""
    for _ in range(MOST_STEPS):
        x, y, xp, yp, xs, ys, _, _ = piece.jet(s)
        dx, dy = point[0] - x, point[1] - y
        slope = dx * xs + dy * ys - xp * xp - yp * yp
        step = (dx * xp + dy * yp) / slope if slope else 0.0
        s -= step
        # Rounding of the parameter, and of the places from which it is computed.
        away = (abs(x) + abs(y) + abs(dx) + abs(dy)) / hypot(xp, yp)
        if abs(step) <= 4 * EPS * (abs(s) + piece.span[1] - piece.span[0] + away):
            return s, float((np.array(point) - piece.point(s)) @ piece.normal(s))
    # Near the centre of curvature a rounding moves the foot by more: accept it if its residual is rounding.
    x, y, xp, yp, *_ = piece.jet(s)
    dx, dy, speed = point[0] - x, point[1] - y, hypot(xp, yp)
    if abs(dx * xp + dy * yp) <= 64 * EPS * speed * (abs(x) + abs(y) + abs(dx) + abs(dy) + speed * abs(s)):
        return s, float((np.array(point) - piece.point(s)) @ piece.normal(s))
    raise DoesNotFit(f"no foot of the point ({point[0]:.6g}, {point[1]:.6g}) is near")


def slip_velocity(track: Curve, x, y, vx, vy, omega, xi1):
    """(11) along the track's unit tangent at `xi1`: velocity of the plate's material point there. Numbers or arrays."""
    tangent, contact = track.tangent(xi1), track.point(xi1)
    return (vx - omega * (contact[1] - y)) * tangent[0] + (vy + omega * (contact[0] - x)) * tangent[1]


@lru_cache(maxsize=1024)
def bends(piece: Piece) -> tuple[float, float]:
    """Least and greatest curvature of a piece, 1/m: infinite at a corner, with the sign of its turn."""
    if isinstance(piece, Corner) or piece.features is None and not isinstance(piece, Chain):
        return (piece.sign * inf, piece.sign * inf) if isinstance(piece, Corner) else (0.0, 0.0)
    values = np.asarray(piece.curvature(np.linspace(*piece.span, BEND_SAMPLES)))
    return float(values.min()), float(values.max())


def clearance(track: Piece, outline: Piece, xi1, xi2):
    """Outline's curvature minus track's, 1/m: positive where the plate fits (admissible contact); NaN where a corner
    touches a corner."""
    return outline.curvature(xi2) - track.curvature(xi1)
