"""The question: names, checks, geometry."""

import re
from math import nan, pi

import numpy as np
import pytest
from hypothesis import given, settings

import cases
from cases import (
    BadCurve,
    BadValue,
    Case,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Gravity,
    RollingResistance,
    Start,
    State,
    Trajectory,
    UnknownName,
    disc,
    lookup,
    registry,
)
from cases import curves as c
from cases.contact import find, follow, overlap, pose, slip_velocity, start_motion
from cases.curves.line_or_circle import as_circle, as_line
from cases.library import line
from reference import METHODS, simulate
from tests.scenes.elliptic import ellipse, elliptic_scenes


def one_sentence(error) -> str:
    text = str(error.value)
    assert text and "\n" not in text and len(text) < 300
    return text


@pytest.mark.parametrize("when", ["0.1", True, [False], b"0", None, 1j, [[0.1]], nan, "nan", 2.0, [0.5, -1e-9]])
def test_what_is_no_time_of_a_motion_is_refused(when):
    rest = Trajectory(t=np.array([0.0, 1.0]), **dict.fromkeys(State._fields, np.zeros(2)))
    with pytest.raises(BadValue) as error:
        rest(when)
    one_sentence(error)


@pytest.mark.parametrize(
    ("call", "kind", "says"),
    [
        (lambda: cases.load("disc_in_circel"), UnknownName, "disc_in_circle"),
        (lambda: cases.load("disc_in_circle", mew=1), UnknownName, "mu"),
        (lambda: cases.load("disc_in_circle", m=-1), BadValue, "greater than zero"),
        (lambda: cases.load("disc_in_circle", mu=nan), BadValue, "finite"),
        (lambda: cases.load("disc_in_circle", mu="0.1"), BadValue, "number"),
        (lambda: cases.load("disc_in_circle", r=1.5), DoesNotFit, "smaller plate"),
        (lambda: cases.load("disc_in_circle", duration=0), BadValue, "greater than zero"),
        (lambda: cases.load("disc_in_circle[mu]"), BadValue, "parameter=number"),
        (lambda: cases.load("disc in circle"), BadValue, "name[parameter=value"),
        (lambda: cases.load_file("no_such_file.py"), UnknownName, "no_such_file"),
        (lambda: CoulombFriction(0.3, mu_static=0.2), BadValue, "at least mu"),
        (lambda: Curve("circle"), BadCurve, "lambda s"),
        (lambda: Curve(lambda s: (s**2, s**3), domain=(-1, 1)), BadCurve, "cusp"),
        (lambda: Curve(lambda s: (s, 1 / s), domain=(-1, 1.3)), BadCurve, "finite"),
        (lambda: Curve(lambda s: (s, 0), domain=(1, -1)), BadValue, "smaller number first"),
        (lambda: Case(ellipse(1, 1), disc(0.1, 1.0), (Gravity,), Start(0.0), 1.0), BadValue, "brackets"),
        (lambda: Case(ellipse(1, 1), disc(0.1, 1.0), (Gravity(1), Gravity(2)), Start(0.0), 1.0), BadValue, "more than"),
        (lambda: Case(ellipse(1, 1), 0.1, (), Start(0.0), 1.0), BadValue, "Plate"),
    ],
)
def test_a_wrong_question_is_refused_in_one_sentence_that_says_what_to_change(call, kind, says):
    with pytest.raises(kind, match=re.escape(says)) as error:
        call()
    one_sentence(error)


@pytest.mark.parametrize(
    ("name", "parameters", "says"),
    [
        ("disc_in_circle", dict(mu=1e9), "PerfectlyRough"),
        ("at_any_size", dict(length=1e100), "m long"),
        ("at_any_size", dict(length=1e-100), "m long"),
        ("at_any_size", dict(mass=1e100), "mass of the plate"),
        ("at_any_size", dict(mass=1e-100), "mass of the plate"),
        ("disc_in_circle", dict(duration=1e100), "duration"),
    ],
)
def test_what_leaves_doubles_no_digits_is_refused_when_the_case_is_made(name, parameters, says):
    with pytest.raises(BadValue, match=re.escape(says)) as error:
        cases.load(name, **parameters)
    one_sentence(error)


@pytest.mark.parametrize(
    ("plate", "start", "effects", "says"),
    [
        (disc(0.1, 1.0, inertia=1e100), Start(0.0), (), "radius of gyration"),
        (disc(0.1, 1.0, inertia=1e-100), Start(0.0), (), "radius of gyration"),
        (disc(0.1, 1.0), Start(1e100), (), "from the origin"),
        (disc(0.1, 1.0), Start(0.0, slip=1e100), (), "slip of Start"),
        (disc(0.1, 1.0), Start(0.0, omega=1e100), (), "omega of Start"),
        (disc(0.1, 1.0), Start(0.0), (Gravity(1e100),), "g of Gravity"),
        (disc(0.1, 1.0), Start(0.0), (CoulombFriction(0.1, mu_static=1e9),), "mu_static"),
        (disc(0.1, 1.0), Start(0.0), (CoulombFriction(0.1), RollingResistance(1e100)), "arm"),
    ],
)
def test_each_enormous_number_is_named(plate, start, effects, says):
    with pytest.raises(BadValue, match=says) as error:
        Case(line(), plate, effects, start, 1.0)
    one_sentence(error)


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


def test_a_plate_that_fits_at_its_contact_but_not_elsewhere_is_refused():
    # Curvature allows contact at the flat side of the slot, but the disc is wider than the slot.
    with pytest.raises(DoesNotFit, match="overlaps"):
        Case(ellipse(3.0, 0.5), disc(0.6, 1.0), (), Start(xi1=-pi / 2), 1.0)


def test_labels_load_back_to_the_same_case():
    for name in cases.names():
        for case in cases.select(name):
            assert cases.load(case.label) == case
    third = cases.load("disc_in_circle", mu=1 / 3)
    assert cases.load(third.label) == third


def test_start_without_xi2_has_no_rotation():
    assert start_motion(cases.load("disc_in_circle", xi1=0.7)).theta == pytest.approx(0.0, abs=1e-15)
    assert start_motion(cases.load("disc_on_incline", slope=0.4)).theta == pytest.approx(0.0, abs=1e-15)


@given(elliptic_scenes)
@settings(max_examples=40, deadline=None)
def test_contact_is_found_again_from_the_pose_it_made(case):
    start = start_motion(case)
    found = find(case, start.x, start.y, start.theta, (start.xi1 + 0.02, start.xi2 - 0.02))
    assert (found.xi1, found.xi2) == pytest.approx((start.xi1, start.xi2), abs=1e-12)
    assert found.gap == pytest.approx(0.0, abs=1e-14)
    assert overlap(case, start.x, start.y, start.theta) is None


@given(elliptic_scenes)
@settings(max_examples=40, deadline=None)
def test_slip_of_the_start_is_read_back_from_its_velocities(case):
    s = start_motion(case)
    assert slip_velocity(case, s.x, s.y, s.vx, s.vy, s.omega, s.xi1) == pytest.approx(case.start.slip, abs=1e-12)


def test_gap_is_the_distance_by_which_a_plate_misses():
    case = cases.load("disc_in_circle")
    xi1, xi2, gap = follow(case, [0.9, 0.89, 0.91], [0.0, 0.0, 0.0], [0.0, 0.1, 0.1])
    assert gap == pytest.approx([0.0, 0.01, -0.01], abs=1e-14)
    assert xi1 == pytest.approx([0, 0, 0], abs=1e-12)
    assert xi2 == pytest.approx([0, -0.1, -0.1], abs=1e-12)


def test_tangent_angle_is_continuous_over_many_turns():
    s = np.linspace(-20, 20, 4001)
    angle = ellipse(1.2, 0.8).tangent_angle(s)
    assert np.abs(np.diff(angle)).max() < 0.1
    assert angle[-1] - angle[0] == pytest.approx(40, abs=1.0)


def test_pose_of_a_disc_in_a_circle_is_the_papers():
    case, xi1 = cases.load("disc_in_circle"), np.linspace(0, 9, 40)
    theta = 0.3 * xi1
    x, y, turned = pose(case, xi1, xi1 - theta)  # (35): ξ₂ = ξ₁ − θ
    assert turned == pytest.approx(theta, abs=1e-13)
    assert np.hypot(x, y) == pytest.approx(0.9 * np.ones(40), abs=1e-14)


def test_shapes_are_recognised_wherever_they_lie():
    assert as_line(Curve(lambda s: (1 + 3 * s, 2 - 4 * s))).direction == pytest.approx([0.6, -0.8])
    circle = as_circle(Curve(lambda s: (2 + 3 * c.cos(5 * s), 1 + 3 * c.sin(5 * s))))
    assert (circle.radius, *circle.centre, circle.left) == pytest.approx((3.0, 2.0, 1.0, True))
    assert as_circle(ellipse(1.0, 1.0 + 1e-9)) is None
    assert as_line(ellipse(1.0, 0.9)) is None
    assert as_line(Curve(("s", "1e-6*exp(-((s-0.3)/1e-4)**2)"), (-1, 1))) is None  # a bump between seventeen samples


def test_curves_of_one_structure_share_it_whatever_their_sizes():
    assert ellipse(1.25, 0.5).structure == ellipse(0.3, 7.0).structure
    assert ellipse(1.25, 0.5).constants == (1.25, 0.5)


def test_a_loaded_case_has_the_parameters_that_were_given_not_equal_ones_of_before():
    """0 equals -0.0 and 1 equals 1.0, so a cache of loaded cases could exchange them."""
    for values in ((0.0, -0.0, 0), (1, 1.0), (-0.0, 0.0)):
        assert [repr(cases.load("disc_in_circle", xi1=x).parameters["xi1"]) for x in values] == [*map(repr, values)]
    assert repr(cases.load("disc_in_circle", xi1=0.0, mu=0.1).parameters) != repr(
        cases.load("disc_in_circle", mu=0.1, xi1=0.0).parameters
    )


def test_a_case_of_a_user_s_file_is_made_at_each_load(tmp_path, monkeypatch):
    """Its function may read a file that has changed since."""
    monkeypatch.setattr(registry, "_entries", dict(registry._entries))
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
