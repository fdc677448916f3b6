"""Impacts: the law of restitution, and the numbers that all effects of a contact give an impact."""

from __future__ import annotations

from typing import NamedTuple

from cases import Case, Impact

from .scene_laws import laws


class ImpactNumbers(NamedTuple):
    """Coefficients of friction against slip and without it, the arm of rolling resistance (m), restitution, and the
    name of its law (`cases.Impact`)."""

    mu: float
    stick: float
    arm: float
    restitution: float
    name: str


def impact_numbers(contact: Case, slip: float) -> ImpactNumbers:
    """The numbers of an impact that begins at a slip velocity (m/s); without restitution where there is no law."""
    law, (mu, stick) = laws(contact), laws(contact).friction.in_impact(contact, slip)
    return ImpactNumbers(mu, stick, law.resistance.arm(contact), restitution(contact), impact_law(contact))


def restitution(contact: Case) -> float:
    """The coefficient of restitution; 0 without a law of impact."""
    impact = contact.effect(Impact)
    return impact.restitution if impact else 0.0


def creates_energy(law: str, before: float, after: float) -> bool:
    """Whether an impact by that law creates energy (J), as Newton's may: more than by rounding."""
    return law == "newton" and after > (1.0 + 1e-12) * before


def impact_law(case: Case) -> str:
    """The name of the case's law of impact; empty if it has none."""
    impact = case.effect(Impact)
    return impact.law if impact else ""
