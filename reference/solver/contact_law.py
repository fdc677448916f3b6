"""Friction and restitution of one contact, by the effects of its support."""

from __future__ import annotations

import numpy as np

from cases import Case, CoulombFriction, Impact, Mode, PerfectlyRough, RollingResistance

# The modes of a contact without slip.
STICKING = (Mode.ROLL, Mode.REST)
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


def coefficients(contact: Case) -> tuple[float, float]:
    """The coefficients of friction of a slip that begins and without slip; infinite for a perfectly rough contact."""
    if contact.effect(PerfectlyRough) is not None:
        return float("inf"), float("inf")
    friction = contact.effect(CoulombFriction)
    return (friction.at_rest, friction.stick) if friction else (0.0, 0.0)


def kinetic(contact: Case, slip):
    """The coefficient of friction at a slip velocity (m/s), or at an array of them."""
    friction = contact.effect(CoulombFriction)
    return friction.at(abs(slip)) if friction and friction.by_speed else coefficients(contact)[0]


def resisting_arm(contact: Case) -> float:
    """The largest couple of a contact's rolling resistance per normal force, m; 0 without."""
    resistance = contact.effect(RollingResistance)
    return resistance.arm if resistance else 0.0


def restitution(contact: Case) -> float:
    """The coefficient of restitution; 0 without Impact."""
    law = contact.effect(Impact)
    return law.restitution if law else 0.0


def slip_modes(contact: Case) -> tuple[Mode, ...]:
    """The modes of a closed contact that may slip."""
    if contact.effect(PerfectlyRough) is not None:
        return ()
    return (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD) if contact.effect(CoulombFriction) else (Mode.SLIDE,)
