"""Sweeps: every row is what `simulate` says, verdicts are the analytic ones, and any stretch can be made by itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from matplotlib.figure import Figure

import cases
import reference
from cases import (
    Case,
    CaseError,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Plate,
    StartPose,
    Support,
    Unilateral,
    UnknownName,
    disc,
)
from cases.library import line
from cases.motion.mechanics import energy
from reference.paper.application import rolls_beyond, slip_end
from reference.sweeping import plan, table
from reference.sweeping.table import ARROW, BAD
from tests.sampling import quick_every

# Families with a mode, an end or an effect each that the others have not, and what is drawn of them. The last two
# differ in their curves from scenario to scenario.
FAMILIES = {
    "disc_in_circle": dict(mu="0.005:0.6", xi1="0:1.55"),
    "ellipse_in_circle": dict(mu="0.01:0.8", xi1="-2.8:-1.7", tilt="-0.5:0.5"),
    "disc_in_cosine": dict(mu="0.01:0.6", xi1="-1.4:-0.3"),
    "disc_rolling_to_rest": dict(v0="-2:2", mu="0.01:0.6", arm="0.001:0.02"),
    "disc_on_spring": dict(mu="0.02:0.3", stretch="0.05:0.4"),
    "disc_sliding_off_hill": dict(angle="0.1:0.8"),
    "disc_on_line": dict(v0="-3:3", mu="0.01:0.8", r="0.05:0.2"),
    "disc_in_circle[xi1=0]": dict(mu="0.005:0.6", R="0.5:2"),
}
FREE = (Gravity(9.81), Unilateral(), Flight(), Impact(0.3))
BALL = disc(0.1, 1.0)


@dataclass(frozen=True)
class Pull(ContactEffect):
    """A force of a package."""

    size: float

    def force(self) -> ContactForce:
        return ContactForce(across=-self.size)


def falling(*effects, plate: Plate = BALL, **more) -> Case:
    """A plate with impacts that falls 20 mm to a line, with effects and what else a case may have."""
    high = 0.1 if plate is BALL else 0.05
    return Case(line(), plate, (*FREE, *effects), StartPose(0.0, high + 0.02, vx=0.5), 0.3, **more)


def at_wall(mu: float) -> Case:
    return falling(CoulombFriction(mu), supports=(Support(Curve(("0.15", "s")), "wall"),))


def with_plate_ahead(mu: float) -> Case:
    return falling(CoulombFriction(mu), others=(FreePlate(BALL, StartPose(0.22, 0.1), "ahead"),))


def pulled(size: float) -> Case:
    return falling(CoulombFriction(0.2), Pull(size))


def by_slip_speed(mu: float) -> Case:
    return falling(CoulombFriction(f"{mu} + 0.1*exp(-v)"))


def on_shaken_table(rate: float) -> Case:
    return falling(CoulombFriction(0.2), Drive(x=f"0.01*sin({rate}*t)"))


def box(mu: float) -> Case:
    return falling(CoulombFriction(mu), plate=Plate.rectangle(0.2, 0.1, 1.0))


# Scenes that the rules on arrays do not know, with a parameter and its values.
GENERAL = {
    at_wall: dict(mu=[0.1, 0.3]),
    with_plate_ahead: dict(mu=[0.1, 0.3]),
    pulled: dict(size=[1.0, 4.0]),
    by_slip_speed: dict(mu=[0.1, 0.3]),
    on_shaken_table: dict(rate=[10.0, 20.0]),
    box: dict(mu=[0.1, 0.3]),
}
# s. Both integrate to 1e-10 by steps of their own; each is then within some 1e-12 of the truth, as simulate is.
APART = 1e-11


def differences(name: str, number: int, seed: int) -> tuple[list[str], float]:
    """Scenarios whose row is not what simulate says, and by how much times differ at most."""
    asked = plan(name, FAMILIES[name], "random", number, seed, rtol=1e-10)
    rows, wrong, apart = table.scenario_rows(asked, 0, number).to_pylist(), [], 0.0
    for row in rows:
        try:
            case = asked.make(**{axis.name: row[axis.name] for axis in asked.axes})
        except CaseError as problem:
            assert (row["outcome"], row["reason"]) == (BAD, str(problem))
            continue
        motion = reference.simulate(case, rtol=1e-10)
        sequence = ARROW.join(
            [*([motion.first_mode] if motion.first_mode else []), *(e.after for e in motion.transitions)]
        )
        if (row["sequence"], row["outcome"]) != (sequence, motion.status):
            wrong.append(f"{case.label}: {row['sequence']} ({row['outcome']}), not {sequence} ({motion.status})")
            continue
        times = [e.time for e in motion.transitions]
        apart = max([apart, *np.abs(np.subtract(row["times"], times))])
    return wrong, apart


@pytest.mark.parametrize("make", GENERAL, ids=lambda make: make.__name__)
def test_every_scene_can_be_swept(make):
    ((name, values),) = GENERAL[make].items()
    for row in reference.sweep(make, **{name: [*values, np.nextafter(values[-1], 9.0)]}).to_dict("records"):
        motion = reference.simulate(make(row[name]))
        changes = [f"{e.contact and f'{e.contact}: '}{e.after}" for e in motion.transitions]
        assert (row["outcome"], row["alone"]) == (motion.status, True)
        assert row["sequence"] == ARROW.join([motion.first_mode, *changes])
        assert [*row["times"]] == [e.time for e in motion.transitions] and row["end"] == motion.t[-1]
        ends = energy(motion.case, motion)[[0, -1]]
        assert [row["energy_start"], row["energy_end"]] == pytest.approx(ends, rel=1e-12)


@quick_every(3)
@pytest.mark.parametrize("name", [*FAMILIES][:4])
def test_rows_are_what_simulate_says(name, accuracy):
    wrong, apart = differences(name, 60, seed=1)
    assert not wrong
    accuracy(case=name, solver="sweep", route="waves", quantity="times against simulate", error=apart, tolerance=APART)


def verdicts(number: int, seed: int) -> tuple[int, int]:
    """How many sampled scenarios have the verdict of Coulomb's inequality at the exact first zero, and how many do not;
    those whose margin is below 1e-9 count as neither."""
    rows = reference.sweep("disc_in_circle", "sobol", number, seed, mu=(0.01, 0.6), xi1=(0.0, 1.5))
    right = wrong = 0
    for mu, xi1, sequence in zip(rows.mu, rows.xi1, rows.sequence, strict=True):
        margin = 3.0 * mu * np.tan(xi1) - 1.0
        expected = "roll" if margin > 0.0 else "slip_forward"
        if margin <= 0.0:
            end = slip_end(mu, xi1)
            margin = 1.0 - end.demand
            expected += f"{ARROW}roll" if margin > 0.0 else f"{ARROW}slip_backward"
        if abs(margin) > 1e-9:
            same = sequence.split(ARROW)[: expected.count(ARROW) + 1] == expected.split(ARROW)
            right, wrong = right + same, wrong + (not same)
    return right, wrong


def test_verdicts_are_those_of_the_inequality_at_the_exact_zero():
    right, wrong = verdicts(64, seed=3)
    assert (wrong, right) == (0, 64)


def test_a_grid_runs_its_last_parameter_fastest_and_every_sample_has_its_place():
    asked = plan("disc_in_circle", dict(mu="0.1:0.3:3", xi1="0.1:0.2:2"))
    assert len(asked) == 6
    columns = asked.columns(0, 6)
    assert columns["mu"].tolist() == pytest.approx([0.1, 0.1, 0.2, 0.2, 0.3, 0.3], abs=1e-15)
    assert columns["xi1"].tolist() == [0.1, 0.2] * 3
    for sample in ("grid", "random", "sobol"):
        vary = dict(mu="0.1:0.3:25:log", xi1="0:1:40") if sample == "grid" else dict(mu="0.1:0.3:log", xi1="0:1")
        asked = plan("disc_in_circle", vary, sample, None if sample == "grid" else 1000, seed=5)
        whole, piece = asked.columns(0, 1000), asked.columns(300, 417)
        for name, column in whole.items():
            assert np.array_equal(column[300:417], piece[name])
            assert np.ptp(column) > 0.0 and (0.0 if name == "xi1" else 0.1) <= column.min()
            assert column.max() <= (1.0 if name == "xi1" else 0.3 * (1 + 1e-15))


def test_parts_of_a_sweep_are_the_whole():
    asked = plan("disc_in_circle", dict(mu="0.05:0.3:12", xi1="0:1.5:12"))
    whole = table.scenario_rows(asked, 0, 144).drop_columns(["cpu_s"]).to_pylist()
    pieces = [row for a, b in ((0, 50), (50, 51), (51, 144)) for row in table.scenario_rows(asked, a, b).to_pylist()]
    for row, piece in zip(whole, pieces, strict=True):
        piece.pop("cpu_s")
        for name in ("times", "at_xi1", "at_xi2"):  # alone or in company, the last digits may differ
            assert row.pop(name) == pytest.approx(piece.pop(name), abs=APART)
        same = {name for name in row if name not in ("alone", "steps", "energy_start", "energy_end")}
        assert {n: row[n] for n in same} == pytest.approx({n: piece[n] for n in same}, abs=APART)


def test_a_bad_scenario_is_a_row_and_harms_no_other():
    rows = reference.sweep("disc_in_circle", r=[0.1, 0.2, 1.5, -0.1], mu=[0.1, -1.0])
    assert rows.outcome.tolist() == ["completed", BAD, "completed", BAD, BAD, BAD, BAD, BAD]
    assert (
        "does not fit" in rows.reason[4] and "greater than zero" in rows.reason[6] and "zero or more" in rows.reason[1]
    )
    assert rows.first_time.isna().tolist() == [False, True, False, True, True, True, True, True]


def test_a_branch_in_the_case_is_seen():
    """A function that does something else beyond some value is not taken for one that does the same."""

    def scene(mu=0.1, xi1=0.0):
        return cases.load("disc_in_circle", mu=mu, xi1=xi1, R=2.0 if 0.3 < mu < 0.301 else 1.0)

    rng = np.random.default_rng(0)
    mus = np.sort(rng.uniform(0.1, 0.5, 400))
    mus[123] = 0.3005
    rows = reference.sweep(scene, mu=np.unique(mus))
    there = rows[(rows.mu > 0.3) & (rows.mu < 0.301)]
    assert len(there) >= 1
    for mu, time in zip(there.mu, there.first_time, strict=True):
        assert time == pytest.approx(slip_end(mu).time * np.sqrt(1.9 / 9.81), abs=1e-9)


def test_certified_rows_have_error_bars():
    asked = plan("disc_in_circle", dict(mu=[0.1, 0.2]))
    (row,) = table.scenario_rows(asked, 0, 1, certified=True).to_pylist()
    assert len(row["error_bars"]) == len(row["times"]) and 0.0 < max(row["error_bars"]) < 1e-12


def test_the_boundary_of_the_application_is_where_the_paper_says():
    """Rolling follows beyond `rolls_beyond(μ₀)`: just above it rolls, just below it reverses."""
    for mu in (0.03, 0.1):
        edge = rolls_beyond(mu)
        rows = reference.sweep("disc_in_circle", mu=mu, xi1=[edge - 1e-8, edge + 1e-8])
        assert rows.first_after.tolist() == ["slip_backward", "roll"]


def test_a_sweep_draws_its_map():
    """A disc rolls on an incline where tan(slope) <= 3 mu, and slides without friction."""
    rows = reference.sweep("disc_on_incline", mu=np.array([0.0, 0.1, 0.2]), slope=np.array([0.1, 0.4]))
    picture = rows.plot_map()
    ax = picture.axes[0]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("mu", "slope")
    shown = ax.collections[0].get_array().reshape(2, 3).tolist()  # rows of slope, columns of mu
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert [[words[int(k)] for k in row] for row in shown] == [
        ["slide", "roll", "roll"],
        ["slide", "slip_forward", "roll"],
    ]
    assert rows[rows.mu > 0.0].plot_map("energy_end", ax=Figure().subplots()).get_xlabel() == "mu"
    with pytest.raises(UnknownName, match="energy_end"):
        rows.plot_map("energy")


def test_a_sweep_is_a_grid_of_xarray():
    pytest.importorskip("xarray")
    grid = reference.sweep("disc_on_incline", mu=np.array([0.1, 0.2]), slope=np.array([0.1, 0.4])).to_xarray()
    assert str(grid["sequence"].sel(mu=0.1, slope=0.4).item()) == "slip_forward"
