"""Engines by the process protocol: the scene they are given, the motion they give, and every way to fail as a row."""

import json
import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import cases
import reference
from adapters import by_process, lookup
from adapters.by_process import engine as process
from adapters.by_process.scene_file import SCHEMA_FILE
from adapters.common import motion_file, motion_table
from adapters.common.facets import visible_span
from adapters.laws.law_process import AdapterProcess
from cases.contact import start_motion
from reports import export
from reports.running.tasks import find_truth, measure

PAGE = Path(__file__).parents[2] / "docs" / "process_protocol.md"
LINE = "disc_on_line[mu=0.1]"
node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


@pytest.fixture
def registered(tmp_path, monkeypatch):
    """Makes a text an executable and an engine; its name."""
    monkeypatch.setenv(lookup.EXECUTABLES, "")

    def make(name: str, text: str) -> str:
        file = tmp_path / name
        file.write_text(text)
        file.chmod(0o755)
        return lookup.register(file)

    return make


def example() -> str:
    """The engine on the page."""
    return PAGE.read_text(encoding="utf-8").split("```js\n")[1].split("```")[0]


def row(name: str, label: str = LINE, rung: int = 4):
    case = cases.load(label)
    setting = lookup.engine(name).ladder(case, "process")[rung]
    return measure(case, name, "process", setting, rung, find_truth(case))


# --- the scene --------------------------------------------------------------------------------------------------------


def strict(text: str):
    """JSON as the standard has it: without NaN and Infinity."""

    def refuse(word):
        raise ValueError(word)

    return json.loads(text, parse_constant=refuse)


def broken(value, form) -> str:
    """Where a value is not of its form: the few words of JSON Schema that the published form uses. "" if nowhere."""
    kinds = {"object": dict, "array": list, "string": str, "number": (int, float), "boolean": bool, "null": type(None)}
    allowed = form.get("type", list(kinds))
    allowed = [allowed] if isinstance(allowed, str) else allowed
    if not any(isinstance(value, kinds[kind]) and not (kind == "number" and value is True) for kind in allowed):
        return f"{value!r:.40} is no {allowed}"
    if ("const" in form and value != form["const"]) or ("enum" in form and value not in form["enum"]):
        return f"{value!r:.40} is not allowed"
    if isinstance(value, dict):
        missing = set(form.get("required", ())) - value.keys()
        strange = value.keys() - form.get("properties", {}).keys() if form.get("additionalProperties") is False else ()
        parts = [broken(part, form.get("properties", {}).get(name, {})) for name, part in value.items()]
        return ", ".join(filter(None, [*missing, *strange, *parts]))
    if isinstance(value, list):
        return ", ".join(filter(None, [broken(part, form.get("items", {})) for part in value]))
    return ""


@pytest.mark.parametrize(
    "name",
    [
        "disc_in_circle",
        "bouncing_disc",
        "tumbling_ellipse",
        "disc_off_ramp",
        "disc_on_free_hemisphere",
        "disc_on_free_wedge",
    ],
)
def test_a_scene_is_of_its_published_form_and_valid_json(name):
    case = cases.load(name)
    form = strict(SCHEMA_FILE.read_text(encoding="utf-8"))
    sent = strict(by_process.as_json({**by_process.scene(case), "setting": {"h": 0.1}}))
    assert not broken(sent, form)
    assert (sent["schema"], sent["version"]) == (by_process.SCHEMA, by_process.VERSION)
    further = {"FreePlates"} if case.others else set()
    further |= {"Polygons"} if name == "disc_on_free_wedge" else set()
    assert sent["effects"].keys() == {type(effect).__name__ for effect in case.effects} | further
    assert "transitions" not in sent and "status" not in sent  # the truth is not handed to an engine
    assert broken({**sent, "version": 1}, form) and broken({**sent, "effects": {"Magnet": {}}}, form)


def test_the_start_in_flight_is_null_where_it_has_no_value():
    sent = strict(by_process.as_json(by_process.scene(cases.load("bouncing_disc"))))
    bare = start_motion(cases.load("bouncing_disc"))._asdict()
    lost = {name for name, value in bare.items() if not np.isfinite(value)}
    assert {name for name, value in sent["start"].items() if value is None} == lost


def test_the_fixed_bodies_of_a_scene_are_lines_discs_and_facets_at_the_curve_s_mean_distance():
    def kinds(label: str) -> list[tuple[str, str]]:
        return [(one["name"], one["kind"]) for one in by_process.scene(cases.load(label))["solids"]]

    assert kinds("disc_on_line") == [("track", "line")] and kinds("disc_rolling_off_hill") == [("track", "disc")]
    assert kinds("disc_spinning_in_v") == [("track", "line"), ("right", "line")]
    (bowl,) = by_process.scene(cases.load("disc_in_circle"), facets=64)["solids"]
    x, y = np.array(bowl["x"]), np.array(bowl["y"])
    assert bowl["kind"] == "chain" and bowl["closed"] and len(x) == 65
    # Along each facet, evenly: its sagitta alone would be 1.2e-3 of the radius at its middle, 8e-4 in the mean.
    share = (np.arange(100) + 0.5) / 100
    along = np.hypot(*(np.outer(1 - share, v[:-1]) + np.outer(share, v[1:]) for v in (x, y)))
    assert np.mean(along) == pytest.approx(1.0, abs=2e-6) and np.ptp(along) > 1e-3


@pytest.mark.parametrize("name", ["disc_in_circle", "tumbling_ellipse"])
def test_geometry_for_other_programs_is_where_the_curves_are(name):
    case = cases.load(name)
    sent = by_process.scene(case)
    start = start_motion(case)
    mjcf = ElementTree.fromstring(sent["mjcf"])
    body = mjcf.find("worldbody/body")
    assert [float(v) for v in body.get("pos").split()] == pytest.approx([start.x, start.y, 0.0])
    assert float(body.find("inertial").get("mass")) == case.plate.mass
    # The front face of each box is a chord of the track, within its sagitta.
    for box in mjcf.findall("worldbody/geom")[::50]:
        x, y, _ = map(float, box.get("pos").split())
        angle, half = float(box.get("euler").split()[2]), float(box.get("size").split()[1])
        front = np.array([x - half * np.sin(angle), y + half * np.cos(angle)])
        samples = np.array(case.track.point(np.linspace(*visible_span(case), 30001))).T
        assert np.hypot(*(samples - front).T).min() < 1e-3
    sdf = ElementTree.fromstring(sent["sdf"])
    assert len(sdf.findall("world/model")) == 2
    assert bool(sdf.findall(".//cylinder")) is (case.plate.radius is not None)


def test_export_writes_the_same_scene_and_a_true_motion_that_is_judged_right(tmp_path):
    case = cases.load(LINE)
    files = {path.name: path for path in export.export(case, tmp_path)}
    sent = strict(files["scene.json"].read_text(encoding="utf-8"))
    assert sent.items() >= strict(by_process.as_json(by_process.scene(case))).items()
    assert sent["transitions"][0]["time"]["value"] == pytest.approx(1 / (3 * 0.1 * 9.81))
    motion = motion_file.trajectory_of(case, motion_table.read(files["motion.csv"]))
    exact = reference.simulate(case)(motion.t)
    assert np.abs(motion.x - exact.x).max() < 1e-12


def chord_error(points: dict[str, list[float]]) -> float:
    """The largest distance of a circle of radius 1 m from the chords of its points, in m."""
    x, y = (np.array(points[name]) for name in "xy")
    return float(1.0 - np.hypot(x[1:] + x[:-1], y[1:] + y[:-1]).min() / 2)


def test_points_sets_the_number_of_points_of_exported_curves(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    errors = {}
    for count in (251, 1001):
        export.run(["disc_in_circle", "--points", str(count), "--out", str(count)])
        scene = strict(Path(f"{count}/scene.json").read_text(encoding="utf-8"))
        assert len(scene["points"]["track"]["s"]) == count == len(scene["points"]["outline"]["s"])
        assert len(np.loadtxt(f"{count}/track.csv", delimiter=",", skiprows=1)) == count
        errors[count] = chord_error(scene["points"]["track"])
    assert errors[251] / errors[1001] == pytest.approx(16.0, rel=1e-3)  # the square of the number of chords


# --- an engine in another language ------------------------------------------------------------------------------------


@node
def test_the_engine_on_the_page_is_right_and_its_cost_is_what_it_says(registered):
    found = row(registered("my_engine", example()))
    assert (found.outcome, found.grade) == ("answered", "good"), found.reason
    assert abs(found.ledger[0].error) < 2e-3  # its step is 1e-3 s
    assert found.cost.cpu_s > 0.0 and found.cost.steps == round(cases.load(LINE).duration / found.setting["h"])


@node
def test_the_engine_on_the_page_refuses_what_it_does_not_know(registered):
    found = row(registered("my_engine", example()), "disc_in_circle[mu=0.2]")
    assert (found.outcome, found.reason) == ("unsupported", "Only discs on level lines are supported.")


@node
def test_the_laws_are_held_on_it(registered, tmp_path):
    registered("my_engine", example())
    with AdapterProcess(str(tmp_path / "my_engine")) as apart:
        assert apart.face == ("my_engine", ("process",))
        sent = {law: outcome for law, outcome, _ in apart.try_laws("process", ["friction_torque", "lift_off"])}
    assert sent["lift_off"] == "refused"


# --- every way to fail ------------------------------------------------------------------------------------------------

HEAD = "#!/bin/sh\n"
LIE = HEAD + (
    'cat > /dev/null; awk \'BEGIN { print "t,x,y,theta"; for (k = 0; k <= 1000; k++)'
    ' print k * 0.001 ",", k * 0.001 ", 0.1,", 0 }\'\n'
)


@pytest.mark.parametrize(("text", "outcome", "word"), [
    (HEAD + "kill -9 $$\n", "crashed", "SIGKILL"),
    (HEAD + "echo no licence >&2; exit 1\n", "crashed", "exit status 1: no licence"),
    (HEAD + "echo '###' >&2; echo out of memory >&2; yes | head -5000 >&2; echo the end >&2; kill -6 $$\n", "crashed",
     "ended by signal SIGABRT: out of memory … "),
    (HEAD + "echo Not a disc. >&2; exit 3\n", "unsupported", "Not a disc."),
    (HEAD + "exit 0\n", "crashed", "no motion"),
    (HEAD + "echo 't,x,y,theta'; echo '__import__(\"os\"),0,0,0'\n", "crashed", "not a finite number"),
    (HEAD + "echo hello\n", "crashed", "no column t, x, y, theta"),
    (LIE, "answered", "another sequence of modes"),
    (LIE + "echo '# cost cpu_s=-1'\n", "crashed", "cost makes no sense"),
    (LIE + "echo '# cost cpu_s=fast'\n", "crashed", "cost is no number"),
    (HEAD + "yes 0,0,0,0\n", "crashed", "wrote more than"),
])  # fmt: skip
def test_every_way_to_fail_is_a_row(registered, text, outcome, word, monkeypatch):
    monkeypatch.setattr(process, "MOST_BYTES", 2**20)
    found = row(registered("failing", text))
    assert found.outcome == outcome, found.reason
    assert word in found.reason
