"""Wheels on straight lines: bowling, billiards, inclined planes. r = 0.1 m, m = 1 kg, g = 9.81 m/s²."""

from math import atan, cos, sin

from cases import Mode

from .facts import at_end, fact, first_mode_is, time_of

G = 9.81
CORIOLIS = "Coriolis, Théorie mathématique des effets du jeu de billard (1835)"
SOMMERFELD = "Sommerfeld, Mechanics, problem IV.8 (high and low shots in billiards)"
GOLDSTEIN = "Goldstein, Poole & Safko, Classical Mechanics, 3rd ed. (rolling with and without slip)"
HALLIDAY = "Halliday, Resnick & Walker, Fundamentals of Physics, ch. 11 (rolling down a ramp)"


def kinetic(case, motion):
    state = motion(motion.t[-1])
    return 0.5 * case.plate.mass * state.vx**2 + 0.5 * case.plate.inertia * state.omega**2


def slid(case, motion):
    return float(motion(motion.transitions[0].time).x)


FACTS = [
    fact("disc_on_line", "start of rolling / s", 1 / (3 * 0.1 * G), GOLDSTEIN, time_of(0), mu=0.1),
    fact("disc_on_line", "speed in rolling / (m/s)", 2 / 3, GOLDSTEIN, at_end("vx"), mu=0.1),
    fact("disc_on_line", "distance slid / m", 5 / (18 * 0.1 * G), GOLDSTEIN, slid, mu=0.1),
    fact("disc_on_line", "energy left of v0 = 1 m/s / J", 1 / 3, GOLDSTEIN, kinetic, mu=0.3),
    fact("thrown_with_spin", "speed of a sphere in rolling / (m/s)", 5 / 7, CORIOLIS, at_end("vx"), shape=0.4),
    fact("thrown_with_spin", "start of rolling of a sphere / s", 2 / (7 * 0.2 * G), SOMMERFELD, time_of(0), shape=0.4),
    fact("thrown_with_spin", "distance slid by a sphere / m", 12 / (49 * 0.2 * G), SOMMERFELD, slid, shape=0.4),
    fact("thrown_with_spin", "hoop, back-spin v0: speed / (m/s)", 0, SOMMERFELD, at_end("vx"), backspin=1.0, shape=1.0),
    fact("thrown_with_spin", "disc, back-spin v0: speed / (m/s)", 1 / 3, SOMMERFELD, at_end("vx"), backspin=1.0),
    fact(
        "thrown_with_spin", "disc, back-spin 4 v0: comes back / (m/s)", -2 / 3, SOMMERFELD, at_end("vx"), backspin=4.0
    ),
    fact("thrown_with_spin", "disc, top-spin 2.5 v0: speed / (m/s)", 1.5, SOMMERFELD, at_end("vx"), backspin=-2.5),
    fact(
        "disc_on_incline",
        "spin of a rolling disc after 1 s / (rad/s)",
        -20 / 3 * G * sin(0.2),
        HALLIDAY,
        at_end("omega"),
    ),
    fact(
        "disc_on_incline",
        "slip of a slipping disc after 1 s / (m/s)",
        G * (sin(0.4) - 3 * 0.1 * cos(0.4)),
        GOLDSTEIN,
        at_end("slip"),
        slope=0.4,
    ),
    fact(
        "disc_on_incline",
        "rolls just below tan α = 3 μ",
        1,
        GOLDSTEIN,
        first_mode_is(Mode.ROLL),
        slope=atan(0.3) - 1e-9,
    ),
    fact(
        "disc_on_incline",
        "slips just above tan α = 3 μ",
        1,
        GOLDSTEIN,
        first_mode_is(Mode.SLIP_FORWARD),
        slope=atan(0.3) + 1e-9,
    ),
    fact(
        "disc_on_incline",
        "spin of a rolling hoop after 1 s / (rad/s)",
        -5 * G * sin(0.15),
        HALLIDAY,
        at_end("omega"),
        slope=0.15,
        shape=1.0,
    ),
]
