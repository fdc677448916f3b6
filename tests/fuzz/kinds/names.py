"""Texts and parameters for a case of the catalogue."""

import functools
from math import inf, nan

import cases

from ..harness import Kind
from .values import ODD

NAMES = (
    "disc_on_line",
    "disc_in_circle",
    "sliding_rod",
    "no_such_case",
    "",
    "disc on line",
    "..",
    "a" * 3000,
    "\0",
    "é",
)
KEYS = ("mu", "v0", "r", "m", "g", "nothing", "", "self", "mu ", "radius", "slope")
NUMBERS = (0.1, -1.0, 0.0, 1e-12, 1e9, 1e150, 1e308, 5e-324, nan, inf, True)
LETTERS = "mu=0.1,[]v0 \n;-+e9naif'\"\\<>$\0é"


def draw(chance):
    which = chance.randrange(3)
    if which == 0:
        inside = "".join(chance.choice(LETTERS) for _ in range(chance.randint(0, 14)))
        text = f"{chance.choice(NAMES)}[{inside}]"
        return f"select {text!r}", functools.partial(cases.select, text)
    if which == 1:
        text = "".join(chance.choice(LETTERS) for _ in range(chance.randint(0, 30)))
        return f"load {text!r}", functools.partial(cases.load, text)
    name = chance.choice(NAMES[:3] if chance.random() < 0.8 else NAMES)
    given = {
        chance.choice(KEYS): chance.choice(NUMBERS if chance.random() < 0.6 else ODD)
        for _ in range(chance.randint(1, 2))
    }
    return f"{name} with {given!r}", lambda: cases.load(name, **given).label


KIND = Kind("names", draw, 400, 40, (("load(3)", functools.partial(cases.load, 3)),))
