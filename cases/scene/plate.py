"""The rigid plate: its outline, mass and inertia, and derived sizes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import cos, inf, pi, sin, sqrt

import numpy as np

from ..contact.geometry import bends
from ..contact.overlap_search import polygon_of
from ..curves import Curve
from ..curves.area import area_inside
from ..curves.backwards import backwards
from ..curves.chain import translate
from ..curves.corner import Edge
from ..curves.outline import Outline, arc, samples_around, say_turned_round, sizes_of
from ..errors import BadCurve, BadValue, instance, items, not_negative, positive, real, whole
from ..library import circle

# A centroid nearer than this part of the outline's size to the origin is there: the rounding of its integrals.
CENTRED = 1e-15

# A smooth outline is convex if its curvature is nowhere below this part of 1/reach.
CONVEX = 1e-6


@dataclass(frozen=True, repr=False)
class Plate:
    """A rigid plate: its outline in its own frame, whose origin is the centre of mass; mass in kg, inertia in kg m².

    A plate of infinite inertia (`inertia=math.inf`) does not turn: a block, a slider, a particle. The outline is a
    smooth curve or an `Outline` with corners. It runs counter-clockwise around the plate; a closed curve s that runs
    the other way is taken backwards, with a warning: its parameter is then −s.
    """

    outline: Curve
    mass: float
    inertia: float
    # Of a `block`: what pictures draw along the track, width and height in metres.
    drawn: tuple[float, float] | None = field(default=None, compare=False)

    def __post_init__(self):
        if not isinstance(self.outline, Curve):
            raise BadValue(f"the outline is {self.outline!r}; give a Curve, or an Outline with corners")
        if self.outline.may_cross:
            raise BadCurve("the outline of a plate cannot cross itself; give one without may_cross=True")
        object.__setattr__(self, "mass", positive("mass of the plate", self.mass))
        is_infinite = real(self.inertia) == inf
        object.__setattr__(self, "inertia", inf if is_infinite else positive("inertia of the plate", self.inertia))
        if _runs_clockwise(self.outline):
            object.__setattr__(self, "outline", backwards(self.outline))
            say_turned_round()

    @classmethod
    def homogeneous(
        cls,
        outline: Curve,
        mass: float,
        holes: Iterable[Curve] = (),
        inlays: Iterable[tuple[Curve, float]] = (),
    ) -> Plate:
        """A plate of one density, but for holes, and for inlays: pairs (outline, density in units of the plate's).

        All outlines are in one frame of any origin; the plate's is moved so that its origin is the centre of mass.
        `mass` is the whole mass, kg. Raises BadCurve for an open outline, or a hole or inlay that is not inside.
        """
        parts = [(hole, 0.0) for hole in items("holes", holes)]
        for pair in items("inlays", inlays):
            inlay, density = (*items("inlay", pair), None, None)[:2]
            parts.append((inlay, not_negative("density of an inlay", density)))
        for curve in (outline, *(part for part, _ in parts)):
            instance("outline of Plate.homogeneous", curve, Curve)
        rows = [(1.0, area_inside(outline))]
        for part, density in parts:
            if not contains(outline, part.point(samples_around(part)).T):
                raise BadCurve("a hole or inlay is not inside the outline; give one that is")
            rows.append((density - 1.0, area_inside(part)))
        weight = sum(density * area.area for density, area in rows)
        x = sum(density * area.area * area.x for density, area in rows) / weight
        y = sum(density * area.area * area.y for density, area in rows) / weight
        moment = sum(density * (a.polar_moment + a.area * ((a.x - x) ** 2 + (a.y - y) ** 2)) for density, a in rows)
        mass = positive("mass of the plate", mass)
        least = CENTRED * float(np.hypot(*outline.point(samples_around(outline))).max())
        x, y = (value if abs(value) > least else 0.0 for value in (x, y))
        if x or y:
            outline = outline.translate(-x, -y) if isinstance(outline, Outline) else translate(outline, -x, -y)
        return cls(outline, mass, mass * moment / weight)

    @classmethod
    def polygon(cls, points, mass: float, radius: float = 0.0) -> Plate:
        """A homogeneous polygon through points (n, 2) in metres, counter-clockwise; corners of `radius`, m."""
        return cls.homogeneous(Outline.polygon(points, radius), mass)

    @classmethod
    def rectangle(cls, width: float, height: float, mass: float, radius: float = 0.0) -> Plate:
        """A homogeneous rectangle; its outline begins at the lower left corner. Corners rounded with `radius`, m."""
        a, b = 0.5 * positive("width of rectangle", width), 0.5 * positive("height of rectangle", height)
        return cls.polygon([(-a, -b), (a, -b), (a, b), (-a, b)], mass, radius)

    @classmethod
    def half_disc(cls, radius: float, mass: float) -> Plate:
        """A homogeneous half disc, round side down; its outline begins at the left end of the arc."""
        r = positive("radius of half_disc", radius)
        return cls.homogeneous(Outline((arc((0.0, 0.0), r, -pi, 0.0), Edge.between((r, 0.0), (-r, 0.0)))), mass)

    @classmethod
    def reuleaux(cls, width: float, mass: float) -> Plate:
        """A homogeneous Reuleaux triangle of constant `width` (m), one corner up; its outline begins with the arc at
        the bottom."""
        d = positive("width of reuleaux", width)
        # Each arc's centre is the opposite corner, at d/√3 from the middle.
        away, sixth = d / sqrt(3.0), pi / 6
        centres = [(away * cos(angle), away * sin(angle)) for angle in (3 * sixth, 7 * sixth, 11 * sixth)]
        starts = (-4 * sixth, 0.0, 4 * sixth)
        return cls.homogeneous(
            Outline([arc(centre, d, start, start + 2 * sixth) for centre, start in zip(centres, starts, strict=True)]),
            mass,
        )

    @classmethod
    def gear(cls, radius: float, teeth: int, depth: float, mass: float, rounding: float = 0.0) -> Plate:
        """A homogeneous gear with straight flanks: tips on a circle of `radius`, roots `depth` inside it, m.

        A tip takes a quarter of a tooth's angle, a root as much; `rounding` is the radius of all corners, m.
        """
        r, d = positive("radius of gear", radius), positive("depth of gear", depth)
        n = whole("teeth of gear", teeth, 3, 1000)
        if not d < r:
            raise BadValue(f"depth = {d:g} of gear is not below its radius {r:g}; give a smaller one")
        points = []
        for tooth in range(n):
            for part, away in ((-1, r), (1, r), (3, r - d), (5, r - d)):
                angle = 2 * pi * (tooth + part / 8) / n - pi / 2
                points.append((away * cos(angle), away * sin(angle)))
        return cls.polygon(points, mass, rounding)

    def __repr__(self) -> str:
        shape = f"radius={self.radius:.6g}" if self.radius else repr(self.outline)
        return f"{'disc' if self.radius else 'Plate'}({shape}, mass={self.mass:.6g}, inertia={self.inertia:.6g})"

    @property
    def gyration(self) -> float:
        """Radius of gyration about the centre of mass, m; of a plate that does not turn its reach, as a length."""
        return sqrt(self.inertia / self.mass) if self.turns else self.reach

    @property
    def turns(self) -> bool:
        """Whether the plate can turn: its inertia is finite."""
        return self.inertia < inf

    @property
    def spins_by_load(self) -> bool:
        """Whether its spin changes as its load says, whatever forces act."""
        return False

    @property
    def encloses_centre(self) -> bool:
        """Whether the centre of mass is inside the outline; true of an open outline, which encloses nothing."""
        return not self.outline.period or contains(self.outline, ((0.0, 0.0),))

    @property
    def inner(self) -> float:
        """The smallest distance of the outline from the centre of mass, m."""
        return sizes_of(self.outline).inner

    @property
    def reach(self) -> float:
        """The largest distance of the outline from the centre of mass, m."""
        return sizes_of(self.outline).reach

    @property
    def width(self) -> float:
        """The larger side of the box about the outline, m."""
        return sizes_of(self.outline).width

    @property
    def radius(self) -> float | None:
        """Radius in metres if the outline is a circle about the centre of mass, else None."""
        return sizes_of(self.outline).radius


class SpinningPlate(Plate):
    """A plate of infinite inertia as a track that turns sees it: the moment of its load is the rate of its spin
    (rad/s²), whatever forces act."""

    @property
    def spins_by_load(self) -> bool:
        return True


@lru_cache(maxsize=256)
def _runs_clockwise(outline: Curve) -> bool:
    low, high = outline.span
    return bool(outline.period and outline.tangent_angle(high) < outline.tangent_angle(low))


def contains(outline: Curve, points) -> bool:
    """Whether points (n, 2) are inside a closed outline."""
    return bool(polygon_of(outline).holds(*np.asarray(points).T).all())


def is_convex(outline: Curve) -> bool:
    """Whether a smooth outline is closed and bends everywhere."""
    return bool(outline.period) and bends(outline)[0] * outline.sizes[0] > CONVEX


def disc(radius: float, mass: float, inertia: float | None = None) -> Plate:
    """A disc about its centre of mass; inertia ½ m r² (homogeneous) if none is given."""
    radius, mass = positive("radius of the disc", radius), positive("mass of the disc", mass)
    return Plate(circle(radius), mass, 0.5 * mass * radius * radius if inertia is None else inertia)


def block(width: float, height: float, mass: float) -> Plate:
    """A block that slides and does not turn: a particle at half its height above the track, drawn along the track as a
    rectangle of width × height (m). It cannot tip; `Plate.rectangle` is a box that turns and touches with its corners.
    """
    width, height = positive("width of the block", width), positive("height of the block", height)
    return replace(disc(0.5 * height, mass, inf), drawn=(width, height))
