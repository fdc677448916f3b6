"""Lift-off, landing and rebound read from samples: closed forms, and the reference sampled like an engine."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

import cases
import reference
from cases import Mode, State, Trajectory
from reports import metrics, trial

G, FLIGHT, ROLL = 9.81, Mode.FLIGHT, Mode.ROLL
HEIGHT = 0.5
FALL = sqrt(2 * HEIGHT / G)


def bouncing(t: np.ndarray, e: float, forces: float = 0.0) -> Trajectory:
    """A point dropped from HEIGHT that bounces with restitution e, always in flight; `forces` everywhere."""
    y, vy = np.empty_like(t), np.empty_like(t)
    begins, speed = -FALL, G * FALL
    while begins <= t[-1] and speed > 1e-6:
        flight = 2 * speed / G
        inside = (t >= begins) & (t < begins + flight)
        y[inside] = speed * (t[inside] - begins) - 0.5 * G * (t[inside] - begins) ** 2
        vy[inside] = speed - G * (t[inside] - begins)
        begins, speed = begins + flight, speed * e
    zero, none = np.zeros_like(t), np.full_like(t, np.nan)
    state = State(zero, y, zero, zero + 1.0, vy, zero, none, zero + forces, zero, none, none)
    return Trajectory(t=t, **state._asdict())


def kinds(reading) -> list[tuple[Mode, Mode]]:
    return [(event.before, event.after) for event in reading.transitions]


@pytest.mark.parametrize("count", [40, 400, 4000])
def test_rebounds_are_read_where_the_paths_before_and_after_meet(count):
    t = np.linspace(0.0, 1.0, count)
    reading = metrics.read(bouncing(t, 0.8), 0.1)
    assert reading.first_mode is FLIGHT and kinds(reading) == [(FLIGHT, FLIGHT)] * 2
    # Gravity bends the path by g h²/2 within a gap, over the speed at which the two lines part.
    assert [event.time for event in reading.transitions] == pytest.approx([FALL, FALL + 1.6 * FALL], abs=t[1] ** 2)


def test_two_samples_of_one_time_are_an_impact_at_that_time():
    t = np.linspace(0.0, 0.6, 61)
    moved = bouncing(np.sort(np.append(t, FALL)), 0.8)
    twice = np.sort(np.append(np.arange(len(moved.t)), np.searchsorted(moved.t, FALL)))
    columns = {name: getattr(moved, name)[twice] for name in ("t", *State._fields)}
    at = int(np.searchsorted(columns["t"], FALL))
    columns["vy"][at] = -G * FALL  # as it flew there
    reading = metrics.read(Trajectory(**columns), 0.1)
    assert [event.time for event in reading.transitions] == [FALL]


def test_impact_of_some_duration_is_told_once_at_its_effective_instant():
    t = np.linspace(0.0, 0.6, 601)
    moved = bouncing(t, 0.8)
    hit = np.abs(t - FALL) < 4e-3
    normal = np.where(hit, np.nan, 0.0)
    columns = {name: getattr(moved, name) for name in State._fields} | {"normal_force": normal}
    reading = metrics.read(Trajectory(t=t, **columns), 0.1)
    assert kinds(reading) == [(FLIGHT, FLIGHT)]
    assert reading.transitions[0].time == pytest.approx(FALL, abs=1e-4)


def test_free_fall_has_no_transition():
    assert kinds(metrics.read(bouncing(np.linspace(0.0, 0.99 * FALL, 300), 0.8), 0.1)) == []


def test_rebounds_of_bouncing_that_comes_to_rest_are_not_listed():
    # It comes to rest at 3 FALL = 0.9578 s.
    t = np.linspace(0.0, 0.9575, 30_001)
    reading = metrics.read(bouncing(t, 0.5), 0.1)
    flights = np.diff([event.time for event in reading.transitions])
    # The flights halve from FALL on; those shorter than a thousandth of the motion are left out.
    assert flights == pytest.approx(FALL * 0.5 ** np.arange(len(flights)), abs=1e-5)
    assert 0.9575e-3 <= flights[-1] < 4 * 0.9575e-3


# Rebounds come closer and closer: the last ones are some gaps long. Measured worst errors, doubled.
SAMPLED = {"bouncing_disc[e=0.5]": 4e-4, "disc_across_circle": 2e-4, "tumbling_ellipse": 4e-4, "hopping_hoop": 1e-5}


@pytest.mark.parametrize("label", SAMPLED)
def test_flights_of_the_catalogue_are_read_from_three_thousand_samples(label, accuracy):
    [case] = cases.select(label)
    exact = reference.simulate(case, rtol=1e-12)
    t = np.linspace(0.0, exact.t[-1], 3000)
    reading = trial.read(case, Trajectory(t=t, **exact(t)._asdict()))
    assert reading.first_mode == exact.first_mode
    rows = metrics.match(exact.transitions, reading.transitions)
    assert [row.verdict for row in rows] == ["matched"] * len(exact.transitions)
    worst = max((row.error for row in rows), key=abs)
    accuracy(case=label, solver="reading", route="samples", quantity="transitions with flights (s)", error=worst,
             tolerance=SAMPLED[label])  # fmt: skip


@pytest.mark.parametrize(("name", "route"), [("exudyn", "native"), ("pymunk", "native")])
def test_bounces_of_an_engine_are_read_one_by_one(name, route, accuracy):
    adapter = pytest.importorskip(f"adapters.{name}")
    case = cases.load("bouncing_disc", e=0.5, duration=1.2)
    exact = reference.simulate(case, rtol=1e-12)
    model = adapter.build(case, route, adapter.ladder(case, route)[-2])
    adapter.run(model)
    reading = trial.read(case, adapter.read(model))
    rows = metrics.match(exact.transitions, reading.transitions)
    first = [row for row in rows if row.event <= 5]
    assert [row.verdict for row in first] == ["matched"] * 5
    accuracy(case=case.label, solver=name, route=route, quantity="first five impacts (s)", tolerance=5e-3,
             error=max((row.error for row in first), key=abs))  # fmt: skip
