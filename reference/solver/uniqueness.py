"""How many motions rigid Coulomb contact allows in a state: none, one or several, by the enumeration of modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Case, Mode

from .accelerations import DecisionInstant
from .decide import motions_of
from .places import place
from .plate_numbers import speed
from .touching import name_of, touching_contacts

# Relative error of a state that is given by formulas: a few roundings of its numbers.
ERROR = 1e-14


def motions_in(case: Case, state: Sequence[float]) -> list[dict[str, Mode]]:
    """The motions that may follow a state of all plates, each as the modes of the contacts that touch.

    `state`: x, y (m), θ of every plate, then vx, vy (m/s), ω. Modes that give the same accelerations are one motion,
    listed with the most contacts. No contact may close: an impact is no motion. Raises Undecidable, and DoesNotFit for
    points not found.
    """
    touching, names = list(touching_contacts(case, np.asarray(state, dtype=float))), list[str]()
    for pair, _ in touching:
        names.append(name_of(pair, set(names)))
    now = DecisionInstant(case, 0.0, tuple(map(float, state)), speed(case, state), ERROR)
    motions = motions_of(now, [place(pair, state, points) for pair, points in touching])
    return [dict(zip(names, modes, strict=True)) for modes in motions]
