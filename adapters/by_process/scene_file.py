"""A case as plain data for a program in any language: what `slip-to-roll cases export` writes and an executable reads.

`scene.schema.json` defines the form, with its version. A scene does not contain the true motion.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from math import atan2, isfinite
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from cases import Case, Chain, CoulombFriction, Curve, Effect, NotSupported, Plate
from cases.contact import start_motion
from cases.contact.polygon_features import circles
from cases.curves.line_or_circle import as_circle, as_line
from cases.scene.free_plates import POSE, names_of, plates_of, start_poses
from cases.scene.supports import TRACK

from ..common.facets import ends, is_round_hill, visible_chain, visible_span
from ..common.several_contacts import may_touch_twice
from . import engine_geometry

SCHEMA, VERSION = "slip-to-roll/scene", 2
SCHEMA_FILE = Path(__file__).with_name("scene.schema.json")

# Coulomb friction whose mu is a formula in v, the slip speed.
FRICTION_BY_SPEED = "CoulombFrictionBySpeed"

# The further fixed curves of a case, its further plates, and those of several plates that are polygons.
SUPPORTS, FREE_PLATES, POLYGONS = "Supports", "FreePlates", "Polygons"

# Chords of a closed curve of a thousand sides miss it by 5e-6 of its radius.
SAMPLES = 1001
# Facets of a curved track without a number in the setting.
FACETS = 800
UNITS = "SI, radians; the plate lies on the left of the track; components along its tangent and left normal"


def scene(case: Case, samples: int = SAMPLES, facets: int = FACETS) -> dict[str, Any]:
    """All data that is needed to build the case, in SI units; null for values that a start in flight does not have.

    `samples`: number of points of each curve; `facets`: number of facets of a curved track. Raises
    NotSupported for supports that are not straight."""
    return finite(
        {
            "schema": SCHEMA,
            "version": VERSION,
            "case": case.label,
            "units": UNITS,
            "plate": _plate(case.plate),
            "track": formula(case.track),
            "outline": formula(case.plate.outline),
            "effects": _effects(case.effects) | _supports(case, samples) | _free_plates(case),
            "start": start_motion(case)._asdict(),
            "duration": case.duration,
            "several_contacts": may_touch_twice(case),
            "closed": {"track": bool(case.track.period), "outline": bool(case.plate.outline.period)},
            "points": {name: points(rows) for name, rows in curve_samples(case, samples).items()},
            "solids": solids(case, facets),
            "mjcf": engine_geometry.mjcf(case),
            "sdf": engine_geometry.sdf(case),
        }
    )


def _effects(effects: tuple[Effect, ...]) -> dict[str, Any]:
    """The parameters of each effect by its name."""
    return {_effect_name(effect): asdict(effect) for effect in effects}  # type: ignore[arg-type]


def _supports(case: Case, samples: int) -> dict[str, Any]:
    """The further fixed curves, by their names, each with all effects that act there: an effect of its own, so that no
    program leaves them out unawares."""
    if not case.supports:
        return {}
    curves = {}
    for support in case.supports:
        line = as_line(support.curve)
        if line is None:
            raise NotSupported(f"Programs have straight supports only, and {support.name!r} is none.")
        reach = ends(case, line)
        s = np.linspace(0.0, float(np.hypot(*(reach[1] - reach[0]))), samples)
        (nx, ny), x_y = (-line.direction[1], line.direction[0]), reach[0][:, None] + line.direction[:, None] * s
        flat = np.column_stack([s, *x_y, np.full(samples, nx), np.full(samples, ny), np.zeros(samples)])
        curves[support.name] = {"points": points(flat), "effects": _effects(support.acting(case.effects))}
    return {SUPPORTS: curves}


def solids(case: Case, facets: int) -> list[dict[str, Any]]:
    """The track and the further supports as bodies that engines with few shapes have: what lies to the right of a
    "line" without ends, a "disc" that is touched from outside, or a "chain" of facets (m, rad)."""
    every = list[dict[str, Any]]()
    for name, curve in ((TRACK, case.track), *((support.name, support.curve) for support in case.supports)):
        line, circle = as_line(curve), as_circle(curve)
        if line:
            (x, y), angle = line.point, atan2(line.direction[1], line.direction[0])
            every.append(dict(kind="line", name=name, x=x, y=y, angle=angle, radius=0.0))
        elif circle and is_round_hill(curve):
            x, y = circle.centre
            every.append(dict(kind="disc", name=name, x=x, y=y, angle=0.0, radius=circle.radius))
        else:
            x, y = visible_chain(case, facets).tolist()
            every.append(dict(kind="chain", name=name, x=x, y=y, closed=bool(curve.period)))
    return every


def _plate(plate: Plate) -> dict[str, Any]:
    """Mass, inertia about the centre of mass, and radius of a disc."""
    return {"mass": plate.mass, "inertia": plate.inertia, "radius": plate.radius}


def _free_plates(case: Case) -> dict[str, Any]:
    """The further plates by their names, each with its start, and the corners of all that are polygons: effects of
    their own, as of the supports."""
    if not case.others:
        return {}
    starts = [dict(zip(POSE, row, strict=True)) for row in start_poses(case)[1:].tolist()]
    plates = zip(case.others, starts, strict=True)
    further = {other.name: _plate(other.plate) | {"start": start} for other, start in plates}
    each = zip(names_of(case), plates_of(case), strict=True)
    polygons = {name: {"corners": _corners(plate)} for name, plate in each if plate.radius is None}
    return {FREE_PLATES: further} | ({POLYGONS: polygons} if polygons else {})


def _corners(plate: Plate) -> dict[str, list[float]]:
    """The corners of a polygon from its centre of mass, counter-clockwise, m."""
    corners = circles(plate)
    return {"x": [corner.x for corner in corners], "y": [corner.y for corner in corners]}


def _effect_name(effect: Effect) -> str:
    """The name of an effect for a program, which rejects names that it does not know: friction by a formula has a name
    of its own, so that no program takes the formula for a number."""
    by_speed = isinstance(effect, CoulombFriction) and effect.by_speed
    return FRICTION_BY_SPEED if by_speed else type(effect).__name__


def formula(curve: Curve) -> list[str] | None:
    """The coordinates as elementary formulas of s; null for a curve in pieces, with corners or by integrals, which has
    only its `points`."""
    if isinstance(curve, Chain) or curve.parts is not None or any(part.has(sp.Integral) for part in curve.expression):
        return None
    return [str(part) for part in curve.expression]


def points(rows: np.ndarray) -> dict[str, list[float]]:
    """A sampled curve by columns."""
    names = ("s", "x", "y", "normal_x", "normal_y", "curvature")
    return {name: column.tolist() for name, column in zip(names, rows.T, strict=True)}


def curve_samples(case: Case, samples: int = SAMPLES) -> dict[str, np.ndarray]:
    """Samples of `track` and `outline`, evenly in the parameter.

    For a track without ends they cover the part that the plate may reach.
    """
    track, outline = case.track, case.plate.outline
    return {
        "track": _curve_rows(track, *visible_span(case), samples),
        "outline": _curve_rows(outline, *outline.span, samples),
    }


def _curve_rows(curve: Curve, low: float, high: float, samples: int) -> np.ndarray:
    """Rows of parameter, point (m), left unit normal, curvature (1/m); shape (samples, 6), and more at corners."""
    s = np.linspace(low, high, samples)
    if isinstance(curve, Chain):
        s = np.union1d(s, curve.vertices(2 * np.pi))
    return np.column_stack([s, *curve.point(s), *curve.normal(s), curve.curvature(s)])


def finite(value: Any) -> Any:
    """The value with null for every number that is not finite, and formulas as text: JSON has neither."""
    if isinstance(value, dict):
        return {str(name): finite(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [finite(part) for part in value]
    if isinstance(value, sp.Basic):
        return str(value)
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not isfinite(value) else value


def as_json(content: dict[str, Any], indent: int | None = None) -> str:
    """The content as JSON text; raises ValueError for a number that JSON does not have."""
    return json.dumps(finite(content), indent=indent, ensure_ascii=False, allow_nan=False)
