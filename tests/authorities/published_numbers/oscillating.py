"""A slider that a spring pulls until it sticks, and a ball on a plane that moves: Siconos.

All numbers were looked up in its repository at the given commit. Only numbers are taken from there.
"""

from __future__ import annotations

from math import atan, atan2, hypot, inf, pi

from cases import Case, CoulombFriction, Drive, Flight, Gravity, Impact, Load, Start, Unilateral, disc
from cases.library import line

from .publications import Number, Publication
from .readings import at, height

_TUTORIALS = "github.com/siconos/siconos-tutorials, examples/mechanics/"
_COMMIT = ", commit b6c9bfd"
# Rounding of a hundred steps of a double, and DOP853's error between its steps: of a metre, of the amplitude.
_ROUNDING = 1e-12

# FrictionOscillator.ref: number of the row, place (m), velocity (m/s).
OSCILLATOR = (
    (10, 12.53405075505686, 4.672201853467469),
    (20, 12.93287600060600, 3.297721387827922),
    (30, 13.19249087298684, 1.890291728857106),
    (43, 13.31777943672665, 0.03452537107654159),
    (200, 1.044495491694369, -12.31774745658930),
    (500, -2.501948714282954, 10.20794801547121),
    (800, 3.373448597209874, -7.972099567461602),
    (1200, 2.403788884076841, 5.322613153382251),
    (1500, -0.7861911397169753, -3.931146536335745),
    (1800, -0.3568996069829933, 2.226951812446628),
    (2100, 0.9558869680782145, -0.3148787080157046),
    (2400, 0.6820441351954105, 0.0),
    (9999, 0.6820441351954105, 0.0),
)
OSCILLATOR_STEP = 0.01

# BallOnMovingPlane.ref: time (s), height of the ball, place and velocity of the plane (m, m/s).
BALL = (
    (0.2, 0.8038, 0.5892253173599042, 2.951056516295154),
    (0.5, 2.370911848981931, 1.442655844074644, 2.707106781186547),
    (1.0, 3.735194565451696, 2.629116499871870, 2.0),
    (1.5, 3.952167607230420, 3.442655844074646, 1.292893218813453),
    (2.0, 4.835824307798360, 3.992500000000001, 1.0),
    (3.0, 5.426244905838504, 5.355883500128130, 2.0),
    (4.0, 8.511493380218548, 7.992500000000003, 3.0),
    (5.0, 10.65510808470837, 10.62911649987188, 2.0),
    (6.0, 12.12898347073914, 11.99250000000001, 1.0),
    (7.0, 13.49215817306292, 13.35588350012814, 2.0),
    (8.0, 16.03620765230527, 15.99250000000001, 3.0),
    (9.0, 18.64826944210841, 18.62911649987186, 2.0),
    (10.0, 19.99325651020532, 19.99249999999999, 1.0),
)
BALL_STEP = 5e-3
# The jumps of the ball's velocity by all impacts before each of these times, added up, m/s (rounded up).
_JUMPS = (0.0, 10.08, 10.08, 18.87, 18.87, 27.38, 42.18, 53.23, 57.97, 70.29, 81.75, 90.1, 99.1)
# Its first row has no velocity of the plane, which is lower by half a step's way of 3 m/s from the first step on.
_LOW = 7.5e-3


def oscillator() -> Case:
    """A slider of 1 kg at a spring of 1 N/m with friction of 1 N, from 12 m with 6 m/s: a disc that does not turn."""
    effects = (Gravity(1.0), Load(fx="-x"), CoulombFriction(1.0), Unilateral())
    return Case(line(), disc(0.1, 1.0, inf), effects, Start(12.0, slip=6.0), 100.0)


def ball() -> Case:
    """A ball that falls by 1 m onto a plane that rises with 2 + cos(π t/2) m/s, restitution 0.9."""
    drive = Drive(y=f"2*t + 2/pi*sin(pi*t/2) - {_LOW}")
    effects = (Gravity(9.81), Unilateral(), drive, Flight(), Impact(0.9, "newton"))
    return Case(line(), disc(0.1, 1.0), effects, Start(0.0, gap=1.0 + _LOW, gap_rate=-3.0), 10.0)


def _siconos_oscillator() -> Publication:
    h, amplitude = OSCILLATOR_STEP, hypot(13.0, 6.0)
    reversals = [atan2(6.0, 13.0) + k * pi for k in range(8)]
    numbers = []
    for row, place, velocity in OSCILLATOR:
        # Its midpoint rule turns the plane of place and velocity by exactly 2 atan(h/2) in a step.
        time = 2 * row * atan(h / 2)
        accuracy = 2 * h * sum(reversal < time + h for reversal in reversals) + _ROUNDING * amplitude
        numbers += [
            Number(f"place in row {row} / m", place, at(time, "x"), accuracy),
            Number(f"velocity in row {row} / (m/s)", velocity, at(time, "vx"), accuracy),
        ]
    return Publication(
        "slider at a spring with friction",
        "Siconos",
        _TUTORIALS + "FrictionOscillator/FrictionOscillator.ref" + _COMMIT,
        "exact until the velocity reverses, since row n is exact at 2 n atan(h/2), h = 10 ms; two steps of 1 m/s and 1 "
        "m/s² by each reversal, where friction is that of the step's end",
        oscillator,
        tuple(numbers),
        whole=True,
    )


def _siconos_ball() -> Publication:
    return Publication(
        "ball on a plane that moves",
        "Siconos",
        _TUTORIALS + "BallOnMovingPlane/BallOnMovingPlane.ref and BallOnMovingPlanePlugin.cpp" + _COMMIT,
        "exact until the first impact; one of its steps of 5 ms times the jump of the velocity by each impact, which "
        "may act a step late",
        ball,
        tuple(
            Number(f"height at {time:g} s / m", above, height(time, 0.1), BALL_STEP * jumps + _ROUNDING)
            for (time, above, *_), jumps in zip(BALL, _JUMPS, strict=True)
        ),
        whole=True,
    )


OSCILLATING = (_siconos_oscillator(), _siconos_ball())
