"""Public functions, and valid arguments of each: what tests put in the place of one of them is rejected or taken."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

import cases
import reference
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
    Gravity,
    Impact,
    Load,
    RollingResistance,
    Start,
    Unilateral,
    disc,
    library,
)


def scene(**how) -> Case:
    usual = dict(duration=1.0, parameters={})
    effects = (Gravity(9.81), Unilateral())
    return Case(cases.library.line(), disc(0.1, 1.0), effects, Start(0.0), **(usual | how))


LINE, CIRCLE, DISC = cases.library.line(), cases.library.circle(1.0), disc(0.1, 1.0)
PARABOLA = Curve(("s", "s**2"), (-1, 1))
CHAIN = cases.Chain.polyline([(0, 0), (1, 0), (1.5, 1)])
SQUARE = cases.Outline.polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
SPLINE = Curve.spline([(0.1 * i, 0.01 * i * i) for i in range(12)])
SCENE = scene()
SAMPLES = {name: np.arange(3.0) for name in ("t", *cases.State._fields)}
MOTION = cases.Trajectory(**SAMPLES)
AT_PLACES = "at curvature jet jets normal place point speed tangent tangent_angle element_at".split()
# Public functions and valid arguments of each; one at a time is replaced.
CALLS: dict[str, tuple[Callable, dict]] = {
    "Gravity": (Gravity, dict(g=9.81, direction=-pi / 2)),
    "CoulombFriction": (CoulombFriction, dict(mu=0.2, mu_static=0.3)),
    "RollingResistance": (RollingResistance, dict(arm=0.01)),
    "Impact": (Impact, dict(restitution=0.5, law="poisson")),
    "Belt": (Belt, dict(speed="1+sin(t)")),
    "Drive": (Drive, dict(x="sin(t)", y=0.0, angle="t")),
    "Load": (Load, dict(fx="sin(t)", fy=1.0, moment=0.0)),
    "Start": (Start, dict(xi1=0.1, xi2=0.0, slip=0.0, omega=1.0, gap=0.0, gap_rate=0.0)),
    "disc": (disc, dict(radius=0.1, mass=1.0, inertia=0.005)),
    "line": (library.line, dict(slope=0.1)),
    "circle": (library.circle, dict(radius=1.0)),
    "ellipse": (library.ellipse, dict(a=1.0, b=0.5)),
    "parabola": (library.parabola, dict(focus=0.4, reach=3.0)),
    "cosine": (library.cosine, dict(depth=0.3, wavenumber=2.0, reach=3.0)),
    "cycloid": (library.cycloid, dict(a=0.25, offset=0.1)),
    "trochoid": (library.trochoid, dict(a=0.5, arm=0.3, arches=2)),
    "superellipse": (library.superellipse, dict(a=0.2, b=0.1, exponent=4)),
    "logarithmic_spiral": (library.logarithmic_spiral, dict(start=0.1, growth=0.2, turns=0.5)),
    "rounded_polygon": (library.rounded_polygon, dict(radius=0.1, corners=3, sharpness=0.5)),
    "Case": (Case, dict(track=CIRCLE, plate=DISC, effects=(Gravity(9.81),), start=Start(0.1), duration=0.1, name="mine",
                        parameters={}, supports=(), others=())),
    "Chain": (cases.Chain, dict(pieces=[LINE], is_closed=False)),
    "Curve": (Curve, dict(function=("s", "s**2"), domain=(-1, 1), residual=None, may_cross=False)),
    "FreePlate": (cases.FreePlate, dict(plate=DISC, start=cases.StartPose(0, 0), name="b")),
    "Outline": (cases.Outline, dict(pieces=[CIRCLE])),
    "Plate": (cases.Plate, dict(outline=CIRCLE, mass=1.0, inertia=1.0)),
    "Support": (cases.Support, dict(curve=LINE, name="b", effects=None)),
    "Trajectory": (cases.Trajectory, SAMPLES),
    "arc": (cases.arc, dict(centre=(0, 0), radius=1.0, start=0.0, end=1.0)),
    "fit_friction": (cases.fit_friction, dict(v=np.arange(1.0, 9), mu=np.full(8, 0.2), within=0.01)),
    "fit_waves": (cases.fit_waves, dict(t=np.arange(9.0), values=np.sin(np.arange(9.0)), within=0.1, integrals=0)),
    "load": (cases.load, dict(name="disc_in_circle", mu=0.2)),
    "entry": (cases.entry, dict(name="disc_in_circle")),
    "load_file": (cases.load_file, dict(path="nowhere.py")),
    "names": (cases.names, dict(hard=None)),
    "select": (cases.select, dict(text="disc_in_circle", long=False)),
    "Chain.polyline": (cases.Chain.polyline, dict(points=[(0, 0), (1, 0)])),
    "Curve.in_pieces": (Curve.in_pieces, dict(pieces=SPLINE.parts, may_cross=False)),
    "Curve.spline": (Curve.spline, dict(points=[(0.1 * i, 0.01 * i * i) for i in range(12)], smoothing=0.0,
                                        closed=False, scale=1.0, may_cross=False)),
    "Outline.polygon": (cases.Outline.polygon, dict(points=[(0, 0), (1, 0), (1, 1), (0, 1)], radius=0.0)),
    "Plate.gear": (cases.Plate.gear, dict(radius=1.0, teeth=8, depth=0.1, mass=1.0, rounding=0.0)),
    "Plate.homogeneous": (cases.Plate.homogeneous, dict(outline=CIRCLE, mass=1.0, holes=(), inlays=())),
    "Plate.rectangle": (cases.Plate.rectangle, dict(width=1.0, height=1.0, mass=1.0, radius=0.0)),
    "Case.effect": (SCENE.effect, dict(kind=Gravity)),
    "Case.with_name": (SCENE.with_name, dict(name="a", parameters={})),
    "Start.check": (Start(0.1).check, dict(track=CIRCLE, outline=DISC.outline, effects=SCENE.effects)),
    "Start.motion": (Start(0.1).motion, dict(track=CIRCLE, outline=DISC.outline)),
    "Support.acting": (cases.Support(LINE, "a").acting, dict(of_case=SCENE.effects)),
    "Drive.at_times": (cases.Drive("sin(t)").at_times, dict(t=np.zeros(2))),
    "Trajectory.of": (MOTION.of, dict(contact="plate/track")),
    "Trajectory.plate": (MOTION.plate, dict(name="plate")),
    "Trajectory.times": (MOTION.times, dict(count=5)),
    "Trajectory.to_frame": (MOTION.to_frame, dict(count=5)),
    "Trajectory()": (MOTION, dict(t=0.5)),
    "polar": (cases.constructions.polar, dict(radius=lambda s: 1 + 0 * s, domain=None)),
    "natural": (cases.constructions.natural,
                dict(curvature=lambda s: s, length=1.0, start=(0.0, 0.0), angle=0.0, may_cross=False)),
    "piecewise": (cases.constructions.piecewise, dict(curves=[LINE], may_cross=False)),
    "from_support": (cases.library.from_support, dict(support=lambda s: 1 + 0 * s)),
    "integral": (cases.curves.integral, dict(formula=lambda s: s, upper=1.0, lower=0.0)),
    "simulate": (reference.simulate, dict(case=SCENE, rtol=1e-6, method="dop853")),
    "check": (reference.check, dict(case=SCENE, motion=MOTION, rtol=1e-6)),
    "sweep": (reference.sweep, dict(case="disc_on_line", mu="0.1", sample="grid", number=None, seed=0, rtol=1e-6)),
}  # fmt: skip
for number, curve in enumerate((LINE, CIRCLE, PARABOLA, CHAIN, SQUARE, SPLINE)):
    arguments = dict.fromkeys(AT_PLACES, {"s": 0.1}) | {
        "angle_table": {"span": (0.0, 0.5)}, "even": {"low": 0.0, "high": 0.5, "count": 4}, "element": {"number": 0},
        "length": {"low": 0.0, "high": 0.5}, "part": {"number": 0}, "translate": {"x": 0.0, "y": 0.0},
        "vertices": {"longest_turn": 0.1},
    }  # fmt: skip
    CALLS |= {
        f"{name} of curve {number}": (getattr(curve, name), right)
        for name, right in arguments.items()
        if hasattr(curve, name)
    }
