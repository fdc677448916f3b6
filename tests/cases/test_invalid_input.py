"""Invalid input is rejected in one sentence that says what to write instead, before anything runs.

The scenes that a limit excludes are rows of `test_limits`; numbers of all types are in `test_numbers`, what is typed on
command lines is in `test_commands` and in `tests/fuzz`.
"""

from dataclasses import dataclass
from math import atan, inf, nan, pi

import numpy as np
import pytest
import sympy as sp

import cases
import reference
from cases import (
    BadCurve,
    BadValue,
    Belt,
    Case,
    CaseError,
    Chain,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Drive,
    EndCondition,
    Flight,
    Gravity,
    Impact,
    Load,
    NotSupported,
    Outline,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    StartPose,
    State,
    Support,
    Trajectory,
    Unilateral,
    UnknownName,
    arc,
    contact,
    disc,
    fit_friction,
    fit_waves,
    library,
)
from cases import curves as c
from cases.constructions import natural, piecewise
from cases.library import circle, ellipse, line
from reference.paper.application import slip_end

G, ROUGH = Gravity(9.81), (Gravity(9.81), CoulombFriction(0.2), Unilateral())
FREE = (*ROUGH, Flight(), Impact(0.0, "moreau"))
T, V = np.linspace(0.0, 2.0, 401), np.linspace(0.0, 2.0, 41)
SQUARE = [(0, 0), (2, 0), (2, 1), (0, 1)]
DISC, CIRCLE, LEVEL = disc(0.5, 2.0), circle(1.0), Curve(("s", "0.0"), (0, 1))
POINTS = np.column_stack([np.linspace(-3.0, 3.0, 20), np.cos(np.linspace(-6.0, 6.0, 20))])
REST = Trajectory(t=np.array([0.0, 1.0]), **dict.fromkeys(State._fields, np.zeros(2)))
STRIBECK, U = "0.1 + 0.1*exp(-v/0.05)", sp.Symbol("u")


def level(*effects, plate=DISC, **start) -> Case:
    return Case(line(), plate, effects, Start(xi1=0.0, **start), 1.0)


def supported(*supports, effects=FREE) -> Case:
    return Case(line(), disc(0.5, 1.0), effects, StartPose(0.0, 0.5), 1.0, supports=supports)


def in_circle(**parameters) -> Case:
    return cases.load("disc_in_circle", **parameters)


def prove(case: Case) -> object:
    pytest.importorskip("flint")
    return reference.prove(case)


def sweep(**how) -> object:
    return reference.sweep_chunks("disc_in_circle", **how)


class Sandpaper(PerfectlyRough):
    """A class of an author's own; it must not pass for another kind of effect than PerfectlyRough."""


class Sticky(CoulombFriction):
    """The same of CoulombFriction."""


class Loose(ContactEffect):
    """It is no frozen dataclass."""


@dataclass(frozen=True)
class Pull(ContactEffect):
    """An effect of a package, with formulas of its own."""

    along: str = "0.0"
    couple: str = "0.0"
    conditions: tuple = ()

    def force(self):
        return ContactForce(along=self.along, couple=self.couple)

    def ends(self):
        return self.conditions


@dataclass(frozen=True)
class Failing(ContactEffect):
    """An effect whose function fails."""

    def force(self):
        raise KeyError("pull")


TWICE = EndCondition("ended", "1 - t", "Time."), EndCondition("ended", "1 - slip", "Slip.")
# What is called, and a part of the sentence.
ROWS = {
    BadValue: [
        *((lambda when=when: REST(when), "") for when in ("0.1", True, [False], b"0", None, 1j, [[0.1]], nan, "nan")),
        *((lambda when=when: REST(when), "") for when in (2.0, [0.5, -1e-9])),
        (lambda: in_circle(m=-1), "greater than zero"),
        (lambda: in_circle(mu=nan), "finite"),
        (lambda: in_circle(mu="0.1"), "number"),
        (lambda: in_circle(duration=0), "greater than zero"),
        (lambda: in_circle(mu=1e9), "PerfectlyRough"),
        (lambda: in_circle(duration=1e100), "duration"),
        (lambda: cases.load("disc_in_circle[mu]"), "parameter=number"),
        (lambda: cases.load("disc in circle"), "name[parameter=value"),
        # What leaves doubles no digits.
        (lambda: cases.load("at_any_size", length=1e100), "m long"),
        (lambda: cases.load("at_any_size", length=1e-100), "m long"),
        (lambda: cases.load("at_any_size", mass=1e100), "mass of the plate"),
        (lambda: cases.load("at_any_size", mass=1e-100), "mass of the plate"),
        (lambda: level(plate=disc(0.1, 1.0, inertia=1e100)), "radius of gyration"),
        (lambda: level(plate=disc(0.1, 1.0, inertia=1e-100)), "radius of gyration"),
        (lambda: Case(line(), DISC, (), Start(1e100), 1.0), "from the origin"),
        (lambda: level(slip=1e100), "slip of Start"),
        (lambda: level(omega=1e100), "omega of Start"),
        (lambda: level(Gravity(1e100)), "g of Gravity"),
        (lambda: level(CoulombFriction(0.1, mu_static=1e9)), "mu_static"),
        (lambda: level(CoulombFriction(0.1), RollingResistance(1e100)), "arm"),
        # Effects, and those that need or exclude each other.
        (lambda: level(Gravity), "brackets"),
        (lambda: level(Gravity(1), Gravity(2)), "more than"),
        (lambda: Case(CIRCLE, 0.1, (), Start(0.0), 1.0), "Plate"),
        (lambda: CoulombFriction(0.3, mu_static=0.2), "at least mu"),
        (lambda: CoulombFriction(0.0, mu_static=0.2), "mu greater than zero"),
        (lambda: level(PerfectlyRough(), Sticky(0.3)), "give CoulombFriction"),
        (lambda: level(*ROUGH, gap=-0.1), "gap"),
        (lambda: level(CoulombFriction(0.1), Sandpaper()), "give PerfectlyRough"),
        (lambda: level(*ROUGH, gap=0.1), "add Flight"),
        (lambda: level(*ROUGH, gap_rate=0.1), "add Flight"),
        (lambda: level(*ROUGH, Flight(), gap_rate=-0.1), "add Impact"),
        (lambda: level(G, PerfectlyRough(), slip=0.1), "slip=0"),
        (lambda: Impact(1.5), "between 0 and 1"),
        (lambda: Impact(0.5, law="hertz"), "moreau"),
        (lambda: RollingResistance(-0.1), "arm"),
        (lambda: Load(fx="2*w"), "use t, x, y, theta, vx, vy, omega"),
        (lambda: Load(fx=nan), "finite"),
        (lambda: Load(fx="__import__('os')"), "fx of Load"),
        (lambda: Load(fx=[1.0]), "fx of Load"),
        (lambda: Belt("v"), "use t"),
        (lambda: Belt(None), "speed of Belt"),
        (lambda: level(*ROUGH, Belt("1/t")), "at t = 0"),
        (
            lambda: contact.slip_velocity(level(*ROUGH, Belt("t"), slip=0.1), 0.0, 0.5, 1.0, 0.0, 0.0, 0.0),
            "give the times",
        ),
        (lambda: supported(Support(line(pi / 2), "wall", (CoulombFriction(0.2), Belt("1/t")))), "has no value"),
        (lambda: Drive(), "leave Drive out"),
        (lambda: Drive(x=1.0), "leave Drive out"),
        (lambda: Drive(x="v"), "use t"),
        (lambda: level(*ROUGH, Drive(x="1/t")), "at t = 0"),
        (lambda: Case(line(), DISC, (G, Drive(x="1/t")), StartPose(0.0, 0.5), 1.0), "that have values at t = 0"),
        (lambda: level(*ROUGH, plate=disc(0.1, 1.0, inf), omega=1.0), "give omega=0"),
        (lambda: Plate(ellipse(0.1, 0.05), 1.0, -inf), "inertia of the plate"),
        *(
            (lambda mu=mu: CoulombFriction(mu), words)
            for mu, words in {
                "0.3 - 0.1*v": "is -",
                "0.2 - 0.3*exp(-((v - 1)/1e-4)**2)": "at v = 1 m/s",
                "0.1 + sqrt(v)": "not smooth at v = 0",
                "0.1 + v*log(v)": "no finite value at v = 0",
                "0.1*exp(v)": "no finite value",
                "0.1 + w": "use v and",
                "0.1*v": "greater than 0 there",
                "-0.1": "zero or more",
                (0.1,): "a number, or a formula in v",
                None: "a number, or a formula in v",
            }.items()
        ),
        (lambda: CoulombFriction(STRIBECK, 0.15), "below mu = 0.2 at v = 0"),
        (lambda: level(*ROUGH, Loose()), "Loose is no frozen dataclass"),
        (lambda: level(*ROUGH, Pull("sin(t)")), "no polynomial of degree 2"),
        (lambda: level(*ROUGH, Pull("slip**3")), "no polynomial of degree 2"),
        (lambda: level(*ROUGH, Pull(couple="-0.1*theta")), "couple of Pull"),
        (lambda: level(*ROUGH, Failing()), "the formulas of Failing fail"),
        (lambda: level(*ROUGH, Pull(conditions=TWICE)), "two conditions end the motion with the status 'ended'"),
        # Supports.
        (lambda: Support(line(), "track"), 'give a word such as "wall"'),
        (lambda: Support(3, "wall"), "give a Curve"),
        (lambda: Support(line(), "wall", (G,)), "is no effect of one Support"),
        (lambda: Support(line(), "wall", 0.3), "give a tuple"),
        (lambda: supported(line()), 'give Support(curve, "name")'),
        (lambda: supported(Support(line(0.5), "a"), Support(line(0.4), "a")), "give each its own"),
        (lambda: supported(Support(line(0.5), "a"), effects=(G,)), "add Unilateral"),
        (lambda: supported(Support(line(0.5), "a", (Impact(0.1, "newton"),))), "with the same law"),
        (lambda: supported(Support(line(0.5), "a", (CoulombFriction(1e5),))), "is 100000; give at most 10000"),
        # Curves, and what they are made of.
        (lambda: Curve(lambda s: (s, 0), domain=(1, -1)), "smaller number first"),
        (lambda: library.superellipse(1.0, 1.0, 3), "even whole number"),
        (lambda: circle(-1.0), "greater than zero"),
        (lambda: Outline.polygon([(0, 0), (1, 0)]), "give at least 3"),
        (lambda: Outline.polygon([(0, 0), (1, 0), (1, 0), (0, 1)]), "points 1 and 2 are the same"),
        (lambda: Outline.polygon([(0, 0), (1, 0), (0, 1), (0, 0)]), "leave it out"),
        (lambda: Outline.polygon([(0, 0), (1, 0), (0, nan)]), "y of a point"),
        (lambda: Outline.polygon(SQUARE, 0.5), "too short for corners of radius"),
        (lambda: Chain([]), "smooth curves"),
        (lambda: Chain(3), "smooth curves"),
        (lambda: Plate.gear(0.1, 8, 0.2, 1.0), "below its radius"),
        (lambda: arc((0, 0), 1.0, 2.0, 2.0), "two angles"),
        (lambda: Curve.spline(POINTS[:5]), "give at least 6"),
        (lambda: Curve.spline([(0, 0), (1, 0), (nan, 1)] * 4), "point 3 is not finite"),
        (lambda: Curve.spline([1, 2, 3]), "shape (n, 2)"),
        (lambda: Curve.spline([("a", "b")] * 9), "not numbers"),
        (lambda: Curve.spline(POINTS, smoothing=-1.0), "smoothing is -1"),
        (lambda: Curve.spline(POINTS, closed="no"), "closed is"),
        (lambda: piecewise([LEVEL]), "give at least two"),
        (lambda: piecewise([LEVEL, Curve(("s", "s**2"))]), "curve 2 is not one formula"),
        (lambda: piecewise("xy"), "curves of piecewise is 'xy'; give a tuple"),
        # Samples.
        (lambda: fit_waves(T, np.sin(200.0 * T), 0.1), "with frequencies up to"),
        (lambda: fit_friction(V, 0.3 + 0.1 * np.sin(20.0 * V), 1e-3), "with 4 decays it is"),
        (lambda: fit_waves(T, T[1:], 0.1), "t has 401 numbers, values 400"),
        (lambda: fit_waves(T[::-1], T, 0.1), "t does not increase"),
        (lambda: fit_waves(T, np.full(401, nan), 0.1), "holds NaN"),
        (lambda: fit_waves(T, ["fast"] * 401, 0.1), "other than numbers"),
        (lambda: fit_waves(T, T, 0.0), "within is 0"),
        (lambda: fit_waves(T, T, 0.1, 3), "integrals is 3"),
        (lambda: fit_friction(V - 1.0, V, 0.1), "not negative"),
        *(
            (lambda make=make, value=value: make(value), words)
            for make, words in (
                (Belt, "fit_waves"),
                (lambda x: Drive(x=x), "fit_waves"),
                (lambda fx: Load(fx=fx), "in t, x, y, theta, vx, vy, omega as text"),
                (CoulombFriction, "in v, the slip speed, as text"),
            )
            for value in (np.sin, lambda t: 0.1, V, V.tolist(), (T, T), {"t": 1.0}, None)
        ),
        # Sweeps, tolerances, and the paper's application.
        (lambda: sweep(mu="0.5:0.1:3"), "which is empty; give the smaller number first"),
        (lambda: sweep(mu="0.1:0.1:3"), "which is empty"),
        (lambda: sweep(mu="0.1:0.5:0"), "the count of mu is 0"),
        (lambda: sweep(mu="0:0.5:9:log"), "by powers; give a start above zero"),
        (lambda: sweep(mu="a:b:c"), "cannot be read; write mu=low:high:count"),
        (lambda: sweep(mu=[]), "mu has no value"),
        (lambda: sweep(mu=b"1"), "mu is b'1'; give a number, a list of numbers or text"),
        (lambda: sweep(mu={0.1: 0.2}), "give a number, a list of numbers or text"),
        (lambda: sweep(mu="0.1:0.5"), "mu has no count; write mu=0.1:0.5:count"),
        (lambda: sweep(), "nothing varies"),
        (lambda: sweep(mu="0.1:0.5", sample="random"), "needs the number of scenarios"),
        (lambda: sweep(mu="0.1:0.5:3", number=5), "a grid has as many scenarios as its axes say"),
        (lambda: sweep(mu=[0.1, nan]), "give a finite number"),
        *(
            (lambda run=run, rtol=rtol: run(rtol), "give a number between 1e-14 and 0.01")
            for rtol in ("1e-6", None, True, 1e-15, 0.1, nan, [1e-6])
            for run in (
                lambda rtol: reference.simulate(in_circle(), rtol=rtol),
                lambda rtol: reference.sweep("disc_in_circle", mu="0.1:0.2:2", rtol=rtol),
            )
        ),
        *((lambda a=a: slip_end(*a), "give 0 <= release") for a in ((0.1, -0.1), (0.1, 1.6), (0.0, 0.0), (0.1, 0, 0))),
        (lambda: slip_end(0.1, atan(1 / 0.3) + 1e-9), "release it higher"),
    ],
    DoesNotFit: [
        (lambda: in_circle(r=1.5), "smaller plate"),
        # Curvature allows contact at the flat side of the slot, but the disc is wider than the slot.
        (lambda: Case(ellipse(3.0, 0.5), disc(0.6, 1.0), (), Start(xi1=-pi / 2), 1.0), "overlaps"),
        (lambda: Case(line(), DISC, ROUGH, StartPose(0.0, 0.4), 1.0), "overlaps its track"),
        (lambda: Case(line(), Plate(library.superellipse(0.2, 0.1, 6), 1.0, 0.01), ROUGH, Start(0.0), 1.0), "not fit"),
        (lambda: level(G, RollingResistance(0.01)), "CoulombFriction or PerfectlyRough"),
        (lambda: level(G, Belt(1.0)), "CoulombFriction or PerfectlyRough"),
        (lambda: level(*ROUGH, Belt(1.0), RollingResistance(0.01)), "no established law"),
        (lambda: level(G, Flight()), "add it or remove Flight"),
        (lambda: level(G, Unilateral(), Impact(0.5)), "needs Flight"),
        (lambda: level(CoulombFriction(0.1), PerfectlyRough()), "contradict"),
        (lambda: level(*ROUGH, RollingResistance(0.01), plate=disc(0.1, 1.0, inf)), "leave RollingResistance out"),
        (lambda: supported(Support(line(0.5), "a")), "overlaps support 'a'"),
        (lambda: supported(Support(Curve(("s", "s**2 + 3.0"), (-2, 2)), "bowl")), "lies behind support"),
        (
            lambda: supported(Support(line(pi / 2), "wall", (RollingResistance(0.01),)), effects=(G, Unilateral())),
            "roll",
        ),
    ],
    BadCurve: [
        (lambda: Curve("circle"), "lambda s"),
        (lambda: Curve(lambda s: (s**2, s**3), domain=(-1, 1)), "cusp"),
        (lambda: Curve(lambda s: (s, 1 / s), domain=(-1, 1.3)), "finite"),
        (lambda: library.trochoid(0.3, 0.5), "cusps or loops"),
        (lambda: library.from_support(lambda s: 0.1 + 0.05 * c.cos(3 * s)), "cusp"),
        (lambda: Curve(lambda s: (c.sin(s), c.sin(2 * s))), "crosses itself"),
        (lambda: Curve(lambda s: (s - 2 * c.sin(s), -2 * c.cos(s)), (-4, 4)), "crosses itself"),
        # Its loops' chords cross in one pair of sides, the curve in the next.
        (lambda: Curve(("s + 1.2830888*sin(s)", "-1.2830888*cos(s)"), (-10.3993, 10.3993)), "crosses itself"),
        (lambda: Curve(("s", "s^2"), (-1, 1)), "**"),
        (lambda: Curve(("s", "cos(t)")), "'t'"),
        (lambda: Curve(("s", "s.__class__")), "more than arithmetic"),
        (lambda: Curve(("s", "cos(s")), "cannot be read"),
        (lambda: Outline.polygon([(0, 0), (2, 0), (0, 1), (2, 1)]), "crosses itself near (1, 0.5)"),
        (lambda: Chain([LEVEL, LEVEL]), "pieces that join"),
        (lambda: Chain.polyline([(0, 0), (1, 0), (0, 0)]), "turns back"),
        (lambda: Chain([line()]), "has no ends"),
        (lambda: Plate.homogeneous(library.parabola(1.0), 1.0), "closed outline"),
        (lambda: Plate.homogeneous(CIRCLE, 1.0, holes=[circle(1.1)]), "not inside"),
        (
            lambda: Curve.spline([(np.cos(a), np.sin(a)) for a in np.linspace(0, 4, 30)], closed=True),
            "closed curve has",
        ),
        (lambda: piecewise([LEVEL, Curve(("1 + s", "s"), (0, 1))]), "corner of 0.785"),
        (lambda: piecewise([LEVEL, Curve(("s", "0.0"), (1.2, 2))]), "ends 0.2 m from"),
        (lambda: Curve(lambda s: (s, sp.Integral(U, (U, s, 1))), (0, 1)), "lower is a number"),
        (lambda: Curve(lambda s: (s, c.integral(lambda u: u * s, s)), (0, 1)), "use u1 alone"),
        (lambda: natural(lambda s: 4.0 * c.exp(-((s - 4) ** 2)), 8.0), "allow it with may_cross=True"),
    ],
    UnknownName: [
        (lambda: cases.load("disc_in_circel"), "disc_in_circle"),
        (lambda: in_circle(mew=1), "mu"),
        (lambda: cases.load_file("no_such_file.py"), "no_such_file"),
        (lambda: Curve.spline("nowhere.csv"), "there is no file of points"),
        (lambda: sweep(nu="0:1:3"), "there is no parameter of disc_in_circle 'nu'"),
        (lambda: sweep(mu="0.1:0.5", sample="grit"), "there is no sampling 'grit'"),
        (lambda: reference.simulate(in_circle(), method="augmentd"), "augmented"),
    ],
    NotSupported: [
        (lambda: Outline.polygon(SQUARE).jet(0.0), "smooth curve"),
        (lambda: Curve.spline(POINTS).expression, "no single formula"),
        (lambda: reference.simulate(cases.load("ladder_at_wall"), method="augmented"), "has one contact"),
        (lambda: prove(level(*ROUGH, Pull("0.1"))), "has Pull, which proofs do not cover"),
        (lambda: prove(level(G, CoulombFriction(STRIBECK), Unilateral())), "depends on the slip velocity"),
        (lambda: prove(cases.load("bouncing_disc", e=0.5)), "begins in flight"),
    ],
    CaseError: [
        # What no table resolves, at once; before, it took up to minutes.
        (lambda: Curve(("s", "sin(1e6*s)"), domain=(-1.0, 1.0)), "give a shorter"),
        (lambda: Curve(("s", "sin(5e3*s)"), domain=(-1.0, 1.0)), "give a shorter"),
        (lambda: Curve(("cos(1e6*s)", "sin(1e6*s)"), domain=(-1.0, 1.0), may_cross=True), "give a shorter"),
        (lambda: Curve(("s", "s**2"), domain=(1.0, 1.0 + 1e-14)), "give a wider"),
    ],
}
CALLS = [(kind, call, words) for kind, rows in ROWS.items() for call, words in rows]


@pytest.mark.parametrize(("kind", "call", "words"), CALLS, ids=[f"{k.__name__}-{words}" for k, _, words in CALLS])
def test_invalid_input_is_rejected_in_one_sentence_that_says_what_to_write(kind, call, words):
    with pytest.raises(kind) as error:
        call()
    text = str(error.value)
    assert words in text and "\n" not in text and 0 < len(text) < 300
