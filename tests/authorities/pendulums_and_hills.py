"""Pendulums, cycloids, the ring without gravity, hills and loops. R = 1 m, r = 0.1 m, m = 1 kg, g = 9.81 m/s²."""

from math import cos, log, pi, sin, sqrt

import numpy as np
from mpmath import ellipk

from .facts import at_start, derived, ends_with, facts, row, spread, time_of, zero_of

G, L = 9.81, 0.9

# All derived; k = J/(m r²). Landau & Lifshitz (pendulums), Huygens (cycloid), Cardano (the straight line), Kleppner &
# Kolenkow (ring), Goldstein and Halliday (hills and loops) are said to have them; we did not look them up.
PENDULUM = derived(
    "L φ'²/2 = g (cos φ − cos a); with sin(φ/2) = sin(a/2) sin u half a period is 2 sqrt(L/g) K(sin²(a/2)); "
    "N = m g cos φ + m L φ'² = m g (3 cos φ − 2 cos a)"
)
ROLLING_PENDULUM = derived(
    "L φ' = v and r ω = −v: (3/4) m (L φ')² − m g L cos φ is the energy of a pendulum of length 3 L/2, times a constant"
)
STRAIGHT_LINE = derived(
    "in a circle of 2 r the disc turns by −(α − α0) while its centre goes from α0 to α: the rim point at 2 α0 − α is "
    "at r (e^(iα) + e^(i(2 α0 − α))) = 2 r cos(α − α0) e^(iα0)"
)
CYCLOID = derived("with s = 4 a sin(t/2) the height is s²/(8 a): s'' = −g s/(4 a), half a period is 2π sqrt(a/g)")
ROLLING_CYCLOID = derived("energy (3/4) m s'² + m g s²/(8 a): s'' = −g s/(6 a), half a period is 2π sqrt(1.5 a/g)")
RING = derived(
    "dv/dt = −μ v²/L: v = v0/(1 + μ v0 t/L), angle = ln(1 + μ v0 t/L)/μ; it rolls once v = v0/(1 + k), where "
    "μ v0 t/L = k = 1/2; N = m v²/L"
)
DEPARTURE = derived(
    "energy (1 + k) v²/2 = g (R + r)(1 − cos φ) and N = 0, v² = g (R + r) cos φ, give cos φ = 2/(3 + k), k = 0 without "
    "friction; rolling takes m g sin φ·k/(1 + k) = m g sin φ/3, and N = m g (7 cos φ − 4)/3: slip where "
    "sin φ = μ (7 cos φ − 4)"
)
LOOP = derived(
    "v² = g L (ratio − 2 (1 − cos φ)/(1 + k)) and N = m g cos φ + m v²/L, φ from the bottom: N/(m g) = ratio − 2 + "
    "3 cos φ sliding, ratio − 4/3 + 7/3 cos φ rolling, where friction is m g sin φ/3"
)


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


FACTS = facts(
    {
        ("frictionless_pendulum", PENDULUM): [
            row("half period / s", swing(1.0, L), zero_of(back)),
            row("half period / s", swing(0.1, L), zero_of(back), amplitude=0.1),
            row("normal force at the bottom / N", G * (3 - 2 * cos(1.0)), bottom_force),
        ],
        ("rolling_pendulum", ROLLING_PENDULUM): [
            row("half period / s", swing(1.0, 1.5 * L), zero_of(back)),
            row("half period / s", swing(0.5, 1.5 * L), zero_of(back), amplitude=0.5),
        ],
        ("cardano_disc", STRAIGHT_LINE): [
            row("rim point off its diameter / m", 0.0, spread(away_from_diameter)),
        ],
        ("cycloidal_pendulum", CYCLOID): [
            row("half period from 2 rad / s", 2 * pi * sqrt(0.25 / G), zero_of(back), s0=-2.0),
            row("half period from ½ rad / s", 2 * pi * sqrt(0.25 / G), zero_of(back), s0=-0.5),
        ],
        ("rolling_on_cycloid", ROLLING_CYCLOID): [
            row("half period / s", 2 * pi * sqrt(0.375 / G), zero_of(back)),
        ],
        ("disc_in_weightless_ring", RING): [
            row("start of rolling / s", 0.5 * L / (0.3 * 2.0), time_of(0)),
            row("angle slid / rad", log(1.5) / 0.3, lambda case, m: m.transitions[0].xi1),
            row(
                "normal force half-way / N",
                (2 / (1 + 0.3 * 2 * 0.375 / L)) ** 2 / L,
                lambda case, m: m(0.375).normal_force,
            ),
        ],
        ("disc_sliding_off_hill", DEPARTURE): [
            row("cos φ of departure", 2 / 3, departure_cosine),
        ],
        ("disc_rolling_off_hill", DEPARTURE): [
            # The disc rolls all the way in the limit μ → ∞; for μ = 10⁴, the largest that a case may
            # have, the cosine differs by about 1/μ times the sine.
            row("cos φ of departure, μ → ∞", 4 / 7, departure_cosine, tolerance=1e-4, mu=1e4),
            row("the same, as a sphere", 10 / 17, departure_cosine, tolerance=1e-4, mu=1e4, shape=0.4),
            row("½ sin φ − μ(7/2 cos φ − 2) where slip begins", 0.0, slip_angle_condition, mu=0.3),
        ],
        ("sliding_loop", LOOP): [
            row(
                "below 5 it leaves: cos φ",
                (2 - 4.9) / 3,
                lambda case, m: cos(m.transitions[-1].xi1 + pi / 2),
                ratio=4.9,
            ),
            row("just above 5 it goes round", 1, ends_with("completed"), ratio=5.0001),
            row("just below 5 it leaves", 1, ends_with("lift_off"), ratio=4.9999),
            row("bottom minus top normal force / N", 6 * G, top_minus_bottom, ratio=5.1),
        ],
        ("rolling_loop", LOOP): [
            row("normal force at the top / N", G * (5 - 4 / 3 - 7 / 3), force_at_top, ratio=5.0),
            row("sin φ/3 − N μ/(m g) where slip begins", 0.0, loop_slip_condition, ratio=3.5),
            row("normal force at the bottom / N", G * 4.5, at_start("normal_force"), ratio=3.5),
        ],
    }
)
