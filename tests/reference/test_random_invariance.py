"""Random smooth tracks, plates and starts: the motion is the same in a mirror, turned, in other units and by other
parameters, by both methods."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import reference
from cases import (
    Case,
    CaseError,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Mode,
    Plate,
    Start,
    Trajectory,
    Unilateral,
    disc,
    library,
)
from tests.scenes.elliptic import examples, numbers
from tests.scenes.motions import in_other_parameters, in_other_units, mirrored, warped

SWAPPED = {Mode.SLIP_FORWARD: Mode.SLIP_BACKWARD, Mode.SLIP_BACKWARD: Mode.SLIP_FORWARD}
LENGTH, TIME, MASS = 10.0, 10.0, 10.0


def waves(a, k, p):
    return Curve(("s", f"0.05*s**2 + {a / k**2!r}*sin({k!r}*s + {p!r})"), (-4.0, 4.0))


def step(a, k, p):
    """Endless, with a step and a bump."""
    return Curve(("s", f"{a / k**2!r}*tanh({k!r}*(s - {p!r})) + {0.3 * a / k**2!r}*exp(-({k!r}*(s + {p!r}))**2)"))


def bowl(a, k, p):
    return library.ellipse(0.8 + 0.1 * a, 0.6 + 0.1 * p)


def scene(track, a, k, p, long, wide, mu, flies, restitution, xi1, slip, omega, gap) -> Case | None:
    """A plate on one of the tracks for 0.8 s; None where it does not fit there."""
    plate = disc(long, 1.3) if wide is None else Plate(library.ellipse(long, wide * long), 1.3, 0.3 * long**2)
    effects = [Gravity(9.81), Unilateral(), *([CoulombFriction(mu)] if mu else [])]
    if flies:
        effects += [Flight(), Impact(restitution, law="poisson")]
    try:
        start = Start(xi1, None if wide is None else 0.3, slip, omega, gap=gap if flies else 0.0)
        return Case(track(a, k, p), plate, tuple(effects), start, 0.8)
    except CaseError:
        return None


scenes = st.builds(
    scene,
    track=st.sampled_from([waves, step, bowl]),
    a=numbers(0.2, 2.0),
    k=numbers(1.0, 6.0),
    p=numbers(0.1, 1.0),
    long=numbers(0.05, 0.15),
    wide=st.none() | numbers(0.6, 0.9),
    mu=st.just(0.0) | numbers(0.02, 0.8),
    flies=st.booleans(),
    restitution=numbers(0.1, 0.8),
    xi1=numbers(-1.5, 1.5),
    slip=numbers(-2.0, 2.0),
    omega=numbers(-10.0, 10.0),
    gap=st.just(0.0) | numbers(0.01, 0.3),
)
powers = st.integers(-6, 6).map(float)
changes = st.fixed_dictionaries(
    dict(length=powers, time=powers, mass=powers, parameter=powers, turn=numbers(-3.0, 3.0))
    | dict(mirror=st.booleans(), warp=st.booleans())
)


def seen(case: Case, how: dict) -> Case:
    """The case in a mirror or not, turned, with other units of length, time, mass and of its parameters."""
    case = mirrored(case) if how["mirror"] else case
    case = warped(case) if how["warp"] else case
    case = in_other_units(case, LENGTH ** how["length"], TIME ** how["time"], MASS ** how["mass"], how["turn"])
    return in_other_parameters(case, 10.0 ** how["parameter"])


def events(motion: Trajectory, swapped: dict) -> list:
    pairs = [(t.before, t.after) for t in motion.transitions]
    return [motion.status, *((swapped.get(before, before), swapped.get(after, after)) for before, after in pairs)]


def times(motion: Trajectory) -> np.ndarray:
    return np.array([*(t.time for t in motion.transitions), motion.t[-1]])


def check(case: Case | None, how: dict, method: str) -> None:
    assume(case is not None)
    here, rough = both(case, method)
    assume(here.status not in ("unfinished",))
    # What happens must not hang on the digits that the tolerance leaves.
    assume(events(rough, {}) == events(here, {}))
    compare(case, here, rough, how, method)


def both(case: Case, method: str) -> tuple[Trajectory, Trajectory]:
    """The case's motion, and the same at a thousand times the tolerance."""
    here, rough = (reference.simulate(case, rtol=rtol, method=method) for rtol in (1e-12, 1e-9))
    return here, rough


def compare(case: Case, here: Trajectory, rough: Trajectory, how: dict, method: str) -> None:
    """Assert that the motion is the same in another description."""
    there = reference.simulate(seen(case, how), rtol=1e-12, method=method)
    assert events(there, SWAPPED if how["mirror"] else {}) == events(here, {}), there.reason
    time, sign = TIME ** how["time"], -1.0 if how["mirror"] else 1.0
    # Two motions at 1e-12 differ by no more than one at 1e-9 does from them, and by the rounding of the units.
    allowed = 1e-10 + np.abs(times(rough) - times(here))
    assert np.all(np.abs(times(there) / time - times(here)) <= allowed)
    looks = np.linspace(0.0, min(here.t[-1], there.t[-1] / time), 9)[:-1]
    own, wide, other = here(looks), rough(looks), there(looks * time)
    # At an instant that the two put on different sides of an impact velocities jump.
    near = np.min(np.abs(looks[:, None] - times(here)[None, :]), axis=1) > 1e-6
    off = np.abs(sign * other.omega * time - own.omega)[near]
    assert np.all(off <= 1e-7 * (1.0 + np.abs(own.omega[near])) + np.abs(wide.omega - own.omega)[near])


@pytest.mark.slow
@pytest.mark.parametrize("method", reference.METHODS)
@given(case=scenes, how=changes)
@examples(6, 200)
def test_a_random_motion_is_the_same_however_it_is_described(method, case, how):
    check(case, how, method)


SAMPLE = {
    # Track with its a, k and p; plate; friction; with flights and restitution; start.
    "millimetres, light": (
        scene(waves, 1.1, 2.0, 0.3, 0.1, None, 0.2, False, 0.0, -0.7, 0.4, -3.0, 0.0),
        dict(length=3.0, time=0.0, mass=-6.0),
    ),
    "kilometres, weak gravity": (
        scene(bowl, 0.9, 1.0, 0.5, 0.12, 0.8, 0.3, True, 0.4, -1.2, 0.5, 2.0, 0.1),
        dict(length=-3.0, time=2.0, mass=3.0),
    ),
    "strong gravity, heavy": (
        scene(step, 0.5, 3.0, 0.4, 0.08, None, 0.4, False, 0.0, -1.0, 0.3, -6.0, 0.0),
        dict(length=1.0, time=-3.0, mass=6.0),
    ),
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", SAMPLE)
def test_motions_are_the_same_in_other_units(name):
    case, units = SAMPLE[name]
    here, rough = both(case, reference.METHODS[0])
    assert here.status == "completed" and events(rough, {}) == events(here, {}) and here.transitions
    how = dict(parameter=0.0, turn=0.0, mirror=False, warp=False) | units
    compare(case, here, rough, how, reference.METHODS[0])
