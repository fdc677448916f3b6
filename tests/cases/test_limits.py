"""Every limit of the table: a scene that has it, the sentence, and what happens; and the page that is made from it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import inf, pi
from pathlib import Path

import pytest

import cases
import reference
from cases import (
    BadValue,
    Belt,
    Case,
    Chain,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Drive,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Outline,
    PerfectlyRough,
    Plate,
    RollingResistance,
    StartPose,
    Support,
    Unilateral,
    disc,
)
from cases.curves import cos, sin
from cases.library import line
from cases.scene.limits import LIMITS, Reason, Scope, limit, without_certificate
from cases.scene.limits_page import as_page, in_three_lines
from reference.narration import check

ROOT = Path(__file__).parents[2]
FREE = (Gravity(9.81, -pi / 2), Unilateral(), Flight(), Impact(0.0))
FRICTION, RESISTS = CoulombFriction(0.3), RollingResistance(0.01)
DISC, BLOCK = disc(0.5, 1.0), Plate.rectangle(1.0, 0.6, 1.0)
WALL = (Support(line(pi / 2), "wall"),)
ABOVE = (FreePlate(disc(0.5, 1.0), StartPose(3.0, 1.6), "upper"),)


@dataclass(frozen=True)
class Pull(ContactEffect):
    """A force of a package."""

    size: float = 1.0

    def force(self) -> ContactForce:
        return ContactForce(across=-self.size)


def scene(*effects, plate=DISC, track=None, without=(), start=None, **more) -> Case:
    """A plate just above a level line, that flies and lands, with further effects."""
    acting = tuple(e for e in FREE if not isinstance(e, without)) + effects
    pose = start or StartPose(3.0, 0.3 if plate.outline is BLOCK.outline else 0.5)
    return Case(track or line(), plate, acting, pose, 0.01, **more)


BLOCK_ABOVE = (FreePlate(BLOCK, StartPose(3.0, 2.0), "upper"),)
FIXED = replace(DISC, inertia=inf)
VALLEY = Chain.polyline([(-9.0, 3.0), (0.0, 0.0), (9.0, 3.0)])
RIDGE = Chain.polyline([(-9.0, -3.0), (0.0, 0.0), (9.0, -3.0)])
DOME = Curve(lambda s: (s, -0.05 * s * s), domain=(-9.0, 9.0))
BOWL = Curve(lambda s: (s, 0.05 * s * s), domain=(-9.0, 9.0))
# A half of an ellipse, whose side lies on top.
BOAT = Plate.homogeneous(
    Outline(
        [
            Curve(lambda s: (0.5 * cos(s), 0.3 * sin(s)), domain=(pi, 2 * pi)),
            Curve(lambda s: (0.5 - s, 0.0), domain=(0.0, 1.0)),
        ]
    ),
    1.0,
)
NOT_CONVEX = "several plates that are no smooth convex outlines, or discs and one convex polygon, on straight lines"
HOOK = Chain.polyline([(-0.5, 0.3), (-0.5, -0.3), (0.5, -0.3)])
# A scene for each limit, by its scope and feature: of several contacts once with a support and once by its track alone.
SCENES = {
    (Scope.ANY, "RollingResistance without CoulombFriction or PerfectlyRough"): lambda: scene(RESISTS),
    (Scope.ANY, "Belt without CoulombFriction or PerfectlyRough"): lambda: scene(Belt(1.0)),
    (Scope.ANY, "Flight without Unilateral"): lambda: scene(without=Unilateral),
    (Scope.ANY, "Impact without Flight"): lambda: scene(without=Flight),
    (Scope.ANY, "CoulombFriction with PerfectlyRough"): lambda: scene(FRICTION, PerfectlyRough()),
    (Scope.ANY, "Belt with RollingResistance"): lambda: scene(FRICTION, Belt(1.0), RESISTS),
    (Scope.ANY, "a plate of infinite inertia with RollingResistance"): lambda: scene(FRICTION, RESISTS, plate=FIXED),
    (Scope.SEVERAL_CONTACTS, "no Unilateral (a guide that pulls, too)"): lambda: scene(
        without=(Unilateral, Flight, Impact), supports=WALL
    ),
    (Scope.SEVERAL_PLATES, "no Unilateral or Flight"): lambda: scene(without=(Flight, Impact), others=ABOVE),
    (
        Scope.SHAPES,
        NOT_CONVEX,
    ): lambda: scene(plate=BLOCK, others=BLOCK_ABOVE),
    (Scope.SHAPES, "a plate of infinite inertia on a track that turns (angle of Drive)"): lambda: scene(
        Drive(angle="t"), plate=FIXED
    ),
    (Scope.SHAPES, "a track or support with edges"): lambda: scene(track=RIDGE, plate=BLOCK, start=StartPose(0.0, 0.5)),
    (Scope.SHAPES, "a track or support with corners"): lambda: scene(track=VALLEY, start=StartPose(0.0, 0.6)),
    (Scope.SHAPES, "supports, and a plate with corners that does not turn"): lambda: scene(
        plate=replace(BLOCK, inertia=inf), supports=WALL
    ),
    (Scope.SHAPES, "corners on a curve that bends away, but for convex polygons on closed hills"): lambda: scene(
        plate=BLOCK, track=DOME, start=StartPose(0.0, 0.4)
    ),
    (Scope.SHAPES, "an open outline, or one without a corner or arc that bulges"): lambda: scene(
        plate=Plate(HOOK, 1.0, 0.1), start=StartPose(0.0, 0.3)
    ),
    (Scope.SHAPES, "an outline with a round piece that is no arc of a circle"): lambda: scene(
        plate=BOAT, start=StartPose(0.0, 0.5)
    ),
    (Scope.SHAPES, "an outline with an arc that ends at a corner, on a curved track"): lambda: scene(
        plate=Plate.half_disc(0.5, 1.0), track=BOWL, start=StartPose(0.0, 0.6)
    ),
}


def rows(*scopes):
    some = [row for row in LIMITS if row.scope in scopes]
    return pytest.mark.parametrize("row", some, ids=[f"{row.scope}: {row.feature}" for row in some])


def test_every_limit_has_a_scene_here():
    keys = [(row.scope, row.feature) for row in LIMITS]
    assert len(keys) == len(SCENES) and set(keys) == SCENES.keys()


@rows(Scope.ANY, Scope.SEVERAL_CONTACTS, Scope.SEVERAL_PLATES)
def test_a_scene_with_a_limit_is_rejected_in_the_words_of_its_row(row):
    with pytest.raises(DoesNotFit if row.scope is Scope.ANY else BadValue) as output:
        SCENES[row.scope, row.feature]()
    assert row.matches(str(output.value))


@rows(Scope.SHAPES)
def test_a_scene_without_a_certificate_runs(row):
    case = SCENES[row.scope, row.feature]()
    assert row.matches(limit(case, row.scope))
    assert reference.simulate(case).status == "completed"


def test_a_block_that_does_not_turn_needs_contacts_that_only_push():
    """It is simulated in poses, where each contact only pushes: its weight on two held corners is not unique."""
    with pytest.raises(BadValue, match="bilateral guide with several contacts"):
        scene(plate=replace(BLOCK, inertia=inf), without=(Unilateral, Flight, Impact))


def test_the_check_of_a_case_says_that_its_motion_has_no_certificate():
    make = SCENES[Scope.SHAPES, NOT_CONVEX]
    text = "checked by its laws only, without a certificate: 'plate' and 'upper' are polygons; give smooth convex"
    assert text in check(make()) and "certificate" not in check(scene(plate=BLOCK))


@pytest.mark.parametrize("name", ["disc_in_circle", "sliding_box", "pile_of_discs", "ladder_at_wall"])
def test_a_certified_case_has_no_limit(name):
    assert not without_certificate(cases.load(name))


def test_the_page_and_the_readme_have_the_limits_of_the_table():
    page = (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")
    assert page == f"{as_page()}\n", "python -m cases.scene.limits_page > docs/limits.md"
    assert in_three_lines() in (ROOT / "README.md").read_text(encoding="utf-8"), (
        "give README cases.scene.limits_page's lines"
    )


def test_a_reason_by_mechanics_names_no_code():
    """And one that is not built yet says so in the page."""
    why = [row.why for row in LIMITS if row.reason is Reason.MECHANICS]
    assert why and not any(re.search("built|support|formulation|equation|solver", text) for text in why)
