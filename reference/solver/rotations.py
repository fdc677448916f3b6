"""Rotations of plates against each other, and against what is fixed, that contacts resist."""

from __future__ import annotations

import numpy as np

# In place of the number of a plate: what is fixed.
FIXED = -1
# Of plates (the numbers of a contact's `sides`) whose closed contacts resist rolling: the sense in which the first one
# turns against the second one, or against what is fixed; 0 if it does not.
Sides = tuple[int, ...]
Turns = tuple[tuple[Sides, int], ...]


def turning_row(sides: Sides, size: int) -> np.ndarray:
    """The row (3n,), of that size, of the rotation of a plate against another one, or against what is fixed."""
    row = np.zeros(size)
    row[[3 * body + 2 for body in sides]] = (1.0, -1.0)[: len(sides)]
    return row


def rigid_pairs(turns: Turns) -> list[Sides]:
    """The plates that do not turn against each other. Left out are those that others hold: two plates that do not turn
    against a third one do not turn against each other."""
    together, result = dict[int, int](), list[Sides]()

    def root(body: int) -> int:
        while body in together:
            body = together[body]
        return body

    for sides in (sides for sides, sense in turns if sense == 0):
        first, second = root(sides[0]), root(sides[1] if len(sides) > 1 else FIXED)
        if first != second:
            together[max(first, second)] = min(first, second)
            result.append(sides)
    return result
