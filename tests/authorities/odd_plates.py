"""Valleys, ellipses, unbalanced and odd wheels, the rod. Sizes are the cases' defaults; g = 9.81 m/s²."""

from math import atan, cos, pi, sin, sqrt

import numpy as np

from .facts import at_start, derived, ends_with, facts, row, spread, zero_of

G = 9.81

# All derived. Routh (rocking stones), Lockwood (rolling spiral), Robison and Hall & Wagon (square wheels), Tokieda (the
# hoop), Reuleaux (constant width) and Painlevé are said to have them; we did not look them up.
SMALL_SWINGS = derived(
    "the centre's path has the radius ρ − r at the bottom: (3/2) s'' = −g s/(ρ − r), half a period is "
    "π sqrt(3 (ρ − r)/(2 g))"
)
ROCKING = derived(
    "rolled by the arc s the plate has turned by θ = s/q, 1/q = 1/ρ + 1/ρ', and its centre is at "
    "b − s²/(2 q) + θ s − b θ²/2 = b + (q − b) θ²/2; its kinetic energy is m (k² + b²) θ'²/2, without friction "
    "m k² θ'²/2 with x constant, k² = (a² + b²)/4"
)
ROLLING_ENERGY = "rolling, its kinetic energy is (J + m d²) ω²/2, and friction does no work"
SQUARE_WHEEL = derived(
    "the tangent of y = −a cosh(x/a) lies at the distance a cosh/sqrt(1 + sinh²) = a from the point (x, 0) above the "
    "contact, and touches at a sinh(x/a), the road's arc: the centre is at y = 0; " + ROLLING_ENERGY
)
SPIRAL = derived(
    "rolling, the pole moves at right angles to its radius to the contact, which meets the incline at a constant angle "
    "of cotangent `growth` = tan(slope): level; " + ROLLING_ENERGY
)
HOOP = derived(
    "d² = r² + e² + 2 r e cos φ, J = m (r² − e²), e = share·r: m r² (1 + share cos φ) ω² + m g e cos φ = m g e from "
    "rest at the top"
)
SUPPORT = derived(
    "h(φ) is defined as the distance of the tangent with outward normal φ, h(φ) = r + r·sharpness·cos(3 φ)/8; "
    + ROLLING_ENERGY
)
SLIDING_ROD = derived(
    "m y'' = N − m g with y = half·sin φ + tip, and m half² φ''/3 = −N half cos φ + μ N (half sin φ + tip), give "
    "N (1 + 3 cos²φ − 3 μ cos φ (sin φ + tip/half)) = m (g − half sin φ φ'²); with tip = 0 the bracket is zero where "
    "μ = (1 + tan²φ + 3)/(3 tan φ), least for tan φ = 2: μ = 4/3"
)
# Small swings: their period is the limit's to the square of the swing, here some 1e-3 rad, so 1e-5 relative is ample.
SMALL = 1e-5


def small(quantity, value, of, **parameters):
    """A row of a swing that is read off a zero of that rate."""
    return row(quantity, value, zero_of(of), SMALL, **parameters)


def rolling_half_period(rho):
    return pi * sqrt(1.5 * (rho - 0.1) / G)


def rocking_half_period(a, b, inverse_track, rolls):
    q = 1 / (b / a**2 + inverse_track)
    return pi * sqrt(((a * a + b * b) / 4 + (b * b if rolls else 0.0)) / (G * (q - b)))


def energy(case, state):
    m, J = case.plate.mass, case.plate.inertia
    return 0.5 * m * (state.vx**2 + state.vy**2) + 0.5 * J * state.omega**2 + m * G * state.y


def spin_energy(case, state):
    """½ (J + m d²) ω², d from the centre of mass to the contact point: what a rolling plate's kinetic energy is."""
    contact = case.track.point(state.xi1)
    d2 = (state.x - contact[0]) ** 2 + (state.y - contact[1]) ** 2
    return 0.5 * (case.plate.inertia + case.plate.mass * d2) * state.omega**2


def hoop_spin(case, motion):
    """ω of the hoop where slip begins, over the value that rolling from rest at the top gives."""
    state, share = motion(motion.transitions[0].time), case.parameters.get("share", 0.8)
    phi = state.xi2 + pi
    return state.omega / -sqrt(G / 0.5 * share * (1 - cos(phi)) / (1 + share * cos(phi)))


def triangle_height(case, state):
    """Height of the centre minus h(φ) in the direction of the contact."""
    phi = state.xi2
    return state.y - 0.1 * (1 + 0.8 * np.cos(3 * phi) / 8)


def omega(state):
    return state.omega


def back(state):
    return state.vx


def rod_force(mu, angle):
    return G / (1 + 3 * cos(angle) ** 2 - 3 * mu * cos(angle) * (sin(angle) + 0.002))


def centrifugal_minus_g(case, motion):
    state = motion(motion.transitions[0].time)
    angle = -pi / 2 - motion.transitions[0].xi2
    return 0.5 * sin(angle) * state.omega**2 - G


FACTS = facts(
    {
        ("disc_in_parabola", SMALL_SWINGS): [
            small("half period of a small rolling swing / s", rolling_half_period(0.8), back, xi1=-1e-3, mu=1.0),
        ],
        ("disc_in_cosine", SMALL_SWINGS): [
            small("half period of a small rolling swing / s", rolling_half_period(1 / 1.2), back, xi1=-1e-3, mu=1.0),
        ],
        ("disc_in_catenary", SMALL_SWINGS): [
            small("half period of a small rolling swing / s", rolling_half_period(0.5), back, xi1=-1e-3, mu=1.0),
        ],
        ("disc_in_ellipse", SMALL_SWINGS): [
            small(
                "half period of a small rolling swing / s",
                rolling_half_period(1 / 0.6),
                back,
                xi1=-pi / 2 - 1e-3,
                mu=1.0,
            ),
        ],
        ("disc_on_trochoid", SMALL_SWINGS): [
            small("half period of a small rolling swing / s", rolling_half_period(0.64 / 0.3), back, xi1=-1e-3, mu=1.0),
        ],
        ("ellipse_on_line", ROCKING): [
            small(
                "half period of small rolling rocking / s", rocking_half_period(0.3, 0.2, 0.0, True), omega, tilt=1e-3
            ),
        ],
        ("ellipse_on_ice", ROCKING): [
            small(
                "half period of small sliding rocking / s", rocking_half_period(0.3, 0.2, 0.0, False), omega, tilt=1e-3
            ),
            row("path of the centre sideways / m", 0.0, spread(lambda case, state: state.x)),
        ],
        ("ellipse_on_hill", ROCKING): [
            small("half period of a rocking stone / s", rocking_half_period(0.3, 0.2, 1.0, True), omega, tilt=1e-3),
        ],
        ("straight_edge_on_catenary", SQUARE_WHEEL): [
            row("rise of the centre / m", 0.0, spread(lambda case, state: state.y)),
            row("change of (J + m d²) ω²/2 / J", 0.0, spread(spin_energy)),
        ],
        ("spiral_on_incline", SPIRAL): [
            row("rise of the pole / m", 0.0, spread(lambda case, state: state.y)),
            row("change of (J + m d²) ω²/2 / J", 0.0, spread(spin_energy)),
        ],
        ("littlewood_hoop", HOOP): [
            row("ω of the rolling hoop over its formula", 1.0, hoop_spin),
        ],
        ("rounded_triangle_on_line", SUPPORT): [
            row("centre's height minus h(φ) / m", 0.0, spread(triangle_height)),
            row("change of energy in rolling / J", 0.0, spread(energy)),
        ],
        ("sliding_rod", SLIDING_ROD): [
            row("normal force at the start, μ = 0.5 / N", rod_force(0.5, 1.2), at_start("normal_force"), mu=0.5),
            row("normal force at the start, μ = 1.2 / N", rod_force(1.2, 1.2), at_start("normal_force"), mu=1.2),
            # The threshold is 4/3 for a tip without size; the tip here moves it by 2.1e-3.
            row("regular at tan φ = 2 for μ = 1.33", 0, ends_with("paradox"), mu=1.33, angle=atan(2.0), duration=1e-3),
            row("paradox at tan φ = 2 for μ = 1.34", 1, ends_with("paradox"), mu=1.34, angle=atan(2.0)),
        ],
        ("hopping_rod", SLIDING_ROD): [
            row(
                "normal force at the start / N",
                (G - 0.5 * sin(1.0) * 16) / (1 + 3 * cos(1.0) ** 2 - 3.6 * cos(1.0) * (sin(1.0) + 0.002)),
                at_start("normal_force"),
            ),
            row("half·sin φ·ω² − g where it departs / (m/s²)", 0.0, centrifugal_minus_g),
            row("the same for μ = 0.9", 0.0, centrifugal_minus_g, mu=0.9),
        ],
    }
)
