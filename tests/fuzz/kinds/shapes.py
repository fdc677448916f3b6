"""Curves that meet themselves, jump, leave a part out; points measured badly."""

import functools
from math import pi

import numpy as np
import sympy as sp

from cases import Curve

from ..harness import Kind


def refuses(make):
    """These are no curves: to make one of them is an error."""

    def call():
        make()
        raise AssertionError("it was accepted")

    return call


def arc(turns: float, frequency: int = 1):
    return lambda: Curve(lambda s: (sp.cos(frequency * s), sp.sin(frequency * s)), (0, 2 * pi * turns / frequency))


def trochoid(arm: float, reach: float):
    return lambda: Curve(lambda s: (s + arm * sp.sin(s), -arm * sp.cos(s)), (-reach, reach))


def spiral(growth: float, turns: float):
    """Comes back near itself, and does not meet itself."""
    return lambda: Curve(
        lambda s: (sp.exp(growth * s) * sp.cos(s), sp.exp(growth * s) * sp.sin(s)), (0, 2 * pi * turns)
    )


def measured(turns: float, count: int, noise: float, closed: bool, seed: int):
    angle = np.linspace(0.0, 2 * pi * turns, count, endpoint=False)
    off = noise * np.random.default_rng(seed).standard_normal((count, 2))
    return lambda: Curve.spline(np.column_stack([np.cos(angle), np.sin(angle)]) + off, closed=closed)


def draw(chance):
    which = chance.randrange(6)
    if which == 0:
        turns = chance.uniform(1.02, 4.0)
        return f"a circle run round {turns} times", refuses(arc(turns, chance.randint(1, 5)))
    if which == 1:
        # A loop about π ends before 2π: what ends within one does not meet itself.
        arm, reach = chance.uniform(1.05, 3.0), chance.uniform(2 * pi, 60.0)
        return f"a looped trochoid {arm}, {reach}", refuses(trochoid(arm, reach))
    if which == 2:
        growth, turns = chance.uniform(0.01, 0.3), chance.uniform(1.1, 3.0)
        return f"a spiral {growth}, {turns}", spiral(growth, turns)
    if which == 3:
        count, noise = chance.randint(24, 60), 10 ** chance.uniform(-6, -3.5)
        turns, closed = chance.choice(((1.0, True), (2.0, True), (0.75, True), (0.75, False), (1.4, False)))
        made = measured(turns, count, noise, closed, chance.randrange(10**6))
        words = f"{count} points over {turns} turns, {noise} off, closed={closed}"
        return words, made if (turns, closed) in ((1.0, True), (0.75, False)) else refuses(made)
    if which == 4:
        place, height = chance.uniform(-0.9, 0.9), chance.uniform(0.01, 1.0)
        return f"a jump at {place}", refuses(lambda: Curve(lambda s: (s, height * sp.atan(1 / (s - place))), (-1, 1)))
    a, b, c = (chance.uniform(-1.0, 1.0) for _ in range(3))

    def loops(s):
        return (sp.cos(s) + a * sp.cos(2 * s) + b * sp.sin(3 * s), sp.sin(s) + c * sp.sin(2 * s))

    return f"a closed curve {a}, {b}, {c}", functools.partial(Curve, loops)


FOUND = (
    ("once and a half", refuses(arc(1.5))),
    ("three times", refuses(arc(3.0))),
    ("once, by another parameter", lambda: Curve(lambda s: (sp.cos(3 * s), sp.sin(3 * s)))),
    (
        "a rose of three leaves",
        refuses(lambda: Curve(lambda s: (sp.cos(3 * s) * sp.cos(s), sp.cos(3 * s) * sp.sin(s)))),
    ),
    ("loops without a domain", refuses(lambda: Curve(lambda s: (s + 2 * sp.sin(s), -2 * sp.cos(s))))),
    ("small loops, far", refuses(trochoid(1.05, 100.0))),
    ("twice round", refuses(measured(2.0, 40, 0.0, True, 0))),
    ("a quarter left out", refuses(measured(0.75, 40, 0.0, True, 0))),
    ("loops whose chords cross beside a corner", refuses(trochoid(1.2830888011504848, 10.399308860880407))),
    ("within its first loops", trochoid(1.667, 4.565)),
    ("two turns of a tight spiral", spiral(1e-3, 2.0)),
)
KIND = Kind("shapes", draw, 250, 25, FOUND)
