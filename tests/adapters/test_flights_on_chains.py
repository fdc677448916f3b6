"""Plates that fly over tracks with corners: each scene that the reference simulates is run, or refused in one line."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import reference
from adapters import EngineFailure, refusal
from cases import (
    Case,
    CaseError,
    Chain,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Outline,
    Plate,
    Start,
    Unilateral,
    disc,
)

from .engines import play

TRACKS = {
    "edge": Chain.polyline([(-0.5, 0.0), (0.0, 0.0), (0.0, -0.4)]),
    "notch": Chain.polyline([(-2.0, 1.0), (0.0, 0.0), (2.0, 0.0)]),
    "steps": Chain.polyline([(-0.5, 0.0), (0.0, 0.0), (0.5, -0.2), (1.0, -0.2)]),
    "room": Outline.polygon([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]),
}
GRIP = (Gravity(9.81), CoulombFriction(0.4), Unilateral(), Flight())


@cache
def scenes(track: Chain, count: int, seed: int) -> list[Case]:
    """Random scenes on a track that the reference simulates: on it and above it, with impacts and without."""
    numbers, result = np.random.default_rng(seed), list[Case]()
    for _ in range(20 * count):
        plate, place = (
            (disc(0.1, 1.0), {}) if numbers.random() < 0.7 else (Plate.rectangle(0.2, 0.1, 1.0), {"xi2": 0.5})
        )
        effects = (*GRIP, Impact(0.3)) if numbers.random() < 0.5 else GRIP
        start = dict(xi1=float(numbers.uniform(*track.span)), omega=float(numbers.uniform(-5.0, 5.0)))
        try:
            case = Case(track, plate, effects, Start(**start, **place, gap=0.05 * float(numbers.integers(2))), 0.4)
            reference.simulate(case)
        except CaseError:
            continue
        result.append(case)
        if len(result) == count:
            break
    return result


@pytest.mark.parametrize("name", ["pymunk", "box2d", "pybullet", "exudyn"])
@pytest.mark.parametrize("track", TRACKS)
def test_a_scene_is_run_or_refused(track, name):
    adapter = pytest.importorskip(f"adapters.{name}")
    for case in scenes(TRACKS[track], 2, seed=len(track)):
        for route in adapter.routes:
            reason = refusal(adapter, case, route)
            if reason:
                assert reason.endswith(".") and ". " not in reason
                continue
            try:
                motion = play(name, route, case, 0)
            except EngineFailure as failure:
                pytest.fail(f"{case.label} at {case.start}: {failure}")
            assert len(motion.t) >= 2


def test_a_disc_dropped_on_a_chain_lands_when_it_falls_to_it():
    case = Case(TRACKS["notch"], disc(0.1, 1.0), GRIP, Start(xi1=3.9, gap=0.05), 0.4)
    motion = play("pymunk", "native", case, 2)
    # A fall of 0.05 m, within two steps of 2 ms.
    assert motion.status == "landing" and motion.t[-1] == pytest.approx((2 * 0.05 / 9.81) ** 0.5, abs=4e-3)
