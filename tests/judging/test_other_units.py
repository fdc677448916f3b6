"""Another parameter or another unit changes no judgement of the same motion: transitions, errors, laws, hints."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from adapters.common import motion_file, motion_table
from cases import Case, Trajectory, Transition
from reports.judging import diagnosis, distances, residuals, slip_phases, transitions, validation
from tests.sampling import quick_every
from tests.scenes.motions import in_other_parameters, in_other_units, motion_of, warped

# Quick ones, and others.
NAMES = [
    "disc_in_circle",
    *(pytest.param(name, marks=pytest.mark.slow) for name in ("disc_in_cosine", "disc_off_ramp", "ellipse_on_line")),
]
# The case otherwise, and its unit of length and of time.
OTHERWISE = {
    "parameter*1e6": (lambda case: in_other_parameters(case, 1e6), 1.0, 1.0),
    "parameter*1e-6": (lambda case: in_other_parameters(case, 1e-6), 1.0, 1.0),
    "warped parameter": (warped, 1.0, 1.0),
    "length*1e6": (lambda case: in_other_units(case, 1e6, 1.0, 1.0, 0.0), 1e6, 1.0),
    "length*1e-6": (lambda case: in_other_units(case, 1e-6, 1.0, 1.0, 0.0), 1e-6, 1.0),
    "time*1e6": (lambda case: in_other_units(case, 1.0, 1e6, 1.0, 0.0), 1.0, 1e6),
    "time*1e-6": (lambda case: in_other_units(case, 1.0, 1e-6, 1.0, 0.0), 1.0, 1e-6),
}
COUNT, LATE = 400, 1.0005


def as_an_engine_tells_it(truth: Trajectory) -> pd.DataFrame:
    """Samples of the true motion that run slow by a part in two thousand: poses and velocities."""
    t = np.linspace(0.0, 0.999 * truth.t[-1], COUNT)
    state = truth(t / LATE)
    names = (*motion_table.REQUIRED_COLUMNS[1:], "vx", "vy", "omega")
    return pd.DataFrame({"t": t, **{name: getattr(state, name) for name in names}})


def in_units(table: pd.DataFrame, length: float, time: float) -> pd.DataFrame:
    scale = dict(t=time, x=length, y=length, vx=length / time, vy=length / time, omega=1.0 / time)
    return table.assign(**{name: factor * table[name] for name, factor in scale.items()})


def judged(case: Case, table: pd.DataFrame, length: float, time: float):
    """Transitions and numbers without units, and sentences, of a table as it is judged."""
    truth = motion_of(case)
    motion = motion_file.trajectory_of(case, table)
    read: list[Transition] = list(transitions.read_motion(case, motion).transitions)
    own = distances.distance(distances.differences(motion, truth, case))
    units = dict(
        centre_max=length, centre_rms=length, final_pose=length, slip_max=length / time, slip_rms=length / time
    )
    numbers = [value / units.get(name, 1.0) for name, value in own._asdict().items()]
    gap = motion_file.follow_contact(case, motion_table.columns_of(table))[2]
    output = [*residuals.broken_laws(case, motion, gap), *validation.jumps(case, motion, truth, own.centre_max)]
    return [(t.before, t.after) for t in read], [t.time / time for t in read], numbers, len(output)


@quick_every(2)
@pytest.mark.parametrize("how", OTHERWISE)
@pytest.mark.parametrize("name", NAMES)
def test_a_motion_is_judged_alike_in_other_units_and_by_other_parameters(name, how):
    case = cases.select(name)[0]
    table = as_an_engine_tells_it(motion_of(case))
    change, length, time = OTHERWISE[how]
    modes, times, numbers, output = judged(case, table, 1.0, 1.0)
    other, when, others, tells = judged(change(case), in_units(table, length, time), length, time)
    assert (other, tells) == (modes, output) and modes
    # Zeros of polynomials through samples, whose digits round otherwise.
    assert when == pytest.approx(times, abs=1e-9)
    assert others == pytest.approx(numbers, rel=1e-7, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("time", [1e-6, 1.0, 1e6])
def test_a_velocity_that_is_none_is_noticed_in_every_unit_of_time(time):
    """A micrometre's disc slides at picometres per second in 1e6 s: below 1e-9 m/s everything was let pass."""
    case = in_other_units(cases.select("disc_on_line")[0], 1e-6, time, 1.0, 0.0)
    table = in_units(as_an_engine_tells_it(motion_of(cases.select("disc_on_line")[0])), 1e-6, time)
    motion_file.trajectory_of(case, table)
    with pytest.raises(cases.DoesNotFit, match="vx is not the rate of x"):
        motion_file.trajectory_of(case, table.assign(vx=-table.vx))


@pytest.mark.parametrize("time", [1e-12, 1.0, 1e9])
def test_a_slip_that_only_comes_near_zero_has_no_zero_in_any_unit_of_time(time):
    """Imaginary parts of roots were compared with a billionth of a second."""
    tau = time * np.linspace(-1.0, -0.02, 50)
    near = (tau / time - 0.5) ** 2 + 1e-8
    fits = slip_phases._windows(len(tau)).fits
    parabolas = np.array([degree == 2 for degree, rows in fits for _ in rows])
    assert np.isnan(slip_phases._zeros(tau, near, 2.0 * time)[parabolas]).all()
    meets = (tau / time - 0.5) * (tau / time - 2.0)
    assert slip_phases._zeros(tau, meets, 2.0 * time)[parabolas] == pytest.approx(0.5 * time)


def test_a_unit_is_noticed_of_a_plate_that_does_not_turn():
    """The rounding of its angle, over a turn of nothing, outweighed places that are a thousand times too large."""
    case = cases.select("disc_on_line")[0]
    sliding = replace(case, effects=tuple(e for e in case.effects if type(e).__name__ != "CoulombFriction"))
    truth = reference.simulate(sliding, rtol=1e-12)
    assert np.ptp(truth.theta) < 1e-9
    table = as_an_engine_tells_it(truth)
    noise = 1e-6 * np.random.default_rng(3).standard_normal(len(table))  # of single precision
    columns = motion_table.columns_of(table.assign(x=1e3 * table.x, theta=table.theta + noise))
    assert "x seems to be in millimetres" in diagnosis.pose_mistake(case, columns, truth)
