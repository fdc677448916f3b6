"""Invalid input is rejected in one sentence that says what to write instead, before anything runs or is written.

A row is a call or a command line, and a part of its sentence. Tested elsewhere: the scenes that a limit excludes
(`test_limits`), numbers of all types (`test_numbers`), mistakes inside files, which are tested with the command that
reads them, and drawn input (`tests/fuzz`).
"""

import os
import shlex
import sys
from dataclasses import dataclass, replace
from functools import cache, partial
from math import atan, inf, nan, pi
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import sympy as sp

import adapters
import cases
import reference
from adapters import lookup
from adapters.common import motion_table
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
    FreePlate,
    Gravity,
    Impact,
    Load,
    NotSupported,
    Outline,
    Pair,
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
    block,
    contact,
    disc,
    fit_friction,
    fit_waves,
    library,
    registry,
)
from cases import curves as c
from cases.commands import TEMPLATE
from cases.constructions import natural, piecewise
from cases.library import circle, ellipse, line
from reference.paper.application import slip_end
from reports import build, cli, options, studies
from tests.fuzz.harness import told_by

G, ROUGH = Gravity(9.81), (Gravity(9.81), CoulombFriction(0.2), Unilateral())
FREE = (*ROUGH, Flight(), Impact(0.0, "moreau"))
T, V = np.linspace(0.0, 2.0, 401), np.linspace(0.0, 2.0, 41)
SQUARE = [(0, 0), (2, 0), (2, 1), (0, 1)]
DISC, CIRCLE, LEVEL = disc(0.5, 2.0), circle(1.0), Curve(("s", "0.0"), (0, 1))
POINTS = np.column_stack([np.linspace(-3.0, 3.0, 20), np.cos(np.linspace(-6.0, 6.0, 20))])
REST = Trajectory(t=np.array([0.0, 1.0]), **dict.fromkeys(State._fields, np.zeros(2)))
STRIBECK, U = "0.1 + 0.1*exp(-v/0.05)", sp.Symbol("u")
BOX, ROD = Plate.rectangle(0.2, 0.1, 1.0), Plate.rectangle(1.0, 0.02, 1.0)
BEND, EDGE = Curve(("1 + sin(s)", "1 - cos(s)"), (0, 1)), Chain.polyline([(0, 0), (1, 0), (1, -1)])


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


def augmented(case: Case) -> object:
    return reference.simulate(case, method="augmented")


def stacked(*others, effects=FREE, pairs=()) -> Case:
    """A disc on the floor, with further plates."""
    return Case(line(), DISC, effects, StartPose(0.0, 0.5), 1.0, others=others, pairs=pairs)


def upper(name="upper", plate=DISC, **pose) -> FreePlate:
    return FreePlate(plate, StartPose(**{"x": 0.0, "y": 1.5} | pose), name)


def by_hand(**how) -> object:
    """A report of a case made by hand."""
    return build.report(how.pop("given", [replace(level(*ROUGH), name="by_hand")]), **how)


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
# What is called, and a part of the sentence, by the type of the error.
CALLS = {
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
        (lambda: Load(fx="5*(t>1 and 3)"), "combines other than comparisons by and, or, not"),
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
        (lambda: Curve.spline("points.csv", closed=True), "points.csv:3"),
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
        (lambda: reference.sweep("disc_on_incline", mu=np.array([0.1, 0.2])).plot_map(), "two parameters"),
        # Several plates.
        (lambda: replace(stacked(), others=upper()), "give a tuple"),
        (lambda: stacked(upper(), upper()), "have the name 'upper'"),
        (lambda: stacked(upper(plate=disc(0.5, 1.0, inf), omega=1.0)), "omega=0"),
        (lambda: stacked(upper(), effects=ROUGH), "add Flight"),
        (lambda: upper("plate"), "is the case's plate"),
        (lambda: stacked(pairs=[Pair("plate/track", ())]), "give a tuple such as"),
        (lambda: motion_table.parse("t,x,x of upper,x of upper\n0,0,0,0\n", "m.csv"), "2 columns x of upper"),
        # Blocks.
        (lambda: level(G, plate=BOX, omega=1.0), "a plate that lies on a flat side does not turn; give omega=0"),
        (lambda: block(0.0, 1.0, 1.0), "of the block"),
        (lambda: block(1.0, -1.0, 1.0), "of the block"),
        # Executables and adapters of an author's own.
        *(
            (lambda text=text: options.points_of(text), "give a " + words)
            for text, words in (
                *((text, "whole number from 2 to 100000") for text in ("1", "0", "-5", "2.5", "100001", "many")),
                ("9" * 400, "finite number"),
            )
        ),
        (lambda: lookup.register(Path("taken")), "chmod"),
        (lambda: lookup.register(Path("pymunk")), "of its own"),
        (lambda: lookup.register(Path("two words")), "of its own"),
        (lambda: lookup.find("fails.py"), "fails.py fails: ZeroDivisionError"),
        (lambda: lookup.find("json"), "json is not an adapter: it lacks NAME, routes,"),
        (lambda: lookup.find("empty.py"), "it lacks routes, refuses, ladder, build, run, read, version"),
        *(
            (lambda name=name: studies.study(name), f"in a clone type: python -m tests.benchmarks {name}")
            for name in studies.MOVED
        ),
        (lambda: studies.study("maps"), "maps is a sweep; type: slip-to-roll sweep disc_in_circle"),
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
        (lambda: stacked(upper(y=1.0)), "upper/plate overlap by"),
        *(
            (
                lambda wall=wall: Case(line(), ROD, FREE, StartPose(0.0, 1.0), 1.0, supports=(Support(wall, "wall"),)),
                "overlaps support 'wall'",
            )
            for wall in (library.hill(1.0), Curve(("s", "2*s**2 + 0.8"), (-2, 2)))
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
        (lambda: reference.derivatives(cases.load("disc_on_line"), "nu"), "mu"),
        (lambda: cases.load("none.py:on_a_table"), "no case file"),
        (lambda: adapters.engine("exudin"), "choose from"),
        (lambda: lookup.find("none.py"), "there is no adapter file 'none.py'"),
        (lambda: lookup.find("no_such.module"), "there is no adapter, Python file or module 'no_such.module'"),
        (lambda: REST.plate("disc3"), "disc3"),
    ],
    NotSupported: [
        (lambda: Outline.polygon(SQUARE).jet(0.0), "smooth curve"),
        (lambda: Curve.spline(POINTS).expression, "no single formula"),
        (lambda: augmented(cases.load("ladder_at_wall")), "has one contact"),
        (lambda: augmented(cases.load("disc_on_free_disc")), "one plate"),
        (lambda: augmented(Case(piecewise([LEVEL, BEND]), disc(0.1, 1.0), ROUGH, Start(0.5), 1.0)), "no jumps of curv"),
        (lambda: augmented(Case(EDGE, disc(0.1, 1.0), ROUGH, Start(0.5), 1.0)), "does not integrate over corners"),
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
        (lambda: stacked(pairs=(Pair("disc/plate", ()),)), "there is no pair of the case 'disc/plate'"),
        (lambda: stacked(pairs=(Pair("plate/track", ()),)), "give its effects as those of the case"),
        # Reports of cases made by hand.
        (lambda: by_hand(given=[]), "there is no case"),
        (lambda: by_hand(given=2 * [replace(level(*ROUGH), name="by_hand")]), "give each a different name="),
        (lambda: by_hand(given=["disc_on_line"]), "give a Case"),
        (lambda: by_hand(solvers=["pymonk"]), "pymunk"),
        (lambda: by_hand(effort="some"), "quick"),
        *((lambda jobs=jobs: by_hand(jobs=jobs), "from 1 to") for jobs in (0, "1_0")),
        *(
            (lambda out=out: by_hand(out=out), words)
            for out, words in {".": "inside it", "out\udcff": "no path here", "": "is empty"}.items()
        ),
        *(
            (lambda store=store: by_hand(out="out", store=store), words)
            for store, words in {"": "is empty", ".": "--store", Path.cwd().anchor: "--store"}.items()
        ),
    ],
}  # fmt: skip


class Rejected(Exception):
    """What a command that ended with status 2 printed."""


def command(line: str) -> None:
    """Run `slip-to-roll` with the words of the line; raises Rejected if they are."""
    status, output, text = told_by(cli.main, shlex.split(line))
    assert (status, output) == (2, "") and text.endswith("\n"), text
    raise Rejected(text[:-1])


LABEL = "disc_on_line[mu=0.1]"
RUNS = "case,solver,route,setting,outcome,off,off_doubt\n{},exudyn,native,h,answered,0.1,0\n"
FILES = {
    "broken.py": "from cases import case\n\n\n@case\ndef broken_case():\n    return 1 / 0\n",
    "bowls.py": TEMPLATE.format(name="bowl") + "\n\n@case\ndef other_bowl():\n    return bowl(mu=0.2)\n",
    "own": "#!/bin/sh\n",
    "pymunk": "#!/bin/sh\n",
    "two words": "#!/bin/sh\n",
    "fails.py": "1 / 0\n",
    "empty.py": "NAME = 'empty'\n",
    "formula.py": "".join(
        f"def {name}(*_):\n    return None\n" for name in "refuses ladder build run read version".split()
    )
    + "NAME, routes = 'formula', ('native',)\n",
    "taken": "precious",
    "points.csv": "x,y\n0,0\n1,zero\n",
    "mine/letter.txt": "dear friend",
    "old/manifest.json": '{"format": 2}',
    "old/tables/trajectories.csv": RUNS.format("a"),
    "new/tables/trajectories.csv": RUNS.format("b"),
}
VARY = "sweep disc_in_circle --vary mu=0:1:3"
LINES = [
    ("repot", "did you mean report?"),
    ("release", "did you mean release"),
    ("report --case disc_in_circel", "disc_in_circle"),
    ("report --case disc_in_circle[mu=nan]", "finite"),
    ("report --case disc_in_circle[m=-1]", "greater than zero"),
    ("report --case disc_in_circle[mass=1]", "parameter"),
    ("report --case disc_in_circle[mu]", "parameter=number"),
    ("report --case disc_in_circle[r=2]", "smaller plate"),
    ("report --case", "expected at least one"),
    ("report --case-file nowhere.py", "nowhere.py"),
    ("report --case-file broken.py", "ZeroDivisionError"),
    ("report --solver exudin", "exudyn"),
    ("report --quick --solver pymunk@", "'' is not a version"),
    ("report --quick --solver pymunk@latest", "'latest' is not a version"),
    ("report --quick --solver pymunk@5.7", "select one of these"),
    ("report --quick --solver pimunk@7", "there is no solver 'pimunk'"),
    ("report --quick --solver reference@1", "the reference has one version"),
    ("report --solvr exudyn", "--solver"),
    ("report --jobs many", "whole number"),
    ("report --jobs 0", "from 1 to"),
    ("report --jobs=--", "has no value but --"),
    ("report --case-file=--", "has no value but --"),
    ("report --quick --full", "not allowed with"),
    ("report --out .", "inside it"),
    ("report --out taken", "which is a file"),
    ("report --out mine", "holds letter.txt and is no report; give another folder"),
    ("report --out new", "holds tables and is no report; give another folder"),
    ("report --store a/b --out a", "not inside each other"),
    ("report --store taken", "which is a file"),
    pytest.param("report --out /proc/report", "cannot be written to", marks=pytest.mark.skipif(
        sys.platform != "linux", reason="no /proc")),  # there everybody may write, says the system, and nobody can
    ("report --engine ./own --dask local", "give one of the two"),
    ("report --points 3", "--points is for executables"),
    (f"report --case {LABEL} --trajectory mine", "give --trajectory NAME=FILE.csv"),
    (f"report --case {LABEL} --trajectory =mine.csv", "give --trajectory NAME=FILE.csv"),
    (f"report --case {LABEL} --trajectory reference=mine.csv", "takes the name of the solver reference"),
    (f"report --case {LABEL} --trajectory mine@disc_on_lien=mine.csv", "no case in this report 'disc_on_lien'"),
    (f"report --case {LABEL} --trajectory mine=nowhere.csv", "there is no file 'nowhere.csv'"),
    (f"report --case {LABEL} --trajectory mine=columns.csv", "has no column theta"),
    (f"report --case {LABEL} --trajectory mine=unsorted.csv", "does not increase"),
    (f"report --case {LABEL} --trajectory mine=millimetres.csv", "give metres"),
    ("report --case disc_on_line --trajectory mine=mine.csv", "names no case, and the report has"),
    ("report --trajectory mine@disc_on_line=mine.csv", "give one of disc_on_line["),
    ("report study stability a b c", "'a' is one argument too many"),
    ("report study nothing", "nothing"),
    (f"compare {LABEL} mine.csv --colour", "there is no option '--colour'"),
    (f"compare {LABEL} nowhere.csv", "nowhere.csv"),
    (f"compare {LABEL} mine.csv --solver exudyn", "are for the folders of two reports"),
    (f"compare {LABEL} mine.csv --worse-than 10%", "are for the folders of two reports"),
    ("compare bowls none.csv", "give one: bowls.py:bowl"),
    ("compare bowls.py:no_such_case none.csv", "there is no case in bowls.py 'no_such_case'"),
    ("compare old mine", "contains no report"),
    ("compare old new --worse-than 10%", "no run in common"),
    ("compare old old --worse-than ten", "--worse-than is 'ten'; give a share such as 10% or 0.1"),
    ("compare old old --worse-than -5%", "expected one argument"),
    ("compare old old --worse-than=-5%", "--worse-than is '-5%'; give a share such as 10% or 0.1"),
    ("compare old old --worse-than 10% --format yaml", "there is no --format 'yaml'; choose from json, junit, text"),
    ("compare old old --worse-than 10% --solver nobody", "has no runs of the solver nobody"),
    ("compare old old --format junit", "--format"),
    ("compare old old --solver exudyn", "give --solver twice"),
    ("compare old old --solver exudyn --solver nobody", "has no rows of the solver nobody"),
    ("gate new", "give --baseline DIR"),
    ("gate --baseline old nowhere", "contains no report"),
    ("history", "name an engine, for example pymunk"),
    ("history pymunk@7.0.0", "give an engine without a version"),
    ("history reference", "reference has no history of releases"),
    ("history pymnk", "choose from box2d, exudyn"),
    ("sweep disc_in_circel --vary mu=0:1:3", "there is no case 'disc_in_circel'"),
    ("sweep disc_in_circle --vary nu=0:1:3", "there is no parameter of disc_in_circle 'nu'"),
    ("sweep disc_in_circle --vary mu=1:0:3", "which is empty"),
    ("sweep disc_in_circle --vary mu", "write --vary parameter=low:high:count"),
    ("sweep disc_in_circle", "nothing varies"),
    (f"{VARY} --vary mu=0:1:3", "given twice"),
    ("sweep disc_in_circle --vary mu=0:1 --sample sobol", "needs the number of scenarios"),
    (f"{VARY} --refine 0", "--refine is 0; give a number greater than zero"),
    ("sweep disc_in_circle --vary mu=0.1,0.2 --refine 1e-3", "needs a range to divide"),
    (f"{VARY} --solver exudin", "there is no solver 'exudin'"),
    (f"{VARY} --jobs 0", "from 1 to"),
    (f"{VARY} --log-level loud", "there is no --log-level 'loud'; choose from debug, error, info, warning"),
    (f"{VARY} --out=--", "has no value but --"),
    (f"{VARY} --rtol much", "give a number"),
    ("sweep disc_in_circle --vary mu=0:1 --sample random --number 1.5", "--number is 1.5; give a whole"),
    ("sweep disc_in_circle --vary mu=0:1 --sample random --seed 0.5", "--seed is 0.5"),
    (f"{VARY} --dask nonsense", "missing port number in address 'nonsense'"),
    (f"{VARY} --out .", "contains the working folder"),
    (f"{VARY} --out mine", "holds letter.txt and is no sweep; give another folder"),
    ("sweep bowls --vary mu=0.1,0.2", "give one: bowls.py:bowl"),
    *((f"cases {name} bowls", "give one: bowls.py:bowl") for name in ("film", "show", "export")),
    ("cases show bowls.py:bowl[mew=1]", "there is no parameter of bowl 'mew'; choose from"),
    ("cases show --case-file no.py x y", "no.py"),
    ("compare nowhere", "'nowhere' is no folder of motions; give a case and a FILE"),
    ("release publish mine", "mine holds no report"),
    ("release deposit mine", "contains no published report"),
    ("cases film disc_on_line --out film.avi", "end it in .gif or .mp4"),
    *((f"{name} bash", f"{name} is gone; {words}") for name, words in cli.GONE.items()),
    ("laws exudin", "there is no adapter, Python file or module 'exudin'; choose from"),
    ("laws formula.py --law friction_torqe", "there is no law 'friction_torqe'; did you mean friction_torque or"),
    ("laws formula.py --route assisted", "there is no route of formula 'assisted'; choose from native"),
    ("laws .", "the adapter . fails while it is imported: TypeError: "),
    ("laws", "the following arguments are required: ADAPTER; see"),
    ("laws formula.py --rout native", "there is no option '--rout'; choose from --help, --law, --log-level, --route"),
    ("cases shwo", "choose from"),
    ("cases new", "new NAME"),
    ("cases new 'my valley'", "cannot name a case"),
    ("cases new class", "cannot name a case"),
    ("cases new disc_on_line", "already a case"),
    ("cases check nowhere.py", "no case file"),
    ("cases check", "check FILE"),
    ("cases show", "CASE"),
    ("cases show disc_on_lime", "disc_on_line"),
    ("cases show disc_on_line mew=0.3", "mu"),
    ("cases show disc_on_line mu=slippery", "parameter=number"),
    ("cases show disc_on_line --colour", "--colour"),
    ("cases show disc_on_line --out", "--out"),
    ("cases export disc_on_line mu=-1", "zero"),
]  # fmt: skip


@cache
def texts() -> dict[str, str]:
    """Files by name: FILES, one with a motion of the case, and such as have none."""
    exact = reference.simulate(cases.load(LABEL), rtol=1e-12)
    t = np.linspace(0.0, exact.t[-1], 301)
    state = exact(t)
    table = pd.DataFrame({"t": t, "x": state.x, "y": state.y, "theta": state.theta})
    tables = {
        "mine.csv": table,
        "columns.csv": table.drop(columns="theta"),
        "unsorted.csv": table.iloc[::-1],
        "millimetres.csv": table.assign(x=1e3 * table.x, y=1e3 * table.y),
    }
    return FILES | {name: table.to_csv(index=False) for name, table in tables.items()}


@pytest.fixture
def desk(tmp_path, monkeypatch) -> Path:
    """A working folder with those files."""
    monkeypatch.chdir(tmp_path)
    cases.names()  # the catalogue is loaded when it is first asked for
    own = {name: entry for name, entry in registry._entries.items() if entry.is_own}
    monkeypatch.setattr(registry, "_entries", own)
    monkeypatch.setenv(lookup.EXECUTABLES, "")  # and again after the test
    for name, text in texts().items():
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(text)
    for name in ("own", "pymunk", "two words"):
        os.chmod(name, 0o755)
    return tmp_path


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts}


ROWS = [(kind, call, words) for kind, rows in CALLS.items() for call, words in rows]
LINE_ROWS = [row if hasattr(row, "marks") else pytest.param(*row) for row in LINES]


@pytest.mark.parametrize(
    ("kind", "call", "words"),
    [
        *(pytest.param(*row, id=f"{row[0].__name__}-{row[2]}") for row in ROWS),
        *(
            pytest.param(Rejected, partial(command, row.values[0]), row.values[1], id=row.values[0], marks=row.marks)
            for row in LINE_ROWS
        ),
    ],
)
def test_invalid_input_is_rejected_in_one_sentence_that_says_what_to_write(kind, call, words, desk):
    before = contents(desk)
    with pytest.raises(kind) as error:
        call()
    text = str(error.value)
    assert words in text and "\n" not in text and 0 < len(text) < (600 if kind is Rejected else 300), text
    assert contents(desk) == before
