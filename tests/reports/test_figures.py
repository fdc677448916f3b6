"""What figures show: default settings in the headline, a unit on each axis, no points that the truth cannot resolve."""

from dataclasses import replace
from math import nan

import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot as plt

import cases
from adapters import Setting
from cases import Cost, Curve, Mode, Transition, curves, library
from cases.pictures.plots import parameter_unit
from reference.sweeping import plan
from reports.analysis.work_precision import work_precision_rows
from reports.drawing import figures, work_precision_figure
from reports.drawing.figure_files import save
from reports.drawing.style import STYLE, LineStyles, logarithmic, looks_of
from reports.judging.distances import Distance
from reports.judging.ledger import LedgerRow
from reports.judging.score import Score
from reports.running.records import Experiment, Run, Truth
from reports.sweeping.parameter_units import parameter_label

from .test_work_precision import made

pytestmark = pytest.mark.builds

CASE = cases.load("disc_in_circle", mu=0.2)
EVENT = Transition(0.5, Mode.SLIP_FORWARD, Mode.ROLL, "the slip velocity vanished")
TIMES = np.linspace(0.0, 1.0, 201)
NAMES = ("x", "y", "theta", "slip", "xi1", "xi2", "normal_force", "friction_force", "lambda")
BAR = 1e-12


@pytest.fixture(autouse=True)
def drawing():
    with matplotlib.rc_context(STYLE):
        yield
    plt.close("all")


def truth() -> Truth:
    samples = {"t": TIMES, **{name: np.maximum(0.5 - TIMES, 0.0) for name in NAMES}}
    return Truth("taylor", (EVENT,), (BAR,), Mode.SLIP_FORWARD, "completed", samples=samples, centre_bar=BAR)


def run(setting: Setting, error: float, solver: str = "one", rung: int = 1) -> Run:
    off = {"t": TIMES, **{name: np.full(len(TIMES), error) for name in (*NAMES, "angle")}}
    row = LedgerRow(1, EVENT.before, EVENT.after, EVENT.time + error, EVENT.time, error, "paired")
    score = Score(abs(error), 0.0, abs(error), 0.0, 0.0, nan, 0.0, 1e-3, False)
    samples = {"t": TIMES, **{name: np.maximum(0.5 - TIMES, 0.0) + error for name in NAMES}}
    return Run(
        CASE.label, solver, "native", setting, rung, "answered", first_mode=str(EVENT.before), ledger=(row,),
        distance=Distance(*6 * (abs(error),)), cost=Cost(steps=100 * rung), samples=samples, off=off, score=score,
    )  # fmt: skip


def experiment(*runs: Run) -> Experiment:
    return Experiment((CASE,), {CASE.label: truth()}, runs, 0.0)


DEFAULT = Setting.of(rung="defaults")


def test_the_headline_shows_default_settings_not_the_finest():
    shown = experiment(run(DEFAULT, 0.04), run(Setting.of(h=1e-3), 1e-6, rung=2), run(DEFAULT, 1e-14, "reference"))
    figure = figures.headline(shown, CASE, looks_of(shown))
    above, near, below = figure.axes
    expected = np.interp(TIMES, TIMES, truth().samples["slip"]) + 0.04
    lines = [line.get_ydata() for line in above.lines if len(line.get_ydata()) == len(TIMES)]
    assert any(np.allclose(line, expected) for line in lines)
    assert not any(np.allclose(line, truth().samples["slip"] + 1e-6, atol=1e-7, rtol=0) for line in lines[1:])
    assert "default settings" in above.get_title(loc="left")
    # The first transition, 40 ms late, lies within the second panel.
    low, high = near.get_xlim()
    assert low < EVENT.time < EVENT.time + 0.04 < high < 1.0
    (error,) = [line.get_ydata() for line in below.lines if len(line.get_ydata()) > 3]
    assert np.nanmax(error) == pytest.approx(0.04)


def test_a_motion_without_default_settings_is_in_the_headline_too():
    shown = experiment(run(Setting.of(file="mine.csv"), 0.01))
    assert len(figures._with_defaults(shown, CASE.label)) == 1


def test_errors_that_the_truth_cannot_resolve_make_no_figure():
    inside = experiment(*(run(Setting.of(rtol=r), 0.3 * BAR, rung=i) for i, r in enumerate((1e-9, 1e-11, 1e-12), 1)))
    assert figures.errors(inside, CASE, looks_of(inside)) is None
    outside = experiment(*inside.runs, run(Setting.of(rtol=1e-6), 3.0 * BAR, rung=4))
    assert figures.errors(outside, CASE, looks_of(outside)) is not None


def test_a_legend_shows_the_markers_of_its_points():
    shown = experiment(run(DEFAULT, 0.1), run(Setting.of(h=1e-3), 1e-3, rung=2), run(Setting.of(h=1e-4), 1e-4, rung=3))
    (ax,) = figures.errors(shown, CASE, looks_of(shown)).axes
    (handle,) = ax.get_legend().legend_handles
    assert handle.get_marker() == looks_of(shown).marker("one", "native")


def test_a_map_of_many_cells_is_an_image_in_a_figure_of_paths(tmp_path):
    figure, ax = plt.subplots()
    ax.pcolormesh(np.arange(21.0), np.arange(21.0), np.arange(400.0).reshape(20, 20), rasterized=True)
    save(figure, tmp_path, "map", "", "", "")
    svg = (tmp_path / "map.svg").read_text()
    assert svg.count("<image ") == 1 and svg.count("<path") < 50


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("case", "track", "force"),
    [("disc_in_circle", "rad", "N/m"), ("disc_on_line", "m", "N"), ("disc_in_ellipse", "", "N/m")],
)
def test_each_axis_of_a_motion_has_its_name_and_its_unit(case, track, force):
    case = cases.load(case)
    shown = replace(experiment(), truths={case.label: truth()})
    labels = [ax.get_ylabel() for ax in figures.motion(shown, case, LineStyles([])).axes]
    assert labels[:4] == ["slip velocity / (m/s)", "error / (m/s)"] + [
        f"{name}{track and f' / {track}'}" for name in ("track parameter ξ₁", "error")
    ]
    assert f"multiplier λ / {f'({force})' if '/' in force else force}" in labels


@pytest.mark.parametrize(
    ("curve", "unit"),
    [
        (library.circle(0.3), "rad"), (library.line(0.2), "m"), (library.ellipse(1.0, 0.6), ""),
        (library.cosine(0.3, 2.0), "m"), (Curve(lambda s: (2 * s, 3 * s), domain=(0, 1)), ""),
        (Curve(lambda s: (0.3 * curves.cos(2 * s), 0.3 * curves.sin(2 * s))), ""),
    ],
)  # fmt: skip
def test_a_curves_parameter_is_in_radians_only_if_it_is_an_angle(curve, unit):
    assert parameter_unit(curve) == unit


@pytest.mark.parametrize(
    ("case", "parameter", "label"),
    [
        ("disc_in_circle", "xi1", "start on the track ξ₁ / rad"),
        ("disc_in_cosine", "xi1", "start on the track ξ₁ / m"),
        ("disc_in_ellipse", "xi1", "start on the track ξ₁"), ("disc_in_circle", "mu", "friction coefficient μ"),
        ("disc_on_line", "v0", "v0 / (m/s)"), ("disc_on_incline", "slope", "slope / rad"),
        ("disc_in_circle", "r", "r / m"), ("disc_in_circle", "g", "g / (m/s²)"), ("bouncing_disc", "e", "e"),
        ("disc_in_cosine", "wavenumber", "wavenumber"),
    ],
)  # fmt: skip
def test_a_map_labels_an_axis_by_the_unit_of_its_parameter(case, parameter, label):
    low = {"xi1": -0.9}.get(parameter, 0.05)
    assert parameter_label(plan(case, {parameter: [low, low + 0.03, low + 0.06]}), parameter) == label


def test_an_axis_of_less_than_two_decades_has_ticks_between_the_powers():
    _, ax = plt.subplots()
    logarithmic(ax, "x")
    ax.set_xlim(0.02, 0.9)
    texts = [ax.xaxis.get_major_formatter()(tick) for tick in ax.get_xticks() if 0.02 <= tick <= 0.9]
    assert texts == ["0.02", "0.05", "0.1", "0.2", "0.5"]
    ax.set_xlim(1e-6, 1.0)
    assert all(text.startswith(("10", "1", "0.1")) for text in map(ax.xaxis.get_major_formatter(), ax.get_xticks()))


def test_work_and_precision_are_of_whole_calls_and_have_no_panel_below_the_truths_error():
    shown, measured = made(("a", "s", 1e-7, 3.0))
    timings = {key: replace(timing, call_s=5.0) for key, timing in measured.timings.items()}
    points = work_precision_rows(shown, measured._replace(timings=timings))
    hidden = [p | {"below_floor": p["below_floor"] or p["quantity"] == "centre_rms"} for p in points]
    label = points[0]["case"]
    figure = work_precision_figure.case_figure(shown, label, hidden, looks_of(shown))
    titles = {ax.get_title(loc="left") for ax in figure.axes}
    assert "first transition's time" in titles and "centre, root mean square" not in titles
    places = [x for ax in figure.axes for line in ax.lines if line.get_marker() == "o" for x in line.get_xdata()]
    assert set(places) == {5.0}
    assert all("/" in ax.get_ylabel() or "share" in ax.get_ylabel() for ax in figure.axes if ax.get_title(loc="left"))


def test_the_profile_of_costs_is_of_whole_calls_and_states_the_number_of_cases():
    row = {"case": "c", "level": 0.01, "route": "r", "cpu_s": 1.0, "ratio": 1.0}
    rows = [row | {"solver": "a", "call_s": 1.0}, row | {"solver": "b", "call_s": 4.0}]
    assert work_precision_figure._ratios(rows) == {(0.01, "a", "r"): [1.0], (0.01, "b", "r"): [4.0]}
    (ax,) = work_precision_figure.summary(rows, LineStyles([("a", "r"), ("b", "r")])).axes
    assert ax.get_ylabel() == "share of the timed cases (n = 1)"
