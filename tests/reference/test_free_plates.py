"""Several free plates: exact motions, invariance, and both formulations in the whole sequence."""

from math import cos, inf, pi, sin, sqrt

import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import reference
from adapters.interface import refusal
from cases import (
    Case,
    CoulombFriction,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Mode,
    StartPose,
    Unilateral,
    disc,
)
from cases.library import line
from reference.certification import certify
from reference.witness import predict
from tests.scenes.agreement import agree

G = 9.81


def scene(discs, mu=0.0, e=0.0, duration=1.5, slope=0.0, supports=(), law="moreau") -> Case:
    """Discs (radius, mass, x, y, vx, vy, ω), those of negative mass without rotation, on a line."""
    plates = [disc(r, abs(m), inf if m < 0.0 else None) for r, m, *_ in discs]
    poses = [StartPose(x, y, 0.0, vx, vy, omega) for _, _, x, y, vx, vy, omega in discs]
    effects = (Gravity(G), Unilateral(), Flight(), Impact(e, law), *((CoulombFriction(mu),) if mu else ()))
    others = tuple(FreePlate(p, s, f"disc{i + 2}") for i, (p, s) in enumerate(zip(plates[1:], poses[1:], strict=True)))
    return Case(line(slope), plates[0], effects, poses[0], duration, supports=supports, others=others)


def on_top(phi=0.3, masses=(2.0, 1.0), radii=(0.5, 0.4), **rest) -> Case:
    """A disc at rest on a disc on the floor, the line of the centres at φ from the vertical."""
    far = sum(radii)
    upper = radii[1], masses[1], far * sin(phi), radii[0] + far * cos(phi), 0.0, 0.0, 0.0
    return scene([(radii[0], masses[0], 0.0, radii[0], 0.0, 0.0, 0.0), upper], **rest)


def row(speed=1.0, gap=0.0, count=3, **rest) -> Case:
    """Equal discs on the floor; the first one moves towards the others, which are `gap` apart."""
    first = 0.1, 1.0, -0.5, 0.1, speed, 0.0, 0.0
    return scene([first, *((0.1, 1.0, i * (0.2 + gap), 0.1, 0.0, 0.0, 0.0) for i in range(count - 1))], **rest)


# --- exact motions ----------------------------------------------------------------------------------------------------


def leaving(phi: float, masses, far: float) -> tuple[float, float]:
    """Time and angle at which a disc leaves a free disc without friction.

    L φ̇² (1 − κ cos²φ) = 2 g (cos φ₀ − cos φ), κ = m₂/(m₁ + m₂), by momentum and energy; the force vanishes where
    φ̇² = g cos φ/L. The time is a quadrature, with φ = φ₀ + z² at its singular start.
    """
    kappa = masses[1] / sum(masses)

    def square(off: float) -> float:
        """φ̇² at φ₀ + `off`, without the cancellation of the two cosines."""
        fallen = 2.0 * sin(phi + 0.5 * off) * sin(0.5 * off)
        return 2.0 * G * fallen / (far * (1.0 - kappa * cos(phi + off) ** 2))

    end = brentq(lambda off: square(off) - G * cos(phi + off) / far, 0.1, 1.2, xtol=1e-15)
    time, _ = quad(lambda z: 2.0 * z / sqrt(square(z * z)), 0.0, sqrt(end), epsabs=1e-14, epsrel=1e-14)
    return time, phi + end


MASSES = [(2.0, 1.0), *(pytest.param(m, marks=pytest.mark.slow) for m in ((0.2, 3.0), (-1.0, 1.0), (1e3, 1.0)))]


@pytest.mark.parametrize("masses", MASSES)
def test_a_disc_leaves_a_free_disc_at_the_exact_time(masses):
    """Also a hemisphere (a disc that does not turn), and one so heavy that it hardly moves: cos φ = (2/3) cos φ₀."""
    motion = reference.simulate(on_top(masses=masses, duration=1.0), rtol=1e-12)
    time, angle = leaving(0.3, (abs(masses[0]), masses[1]), 0.9)
    first = motion.transitions[0]
    assert (first.contact, first.before, first.after) == ("disc2/plate", Mode.SLIDE, Mode.FLIGHT)
    assert first.time == pytest.approx(time, abs=2e-13)
    assert pi / 2 - first.xi1 == pytest.approx(angle, abs=1e-12)  # ξ₁: the polar angle of the lower disc's outline
    if masses[0] == 1e3:
        assert cos(angle) == pytest.approx(2 / 3 * cos(0.3), rel=1e-3)
    now, upper = motion(0.9), motion.plate("disc2")(0.9)
    assert abs(masses[0]) * now.vx + masses[1] * upper.vx == pytest.approx(0.0, abs=1e-11 * max(masses))
    assert motion.contacts["disc2/plate"].normal_force[0] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("count", [9, 20])
def test_a_velocity_goes_through_a_long_row_of_discs_apart(count):
    """Equal discs 0.05 m apart exchange their velocities one after the other, the first two after 0.3 m at 1 m/s."""
    motion = reference.simulate(row(gap=0.05, count=count, e=1.0, duration=1.5), method="dop853")
    times = [0.3 + 0.05 * k for k in range(count - 1)]
    assert [one.time for one in motion.transitions] == pytest.approx(times, abs=1e-12)
    assert motion.status == "completed"
    assert motion.plate(f"disc{count}").vx[-1] == pytest.approx(1.0, abs=1e-12)


def test_an_impact_goes_through_a_row_of_discs():
    """Apart, each passes its speed on to the next. Touching, e = 1 between whole impulses: −1/3, 2/3, 2/3, as derived
    in test_impacts_of_bodies. The first contact closes after 0.3 m/(1 m/s)."""
    apart = reference.simulate(row(gap=0.01, e=1.0))
    assert [t.time for t in apart.transitions] == pytest.approx([0.3, 0.31], abs=1e-14)
    assert _speeds(apart) == pytest.approx([0.0, 0.0, 1.0], abs=1e-13)
    together = reference.simulate(row(e=1.0))
    assert [t.time for t in together.transitions] == pytest.approx([0.3], abs=1e-14)
    assert _speeds(together) == pytest.approx([-1 / 3, 2 / 3, 2 / 3], abs=1e-13)
    assert _speeds(reference.simulate(row())) == pytest.approx([1 / 3] * 3, abs=1e-13)


def _speeds(motion) -> list[float]:
    return [float(motion.plate(name).vx[-1]) for name in motion.plate_names]


# --- both formulations ------------------------------------------------------------------------------------------------


def test_both_formulations_agree_in_one_impact():
    discs = [(0.1, 1.0, -0.25, 0.1, 1.0, 0.0, 0.0), (0.1, 2.0, 0.0, 0.1, 0.0, 0.0, 0.0)]
    agree(scene(discs, mu=0.3, duration=0.1))


@pytest.mark.slow
def test_impacts_that_accumulate_without_a_known_end_are_reported():
    """A disc rattles between ground and another disc, which bounces on the ground itself."""
    apart = 0.3, 2.069987185085996, 0.4615893205125288, 0.6833214045533877, 0.0, 0.0, 0.0
    last = 0.3, 0.7822590123394563, 1.2464105392568574, 0.565679503465289, -0.3023057580652973, 0.0, -1.69070504475309
    case = scene(
        [(0.3, 2.3197613868558262, 0.0, 0.3, 0.0, 0.0, 0.0), apart, last], mu=0.2014002487, e=0.5, duration=1.0
    )
    one, other = reference.simulate(case), predict(case)
    assert one.status == other.status == "accumulation" and "follow each other ever faster" in one.reason
    assert one.t[-1] == pytest.approx(other.end, abs=1e-4)


@pytest.mark.slow
def test_a_motion_of_several_plates_is_certified():
    certificate = certify(on_top(mu=0.5, duration=1.4))
    assert len(certificate.transitions) == 3 and "contact frame 1e-13" in certificate.witnesses
    assert max(time.bar for *_, time, _ in certificate.transitions) < 1e-12
    assert certificate.samples["x of disc2"][-1].bar < 1e-11


# --- invalid cases ----------------------------------------------------------------------------------------------------


def test_several_plates_are_rejected_in_a_sentence():
    from adapters import exudyn

    assert refusal(exudyn, on_top(), "integrator") == "The integrator route does not support several plates (others)."
