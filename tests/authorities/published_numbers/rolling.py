"""Slipping and rolling on lines, and the transitions between them: Drake, MFiX, Newton, scopi.

All numbers were looked up in the repositories at the given commits. Only numbers and formulas are taken from there.
"""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt, tan

import cases
from cases import Case, CoulombFriction, Gravity, Plate, Start, Trajectory, Unilateral
from cases.library import circle, line

from .publications import Number, Publication, Reading
from .readings import SPHERE, at, sliding, sphere

# The ball is bowled along z at 8 m/s with a spin of −8π rad/s about z: its rim slips in a fixed direction u (friction
# does not change it), along which the motion is a plate's; the velocity across u is constant.
_R, _V0, _SPIN = 0.10795, 8.0, -8 * pi
_SLIP = sqrt((_SPIN * _R) ** 2 + _V0**2)
_UX, _UZ = _SPIN * _R / _SLIP, _V0 / _SLIP


def _bowl() -> Case:
    along = _V0 * _UZ
    effects = (Gravity(9.8), CoulombFriction(0.12), Unilateral())
    plate = Plate(circle(_R), 6.35, 0.0296)
    return Case(line(), plate, effects, Start(xi1=0.0, slip=_SLIP, omega=(_SLIP - along) / _R), 2.5)


def _in_space(quantity: str, time: float) -> Reading:
    """x, z, vx, vz, wx, wz of the ball from the plate's motion along u and the uniform motion across it."""
    across = _V0 * _UX  # the speed across u, along (−u_z, u_x) in (x, z)
    spin_along = _SPIN * _UZ  # the spin about u

    def read(motion: Trajectory) -> float:
        state = motion(time)
        values = {
            "x": state.x * _UX - across * time * _UZ,
            "z": state.x * _UZ + across * time * _UX,
            "vx": state.vx * _UX - across * _UZ,
            "vz": state.vx * _UZ + across * _UX,
            "wx": -state.omega * _UZ + spin_along * _UX,
            "wz": state.omega * _UX + spin_along * _UZ,
        }
        return float(values[quantity])

    return read


def _bowling() -> Publication:
    """Drake's bowling ball, which slides and then rolls: numbers at three times."""
    names = ("x", "z", "vx", "vz", "wx", "wz")
    rows = (
        (1.0, 2e-6, (0.188846948, 7.44315099, 0.377693896, 6.88630198, 25.7912332, -16.3860333)),
        (2.054, 2e-7, (0.796728926, 14.0827022, 0.775181741, 5.71423797, 52.9341173, -7.18093322)),
        (2.4, 4e-7, (1.06494181, 16.0598286, 0.775181741, 5.71423797, 52.9341173, -7.18093321)),
    )
    numbers = [Number("start of rolling / s", 2.054, lambda m: m.transitions[0].time, 0.002)]
    for time, accuracy, values in rows:
        numbers += [
            Number(f"{name} at {time:g} s", value, _in_space(name, time), accuracy)
            for name, value in zip(names, values, strict=True)
        ]
    return Publication(
        "bowling ball",
        "Drake",
        "github.com/RobotLocomotion/drake, multibody/benchmarks/bowling_ball/test/bowling_ball_analytical_solution_test"
        ".cc, BowlingBallSlidingToRolling (numbers of MotionGenesis), commit 7302312",
        "its test's bounds on the largest difference from the closed form",
        _bowl,
        tuple(numbers),
        whole=True,
    )


def _drake_incline() -> Publication:
    slope, r, m, g = radians(15.0), 0.05, 0.1, 9.81

    def case() -> Case:
        effects = (Gravity(g), CoulombFriction(0.5, 1.0), Unilateral())
        return Case(line(slope), sphere(r, m), effects, Start(xi1=0.0), 1.0)

    def speed_over_formula(motion: Trajectory) -> float:
        end = motion(1.0)
        return sqrt(float(end.vx**2 + end.vy**2) / (2 * g * float(motion(0.0).y - end.y) / (1 + SPHERE)))

    def couple(motion: Trajectory) -> float:
        return -float(motion(1.0).friction_force) * r

    moment = m * g * (1 - 1 / (1 + SPHERE)) * sin(slope) * r
    return Publication(
        "sphere on a slope of 15°",
        "Drake",
        "github.com/RobotLocomotion/drake, multibody/plant/test/inclined_plane_test.cc, RollingSphereTest (formulas), "
        "commit 0200c5c",
        "its test's relative bounds: 5.5e-4 on the speed, 1e-9 on the couple",
        case,
        (
            Number("speed after 1 s over sqrt(2 g h/(1 + 2/5))", 1.0, speed_over_formula, 5.5e-4),
            Number("couple of friction / N m", moment, couple, 1e-9 * moment),
        ),
    )


_MFIX = "github.com/truongd8593/mfix (a copy of MFiX), tests/dem/"


def _mfix_slip_to_roll(mu: float, time: float, speed: float, spin: float, errors: tuple[float, ...]) -> Publication:
    r, v0, g = 0.0005, 0.1, 9.81
    rounding = 5.1e-9
    readings: tuple[tuple[str, Reading], ...] = (
        ("start of rolling · μ g/v0", lambda m: m.transitions[0].time * mu * g / v0),
        ("speed in rolling/v0", lambda m: float(m(m.t[-1]).vx) / v0),
        ("spin in rolling · r/v0", lambda m: -float(m(m.t[-1]).omega) * r / v0),
    )
    exact, theirs = (0.28571429, 0.71428571, 0.71428571), (time, speed, spin)
    numbers = [Number(name, value, read, rounding) for (name, read), value in zip(readings, exact, strict=True)]
    for (name, read), value, percent, right in zip(readings, theirs, errors, exact, strict=True):
        # Both the number and the exact one are printed to eight digits.
        numbers.append(Number(f"{name}, its own", value, read, 2 * rounding, distance=right * percent / 100))
    return Publication(
        f"DEM04, slip to roll, μ = {mu:g}",
        "MFiX",
        _MFIX + "DEM04/AUTOTEST/POST_TIME.dat, POST_TVEL.dat, POST_AVEL.dat, commit 15c6363",
        "the last printed digit; of its own numbers, their printed distance from the closed form is compared",
        lambda: sliding(r, mu, v0, 0.6 * v0 / (mu * g), g),
        tuple(numbers),
    )


def _newton() -> Publication:
    return Publication(
        "sphere sliding into rolling",
        "Newton (Kamino)",
        "github.com/newton-physics/newton, newton/tests/kamino/test_kamino_solvers_dvi.py, test_08e (line 2700), "
        "commit 41a5392",
        "its test's bounds",
        lambda: sliding(0.1, 0.5, 2.0, 0.233),
        (
            Number("speed in rolling / (m/s)", 2.0 / (1.0 + SPHERE), lambda m: float(m(m.t[-1]).vx), 1e-4),
            Number("slip left / (m/s)", 0.0, lambda m: float(m(m.t[-1]).slip), 1e-5),
        ),
    )


_SCOPI = "github.com/hpc-maths/scopi, test/"


def _along(slope: float, time: float) -> Reading:
    """The distance of the centre down the slope since the start."""

    def read(motion: Trajectory) -> float:
        here, start = motion(time), motion(0.0)
        return float((here.x - start.x) * cos(slope) - (here.y - start.y) * sin(slope))

    return read


def _scopi_formula(mu: float, slope: float, errors: tuple[float, float, float, float]) -> Publication:
    """The published closed form with r = g = 1 at 10.01 s; `errors` are scopi's own, relative, with steps of 10 ms."""
    time, landing = 10.01, sqrt(2 / cos(slope))
    since, way_in_fall = time - landing, 0.5 * landing**2 * sin(slope)
    if tan(slope) <= 3 * mu:
        speed = 2 / 3 * time * sin(slope)
        spin, rotation_angle = -speed, -(since**2 / 3 + 2 / 3 * landing * since) * sin(slope)
        way = way_in_fall - rotation_angle
    else:
        speed, spin = time * (sin(slope) - mu * cos(slope)), -2 * mu * time * cos(slope)
        way = way_in_fall + 0.5 * (time**2 - landing**2) * (sin(slope) - mu * cos(slope))
        rotation_angle = -mu * (time**2 - landing**2) * cos(slope)
    place, rotation, velocity, turning = errors
    numbers = (
        Number("way down the slope", way, _along(slope, time), place * way),
        # For the rotation, scopi gives the error of the quaternion, which is half as large.
        Number("rotation / rad", rotation_angle, at(time, "theta"), 2 * rotation),
        Number("speed", speed, lambda m: float(m(time).vx) / cos(slope), velocity * speed),
        Number("spin", spin, at(time, "omega"), -turning * spin),
    )
    return Publication(
        f"disc falling onto an incline of {slope * 180 / pi:.0f}°, μ = {mu:g}",
        "scopi",
        _SCOPI
        + "analytical_solution.cpp, *_sphere_plane_friction (formulas), test_friction.cpp line 114 (errors), commit "
        "8c6411a",
        "scopi's own relative errors at this time, about 1e-3, with steps of 10 ms",
        lambda: cases.load("disc_onto_incline", mu=mu, slope=slope, height=1.0, r=1.0, g=1.0, duration=10.1),
        numbers,
    )


def _scopi_run() -> Publication:
    slope, step, speed = pi / 6, 0.1, 8.269
    start_y = 3 / cos(slope)

    def place(coordinate: str) -> Reading:
        # Our disc starts where the origin is the incline's nearest point; theirs starts vertically above the origin.
        shift = {"x": 3 * sin(slope), "y": 3 * cos(slope)}
        return lambda m: float(getattr(m(20.0), coordinate)) - shift[coordinate] + (start_y if coordinate == "y" else 0)

    numbers = (
        Number("x after 20 s", 71.56701162523167, place("x"), step * speed),
        Number("y after 20 s", -38.95437061818806, place("y"), step * speed),
        Number("vx after 20 s", 7.161246987036821, at(20.0, "vx"), step),
        Number("vy after 20 s", -4.131774373007218, at(20.0, "vy"), step),
        Number("spin after 20 s", -1.732290999947742, at(20.0, "omega"), step * 0.0866),
    )
    return Publication(
        "disc falling onto an incline, a run with steps of 0.1 s",
        "scopi",
        _SCOPI + "references/sphere_plane_friction_mu01.json and test_gradient.cpp line 194, commit 8c6411a",
        "one of its steps of 0.1 s: the way and the gain of velocity in it",
        lambda: cases.load("disc_onto_incline", mu=0.1, slope=slope, height=1.0, r=2.0, g=1.0, duration=20.1),
        numbers,
    )


def _publications() -> tuple[Publication, ...]:
    return (
        _bowling(),
        _drake_incline(),
        _mfix_slip_to_roll(0.2, 0.28593282, 0.71427215, 0.71431962, (0.07648625, 0.00189890, 0.00474724)),
        _mfix_slip_to_roll(1.0, 0.28732858, 0.71416543, 0.71458642, (0.56500467, 0.01683932, 0.04209829)),
        _newton(),
        _scopi_formula(0.1, pi / 4, (0.00102263, 0.00304414, 0.00100977, 0.000929086)),
        _scopi_formula(0.5, pi / 3, (0.0010907, 0.0096141, 0.00105025, 0.000883162)),
        _scopi_formula(1.0, pi / 6, (0.00107652, 0.00680805, 0.0009990016, 0.000999002)),
        _scopi_run(),
    )


ROLLING = _publications()
