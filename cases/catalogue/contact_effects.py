"""The effects that the families with impacts share; it has no case of its own."""

from cases import CoulombFriction, Effect, Flight, Gravity, Impact, Unilateral
from cases.errors import not_negative


def contact_with_impacts(mu: float, g: float, restitution: float = 0.0) -> tuple[Effect, ...]:
    """Gravity and contact with Moreau's law of impact; with mu = 0 without friction. Raises BadValue for mu < 0."""
    friction = (CoulombFriction(mu),) if not_negative("mu", mu) else ()
    return (Gravity(g), Unilateral(), Flight(), Impact(restitution, "moreau"), *friction)
