"""Random loads of every width in every variable, and motions under them by hand: steps that know where they set in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import asinh, atan, erf, exp, log1p, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from cases import Case, Flight, Gravity, Load, Start, Unilateral, disc
from cases.contact import start_motion
from cases.library import line

RADIUS, G = 0.1, 9.81
VARIABLES = ("t", "x", "y", "theta", "vx", "vy", "omega")
# What a variable is of by itself: a radius, a radian, and how fast the plate falls or turns by as much.
SIZES = dict(t=sqrt(RADIUS / G), x=RADIUS, y=RADIUS, theta=1.0, vx=sqrt(RADIUS * G), vy=sqrt(RADIUS * G), omega=10.0)
_SCALES = np.array([SIZES[name] for name in VARIABLES[1:]])
# An error that is small, and far above those of the motion by hand.
SMALL = 1e-7
SHAPES = {
    "gauss": "{a!r}*exp(-(({q}-{c!r})/{w!r})**2)",
    "tanh": "{a!r}*tanh(({q}-{c!r})/{w!r})",
    "lorentz": "{a!r}/(1+(({q}-{c!r})/{w!r})**2)",
    "soft wall": "{a!r}*(({q}-{c!r})/{w!r}+sqrt(1+(({q}-{c!r})/{w!r})**2))",
}


# The integrals of the shapes of size 1 and width 1 about zero.
INTEGRALS: dict[str, Callable[[float], float]] = {
    "gauss": lambda u: 0.5 * sqrt(pi) * erf(u),
    "tanh": lambda u: abs(u) + log1p(exp(-2.0 * abs(u))),
    "lorentz": atan,
    "soft wall": lambda u: 0.5 * (u * u + u * sqrt(1.0 + u * u) + asinh(u)),
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

    @property
    def conservative(self) -> bool:
        """Whether it depends on nothing but the place along which it does work."""
        return ALONG[self.component] == self.variable

    def work(self, start: float, end: float) -> float:
        """What it does between two places if it is conservative, J."""
        high, low = (INTEGRALS[self.shape]((place - self.centre) / self.width) for place in (end, start))
        return self.size * self.width * (high - low)


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


class End(NamedTuple):
    """How a motion by hand ends: status, time (s), and (x, y, θ, vx, vy, ω)."""

    status: str
    time: float
    state: np.ndarray


def by_hand(case: Case, terms: Sequence[Term], rtol: float = 1e-12, moved: float = 0.0) -> End:
    """The motion of `scene` by DOP853 in steps that cover at most a sixteenth of the way to a term's centre, or of its
    width; on the line until the load lifts the disc off, above it until the disc meets it. `moved`: its start by so
    many `SIZES`, but for the disc's height on the line."""
    begin, load = start_motion(case), case.effect(Load)
    assert load is not None
    flies, mass, inertia = not case.start.in_contact, case.plate.mass, case.plate.inertia

    def rates(t, z):
        fx, fy, moment = load.at(t, *z)
        return np.array([*z[3:], fx / mass, fy / mass - G if flies else 0.0, moment / inertia])

    def guard(t, z):
        return z[1] - RADIUS if flies else G - load.at(t, *z)[1] / mass

    def longest(t, z):
        speeds = dict(zip(VARIABLES, (1.0, *rates(t, z)), strict=True))
        where = dict(zip(VARIABLES, (t, *z), strict=True))
        found = 0.01
        for one in terms:
            way = max(abs(where[one.variable] - one.centre), one.width) / 16.0
            found = min(found, way / speed) if (speed := abs(speeds[one.variable])) else found
        return found

    z = np.array([begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega])
    z += moved * _SCALES * (1.0 if flies else np.array([1.0, 0.0, 1.0, 1.0, 0.0, 1.0]))
    if guard(0.0, z) <= 0.0:
        return End("lift_off", 0.0, z)
    solver = DOP853(rates, 0.0, z, case.duration, rtol=rtol, atol=1e-14)
    while solver.status == "running":
        solver.max_step = longest(solver.t, solver.y)
        t, z = solver.t, solver.y
        solver.step()
        if guard(solver.t, solver.y) <= 0.0:
            return _ended(solver, rates, guard, t, z, rtol, "landing" if flies else "lift_off")
    return End("completed", solver.t, solver.y)


def _ended(solver, rates, guard, t: float, z: np.ndarray, rtol: float, status: str) -> End:
    """The zero of the guard in the solver's last step, which began at (t, z): by halves, each a step of its own."""

    def at(time):
        step = DOP853(rates, t, z, time, rtol=rtol, atol=1e-14, first_step=time - t)
        while step.status == "running":
            step.step()
        return step.y

    low, high = t, solver.t
    for _ in range(60):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (middle, high) if guard(middle, at(middle)) > 0.0 else (low, middle)
    return End(status, high, at(high))


def distance(end: End, state, time: float) -> float:
    """How far another end (x, y, θ, vx, vy, ω) of the same motion is from that by hand, in `SIZES` or in parts of what
    the values are, speeds in parts of the largest (they are sums of each other)."""
    scales = np.maximum(_SCALES, np.abs(end.state))
    scales[3:] = np.maximum(scales[3:], _SCALES[3:] * np.max(np.abs(end.state[3:]) / _SCALES[3:]))
    return float(max(*np.abs(np.array(state, dtype=float) - end.state) / scales, abs(time - end.time) / SIZES["t"]))


def growth(case: Case, terms: Sequence[Term], end: End) -> float:
    """What the motion makes of an error at its start, at least 1; infinite where that ends it otherwise."""
    other = by_hand(case, terms, moved=SMALL)
    return max(distance(end, other.state, other.time) / SMALL, 1.0) if other.status == end.status else np.inf
