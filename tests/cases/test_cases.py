"""The question: names, checks, geometry."""

import pytest
from hypothesis import given, settings

import cases
from cases import Case, CoulombFriction, Curve, Flight, Gravity, Load, Start, Unilateral, disc, lookup, registry
from cases import curves as c
from cases.contact import find, overlap, start_motion
from cases.curves.line_or_circle import as_circle, as_line
from cases.library import line
from reference import METHODS, simulate
from tests.scenes.elliptic import ellipse, elliptic_scenes


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("parameters", [dict(mu=1e4), dict(length=5e-9), dict(length=5e9), dict(mass=1e-60)], ids=str)
def test_at_the_bounds_the_motion_is_still_the_papers(parameters, method):
    """At the largest and smallest sizes allowed the paper's disc keeps its four transitions and its parameters' digits;
    at the strongest friction allowed a disc keeps the three that it has at a tenth of it."""
    if "mu" in parameters:
        ours, plain = (
            simulate(cases.load("disc_in_circle", mu=mu), method=method)
            for mu in (parameters["mu"], parameters["mu"] / 10)
        )
        assert [t.after for t in ours.transitions] == [t.after for t in plain.transitions]
        return
    ours, plain = (simulate(cases.load("at_any_size", **p), method=method) for p in (parameters, {}))
    assert len(ours.transitions) == len(plain.transitions) == 4
    for one, other in zip(ours.transitions, plain.transitions, strict=True):
        assert one.xi1 == pytest.approx(other.xi1, abs=1e-9)


def test_labels_load_back_to_the_same_case():
    for name in cases.names():
        for case in cases.select(name):
            assert cases.load(case.label) == case
    third = cases.load("disc_in_circle", mu=1 / 3)
    assert cases.load(third.label) == third


@given(elliptic_scenes)
@settings(max_examples=40, deadline=None)
def test_contact_is_found_again_from_the_pose_it_made(case):
    start = start_motion(case)
    found = find(case, start.x, start.y, start.theta, (start.xi1 + 0.02, start.xi2 - 0.02))
    assert (found.xi1, found.xi2) == pytest.approx((start.xi1, start.xi2), abs=1e-12)
    assert found.gap == pytest.approx(0.0, abs=1e-14)
    assert overlap(case, start.x, start.y, start.theta) is None


def test_shapes_are_recognised_wherever_they_lie():
    assert as_line(Curve(lambda s: (1 + 3 * s, 2 - 4 * s))).direction == pytest.approx([0.6, -0.8])
    circle = as_circle(Curve(lambda s: (2 + 3 * c.cos(5 * s), 1 + 3 * c.sin(5 * s))))
    assert (circle.radius, *circle.centre, circle.left) == pytest.approx((3.0, 2.0, 1.0, True))
    assert as_circle(ellipse(1.0, 1.0 + 1e-9)) is None
    assert as_line(ellipse(1.0, 0.9)) is None
    assert as_line(Curve(("s", "1e-6*exp(-((s-0.3)/1e-4)**2)"), (-1, 1))) is None  # a bump between seventeen samples


def test_a_loaded_case_has_the_parameters_that_were_given_not_equal_ones_of_before():
    """0 equals -0.0 and 1 equals 1.0, so a cache of loaded cases could exchange them."""
    for values in ((0.0, -0.0, 0), (1, 1.0), (-0.0, 0.0)):
        assert [repr(cases.load("disc_in_circle", xi1=x).parameters["xi1"]) for x in values] == [*map(repr, values)]
    assert repr(cases.load("disc_in_circle", xi1=0.0, mu=0.1).parameters) != repr(
        cases.load("disc_in_circle", mu=0.1, xi1=0.0).parameters
    )


def test_a_case_of_a_user_s_file_is_made_at_each_load(tmp_path, catalogue):
    """Its function may read a file that has changed since."""
    file, radius = tmp_path / "reads.py", tmp_path / "radius.txt"
    file.write_text(
        "from pathlib import Path\nimport cases\n\n\n@cases.case\ndef reads_its_radius():\n"
        f"    return cases.load('disc_on_line', r=float(Path({str(radius)!r}).read_text()))\n"
    )
    registry.load_file(file)
    for size in (0.1, 0.2):
        radius.write_text(str(size))
        assert cases.load("reads_its_radius").parameters == {}
        assert cases.load("reads_its_radius").plate.outline.sizes[0] == pytest.approx(size)


def test_changes_on_a_command_line_are_parameters_of_the_case():
    name = lookup.case_name("disc_in_circle[xi1=0.5]")
    assert name.label(["mu=0.3"]) == "disc_in_circle[xi1=0.5,mu=0.3]"
    assert dict(name.one(["mu=0.3"]).parameters) == {"xi1": 0.5, "mu": 0.3}


def test_load_is_a_number_a_text_or_an_expression():
    t, *_, vx, _, omega = cases.effects.MOTION
    load = Load(fx="-0.5*vx + sin(2*t)", moment=-0.1 * omega)
    assert load.at(0.25, 0, 0, 0, 2.0, 0, 3.0) == pytest.approx([-1.0 + 0.479425538604203, 0.0, -0.3], abs=1e-15)
    assert load == Load(fx=-0.5 * vx + cases.curves.sin(2 * t), moment=-0.1 * omega)


def test_start_off_the_track_has_its_gap_and_its_point_its_velocity():
    case = Case(
        line(),
        disc(0.5, 2.0),
        (Gravity(9.81), CoulombFriction(0.2), Unilateral(), Flight()),
        Start(xi1=0.0, gap=0.3, gap_rate=0.7, slip=-0.2, omega=1.5),
        1.0,
    )
    start = start_motion(case)
    assert (start.x, start.y) == (0.0, 0.8)
    assert find(case, start.x, start.y, start.theta, (0.0, start.xi2)).gap == pytest.approx(0.3, abs=1e-15)
    # The lowest point of the disc moves with the centre and ω × arm, the arm being (0, −1/2).
    assert start.vx + 0.5 * start.omega == pytest.approx(-0.2, abs=1e-15)
    assert start.vy == pytest.approx(0.7, abs=1e-15)
