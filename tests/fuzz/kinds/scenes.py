"""Scenes at the ends of what is accepted: what runs is finite, or says where it ended; work is bounded."""

import functools
from math import pi

import numpy as np

import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
    library,
)

from ..harness import Kind

SIZES = (1e-9, 1e-6, 1e-3, 0.1, 0.1, 0.1, 1.0, 1e3, 1e8)
SPEEDS = (0.0, 0.0, 1.0, -1.0, 1e3, 1e6, 1e8, 1e30, 1e59, 1e-30)
DRIVES = (
    "sin(3*t)", "log(t)", "1/t", "sqrt(t)", "1/(t-0.5)", "sin(1e6*t)", "exp(50*t)", "exp(exp(9*t))", "1e30*sin(t)",
    "-0.2*vx", "x**3", "t**(1/3)", "(1+sin(t)**2)**(2/3)/3", "1e59", "1e90", "log(vx)", "sqrt(x-5)",
    "1/(0.3-x)", "tan(4*t)",
)  # fmt: skip


def simulated(case: Case, method=None):
    """The motion, looked at: numbers all along, or a status that says where they end."""
    motion = reference.simulate(case, rtol=1e-6, method=method)
    assert motion.status and motion.reason.endswith((".", "there", "speeds")), motion.reason
    if motion.status == "completed":
        assert abs(motion.t[-1] - case.duration) <= 1e-9 * case.duration
    for name in ("t", "x", "y", "theta", "vx", "vy", "omega"):
        assert np.all(np.isfinite(getattr(motion, name))), (name, motion.status)
    assert sum(segment for segment in [motion.cost.steps]) <= 2_000_000
    return motion.status


def scene(chance) -> Case:
    """A random one."""
    r = chance.choice(SIZES)
    R = r * chance.choice((1.0, 1 + 1e-12, 1 + 1e-9, 1 + 1e-4, 2.0, 10.0, 1e5))
    track = chance.choice(
        (
            library.line(0.3),
            library.circle(R),
            library.circle(R),
            library.cosine(3 * r, 0.3 / r, 30 * r),
            library.hill(R),
        )
    )
    plate = disc(r, chance.choice((1e-30, 1.0, 1.0, 1e30)), None)
    if chance.random() < 0.3:
        plate = Plate(library.ellipse(r, 0.7 * r), 1.0, chance.choice((0.3, 1e-3, 1e4)) * r * r)
    effects: list = [Gravity(chance.choice((0.0, 9.81, 9.81, 1e-20, 1e30, 1e59)))]
    if chance.random() < 0.7:
        effects.append(CoulombFriction(chance.choice((1e-12, 0.2, 0.2, 10.0, 1e4))))
        effects += [RollingResistance(chance.choice((1e-3, 1.0)) * r)] if chance.random() < 0.2 else []
    if chance.random() < 0.8:
        effects.append(Unilateral())
        if chance.random() < 0.4:
            effects += [Flight(), Impact(chance.choice((0.0, 0.5, 1.0)))]
    if chance.random() < 0.5:
        effects.append(Load(chance.choice(DRIVES)))
    begin = Start(
        chance.uniform(-2.0, 2.0), 0.0 if plate.radius is None else None, chance.choice(SPEEDS), chance.choice(SPEEDS)
    )
    return Case(track, plate, tuple(effects), begin, chance.choice((1e-3, 1.0, 1.0, 10.0)))


def draw(chance):
    def call():
        return simulated(scene(chance))

    return "a random scene", call


def on_line(method=None, **changes):
    given = dict(
        track=library.line(0.0), plate=disc(0.1, 1.0), effects=(Gravity(9.81), CoulombFriction(0.2), Unilateral()),
        start=Start(0.0, slip=1.0), duration=1.0,
    )  # fmt: skip
    return lambda: simulated(Case(**(given | changes)), method)  # type: ignore[arg-type]


def driven(text: str, method=None):
    effects = (Gravity(9.81), CoulombFriction(0.2), Unilateral(), Load(text))
    return on_line(method, effects=effects)


GUIDE = dict(track=library.circle(1.0), effects=(Gravity(9.81),))
FOUND = (
    ("log(t)", driven("log(t)")),
    ("1/t", driven("1/t")),
    ("a third at some depth", driven("(1+sin(t)**2)**(2/3)/3")),
    ("1e90", driven("1e90")),
    *((f"a root of less than 0 by {m}", driven("(0.5-t)**0.3", m)) for m in ("taylor", "dop853", "augmented")),
    ("r = R", on_line(track=library.circle(0.1), start=Start(-1.0))),
    (
        "as long as its circle is wide",
        on_line(
            track=library.circle(0.1), plate=Plate(library.ellipse(0.1, 0.07), 1.0, 1e-5), start=Start(-0.67, 0.0, 1e8)
        ),
    ),
    (
        "r = R, driven",
        lambda: on_line(track=library.circle(0.1), start=Start(-1.0), effects=(Gravity(9.81), Load("sin(3*t)")))(),
    ),
    ("omega 1e8", on_line(**GUIDE, start=Start(-1.0, omega=1e8))),
    (
        "off a hill at 1e30 m/s",
        on_line(track=library.hill(0.1), start=Start(0.8, slip=1e30), effects=(Gravity(9.81), Unilateral(), Flight())),
    ),
    ("1e8 s", on_line(**GUIDE, start=Start(-1.0), duration=1e8)),
    (
        "a vertical track",
        on_line(track=Curve(("0.0", "sin(s)"), (-1.0, 1.0)), start=Start(0.0), effects=(Gravity(9.81),)),
    ),
    (
        "theta",
        functools.partial(
            reference.simulate, Case(library.circle(1.0), disc(0.1, 1.0), (Gravity(9.81),), Start(pi), 0.1)
        ),
    ),
)
LONG = (
    (
        "an ellipse that spins at 1e30 rad/s in a circle as wide",
        on_line(
            track=library.circle(1e-6),
            plate=Plate(library.ellipse(1e-6, 0.7e-6), 1.0, 3e-13),
            effects=(Gravity(1e30), CoulombFriction(1e-12), Unilateral(), Flight(), Impact(1.0)),
            start=Start(-0.39610749731669603, 0.0, -1.0, 1e30),
        ),
    ),
)
KIND = Kind("scenes", draw, 60, 4, FOUND, LONG)
