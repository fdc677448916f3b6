"""The scenes, plates and effects that families share; it has no case of its own."""

from typing import Any

from cases import Case, CoulombFriction, Curve, Effect, Flight, Gravity, Impact, Plate, Start, StartPose, Unilateral
from cases.errors import not_negative
from cases.library import ellipse


def case_on_track(
    track: Curve, plate: Plate, mu: Any, g: float, duration: float, *more: Effect, xi1: float = 0.0, **start: Any
) -> Case:
    """A plate on a track that only pushes, with gravity along −Y, friction and `more` effects.

    `mu`: the coefficient, the friction itself, or None; `start`: what else `Start` takes, such as slip or omega.
    """
    friction = () if mu is None else (mu if isinstance(mu, CoulombFriction) else CoulombFriction(mu),)
    return Case(track, plate, (Gravity(g), *friction, Unilateral(), *more), Start(xi1, **start), duration)


def case_with_impacts(
    track: Curve, plate: Plate, mu: float, g: float, start: StartPose, duration: float, *more: Effect,
    restitution: float = 0.0, **parts: Any,
) -> Case:  # fmt: skip
    """A plate that may touch anything, with the effects of `contact_with_impacts` and `more`; `parts`: what else `Case`
    takes, such as supports or others."""
    return Case(track, plate, (*contact_with_impacts(mu, g, restitution), *more), start, duration, **parts)


def contact_with_impacts(mu: float, g: float, restitution: float = 0.0) -> tuple[Effect, ...]:
    """Gravity and contact with Moreau's law of impact; with mu = 0 without friction. Raises BadValue for mu < 0."""
    friction = (CoulombFriction(mu),) if not_negative("mu", mu) else ()
    return (Gravity(g), Unilateral(), Flight(), Impact(restitution, "moreau"), *friction)


def ellipse_plate(a: float, b: float, m: float) -> Plate:
    """A homogeneous ellipse with half-axes a (along X) and b."""
    return Plate(ellipse(a, b), m, m * (a * a + b * b) / 4)
