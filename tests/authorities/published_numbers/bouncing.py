"""Bouncing balls and single impacts: FMI Reference FMUs, Siconos, PETSc, MFiX, Kratos.

All numbers were looked up in the repositories at the given commits. Only numbers are taken from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, radians, sin, sqrt

from cases import Case, CoulombFriction, Curve, Flight, Gravity, Impact, Plate, Start, Unilateral
from cases import curves as c
from cases.library import line

from .publications import Number, Publication
from .readings import apex, at, bouncing, height, impact, sphere, travel


def _reference_fmu() -> Publication:
    times = (0.451522, 1.08365, 1.52613, 1.83585, 2.05263, 2.20436, 2.31052, 2.38477, 2.43665, 2.47284, 2.498)
    heights = ((0.56, 0.278621), (1.24, 0.219426), (1.67, 0.117025), (1.95, 0.0574593))
    numbers = [
        Number(f"impact {i} / s", t, impact(i), 5e-7 if t < 1 else 5e-6, 1.2e-3, _early(times[:i]))
        for i, t in enumerate(times, start=1)
    ]
    numbers += [Number(f"height at {t:g} s / m", h, height(t, 0.1), 5e-7, 1e-4, _low(t, times)) for t, h in heights]
    return Publication(
        "BouncingBall",
        "FMI Reference FMUs",
        "github.com/modelica/Reference-FMUs, BouncingBall/BouncingBall_ref.csv, commit 00bd2dd (2019; later "
        "versions step by 1 ms or 10 ms, and their first impact is 1.5 ms or 8.5 ms late)",
        "none is given; half a unit of the last printed digit",
        lambda: bouncing(1.0, 0.7, 9.81, 3.0),
        tuple(numbers),
        whole=True,
    )


# Gravity, drop height and restitution of the Reference FMU.
_FMU_G, _FMU_HEIGHT, _FMU_E = 9.81, 1.0, 0.7


def _early(times: Sequence[float]) -> str:
    """Why the last of these impacts of the Reference FMU is early: the flight before it is too short."""
    speed = sqrt(2.0 * _FMU_G * _FMU_HEIGHT)
    if len(times) == 1:
        return f"early by {speed / _FMU_G - times[0]:.1e} s compared with sqrt(2 h/g), before any bounce"
    bounce = len(times) - 1
    exact = 2.0 * _FMU_E**bounce * speed / _FMU_G
    short = exact - (times[-1] - times[-2])
    whole = speed / _FMU_G + sum(2.0 * _FMU_E**k * speed / _FMU_G for k in range(1, bounce + 1)) - times[-1]
    return (
        f"its flight after bounce {bounce} is {short:.1e} s shorter than 2 e^{bounce} sqrt(2 h/g), as if the speed "
        f"after that bounce were {0.5 * _FMU_G * short:.1e} m/s too small; with the flights before, it is "
        f"{whole:.1e} s early"
    )


def _low(time: float, times: Sequence[float]) -> str:
    """Why a height of the Reference FMU is too small: it follows from its own impacts before and after it."""
    before, after = next(pair for pair in pairwise(times) if pair[0] < time < pair[1])
    own = 0.5 * _FMU_G * (time - before) * (after - time)
    return (
        f"it follows from its impacts at {before:g} s and {after:g} s, between which free flight is at {own:.5f} m "
        "then; these impacts are early"
    )


_TUTORIALS = "github.com/siconos/siconos-tutorials, examples/mechanics/"
_COMMIT = ", commit b6c9bfd"


def _siconos_bouncing() -> Publication:
    times = (
        (1, 4.515236409857308e-01),
        (2, 1.264266194760045e00),
        (3, 1.995734493156927e00),
        (4, 2.654055961714119e00),
        (5, 3.246545283415589e00),
        (10, 5.430218002585270e00),
        (15, 6.719654906527705e00),
        (20, 7.481054503936557e00),
        (25, 7.930653352210332e00),
    )
    heights = (
        (0.985, 7.307562821680371e-01),
        (1.975, 7.228353910971286e-02),
        (2.955, 4.303588872526858e-01),
        (4.915, 1.811748826695022e-01),
        (6.845, 3.724831973008282e-02),
    )
    numbers = [Number(f"impact {i} / s", t, impact(i), 1e-12) for i, t in times]
    numbers += [Number(f"height at {t:g} s / m", h, height(t, 0.1), 1e-12) for t, h in heights]
    return Publication(
        "bouncing ball, event-driven",
        "Siconos",
        _TUTORIALS + "BouncingBallEventDriven/BouncingBallED.ref" + _COMMIT,
        "its test compares its own runs with the file to 1e-12",
        lambda: bouncing(1.0, 0.9, 9.81, 8.2),
        tuple(numbers),
        whole=True,
    )


def _siconos_impact_first() -> Publication:
    times = (
        (1, 1.834862385321100e-01),
        (2, 3.486238532110067e-01),
        (3, 4.972477064220083e-01),
        (6, 8.597412844036006e-01),
        (10, 1.195085431008931e00),
        (14, 1.415104725596534e00),
    )
    heights = (
        (0.1, 4.094999999999999e-02),
        (0.3, 2.778853211008974e-02),
        (0.7, 1.739189724769667e-02),
        (1.2, 1.423773416664126e-03),
    )
    numbers = [Number(f"impact {i} after the first / s", t, impact(i), 1e-12) for i, t in times]
    numbers += [Number(f"height at {t:g} s / m", h, height(t, 0.1), 1e-12) for t, h in heights]
    return Publication(
        "ball that begins with an impact",
        "Siconos",
        _TUTORIALS + "BouncingBallEventDriven/BouncingBallED-initialImpact.ref" + _COMMIT,
        "its test compares its own runs with the file to 1e-12",
        # It hits the floor with 1 m/s at time zero and rebounds with 0.9 m/s; our case begins with the rebound.
        lambda: bouncing(0.0, 0.9, 9.81, 1.42, lift=0.9),
        tuple(numbers),
        whole=True,
    )


def _siconos_no_rebound() -> Publication:
    numbers = (
        Number("height at 0.45 s / m", 6.737499999999397e-03, height(0.45, 0.1), 1e-12),
        Number("impact / s", 4.515236409857311e-01, lambda m: m.transitions[0].time, 1e-12),
        Number("height at 3.485 s / m", 0.0, height(3.485, 0.1), 1e-12),
        Number("normal force at 3.485 s / N", 9.81, at(3.485, "normal_force"), 1e-12),
    )
    return Publication(
        "ball that stays where it lands",
        "Siconos",
        _TUTORIALS + "BouncingBallEventDriven/BouncingBallED-withRestingContact.ref" + _COMMIT,
        "its test compares its own runs with the file to 1e-12",
        lambda: bouncing(1.0, 0.0, 9.81, 4.0),
        numbers,
        whole=True,
    )


def _siconos_spinning() -> Publication:
    step = 0.005  # s; an impact acts at the end of its step, so positions are accurate to the path of one step

    def case() -> Case:
        effects = (Gravity(9.81), CoulombFriction(0.1), Unilateral(), Flight(), Impact(0.9))
        return Case(line(), sphere(0.5), effects, Start(xi1=0.0, gap=0.5, slip=-1.0, omega=-2.0), 10.0)

    speed = 2.857142857142858e-01
    numbers = (
        Number("height of the centre at 0.2 s / m", 8.038e-01, at(0.2, "y"), 1e-12),
        Number("speed after the first impact / (m/s)", speed, at(1.0, "vx"), 1e-12),
        Number("spin after the first impact / (rad/s)", -5.714285714285715e-01, at(1.0, "omega"), 1e-12),
        Number("place at 1 s / m", 1.949999999999995e-01, at(1.0, "x"), step * speed),
        Number("place at 3 s / m", 7.664285714285771e-01, at(3.0, "x"), step * speed),
        Number("rotation at 4 s / rad", -2.739285714285717e00, at(4.0, "theta"), step * 2.0),
        Number("height of the centre at 1 s / m", 7.149594137500003e-01, at(1.0, "y"), 2 * step * 3.13),
        Number("place at 9.99 s / m", 2.763571428571451e00, at(9.99, "x"), step * speed),
        Number("speed at 9.99 s / (m/s)", speed, at(9.99, "vx"), 1e-12),
        Number("weight carried at 9.99 s / N", 4.905000000000763e-02 / step, at(9.99, "normal_force"), 1e-12 / step),
    )
    return Publication(
        "spinning ball that bounces until it rolls",
        "Siconos",
        _TUTORIALS + "2DRigidBodies/Ball2D_kernel_only_with_friction.ref" + _COMMIT,
        "velocities: its test compares its own runs with the file to 1e-12; places: the path of one step of 5 ms, of "
        "two after an impact",
        case,
        numbers,
        whole=True,
    )


def thrown_stick(law: str = "moreau") -> Case:
    """Siconos' stick of 1 m, thrown down at 45° onto a floor with friction 0.01; its end is a circle of 1 µm."""
    half, tilt, tip = 0.5, pi / 4, 1e-6
    start = Start(
        xi1=0.0,
        xi2=-pi - tilt,
        gap=0.01,
        slip=-0.5 + 0.1 * (half * cos(tilt) + tip),
        omega=0.1,
        gap_rate=0.1 + 0.1 * half * sin(tilt),
    )
    effects = (Gravity(10.0), CoulombFriction(0.01), Unilateral(), Flight(), Impact(1.0, law))
    outline = Curve(lambda s: (tip * c.cos(s) - half, tip * c.sin(s)))
    return Case(line(), Plate(outline, 1.0, 1.0 / 12.0), effects, start, 0.2)


def _siconos_stick() -> Publication:
    # An impact acts up to two steps of 1e-4 s late: the closing speed is then larger by g·2e-4 s and the impulse by
    # 2 m·g·2e-4 s/2.5, where 2.5 is the effect of the lever arm; friction changes by a hundredth of that, the spin by
    # 12·0.36 rad/s per N s.
    late = 2e-4
    impulse = 2 * 10.0 * late / 2.5
    turn, friction = 12 * 0.36 * impulse, 0.01 * impulse
    x0 = 3.535533905932737e-01
    numbers = (
        Number("impact 1 / s", 6.04e-02, impact(1), late),
        Number("height of the centre before it, at 0.03 s / m", 3.620533905932738e-01, at(0.03, "y"), late * 0.2),
        Number("speed along after it / (m/s)", -5.037388347232359e-01, at(0.1, "vx"), friction),
        Number("speed across after it, at 0.1 s / (m/s)", -5.261165276764048e-01, at(0.1, "vy"), impulse),
        Number("spin after it / (rad/s)", 1.680022848791993e00, at(0.1, "omega"), turn),
        Number("way along until 0.1 s / m", 3.034051457964930e-01 - x0, travel(0.1), late * 0.0037 + 0.04 * friction),
        Number("height of the centre at 0.1 s / m", 3.383778702709042e-01, at(0.1, "y"), late * 0.374 + 0.04 * impulse),
        Number("speed along after impact 2 / (m/s)", -5.068672606709300e-01, at(0.2, "vx"), 2 * friction),
        Number("speed across after impact 2, at 0.2 s / (m/s)", -1.213273932906967e00, at(0.2, "vy"), 2 * impulse),
        Number("spin after impact 2 / (rad/s)", 3.212070578753687e00, at(0.2, "omega"), 2 * turn),
    )
    return Publication(
        "stick that hits with friction, e = 1",
        "Siconos",
        _TUTORIALS + "ImpactingStick/ImpactingStick.ref and ImpactingStick.cpp" + _COMMIT,
        "the change by an impact that acts two of its steps of 0.1 ms late; its law is Moreau's",
        thrown_stick,
        numbers,
        whole=True,
    )


def _petsc(height: float, times: tuple[float, ...], processor: int) -> Publication:
    return Publication(
        f"ball thrown up from {height:g} m",
        "PETSc",
        f"github.com/petsc/petsc, src/ts/tutorials/ex44.c and output/ex44_2.out, processor {processor}, commit 4f687e3",
        "half a unit of the last printed digit",
        lambda: bouncing(height, 0.9, 9.8, times[-1] + 0.1, lift=20.0),
        tuple(Number(f"impact {i} / s", t, impact(i), 0.005) for i, t in enumerate(times, start=1)),
        whole=True,
    )


_MFIX = "github.com/truongd8593/mfix (a copy of MFiX), tests/dem/"


def _mfix_heights(e: float, heights: tuple[float, ...], duration: float) -> Publication:
    return Publication(
        f"DEM02, hard sphere, e = {e:g}",
        "MFiX",
        _MFIX + "DEM02/AUTOTEST/POST_HEIGHT.dat, column Height, commit 15c6363",
        "half a unit of the last printed digit",
        lambda: bouncing(0.4, e, 9.81, duration),
        tuple(Number(f"height of bounce {i} / m", h, apex(i), 5.1e-9) for i, h in enumerate(heights, start=1)),
        whole=True,
    )


def _mfix_soft() -> Publication:
    rows = ((1, 0.42332601, 0.15895985), (5, 0.23803012, 0.60185102), (10, 0.14706436, 1.05382008))
    return Publication(
        "DEM02, soft sphere (5 MN/m), e = 0.9",
        "MFiX",
        _MFIX + "DEM02/AUTOTEST/POST_HEIGHT.dat, column Height_MFIX, KN = 0.5E+07, commit 15c6363",
        "the last printed digit of its distance from the hard sphere, column %REL DIFF, which is compared",
        lambda: bouncing(0.4, 0.9, 9.81, 4.6),
        # The percentages refer to the hard sphere's height.
        tuple(Number(f"height of bounce {i} / m", h, apex(i), 2e-8, distance=h * p / (100 - p)) for i, h, p in rows),
    )


def _kratos(
    degrees: float, spin: float, speed_ratio: float, spin_off: float = 0.0, speed_ratio_off: float = 0.0
) -> Publication:
    """`spin_off`, `speed_ratio_off`: known relative errors of the two numbers if the rim sticks. A rim that rebounds
    with β times its slip velocity gives a solid sphere the spin 5/7 (1 + β) v sin α/r and leaves it 5/7 − 2/7 β of its
    tangential speed; rigid friction has β = 0. (Derived: impulse and angular momentum about the contact.)"""
    r, v, mu, e = 0.0025, 3.9, 0.092, 0.98
    angle = radians(degrees)
    rebound = 7.0 / 5.0 * spin * r / (v * sin(angle)) - 1.0
    sticks = f"at {degrees:g}°, below atan(3.5 μ (1 + e)) = 32.5°, the rim sticks, and its tangential spring rebounds"
    of_spin = f"{sticks}: the spin is 5/7 (1 + β) v sin α/r with β = {rebound:.2f}; rigid friction has β = 0"
    of_speed = (
        f"{sticks}: with the β = {rebound:.2f} of its spin, 5/7 - 2/7 β = {5 / 7 - 2 / 7 * rebound:.4f} of the speed "
        "is kept; rigid friction keeps 5/7"
    )

    def case() -> Case:
        effects = (CoulombFriction(mu), Unilateral(), Flight(), Impact(e))
        start = Start(xi1=0.0, gap=r, gap_rate=-v * cos(angle), slip=v * sin(angle))
        return Case(line(), sphere(r), effects, start, 4 * r / (v * cos(angle)))

    return Publication(
        f"sphere thrown at a wall at {degrees:g}°",
        "Kratos DEM",
        "github.com/KratosMultiphysics/Kratos, applications/DEMApplication/tests/DEM3D_chung_ooi_tests/test4_data/"
        "benchmark4_dt_2e-08_final_angular_vel_list_data.dat (commit d086b69) and "
        "…_tangential_restitution_coefficient_list_data.dat (b674a56), Materials4.json",
        "its test's bounds on its mean relative error: 2.2 % of the spin, 1.6 % of the speed",
        case,
        (
            Number(
                "spin after the impact / (rad/s)",
                spin,
                lambda m: -float(m(m.t[-1]).omega),
                0.022 * spin,
                spin_off * spin,
                of_spin,
            ),
            Number(
                "tangential speed kept",
                speed_ratio,
                lambda m: float(m(m.t[-1]).vx) / (v * sin(angle)),
                0.016 * speed_ratio,
                speed_ratio_off * speed_ratio,
                of_speed,
            ),
        ),
    )


def _publications() -> tuple[Publication, ...]:
    e9 = (0.424, 0.36244, 0.3125764, 0.27218688, 0.23947138, 0.21297181, 0.19150717, 0.17412081, 0.16003785, 0.14863066)
    e6 = (0.244, 0.15184, 0.1186624, 0.10671846, 0.10241865, 0.10087071)
    ground = (4.08, 7.76, 11.06, 14.04, 16.71, 19.12, 21.29, 23.25, 25.00, 26.58)
    higher = (4.32, 8.42, 12.11, 15.43, 18.41, 21.10, 23.52, 25.70)
    thrown = (
        (20, 502.95453645, 0.62190916, 0.245, 0.15),  # the rim sticks below atan(3.5 μ (1 + e)) = 32.5°
        (30, 611.05616648, 0.68590534, 0.09, 0.042),
        (40, 540.96892548, 0.78374858),
        (60, 353.30932342, 0.89523584),
        (80, 122.80838960, 0.96800427),
    )
    return (
        _reference_fmu(),
        _siconos_bouncing(),
        _siconos_impact_first(),
        _siconos_no_rebound(),
        _siconos_spinning(),
        _siconos_stick(),
        _petsc(0.0, ground, 0),
        _petsc(5.0, higher, 1),
        _mfix_heights(0.9, e9, 4.6),
        _mfix_heights(0.6, e6, 1.13),
        _mfix_soft(),
        *(_kratos(*row) for row in thrown),
    )


BOUNCING = _publications()
