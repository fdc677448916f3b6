"""Figures as data, and what both writers make of them: the same points, in the page and in files."""

import re
import xml.etree.ElementTree as ET
from math import nan

import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot as plt

import cases
from adapters import Setting
from cases import Mode, Transition
from cases.pictures.style import apply_style
from reports.analysis.verdict import SceneOffs
from reports.drawing import figure_files, figures, matplotlib_writer, svg_writer
from reports.drawing.style import STYLE, LineStyles
from reports.drawing.traces import Diagram, Panel, PlotAxis, Trace
from reports.judging.distances import Distance
from reports.judging.ledger import LedgerRow
from reports.judging.score import Score
from reports.running.records import Experiment, Run, Truth

CASE = cases.load("disc_in_circle", mu=0.2)
EVENT = Transition(0.5, Mode.SLIP_FORWARD, Mode.ROLL, "the slip velocity vanished")
TIMES = np.linspace(0.0, 1.0, 201)
NAMES = ("x", "y", "theta", "slip", "xi1", "xi2", "normal_force")
BAR = 1e-12
DEFAULT = Setting.of(rung="defaults")


@pytest.fixture(autouse=True)
def drawing():
    with matplotlib.rc_context(STYLE):
        yield
    plt.close("all")


def truth() -> Truth:
    samples = {"t": TIMES, **{name: np.maximum(0.5 - TIMES, 0.0) for name in NAMES}}
    return Truth("taylor", (EVENT,), (BAR,), Mode.SLIP_FORWARD, "completed", samples=samples, centre_bar=BAR)


def score(off: float) -> Score:
    return Score(abs(off), 0.0, abs(off), 0.0, 0.0, nan, 0.0, 1e-3, False)


def run(setting: Setting, error: float, solver: str = "one", rung: int = 1) -> Run:
    off = {"t": TIMES, **{name: np.full(len(TIMES), error) for name in (*NAMES, "angle")}}
    row = LedgerRow(1, EVENT.before, EVENT.after, EVENT.time + error, EVENT.time, error, "paired")
    return Run(
        CASE.label, solver, "native", setting, rung, "answered", first_mode=str(EVENT.before), ledger=(row,),
        distance=Distance(*6 * (abs(error),)), cost=cases.Cost(steps=100 * rung), off=off, score=score(error),
    )  # fmt: skip


def experiment(*runs: Run) -> Experiment:
    return Experiment((CASE,), {CASE.label: truth()}, runs)


# --- the data ---------------------------------------------------------------------------------------------------------


def test_the_headline_has_default_settings_and_not_the_finest():
    runs = run(DEFAULT, 0.04), run(Setting.of(h=1e-3), 1e-6, rung=2), run(DEFAULT, 1e-14, "reference")
    diagram = figures.headline(experiment(*runs), CASE)
    (whole,), (near, errors) = diagram.rows
    exact, line = whole.traces
    assert (exact.solver, line.solver) == ("", "one") and "default settings" in diagram.title
    assert np.allclose(np.array(line.y), np.maximum(0.5 - np.array(line.x), 0.0) + 0.04, atol=1e-9)
    # The first transition, 40 ms late, lies within the second panel.
    assert near.x.low < EVENT.time < EVENT.time + 0.04 < near.x.high < 1.0
    assert max(errors.traces[0].y) == pytest.approx(0.04)
    assert len(figures.with_defaults(experiment(run(Setting.of(file="mine.csv"), 0.01)), CASE.label)) == 1


def test_a_pile_of_discs_has_the_modes_of_the_contact_whose_slip_is_drawn():
    """Three contacts in one list of transitions said "slip v > 0" over a slip of −0.047 m/s."""
    from reports.running.tasks import find_truth

    case = cases.load("pile_of_discs", mu=0.08)
    certified = find_truth(case)
    spans = figures._spans(certified, (0.0, case.duration))
    contact = next(iter(certified.scales))
    assert spans[0].name.startswith(f"{contact}: ") and len(spans) == len(certified.scales[contact].phases) > 1
    slips = {span.name: np.interp(0.5 * (span.low + span.high), certified.samples["t"], certified.samples["slip"])
             for span in spans if "slip" in span.name}  # fmt: skip
    assert slips and all(("v > 0" in name) == (slip > 0.0) for name, slip in slips.items())


def test_default_settings_are_hollow_and_a_smaller_error_than_the_axis_is_an_arrow():
    runs = run(DEFAULT, 0.3), run(Setting.of(h=1e-3), 1e-3, rung=2), run(Setting.of(h=1e-4), 1e-9, rung=3)
    diagram = figures.against_steps(experiment(*runs), CASE)
    line, marks = diagram.rows[0][0].traces
    assert marks.hollow == {0} and line.x == [200, 300] and min(line.y) == figures.LEAST_OFF
    svg = str(svg_writer.svg(diagram, LineStyles([("one", "native")])))
    assert svg.count('class="arrow') == 1 and svg.count('class="mark') == 2 and svg.count('class="mark hollow') == 1
    assert figures.against_cost("case", []) is None


def test_each_scene_is_a_dot_with_its_address_and_the_median_is_named():
    offs = {("one", "native"): {c: SceneOffs(d, score(f)) for c, d, f in (("a", 0.5, 1e-8), ("b", 0.1, 0.01))},
            ("two", "native"): {"a": SceneOffs(nan, score(0.2))}}  # fmt: skip
    diagram = figures.strip(offs, lambda case: f"#{case}")
    (panel,) = diagram.rows[0]
    assert [name for _, name in panel.y.names] == ["one, default", "one, finest", "two, finest"]
    assert panel.traces[0].links == ["#b", "#a"] and panel.traces[0].pale == {0}
    assert [text for *_, text in panel.medians] == ["30 %", "0.5 %", "20 %"]
    svg = str(svg_writer.svg(diagram, LineStyles(offs)))
    assert svg.count("<a href=") == 5 and svg.count('class="arrow') == 1  # 1e-8 is beyond the axis
    assert figures.strip({}, str) is None


# --- the writers ------------------------------------------------------------------------------------------------------

LOOKS = LineStyles([("one", "native"), ("one", "other"), ("pymunk", "native")])
TWO = Diagram(
    "A title", "Words.",
    ((Panel(PlotAxis("steps", True), PlotAxis("off", True, is_percent=True),
            (Trace("one", "native", [1.0, 10.0, 100.0], [0.5, nan, 0.005], is_marked=True, tips=["<a>", "b", "c"]),
             Trace("pymunk", "native", [1.0, 100.0], [0.1, 0.2], label="pymunk"))),),),
)  # fmt: skip


def test_both_writers_draw_the_same_points_with_the_solvers_marker():
    svg = ET.fromstring(str(svg_writer.svg(TWO, LOOKS)))
    marks = [node for node in svg.iter() if node.get("class") == "mark"]
    assert len(marks) == 2 and {node.get("d") for node in marks} == {svg_writer._SHAPES[LOOKS.marker("one")]}
    assert [node.text for node in svg.iter("title")] == ["<a>", "c"]
    groups = [(g.get("data-solver"), g.get("data-route")) for g in svg.iter("g")]
    assert groups == [("one", "native"), ("pymunk", "native")]
    assert {"100 %", "10 %", "1 %", "0.1 %"} <= {node.text for node in svg.iter("text")}
    with apply_style():
        (ax,) = matplotlib_writer.draw(TWO, LOOKS).axes
    points = [(x, y) for line in ax.lines if line.get_marker() == LOOKS.marker("one") for x, y in line.get_xydata()]
    assert points == [(1.0, 0.5), (100.0, 0.005)]
    assert ax.get_title(loc="left") == "A title" and [text.get_text() for text in ax.texts] == ["pymunk"]


def test_a_line_is_interrupted_where_there_is_no_value_and_where_it_leaves_the_axes():
    trace = Trace("one", "native", [0.0, 1.0, 2.0, 3.0, 4.0], [0.0, nan, 1.0, 9.0, 1.0])
    diagram = Diagram("", "", ((Panel(PlotAxis(), PlotAxis(low=0.0, high=2.0), (trace,)),),))
    (path,) = re.findall(r'class="curve" d="([^"]*)"', str(svg_writer.svg(diagram, LOOKS)))
    assert path.count("M") == 3 and "nan" not in path


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_figure_is_well_formed_and_says_how_it_is_made(tmp_path):
    figure, ax = plt.subplots()
    ax.bar([0, 1], [1.0, nan])
    ax.plot([], [], "o")  # nothing to draw: a group without content
    ax.text(0.5, 0.5, "")
    drawn = figure_files.save(figure, tmp_path, "figure", "case", "Title", "Words")
    figure_files.embed_command(tmp_path, drawn, "python -m reports.build --case a<b")
    output = ET.parse(tmp_path / "figure.svg").getroot()
    assert "--case a<b" in next(child.text or "" for child in output if child.tag.endswith("desc"))


def test_text_stays_text_after_the_style_of_a_figure_ended(tmp_path):
    """The outlines of letters were most of the paper's figures."""
    with matplotlib.rc_context(STYLE):
        figure, ax = plt.subplots()
        ax.set_title("a title")
    with matplotlib.rc_context({"svg.fonttype": "path"}):
        figure_files.save(figure, tmp_path, "figure", "", "Title", "Words")
    assert ">a title<" in (tmp_path / "figure.svg").read_text()
