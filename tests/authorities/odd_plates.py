"""Valleys, ellipses, unbalanced and odd wheels, the rod. Sizes are the cases' defaults; g = 9.81 m/s²."""

from math import atan, cos, pi, sin, sqrt

import numpy as np

from cases.contact import start_motion

from .facts import at_start, ends_with, fact, spread, zero_of

G = 9.81
ROUTH = "Routh, Elementary Rigid Dynamics (small oscillations, rocking stones)"
WHEELS = "Hall & Wagon, Roads and wheels, Math. Mag. 65 (1992); Robison, Math. Mag. 33 (1960)"
LOCKWOOD = "Lockwood, A Book of Curves (1961), ch. 11"
TOKIEDA = "Tokieda, The hopping hoop, Am. Math. Monthly 104 (1997)"
PAINLEVE = "Génot & Brogliato, Eur. J. Mech. A/Solids 18 (1999); Painlevé, C. R. Acad. Sci. 121 (1895)"
REULEAUX = "Reuleaux, Kinematics of Machinery (1876): rolling keeps energy, and h is the plate's support function"
# Small swings: their period is the limit's to the square of the swing, here some 1e-3 rad, so 1e-5 relative is ample.
SMALL = 1e-5


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


def start_height(case, motion):
    return start_motion(case).y


FACTS = [
    fact(
        "disc_in_parabola",
        "half period of a small rolling swing / s",
        rolling_half_period(0.8),
        ROUTH,
        zero_of(back),
        SMALL,
        xi1=-1e-3,
        mu=1.0,
    ),
    fact(
        "disc_in_cosine",
        "half period of a small rolling swing / s",
        rolling_half_period(1 / 1.2),
        ROUTH,
        zero_of(back),
        SMALL,
        xi1=-1e-3,
        mu=1.0,
    ),
    fact(
        "disc_in_catenary",
        "half period of a small rolling swing / s",
        rolling_half_period(0.5),
        ROUTH,
        zero_of(back),
        SMALL,
        xi1=-1e-3,
        mu=1.0,
    ),
    fact(
        "disc_in_ellipse",
        "half period of a small rolling swing / s",
        rolling_half_period(1 / 0.6),
        ROUTH,
        zero_of(back),
        SMALL,
        xi1=-pi / 2 - 1e-3,
        mu=1.0,
    ),
    fact(
        "disc_on_trochoid",
        "half period of a small rolling swing / s",
        rolling_half_period(0.64 / 0.3),
        ROUTH,
        zero_of(back),
        SMALL,
        xi1=-1e-3,
        mu=1.0,
    ),
    fact(
        "ellipse_on_line",
        "half period of small rolling rocking / s",
        rocking_half_period(0.3, 0.2, 0.0, True),
        ROUTH,
        zero_of(omega),
        SMALL,
        tilt=1e-3,
    ),
    fact(
        "ellipse_on_ice",
        "half period of small sliding rocking / s",
        rocking_half_period(0.3, 0.2, 0.0, False),
        ROUTH,
        zero_of(omega),
        SMALL,
        tilt=1e-3,
    ),
    fact(
        "ellipse_on_hill",
        "half period of a rocking stone / s",
        rocking_half_period(0.3, 0.2, 1.0, True),
        ROUTH,
        zero_of(omega),
        SMALL,
        tilt=1e-3,
    ),
    fact("ellipse_on_ice", "path of the centre sideways / m", 0.0, ROUTH, spread(lambda case, state: state.x)),
    fact("straight_edge_on_catenary", "rise of the centre / m", 0.0, WHEELS, spread(lambda case, state: state.y)),
    fact("straight_edge_on_catenary", "change of (J + m d²) ω²/2 / J", 0.0, WHEELS, spread(spin_energy)),
    fact("spiral_on_incline", "rise of the pole / m", 0.0, LOCKWOOD, spread(lambda case, state: state.y)),
    fact("spiral_on_incline", "change of (J + m d²) ω²/2 / J", 0.0, LOCKWOOD, spread(spin_energy)),
    fact("littlewood_hoop", "ω of the rolling hoop over Tokieda's", 1.0, TOKIEDA, hoop_spin),
    fact("rounded_triangle_on_line", "centre's height minus h(φ) / m", 0.0, REULEAUX, spread(triangle_height)),
    fact("rounded_triangle_on_line", "change of energy in rolling / J", 0.0, REULEAUX, spread(energy)),
    fact(
        "sliding_rod",
        "normal force at the start, μ = 0.5 / N",
        rod_force(0.5, 1.2),
        PAINLEVE,
        at_start("normal_force"),
        mu=0.5,
    ),
    fact(
        "sliding_rod",
        "normal force at the start, μ = 1.2 / N",
        rod_force(1.2, 1.2),
        PAINLEVE,
        at_start("normal_force"),
        mu=1.2,
    ),
    # The threshold is 4/3 for a tip without size; the tip here moves it by 2.1e-3.
    fact(
        "sliding_rod",
        "regular at tan φ = 2 for μ = 1.33",
        0,
        PAINLEVE,
        ends_with("paradox"),
        mu=1.33,
        angle=atan(2.0),
        duration=1e-3,
    ),
    fact(
        "sliding_rod", "paradox at tan φ = 2 for μ = 1.34", 1, PAINLEVE, ends_with("paradox"), mu=1.34, angle=atan(2.0)
    ),
]
