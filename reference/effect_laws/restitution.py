"""Impacts: the law of restitution."""

from __future__ import annotations

from cases import Case, Impact


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
