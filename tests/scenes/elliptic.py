"""Random admissible scenes for property tests: ellipses on ellipses, well inside the range where plates fit."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st

from cases import Case, CoulombFriction, Curve, Gravity, Plate, Start, Unilateral
from cases.curves import cos, sin


def ellipse(a: float, b: float) -> Curve:
    """x = a cos s, y = b sin s."""
    return Curve(lambda s: (a * cos(s), b * sin(s)))


def ellipse_in_ellipse(A, B, a, b, xi1, xi2, mu, slip, omega, direction=-1.5707963267948966, shift=0.0, m=1.0) -> Case:
    """An elliptic plate, its centre of mass `shift` along its long axis, inside an elliptic track."""
    outline = Curve(lambda s: (a * cos(s) + shift, b * sin(s)))
    plate = Plate(outline, m, m * (a * a + b * b) / 4 + m * shift**2)
    friction = (CoulombFriction(mu),) if mu else ()
    effects = (Gravity(9.81, direction), *friction, Unilateral())
    return Case(ellipse(A, B), plate, effects, Start(xi1, xi2, slip, omega), duration=1.0)


def examples(everyday: int, thorough: int) -> settings:
    """How many random scenes a test draws every day, and with the slow tests: each may cost a derivation."""
    return settings(max_examples=everyday if settings.get_current_profile_name() == "same" else thorough, deadline=None)


def numbers(low: float, high: float):
    """Floats of ordinary size: hypothesis' favourites near zero are kept, denormals are not."""
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


# The smallest radius of curvature of the track, B²/A ≥ 0.53, exceeds the plate's largest, a²/b or b²/a ≤ 0.5: all fit.
elliptic_scenes = st.builds(
    ellipse_in_ellipse,
    A=numbers(1.0, 1.2),
    B=numbers(0.8, 1.0),
    a=numbers(0.18, 0.3),
    b=numbers(0.18, 0.3),
    xi1=numbers(-3.0, 3.0),
    xi2=numbers(-3.0, 3.0),
    mu=st.just(0.0) | numbers(1e-3, 1.0),
    # A slip below the rounding of the contact point's speeds is none; 1e-6 m/s is far above it.
    slip=st.just(0.0) | numbers(1e-6, 2.0) | numbers(-2.0, -1e-6),
    omega=numbers(-5.0, 5.0),
    direction=numbers(-3.0, 3.0),
    shift=numbers(-0.05, 0.05),
)
