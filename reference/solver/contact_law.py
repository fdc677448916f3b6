"""Friction and restitution of one contact, by the effects of its support."""

from __future__ import annotations

import numpy as np

from cases import Case, CoulombFriction, Impact, Mode, PerfectlyRough, RollingResistance

# The modes of a contact without slip.
STICKING = (Mode.ROLL, Mode.REST)
# The row of one plate's rotation in (vx, vy, ω).
TURNING_ROW = np.array([0.0, 0.0, 1.0])


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
