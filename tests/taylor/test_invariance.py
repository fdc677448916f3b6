"""The same scene in a mirror, turned, in other units and by other parameters; the same motion whoever asks for it."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
import sympy as sp

import cases
import reference
from cases import Case, CoulombFriction, Curve, Flight, Gravity, Impact, Mode, Plate, Start, Unilateral, disc
from cases.library import ellipse, line
from reference.minimal.integrators import taylor
from tests.sampling import quick_every
from tests.scenes.motions import in_other_parameters, in_other_units, mirrored, warped

SWAPPED = {Mode.SLIP_FORWARD: Mode.SLIP_BACKWARD, Mode.SLIP_BACKWARD: Mode.SLIP_FORWARD}
G = Gravity(9.81), Unilateral()
BOUNCES = *G, CoulombFriction(0.3), Flight(), Impact(0.4)
WAVES = Curve(("s", "0.05*s**2 + 0.275*sin(2*s + 0.3)"), (-4.0, 4.0))
STEP = Curve(("s", "0.06*tanh(3*(s - 0.4)) + 0.017*exp(-(3*(s + 0.4))**2)"))
SCENES = {
    "ellipse": Case(ellipse(1.3, 0.9), disc(0.1, 1.0), (*G, CoulombFriction(0.2)), Start(-0.5), 2.0),
    "waves": Case(WAVES, disc(0.1, 1.3), (*G, CoulombFriction(0.2)), Start(-0.7, slip=0.4, omega=-3.0), 0.8),
    "bowl": Case(
        ellipse(0.89, 0.65), Plate(ellipse(0.12, 0.096), 1.3, 0.0043), BOUNCES,
        Start(-1.2, 0.3, slip=0.5, omega=2.0, gap=0.1), 0.8,
    ),
    "step": Case(STEP, disc(0.08, 1.3), (*G, CoulombFriction(0.4)), Start(-1.0, slip=0.3, omega=-6.0), 0.8),
    "bowling": Case(line(), disc(0.1, 1.0), (*G, CoulombFriction(0.1)), Start(0.0, slip=1.0), 1.0),
}  # fmt: skip


class Description(NamedTuple):
    """Another description of a case, the number of its units of time in a second, and the modes that it swaps."""

    of: Callable[[Case], Case]
    time: float = 1.0
    swaps: dict[Mode, Mode] = {}


DESCRIPTIONS = {
    "mirror": Description(mirrored, swaps=SWAPPED),
    "turned": Description(lambda case: in_other_units(case, 1.0, 1.0, 1.0, 0.7)),
    "micrometres": Description(lambda case: in_other_units(case, 1e6, 1.0, 1.0, 0.0)),
    "kilometres, light": Description(lambda case: in_other_units(case, 1e-3, 1.0, 1e-9, 0.0)),
    "milliseconds, heavy": Description(lambda case: in_other_units(case, 1.0, 1e3, 1e9, 0.0), 1e3),
    "parameters by the thousand": Description(lambda case: in_other_parameters(case, 1e3)),
    "uneven parameters": Description(warped),
}


@quick_every(4)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("how", DESCRIPTIONS)
def test_a_motion_is_the_same_however_it_is_described(how, name):
    case, (of, time, swaps) = SCENES[name], DESCRIPTIONS[how]
    here, there = (reference.simulate(one, rtol=1e-13) for one in (case, of(case)))
    assert there.status == here.status == "completed" and here.transitions
    assert [swaps.get(t.after, t.after) for t in there.transitions] == [t.after for t in here.transitions]
    assert [t.time / time for t in there.transitions] == pytest.approx([t.time for t in here.transitions], abs=1e-10)
    instants = np.linspace(0.0, 0.999 * case.duration, 20)
    sense = -1.0 if swaps else 1.0
    assert sense * time * there(time * instants).omega == pytest.approx(here(instants).omega, abs=1e-7)


@pytest.mark.parametrize("length", [1e3, 1e-3], ids=["millimetres", "kilometres"])
def test_the_papers_scene_in_other_units_has_the_same_digits(length):
    case = cases.load("disc_in_circle", mu=0.2)
    here, there = (reference.simulate(one, rtol=1e-13) for one in (case, in_other_units(case, length, 1.0, 1.0, 0.0)))
    assert len(here.transitions) == 4
    assert [t.time for t in there.transitions] == pytest.approx([t.time for t in here.transitions], rel=1e-12)
    instants = np.linspace(0.0, case.duration, 50)
    for quantity, unit in (("x", length), ("y", length), ("theta", 1.0)):
        expected = getattr(here(instants), quantity)
        assert getattr(there(instants), quantity) / unit == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("method", reference.METHODS)
def test_the_instants_asked_for_change_no_bit_of_the_motion(method):
    motion = reference.simulate(SCENES["ellipse"], rtol=1e-13, method=method)
    few, many = np.linspace(0.0, 2.0, 9), np.linspace(0.0, 2.0, 8001)
    for quantity in ("x", "theta", "omega", "slip", "normal_force"):
        in_company = getattr(motion(many), quantity)[::1000]
        assert np.array_equal(getattr(motion(few), quantity), in_company)
        assert np.array_equal(getattr(motion(few[::-1]), quantity)[::-1], in_company)
        assert [float(getattr(motion(float(t)), quantity)) for t in few] == in_company.tolist()


@pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")
def test_a_motion_is_the_same_to_its_last_bit_whatever_was_compiled_before(monkeypatch):
    case = cases.select("ellipse_on_line[mu=1]")[0]
    times, found = np.linspace(0.0, case.duration, 50), []
    for count in (99_900, *range(99_990, 100_000)):  # SymPy names its own symbols by a count, and sorts sums by names
        monkeypatch.setattr(sp.Dummy, "_count", count)
        taylor.integrators_of.cache_clear()
        found.append(np.array(reference.simulate(case, rtol=1e-11, method="taylor")(times)[:3]).tobytes())
    assert len(set(found)) == 1
