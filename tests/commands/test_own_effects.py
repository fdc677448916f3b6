"""Effects of other packages: the example package, by every method of the reference, and how adapters reject them."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from math import pi
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import reference
from adapters.interface import refusal
from adapters.laws import Route
from cases import (
    Case,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Mode,
    Start,
    Unilateral,
    disc,
    registry,
)
from cases.library import circle, line
from reports.running import reference_adapter
from tests.adapters.mutants import of_case
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.moving import on_line

EXAMPLE = Path(__file__).parents[2] / "examples" / "magnetic_wheel"


@pytest.fixture(scope="module", autouse=True)
def example_on_path():
    """The example can be imported in this file's tests alone: its case would be one of the catalogue's in others."""
    known = dict(registry._entries)
    sys.path.insert(0, str(EXAMPLE))
    yield
    sys.path.remove(str(EXAMPLE))
    registry._entries.clear()
    registry._entries.update(known)


def magnet(*values, **named):
    import magnetic_wheel

    return magnetic_wheel.Magnet(*values, **named)


def all_motions(case: Case):
    return [reference.simulate(case, 1e-13, m) for m in reference.solve.ROUTES] + [
        second_states.motion(case, rtol=1e-13)
    ]


def in_circle(effect, slip=0.0, omega=-30.0, mu=0.15) -> Case:
    effects = (Gravity(9.81), CoulombFriction(mu), effect, Unilateral())
    return Case(circle(1.0), disc(0.1, 1.0), effects, Start(-pi / 2, slip=slip, omega=omega), 2.0)


def test_a_magnet_brakes_a_sliding_wheel_as_the_closed_form_says():
    """v̇ = −3 μ (g + pull/m) for a disc: it rolls after v₀/(3 μ (g + pull/m))."""
    effects = (Gravity(9.81), CoulombFriction(0.1), magnet(20.0), Unilateral())
    case = Case(line(), disc(0.1, 1.0), effects, Start(0.0, slip=1.0), 1.0)
    for motion in all_motions(case):
        assert [t.after for t in motion.transitions] == [Mode.ROLL]
        assert motion.transitions[0].time == pytest.approx(1.0 / (0.3 * 29.81), abs=1e-13)
    assert reference.simulate(case)(0.05).normal_force == pytest.approx(29.81, rel=1e-12)


def test_a_condition_ends_the_motion_with_its_status_and_sentence():
    """A wheel that rolls down a ramp reaches the limit of its spin."""
    effects = (Gravity(9.81, -pi / 2 - 0.3), CoulombFriction(0.8), magnet(5.0, 0.0, 30.0), Unilateral())
    case = Case(line(), disc(0.1, 1.0), effects, Start(0.0), 5.0)
    # ω̇ = g sin(0.3)/(1.5 r) while it rolls.
    exact = 30.0 / (9.81 * np.sin(0.3) / 0.15)
    for motion in all_motions(case):
        assert motion.status == "too_fast"
        end = motion.end if isinstance(motion, second_states.SecondMotion) else float(motion.t[-1])
        assert end == pytest.approx(exact, abs=1e-12)
    assert reference.simulate(case).reason == "The spin reached the limit of the magnet."


@dataclass(frozen=True)
class Lift(ContactEffect):
    """A force and a couple that lift the plate while it touches, and not in flight."""

    across: float | str = 0.0
    couple: float = 0.0

    def force(self):
        return ContactForce(across=self.across, couple=self.couple)


# What a case has beside the effect, and how a motion ends whose plate can neither stay nor fly.
ENDS = pytest.mark.parametrize(
    ("more", "status"), [((), "lift_off"), ((Flight(),), "landing"), ((Flight(), Impact(0.5)), "accumulation")]
)


def end_of(motion) -> float:
    return float(motion.end if isinstance(motion, second_states.SecondMotion) else motion.t[-1])


@ENDS
@pytest.mark.parametrize("slip", [1.0, 0.0])
def test_a_growing_force_that_lifts_in_contact_alone_ends_the_motion_where_it_is_the_weight(more, status, slip):
    """N = m g − 30 t vanishes at g/30 s: the disc slips until then, as v₀ > 3 μ (g t − 15 t²), or rolls throughout."""
    for motion in all_motions(on_line(Lift("30*t"), *more, mu=0.1, slip=slip, omega=-3.0)):
        assert motion.status == status
        assert end_of(motion) == pytest.approx(9.81 / 30.0, abs=1e-13)
        # A plate that leaves its track ends in flight; one that can do neither has no mode there.
        assert [t.after for t in motion.transitions] == ([Mode.FLIGHT] if status == "lift_off" else [])


@quick_every(2)
@pytest.mark.parametrize("across", [30.0, -30.0])
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_bounces_are_those_of_the_weight_alone(across, e):
    """A drop from 0.1 m with restitution e ends after √(2 h/g) (1 + e)/(1 − e), whatever acts in contact alone; there a
    force of three times the weight leaves nothing that may follow (the first formulation's paradox; the second sees
    changes without time), and a magnet of that force begins to hold."""
    case = on_line(Lift(across), Flight(), Impact(e), gap=0.1)
    exact = np.sqrt(2 * 0.1 / 9.81) * (1 + e) / (1 - e)
    for motion in all_motions(case):
        time = end_of(motion) if across > 0.0 else motion.transitions[-1].time
        assert motion.status in (("completed",) if across < 0.0 else ("paradox", "accumulation"))
        assert time == pytest.approx(exact, abs=1e-13)
        assert across > 0.0 or motion.transitions[-1].after is Mode.ROLL


def test_adapters_reject_it_in_one_sentence_unless_they_declare_it():
    case = in_circle(magnet(60.0))
    adapter = SimpleNamespace(NAME="other", refuses=lambda case, route: None)
    assert refusal(adapter, case, "native") == (
        "The native route does not support Magnet, an effect of a package of its own."
    )
    adapter.OWN_EFFECTS = (type(magnet(1.0)),)
    assert refusal(adapter, case, "native") is None
    assert refusal(reference_adapter, case, "taylor") is None


def test_its_law_is_kept_by_an_adapter_that_supports_it_and_broken_by_a_mistake():
    import magnetic_wheel_laws

    def weaker(case):
        effects = tuple(magnet(0.9 * e.pull) if isinstance(e, ContactEffect) else e for e in case.effects)
        return Case(case.track, case.plate, effects, case.start, case.duration)

    right, wrong = of_case(), of_case(weaker)
    right.OWN_EFFECTS = wrong.OWN_EFFECTS = (ContactEffect,)
    magnetic_wheel_laws.magnet_braking(Route(right, "native"))
    with pytest.raises(AssertionError, match="magnet braking: .*pull of Magnet"):
        magnetic_wheel_laws.magnet_braking(Route(wrong, "native"))


def test_an_installed_package_adds_its_effect_its_case_and_its_law(tmp_path):
    """As an installation writes it: the modules, and a folder of metadata with the entry points."""
    for module in EXAMPLE.glob("*.py"):
        (tmp_path / module.name).write_bytes(module.read_bytes())
    metadata = tmp_path / "magnetic_wheel-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: magnetic-wheel\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(
        "[slip_to_roll.effects]\nmagnet = magnetic_wheel:Magnet\n"
        "[slip_to_roll.cases]\nmagnetic_wheel = magnetic_wheel\n"
    )
    code = (
        "import cases, reference; from cases.own_effects import registered; from adapters.laws import LAWS; "
        "motion = reference.simulate(cases.load('magnetic_wheel_in_loop')); "
        "print(sorted(registered()), 'magnet_braking' in LAWS, motion.status)"
    )
    environment = {"PYTHONPATH": f"{tmp_path}:{Path(__file__).parents[2]}", "PATH": "/usr/bin:/bin"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, cwd=tmp_path)
    assert run.stdout.strip() == "['magnet'] True completed", run.stderr
