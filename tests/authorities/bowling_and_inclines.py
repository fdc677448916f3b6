"""Wheels on straight lines: bowling, billiards, inclined planes. r = 0.1 m, m = 1 kg, g = 9.81 m/s²."""

from math import atan, cos, sin, sqrt

from cases import Mode

from .facts import at_end, derived, facts, first_mode_is, row, time_of

G = 9.81
# Of a wheel with J = k m r² (disc k = 1/2, sphere 2/5, hoop 1). Coriolis (billiards, 1835), Sommerfeld, Goldstein and
# Halliday are said to have these results; they are derived here, since we did not look them up.
BOWLING = derived(
    "m dv/dt = −μ m g and J dω/dt = −μ m g r for v(0) = v0, ω(0) = +b v0/r (b: back-spin): the slip v + r ω = "
    "v0 (1 + b) − μ g t (1 + 1/k) ends at t = v0 (1 + b)/(μ g (1 + 1/k)) and leaves v = v0 (1 − k b)/(1 + k), since "
    "v − k r ω is conserved; the way is v0 t − μ g t²/2, the energy left (1 + k) m v²/2"
)
# The sphere's 2/7 and 5/7 also stand in MFiX's DEM04 (tests/dem/DEM04 of github.com/truongd8593/mfix, looked up).
ROLLING_DOWN = derived(
    "rolling, (m + J/r²) a = m g sin α, so that r dω/dt = −g sin α/(1 + k): −2/3 g sin α for a disc, −1/2 for a hoop"
)
CONE_DOWN = derived(
    "rolling takes the friction m g sin α·k/(1 + k) ≤ μ m g cos α, hence tan α ≤ 3 μ for a disc; beyond it "
    "dv/dt = g (sin α − μ cos α) and r dω/dt = −μ g cos α/k, so that the slip grows by g (sin α − 3 μ cos α)"
)
LANDING = derived(
    "the normal fall is g cos α t²/2 = height; in the impact friction takes at most μ times its impulse m g T cos α, "
    "as of the force later, so that v = g t (sin α − μ cos α), or 2/3 g t sin α where that suffices to roll"
)


def kinetic(case, motion):
    state = motion(motion.t[-1])
    return 0.5 * case.plate.mass * state.vx**2 + 0.5 * case.plate.inertia * state.omega**2


def slid(case, motion):
    return float(motion(motion.transitions[0].time).x)


def down_the_slope(case, motion):
    return float(motion(1.0).vx) / cos(0.5)


FACTS = facts(
    {
        ("disc_on_line", BOWLING): [
            row("start of rolling / s", 1 / (3 * 0.1 * G), time_of(0), mu=0.1),
            row("speed in rolling / (m/s)", 2 / 3, at_end("vx"), mu=0.1),
            row("distance slid / m", 5 / (18 * 0.1 * G), slid, mu=0.1),
            row("energy left of v0 = 1 m/s / J", 1 / 3, kinetic, mu=0.3),
        ],
        ("thrown_with_spin", BOWLING): [
            row("speed of a sphere in rolling / (m/s)", 5 / 7, at_end("vx"), shape=0.4),
            row("start of rolling of a sphere / s", 2 / (7 * 0.2 * G), time_of(0), shape=0.4),
            row("distance slid by a sphere / m", 12 / (49 * 0.2 * G), slid, shape=0.4),
            row("hoop, back-spin v0: speed / (m/s)", 0, at_end("vx"), backspin=1.0, shape=1.0),
            row("disc, back-spin v0: speed / (m/s)", 1 / 3, at_end("vx"), backspin=1.0),
            row("disc, back-spin 4 v0: comes back / (m/s)", -2 / 3, at_end("vx"), backspin=4.0),
            row("disc, top-spin 2.5 v0: speed / (m/s)", 1.5, at_end("vx"), backspin=-2.5),
        ],
        ("disc_on_incline", ROLLING_DOWN): [
            row("spin of a rolling disc after 1 s / (rad/s)", -20 / 3 * G * sin(0.2), at_end("omega")),
            row(
                "spin of a rolling hoop after 1 s / (rad/s)", -5 * G * sin(0.15), at_end("omega"), slope=0.15, shape=1.0
            ),
        ],
        ("disc_on_incline", CONE_DOWN): [
            row(
                "slip of a slipping disc after 1 s / (m/s)",
                G * (sin(0.4) - 3 * 0.1 * cos(0.4)),
                at_end("slip"),
                slope=0.4,
            ),
            row("rolls just below tan α = 3 μ", 1, first_mode_is(Mode.ROLL), slope=atan(0.3) - 1e-9),
            row("slips just above tan α = 3 μ", 1, first_mode_is(Mode.SLIP_FORWARD), slope=atan(0.3) + 1e-9),
        ],
        ("disc_onto_incline", LANDING): [
            row("landing / s", sqrt(0.2 / (G * cos(0.5))), time_of(0)),
            row("speed of rolling at 1 s / (m/s)", 2 / 3 * G * sin(0.5), down_the_slope),
            row("speed of slipping at 1 s / (m/s)", G * (sin(0.5) - 0.1 * cos(0.5)), down_the_slope, mu=0.1),
        ],
    }
)
