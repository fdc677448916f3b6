"""Pendulums, cycloids, the ring without gravity, hills and loops. R = 1 m, r = 0.1 m, m = 1 kg, g = 9.81 m/s²."""

from math import cos, log, pi, sin, sqrt

import numpy as np
from mpmath import ellipk

from .facts import at_start, ends_with, fact, spread, time_of, zero_of

G, L = 9.81, 0.9
LANDAU_11 = "Landau & Lifshitz, Mechanics, §11 problem 1"
LANDAU_32 = "Landau & Lifshitz, Mechanics, §32 problem 6"
HUYGENS = "Huygens, Horologium oscillatorium (1673)"
ROUTH = "Routh, Dynamics of a Particle (cycloidal motion), with the rolling disc's 3m/2 along its path"
CARDANO = "Cardano, Opus novum de proportionibus (1570)"
RING = "Kleppner & Kolenkow, An Introduction to Mechanics, ch. 2 (block on a ring)"
GOLDSTEIN = "Goldstein, Poole & Safko, Classical Mechanics, ch. 2 (particle on a hemisphere, hoop on a cylinder)"
LOOP = "Halliday, Resnick & Walker, Fundamentals of Physics (loop-the-loop, sliding and rolling)"


def swing(amplitude, length):
    """Half a period."""
    return 2 * sqrt(length / G) * float(ellipk(sin(amplitude / 2) ** 2))


def away_from_diameter(case, state):
    """Distance of the rim point that touched first from the diameter through its first place."""
    place = case.start.xi1
    r, turned = case.plate.radius, place + state.theta  # θ = 0 at the start, the point lies at the polar angle ξ₁
    x, y = state.x + r * np.cos(turned), state.y + r * np.sin(turned)
    return -np.sin(place) * x + np.cos(place) * y


def departure_cosine(case, motion):
    return cos(motion.transitions[-1].xi1)


def slip_angle_condition(case, motion):
    angle, mu = motion.transitions[0].xi1, case.effects[1].mu
    return 0.5 * sin(angle) - mu * (3.5 * cos(angle) - 2)


def loop_slip_condition(case, motion):
    angle = motion.transitions[0].xi1 + pi / 2
    return sin(angle) / 3 - 0.5 * (3.5 - 4 / 3 + 7 / 3 * cos(angle))


def top_minus_bottom(case, motion):
    at_top = zero_of(lambda state: state.xi1 - pi / 2)(case, motion)
    return motion(0.0).normal_force - motion(at_top).normal_force


def force_at_top(case, motion):
    return motion(zero_of(lambda state: state.xi1 - pi / 2)(case, motion)).normal_force


def bottom_force(case, motion):
    return motion(zero_of(lambda state: state.xi1 + pi / 2)(case, motion)).normal_force


def back(state):
    return state.vx


FACTS = [
    fact("frictionless_pendulum", "half period / s", swing(1.0, L), LANDAU_11, zero_of(back)),
    fact("frictionless_pendulum", "half period / s", swing(0.1, L), LANDAU_11, zero_of(back), amplitude=0.1),
    fact("frictionless_pendulum", "normal force at the bottom / N", G * (3 - 2 * cos(1.0)), LANDAU_11, bottom_force),
    fact("rolling_pendulum", "half period / s", swing(1.0, 1.5 * L), LANDAU_32, zero_of(back)),
    fact("rolling_pendulum", "half period / s", swing(0.5, 1.5 * L), LANDAU_32, zero_of(back), amplitude=0.5),
    fact("cardano_disc", "rim point off its diameter / m", 0.0, CARDANO, spread(away_from_diameter)),
    fact("cycloidal_pendulum", "half period from 2 rad / s", 2 * pi * sqrt(0.25 / G), HUYGENS, zero_of(back), s0=-2.0),
    fact("cycloidal_pendulum", "half period from ½ rad / s", 2 * pi * sqrt(0.25 / G), HUYGENS, zero_of(back), s0=-0.5),
    fact("rolling_on_cycloid", "half period / s", 2 * pi * sqrt(0.375 / G), ROUTH, zero_of(back)),
    fact("disc_in_weightless_ring", "start of rolling / s", 0.5 * L / (0.3 * 2.0), RING, time_of(0)),
    fact("disc_in_weightless_ring", "angle slid / rad", log(1.5) / 0.3, RING, lambda case, m: m.transitions[0].xi1),
    fact(
        "disc_in_weightless_ring",
        "normal force half-way / N",
        (2 / (1 + 0.3 * 2 * 0.375 / L)) ** 2 / L,
        RING,
        lambda case, m: m(0.375).normal_force,
    ),
    fact("disc_sliding_off_hill", "cos φ of departure", 2 / 3, GOLDSTEIN, departure_cosine),
    # The disc rolls all the way in the limit μ → ∞; for μ = 10⁶ the cosine differs by about 1/μ times the sine.
    fact(
        "disc_rolling_off_hill", "cos φ of departure, μ → ∞", 4 / 7, GOLDSTEIN, departure_cosine, tolerance=1e-6, mu=1e6
    ),
    fact(
        "disc_rolling_off_hill",
        "the same, as a sphere",
        10 / 17,
        GOLDSTEIN,
        departure_cosine,
        tolerance=1e-6,
        mu=1e6,
        shape=0.4,
    ),
    fact(
        "disc_rolling_off_hill",
        "½ sin φ − μ(7/2 cos φ − 2) where slip begins",
        0.0,
        GOLDSTEIN,
        slip_angle_condition,
        mu=0.3,
    ),
    fact(
        "sliding_loop",
        "below 5 it leaves: cos φ",
        (2 - 4.9) / 3,
        LOOP,
        lambda case, m: cos(m.transitions[-1].xi1 + pi / 2),
        ratio=4.9,
    ),
    fact("sliding_loop", "just above 5 it goes round", 1, LOOP, ends_with("completed"), ratio=5.0001),
    fact("sliding_loop", "just below 5 it leaves", 1, LOOP, ends_with("lift_off"), ratio=4.9999),
    fact("sliding_loop", "bottom minus top normal force / N", 6 * G, LOOP, top_minus_bottom, ratio=5.1),
    fact("rolling_loop", "normal force at the top / N", G * (5 - 4 / 3 - 7 / 3), LOOP, force_at_top, ratio=5.0),
    fact("rolling_loop", "sin φ/3 − N μ/(m g) where slip begins", 0.0, LOOP, loop_slip_condition, ratio=3.5),
    fact("rolling_loop", "normal force at the bottom / N", G * 4.5, LOOP, at_start("normal_force"), ratio=3.5),
]
