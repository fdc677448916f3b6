"""Random loads of every width in every variable."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from cases import Case, Flight, Gravity, Load, Start, Unilateral, disc
from cases.library import line

RADIUS, G = 0.1, 9.81
VARIABLES = ("t", "x", "y", "theta", "vx", "vy", "omega")
# What a variable is of by itself: a radius, a radian, and how fast the plate falls or turns by as much.
SIZES = dict(t=sqrt(RADIUS / G), x=RADIUS, y=RADIUS, theta=1.0, vx=sqrt(RADIUS * G), vy=sqrt(RADIUS * G), omega=10.0)
SHAPES = {
    "gauss": "{a!r}*exp(-(({q}-{c!r})/{w!r})**2)",
    "tanh": "{a!r}*tanh(({q}-{c!r})/{w!r})",
    "lorentz": "{a!r}/(1+(({q}-{c!r})/{w!r})**2)",
    "soft wall": "{a!r}*(({q}-{c!r})/{w!r}+sqrt(1+(({q}-{c!r})/{w!r})**2))",
}


# The place along which a component does work.
ALONG = {"fx": "x", "fy": "y", "moment": "theta"}


class Term(NamedTuple):
    """One term of a load: the component it belongs to, its shape, size, variable, centre and width."""

    component: str
    shape: str
    size: float
    variable: str
    centre: float
    width: float

    @property
    def formula(self) -> str:
        """The term as text."""
        return SHAPES[self.shape].format(q=self.variable, a=self.size, c=self.centre, w=self.width)


def term(rng: np.random.Generator, flies: bool) -> Term:
    """A Gaussian, a step, a Lorentzian or a soft wall in one variable, from ten down to 1e-3 of its size wide."""
    variable = str(rng.choice(VARIABLES if flies else [v for v in VARIABLES if v not in ("y", "vy")]))
    shape = str(rng.choice(list(SHAPES)))
    width = SIZES[variable] * 10 ** rng.uniform(-3, 1)
    component = str(rng.choice(["fx", "fy", "moment"], p=[0.5, 0.2, 0.3]))
    if rng.integers(2):  # half of those that can be are conservative
        component = next((c for c, place in ALONG.items() if place == variable), component)
    # A force of about a weight; of a narrow one as much as changes speeds by about a metre per second.
    a = float(rng.choice([-1, 1])) * rng.uniform(0.2, 1.5) * G * (RADIUS if component == "moment" else 1.0)
    if shape in ("gauss", "lorentz") and variable in ("t", "x", "y", "theta"):
        a *= min(max(SIZES[variable] / width, 1.0), 30.0)
    if shape == "soft wall":
        a *= 0.3 * width / SIZES[variable]
    middle = {"t": 1.0, "x": 1.5, "y": 0.5, "theta": -6.0, "vx": 1.0, "vy": -1.0, "omega": -4.0}[variable]
    centre = middle + rng.uniform(-0.5, 0.5) * abs(middle)
    a, centre, width = float(f"{a:.6g}"), float(f"{centre:.6g}"), float(f"{width:.6g}")
    return Term(component, shape, a, variable, centre, width)


def scene(rng: np.random.Generator, *further) -> tuple[Case, list[Term]]:
    """A disc without friction on a level line, or thrown high above it, under one or two random terms."""
    flies = not further and bool(rng.integers(2))
    terms = [term(rng, flies) for _ in range(rng.integers(1, 3))]
    parts = {c: " + ".join(t.formula for t in terms if t.component == c) or 0.0 for c in ("fx", "fy", "moment")}
    speeds = dict(slip=rng.uniform(0.3, 3.0), omega=-rng.uniform(0.0, 8.0))
    start = Start(0.0, gap=1.0, gap_rate=rng.uniform(-1.0, 3.0), **speeds) if flies else Start(0.0, **speeds)
    effects = (Gravity(G), Load(**parts), Unilateral(), *([Flight()] if flies else []), *further)
    return Case(line(), disc(RADIUS, 1.0), effects, start, 2.0), terms
