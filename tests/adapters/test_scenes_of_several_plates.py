"""The process protocol with several free plates: the scene, the motion that is read back, and engines that run it."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import cases
import reference
from adapters import by_process
from adapters.common import motion_file, motion_table
from cases import BadValue, DoesNotFit
from reports import compare, export


def test_a_scene_has_every_plate_with_its_start():
    sent = by_process.scene(cases.load("pile_of_discs"))
    further = sent["effects"]["FreePlates"]
    assert list(further) == ["second", "upper"]
    assert further["upper"]["start"] == dict(x=0.0, y=0.5 * (1 + 3**0.5), theta=0.0, vx=0.0, vy=0.0, omega=0.0)
    assert further["second"].items() >= dict(mass=1.0, inertia=0.125, radius=0.5).items()
    bodies = ElementTree.fromstring(sent["mjcf"]).findall("worldbody/body")
    assert [body.get("name") for body in bodies] == ["plate", "second", "upper"]
    names = [joint.get("name") for body in bodies for joint in body.findall("joint")]
    assert len(set(names)) == 9 and {"theta", "theta of upper"} <= set(names)
    models = ElementTree.fromstring(sent["sdf"]).findall("world/model")
    assert [model.get("name") for model in models] == ["track", "plate", "second", "upper"]
    hemisphere = by_process.scene(cases.load("disc_on_free_hemisphere"))
    assert hemisphere["plate"]["inertia"] is None and hemisphere["effects"]["FreePlates"]["upper"]["inertia"] > 0.0


def test_a_scene_has_the_corners_of_a_free_polygon():
    """About its centre of mass, a third of both sides from the right angle; the disc's radius stays."""
    effects = by_process.scene(cases.load("disc_on_free_wedge"))["effects"]
    assert effects["Polygons"].keys() == {"plate"} and effects["FreePlates"]["disc"]["radius"] == 0.1
    corners = effects["Polygons"]["plate"]["corners"]
    places = sorted(zip(corners["x"], corners["y"], strict=True))
    np.testing.assert_allclose(places, [(-2 / 3, -1 / 3), (-2 / 3, 2 / 3), (4 / 3, -1 / 3)], atol=1e-15)


def test_the_track_reaches_as_far_as_any_plate():
    case = cases.load("row_of_discs")
    far = replace(case, others=(replace(case.others[0], start=replace(case.others[0].start, x=40.0)), case.others[1]))
    assert max(by_process.scene(far)["points"]["track"]["x"]) > 40.0


def test_slip_is_that_of_the_place_where_friction_acts():
    """A disc rolls on the floor and overlaps it by 1 cm: it sticks in the middle of that, and its outline slips."""
    case = cases.load("row_of_discs")
    names = "t,x,y,theta,vx,vy,omega," + ",".join(
        f"{name} of {other.name}" for other in case.others for name in ("x", "y", "theta", "vx", "vy", "omega")
    )
    rest = ",".join(f"{other.start.x!r},{other.start.y!r},0,0,0,0" for other in case.others)
    rows = []
    for t in np.linspace(0.0, 0.2, 41).tolist():
        rows.append(f"{t!r},{-0.5 + t!r},{0.09 if t else 0.1},{-t / 0.095!r},1,0,{-1 / 0.095!r},{rest}")
    text = "\n".join([names, *rows])
    for head, slip in (("", -0.005 / 0.095), ("# lever = 0.5\n", 0.0)):
        motion = motion_file.trajectory_of(case, motion_table.parse(head + text, "motion.csv"))
        np.testing.assert_allclose(motion.contacts["plate/track"].slip[5:], slip, atol=1e-12)
    with pytest.raises(BadValue, match="lever is 2"):
        motion_file.trajectory_of(case, motion_table.parse("# lever = 2\n" + text, "motion.csv"))


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The true motion of a disc on a free disc, as `cases export` writes it; case and file."""
    case, folder = cases.load("disc_on_free_disc[mu=0.5]"), tmp_path_factory.mktemp("exported")
    return case, next(path for path in export.export(case, folder) if path.name == "motion.csv")


@pytest.mark.slow
def test_the_true_motion_is_read_back_with_a_pose_per_plate(exported):
    case, file = exported
    motion = motion_file.trajectory_of(case, motion_table.read(file))
    exact = reference.simulate(case)
    assert motion.plate_names == exact.plate_names and set(motion.contact_names) == set(exact.contact_names)
    for name in motion.plate_names:
        own, true = motion.plate(name), exact.plate(name)(motion.t)
        assert np.abs([own.x - true.x, own.y - true.y, own.theta - true.theta]).max() < 1e-10
    # Without forces, the gap shows the lift-off a sample late.
    assert "very good" in compare.compare(case, file).splitlines()[0]


@pytest.mark.slow
def test_the_true_motion_of_a_free_polygon_is_read_back(tmp_path):
    """Its export was rejected: a scene had discs only."""
    case = cases.load("disc_pushes_block")
    file = next(path for path in export.export(case, tmp_path) if path.name == "motion.csv")
    assert "excellent" in compare.compare(case, file).splitlines()[0]


def test_velocities_of_further_plates_are_differences_if_the_file_has_none(exported):
    case, file = exported
    table = motion_table.read(file)
    motion = motion_file.trajectory_of(case, table.drop(columns=["vx of upper", "vy of upper", "omega of upper"]))
    smooth = (motion.t > 0.65) & (motion.t < 0.7)
    # h² v''/6 of samples 0.65 ms apart, before it leaves the lower disc: 4e-6 m/s.
    assert np.abs(motion.plate("upper").vy[smooth] - table["vy of upper"][smooth]).max() < 1e-5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.drop(columns="theta of upper"), "no column 'theta of upper'"),
        (lambda table: table.assign(**{"x of upper": table["x of upper"] + 0.1}), "of upper, the centre of mass"),
        (lambda table: table.assign(**{"vx of upper": -table["vx of upper"]}), "vx of upper is not the rate of x"),
        (lambda table: table.assign(**{"theta of upper": 57.3 * table["theta of upper"]}), "theta of upper"),
    ],
)
def test_a_table_that_is_no_motion_of_all_plates_is_rejected(exported, change, message):
    case, file = exported
    with pytest.raises((BadValue, DoesNotFit), match=message):
        motion_file.trajectory_of(case, change(motion_table.read(file)))
