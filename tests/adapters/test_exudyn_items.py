"""What Exudyn's stock items model in addition to discs on fixed tracks, held against the truth, one scene per kind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
from adapters import refusal
from cases import Belt, Case, CoulombFriction, Gravity, Start, Unilateral, disc
from cases.library import circle, line
from tests.adapters.test_engine_effects import off, play

exudyn = pytest.importorskip("adapters.exudyn")
from adapters.exudyn import rolls  # noqa: E402

# The largest distance (m) from the truth at the fifth rung; of the coarse rungs it is several times as much. Creep,
# penetration and an unlocated end of slip leave some 1e-5 m, a corner's sphere a share of its radius (1e-3 m).
KINDS = {
    "held angle on a line": ("block_on_ramp[slope=0.3,mu=0.5]", 1e-3),
    "held angle in a circle": ("particle_in_bowl", 1e-4),
    "held angle and a load": ("slider_on_spring", 1e-3),
    "running line": ("disc_on_conveyor[speed=-2,mu=0.4]", 1e-4),
    "running circle": ("disc_in_drum", 1e-3),
    "running supports": ("disc_in_v_of_belts", 1e-4),
    "corners on a line": ("sliding_box[mu=0.4,slope=0.2]", 1e-3),
    "corners that land": ("dropped_box[tilt=-0.5,drop=0.3,slope=0.2,mu=0.15]", 5e-3),
    "corners in a circle": ("rod_in_bowl[angle=0.7,mu=0.2]", 2e-2),
    "corners on two lines": ("ladder_at_wall[mu=0.1,mu_wall=0.2]", 5e-2),
    "discs on hills": ("disc_between_hills", 1e-3),
    "Stribeck's friction": ("stribeck_disc", 1e-3),
    "viscous friction, held": ("block_on_viscous_ramp", 1e-3),
}


@pytest.mark.sampled(4)
@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_item_is_near_the_truth(kind):
    label, most = KINDS[kind]
    case = next(case for case in cases.select(label) if case.label == label)
    assert refusal(exudyn, case, "native") is None
    assert off(case, play("exudyn", "native", case, 5))[0] < most


def test_a_plate_that_does_not_turn_keeps_any_angle():
    track = line(0.4)
    case = Case(
        track, disc(0.1, 1.0, np.inf), (Gravity(9.81), CoulombFriction(0.1), Unilateral()), Start(0.0, xi2=1.0), 0.3
    )
    motion = play("exudyn", "native", case, 2)
    assert np.abs(motion.theta - motion.theta[0]).max() < 1e-12 and abs(motion.theta[0]) > 0.1


@pytest.mark.parametrize("track", [line(0.2), circle(1.0)])
def test_a_belt_s_surface_keeps_its_speed(track):
    """The plate's friction changes the speed of the heavy body by less than 1e-7 m/s."""
    friction = (Gravity(9.81), CoulombFriction(0.3), Unilateral(), Belt(2.0))
    case = Case(track, disc(0.1, 2.0), friction, Start(xi1=-np.pi / 2 if track.period else 0.0, slip=-2.0), 1.0)
    setting = exudyn.ladder(case, "native")[2]
    model = exudyn.build(case, "native", setting)
    exudyn.run(model)
    velocities = model.system.system.systemData.GetODE2Coordinates_t()
    speed = np.hypot(*velocities[3:5]) if not track.period else abs(velocities[5])
    assert speed == pytest.approx(2.0, abs=1e-7)


@pytest.mark.parametrize(
    ("mu", "law"),
    [
        ("0.1 + 0.1*exp(-v/0.05) + 0.02*v", (0.1, 0.1, 0.05, 0.02)),
        ("0.2 + 0.3*v", (0.2, 0.0, 1.0, 0.3)),
        ("0.4*exp(-10*v)", (0.0, 0.4, 0.1, 0.0)),
        ("0.2 + 0.2/(1 + v/0.1)", None),
        ("0.3 - 0.1*exp(-v)", None),
        ("0.1 + 0.1*exp(-v) + 0.1*exp(-2*v)", None),
    ],
)
def test_stribeck_s_law_is_recognised(mu, law):
    read = rolls.stribeck_law(CoulombFriction(mu))
    assert read is None if law is None else read == pytest.approx(law)


def test_a_corner_s_sphere_shrinks_with_the_setting_and_leaves_no_gap():
    case = next(case for case in cases.select("sliding_box") if case.label == "sliding_box")
    motions = [play("exudyn", "native", case, rung) for rung in (2, 6)]
    # It stands on the line, whatever the sphere: its centre stays at half the height within the deflection.
    assert all(np.abs(motion.y - 0.1).max() < 1e-3 for motion in motions)
    coarse, fine = (off(case, motion)[0] for motion in motions)
    assert fine < 0.3 * coarse
    other = replace(case, effects=tuple(e for e in case.effects if not isinstance(e, CoulombFriction)))
    assert play("exudyn", "native", other, 2).x[-1] == pytest.approx(1.0, abs=1e-6)
