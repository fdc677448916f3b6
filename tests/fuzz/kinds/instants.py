"""Times at which a motion is asked for, in every form."""

from functools import lru_cache

import numpy as np

import cases
import reference

from ..harness import Kind
from .values import ODD


@lru_cache(maxsize=1)
def motions():
    """One that knows itself between its steps, one of samples alone."""
    motion = reference.simulate(cases.load("disc_on_line"))
    return motion, cases.Trajectory(**{name: getattr(motion, name) for name in ("t", *cases.State._fields)})


def asked(which: int, when):
    def call():
        state = motions()[which](when)
        assert np.all(np.isfinite(state.x))
        return state

    return call


def draw(chance):
    when = chance.choice(ODD)
    if chance.random() < 0.6:
        when = [chance.choice((0.0, 0.1, 1.0, -1e-9, 1e9, float("nan"), 0.5)) for _ in range(chance.randint(1, 3))]
        when = chance.choice((lambda v: v, np.array, tuple, lambda v: v[0], lambda v: [v], np.float64))(when)
    which = chance.randrange(2)
    return f"motion({when!r})", asked(which, when)


KIND = Kind(
    "instants",
    draw,
    250,
    40,
    tuple((f"motion({w!r})", asked(0, w)) for w in (-1, 5e9, "a", "0.1", True, None, 1j, {}, [[0.1]])),
)
