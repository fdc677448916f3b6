"""Starts in which a plate overlaps its track anywhere are rejected, however little it does."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cases import (
    Case,
    Chain,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Plate,
    Start,
    StartPose,
    Unilateral,
    disc,
    library,
)
from cases.contact.overlap_search import deepest_overlap
from cases.library import ellipse
from tests.sampling import quick_every

FLYING = (Gravity(9.81), Unilateral(), Flight())


def lobed(height: float, lobes: float) -> Plate:
    radius = f"({height!r}*cos({lobes!r}*s) + 0.1)"
    return Plate(Curve((f"{radius}*cos(s)", f"{radius}*sin(s)")), 1.0, 0.005)


def wavy(height: float, number: float, phase: float) -> Curve:
    return Curve(("s", f"{height!r}*sin({number!r}*s + {phase!r})"), (-1.0, 1.0))


# Flight 1758 over ripples: 64 lobes, and ripples of 0.1 µm by 0.15 mm. The pair of the start is 0.1 µm apart.
GAP, DEPTH = 1.1236753229814419e-07, 7.889252608766717e-07


@cache
def waves() -> Curve:
    return wavy(1.3510752204238006e-7, 42006.83074155321, 3.5523624667221463)


def start_of_lobes(gap: float) -> Case:
    start = Start(-0.1429113783724042, 0.7698956890117601, slip=1.0, gap=gap, gap_rate=-0.4)
    return Case(waves(), lobed(1.144054318356496e-6, 64.0), FLYING, start, 0.1)


def test_another_lobe_of_a_start_overlaps_by_a_micrometre():
    with pytest.raises(DoesNotFit, match="overlaps its track") as error:
        start_of_lobes(GAP)
    assert "\n" not in str(error.value)
    begun, outline = start_of_lobes(GAP + DEPTH + 1e-10).start, lobed(1.144054318356496e-6, 64.0).outline
    state = replace(begun, gap=GAP).motion(waves(), outline)
    deepest = deepest_overlap(waves(), outline, state.x, state.y, state.theta, begun.xi1)
    assert deepest is not None and -deepest.gap == pytest.approx(DEPTH, rel=1e-5)
    assert deepest.xi1 == pytest.approx(-0.143339588, abs=1e-9)


def closest(track: Curve, outline: Curve, start: Start) -> float:
    """The least height (m, negative inside) of the outline's points above a track y = f(x), by samples of the outline
    that are refined around the lowest ones."""
    begun = start.motion(track, outline)
    c, s = np.cos(begun.theta), np.sin(begun.theta)

    def height(xi2):
        u, v = outline.point(xi2)
        return begun.y + s * u + c * v - track.point(begun.x + c * u - s * v)[1]

    low, high = outline.span
    xi2 = np.linspace(low, high, 100_001)
    heights = height(xi2)
    lowest, wide = xi2[np.argsort(heights)[:500]], xi2[1] - xi2[0]
    for _ in range(10):
        grid = lowest[:, None] + wide * np.linspace(-1.0, 1.0, 9)
        heights = height(grid.ravel()).reshape(grid.shape)
        lowest, wide = grid[np.arange(len(lowest)), heights.argmin(axis=1)], wide / 4.0
    return float(heights.min())


@pytest.mark.parametrize("deep", (1e-9, 1e-6, 1e-4))
def test_a_corner_of_a_box_on_a_step_is_in_the_floor_below(deep):
    """The middle of a side of 0.2 m touches the step's edge at 1.2 rad: its end is 0.1 sin 1.2 m below the edge."""

    def on_step(height: float) -> Case:
        track = Chain.polyline([(-3.0, 0.0), (0.0, 0.0), (0.0, -height), (3.0, -height)])
        effects = Gravity(9.81), CoulombFriction(0.5), Unilateral()
        return Case(track, Plate.rectangle(0.2, 0.17, 1.0), effects, Start(4.2, xi2=0.1), 0.1)

    below = 0.1 * np.sin(1.2)
    on_step(below + deep)
    with pytest.raises(DoesNotFit, match=f"overlaps its track by {deep:g}"):
        on_step(below - deep)


@quick_every(3)
@pytest.mark.parametrize("seed", range(3))
def test_random_starts_over_ripples_are_rejected_if_and_only_if_they_overlap(seed):
    random = np.random.default_rng(seed)
    number = float(10 ** random.uniform(2, 4.3))
    # More bent than the plates: the pair of the start is seldom the nearest.
    track = wavy(float(10 ** random.uniform(1.5, 2.2) / number**2), number, float(random.uniform(0, 6)))
    plates = disc(0.1, 1.0), Plate(ellipse(0.1, 0.06), 1.0, 0.004), lobed(float(10 ** random.uniform(-7, -5)), 40.0)
    rejected = list[bool]()
    for plate in plates:
        for sign in (-1.0, 1.0):
            start = Start(float(random.uniform(-0.2, 0.2)), float(random.uniform(-3, 3)), gap=5e-3)
            # Above the first touch by a micrometre or less, or below it; the gap is not vertical.
            above = sign * float(10 ** random.uniform(-10, -6))
            for _ in range(5):
                height = closest(track, plate.outline, start)
                start = replace(start, gap=max(start.gap + above - height, 1e-9))
            height = closest(track, plate.outline, start)
            assert abs(height) > 1e-12, "this scene shows nothing: a rounding decides"
            try:
                Case(track, plate, FLYING, start, 0.1)
                rejected.append(False)
            except DoesNotFit as problem:
                assert "overlaps" in str(problem)
                rejected.append(True)
            assert rejected[-1] == (height < 0.0), (seed, height)
    assert any(rejected) and not all(rejected)


def test_a_small_plate_inside_another_one_overlaps_it():
    """No points of both outlines are nearest there: the disc is deeper inside than it is wide."""
    inside = FreePlate(disc(0.05, 1.0), StartPose(0.0, 0.5), "small")
    effects = Gravity(9.81), CoulombFriction(0.3), Unilateral(), Flight(), Impact(0.0)
    block = Plate.rectangle(0.5, 0.4, 1.0, radius=0.05)
    with pytest.raises(DoesNotFit, match="small/plate overlap"):
        Case(library.line(), block, effects, StartPose(0.0, 0.5), 1.0, others=(inside,))
