"""A free polygon and discs: exact motions, the paper's matrix at instants, and both formulations in whole sequences."""

from dataclasses import replace
from math import atan, cos, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import cases
import reference
from adapters import pymunk
from adapters.interface import refusal
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Mode,
    Plate,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.library import line

G = 9.81


def scene(polygon: Plate, pose: StartPose, ball: Plate, at: StartPose, floor: float = 0.0, mu: float = 0.0, time=1.0):
    """A polygon and a disc on a floor with friction of its own; the track is far below."""
    own = (CoulombFriction(floor),) if floor else ()
    effects = (Gravity(G), Unilateral(), Flight(), Impact(0.0), *((CoulombFriction(mu),) if mu else ()))
    support = Support(Curve(lambda s: (s, 5.0 + 0 * s)), "floor", own)
    up = (replace(pose, y=pose.y + 5.0), replace(at, y=at.y + 5.0))
    return Case(line(), polygon, effects, up[0], time, supports=(support,), others=(FreePlate(ball, up[1], "disc"),))


def over_the_edge(mass: float, speed: float, floor: float) -> Case:
    """A disc of 1 kg slides without friction over the edge of a block of width 1 m and height 0.4 m."""
    ball, at = disc(0.1, 1.0), StartPose(0.3, 0.5, vx=speed)
    return scene(Plate.rectangle(1.0, 0.4, mass), StartPose(0.0, 0.2), ball, at, floor)


# --- exact motions ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "mass,floor",
    [(2.0, 0.0), pytest.param(0.3, 0.0, marks=pytest.mark.slow), pytest.param(5.0, 0.9, marks=pytest.mark.slow)],
)
def test_a_disc_passes_from_an_edge_to_a_corner_and_leaves_it_at_the_exact_time(mass, floor):
    """With u = r φ̇ about the corner, momentum and energy in the frame of the centre of mass give
    u² (1 − κ cos²φ) = v² (1 − κ) + 2 g r (1 − cos φ), κ = m/(M + m), and κ = 0 if the block sticks; the force vanishes
    where u² = g r cos φ, as the block has no acceleration there."""
    kappa, speed, r = 0.0 if floor else 1.0 / (1.0 + mass), 0.4, 0.1

    def square(phi: float) -> float:
        return (speed**2 * (1.0 - kappa) + 4.0 * G * r * sin(0.5 * phi) ** 2) / (1.0 - kappa * cos(phi) ** 2)

    end = brentq(lambda phi: square(phi) - G * r * cos(phi), 0.0, 1.5, xtol=1e-15)
    turning, _ = quad(lambda phi: r / sqrt(square(phi)), 0.0, end, epsabs=1e-14, epsrel=1e-14)
    motion = reference.simulate(over_the_edge(mass, speed, floor), rtol=1e-12)
    first = motion.transitions[0]
    assert (first.contact, first.before, first.after) == ("disc/plate", Mode.SLIDE, Mode.FLIGHT)
    assert first.time == pytest.approx(0.2 / speed + turning, abs=1e-12)  # the slack of the handing over: 1e-13 m
    arm = motion.plate("disc")(first.time).x - motion(first.time).x - 0.5
    assert arm == pytest.approx(r * sin(end), abs=1e-12)
    assert (np.abs(motion.vx).max() < 1e-14) == bool(floor)  # a block that sticks moves by rounding


def test_a_free_wedge_has_the_exact_acceleration():
    """m g sin α cos α/(M + m sin²α), by momentum and the constraint of the slope."""
    case, angle = cases.load("disc_on_free_wedge"), atan(0.5)
    motion = reference.simulate(case, rtol=1e-12)
    exact = -G * sin(angle) * cos(angle) / (3.0 + sin(angle) ** 2)
    assert motion(0.4).vx == pytest.approx(0.4 * exact, abs=1e-13)
    assert motion.plate("disc")(0.4).vx * 1.0 + 3.0 * motion(0.4).vx == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("share,sticks", [(1.001, True), (0.999, False)])
def test_a_wedge_under_a_sliding_disc_sticks_up_to_the_exact_coefficient(share, sticks):
    """N = (M + m cos²α) g and T = m g sin α cos α. Two corners share T: each within its own bound."""
    wedge, angle = Plate.polygon([(0, 0), (2, 0), (0, 1)], 3.0), atan(0.5)
    normal, friction = (3.0 + cos(angle) ** 2) * G, G * sin(angle) * cos(angle)
    at = StartPose(0.5 + 0.1 * sin(angle), 0.75 + 0.1 * cos(angle))
    mu = share * friction / normal
    motion = reference.simulate(
        scene(wedge, StartPose(2 / 3, 1 / 3), disc(0.1, 1.0), at, floor=mu, time=0.1), rtol=1e-12
    )
    assert motion.status == "completed" and (np.abs(motion.vx).max() < 1e-14) == sticks
    columns = [motion.contacts[name] for name in ("plate/floor", "plate/floor 3")]
    if not sticks:
        assert {t.after for t in motion.transitions} == set() and columns[0].slip[-1] != 0.0
        return
    forces = [one.normal_force[0] for one in columns]
    assert sum(forces) == pytest.approx(normal, rel=1e-12)
    for one, own, other in zip(columns, forces, forces[::-1], strict=True):
        low, high = max(-mu * own, friction - mu * other), min(mu * own, friction + mu * other)
        assert one.friction_range[:, 0] == pytest.approx([low, high], abs=1e-12 * normal)
        assert np.isnan(one.friction_force[0])


# --- both formulations ------------------------------------------------------------------------------------------------


def test_a_motion_that_ends_where_it_begins_has_all_plates():
    """A block that slides at mu = 1,000 has no consistent forces; the motion had the first plate alone, and a report
    whose truth has such a null motion ended with an error."""
    ball, at = disc(0.1, 1.0), StartPose(1.0, 0.1)
    case = scene(Plate.rectangle(0.2, 0.2, 1.0), StartPose(0.0, 0.1, vx=-0.3), ball, at, floor=1e3)
    motion = reference.simulate(case)
    assert motion.status == "paradox" and motion.t.tolist() == [0.0]
    assert motion.plate_names == ("plate", "disc") and motion.plate("disc").x.tolist() == [1.0]


# --- invalid cases ----------------------------------------------------------------------------------------------------


def test_engines_refuse_shapes_that_they_do_not_have():
    good = over_the_edge(2.0, 0.4, 0.0)
    for plate, sentence in (
        (Plate.half_disc(0.2, 1.0), None),
        (Plate.polygon([(0, 0), (1, 0), (0.3, 0.3), (0, 1)], 1.0),
         "pymunk's polygons are convex, and an outline here has corners that point inwards."),
    ):  # fmt: skip
        other = replace(good, others=(replace(good.others[0], plate=plate, start=StartPose(3.0, 7.0)),))
        assert refusal(pymunk, other, "native") == sentence
    # As any adapter that does not list its routes in FREE_POLYGONS.
    engine = SimpleNamespace(NAME="discs", SEVERAL_PLATES=("native",), SUPPORTS=("native",), refuses=lambda *_: None)
    sentence = "The native route does not support several plates unless all of them are discs."
    assert refusal(engine, good, "native") == sentence
    assert refusal(pymunk, good, "native") is None
