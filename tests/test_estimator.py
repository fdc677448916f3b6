"""How well transitions are read from samples like an engine's: the reading's own error is below the engine's.

The reference's motion is sampled at the engine's own times and with what the engine does to velocities and forces. The
transitions read from that would be exact but for the reading itself; beside it stands what the engine itself got.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import cases
import reference
from adapters import Setting
from cases import Case, CoulombFriction, State, Trajectory
from cases.contact import slip_velocity
from reports import metrics

SCENES = ("disc_in_circle[mu=0.1]", "disc_in_circle[mu=0.2]", "disc_in_parabola", "disc_in_ellipse", "ellipse_in_circle")


@lru_cache(maxsize=8)
def scene(label: str) -> tuple[Case, Trajectory]:
    """The case and the reference's motion."""
    [case] = cases.select(label)
    return case, reference.simulate(case, rtol=1e-13)


def regularised(case: Case, exact: Trajectory, played: Trajectory, setting: Setting) -> Trajectory:
    """As exudyn samples: what sticks creeps, with the share of vreg that friction has of its bound."""
    state = exact(played.t)
    mu = case.effect(CoulombFriction).mu
    # Where nothing presses (a release with N = 0) there is no friction to creep for.
    pressed = np.where(state.normal_force > 0.0, state.normal_force, np.inf)
    creep = -setting["vreg"] * np.clip(state.friction_force / (mu * pressed), -1.0, 1.0)
    sticks = np.abs(state.slip) <= setting["vreg"]
    return motion(played, state._replace(slip=np.where(sticks, creep, state.slip)))


def half_stepped(case: Case, exact: Trajectory, played: Trajectory, setting: Setting) -> Trajectory:
    """As pymunk samples: velocities are means of those half a step before and after, forces their difference."""
    h, last = float(played.t[1] - played.t[0]), float(exact.t[-1])
    state = exact(played.t)
    before, after = exact(np.maximum(played.t - 0.5 * h, 0.0)), exact(np.minimum(played.t + 0.5 * h, last))
    rates = [0.5 * (getattr(before, name) + getattr(after, name)) for name in ("vx", "vy", "omega")]
    rates = [np.concatenate([[getattr(state, name)[0]], rate[1:]]) for name, rate in zip(("vx", "vy", "omega"), rates, strict=True)]
    slip = slip_velocity(case, state.x, state.y, *rates, state.xi1)
    force = [0.5 * (getattr(before, name) + getattr(after, name)) for name in ("normal_force", "friction_force")]
    vx, vy, omega = rates
    return motion(played, state._replace(vx=vx, vy=vy, omega=omega, slip=slip, normal_force=force[0], friction_force=force[1]))


def motion(played: Trajectory, state: State) -> Trajectory:
    """The state as if the engine that `played` had given it."""
    return Trajectory(t=played.t, **state._asdict(), slip_resolution=played.slip_resolution)


SAMPLED = {"exudyn": regularised, "pymunk": half_stepped}


def errors(exact: Trajectory, moved: Trajectory, mu: float) -> np.ndarray:
    """Errors of the transitions' times; fails unless each is found and none invented."""
    rows = metrics.match(exact.transitions, metrics.read_transitions(moved, mu))
    assert [row.verdict for row in rows] == ["matched"] * len(exact.transitions)
    return np.array([row.error for row in rows])


@pytest.mark.parametrize("label", SCENES)
@pytest.mark.parametrize(("name", "route", "rungs"), [("exudyn", "assisted", (3, 4, 5)), ("exudyn", "native", (3, 4, 6)),
                         ("pymunk", "assisted", (2, 4, 5)), ("pymunk", "native", (3, 5))])
def test_reading_is_more_accurate_than_what_it_reads(label, name, route, rungs, accuracy):
    adapter = pytest.importorskip(f"adapters.{name}")
    case, exact = scene(label)
    refusal = adapter.refuses(case, route)
    if refusal:
        pytest.skip(refusal)
    mu = case.effect(CoulombFriction).mu
    for rung in rungs:
        setting = adapter.ladder(case, route)[rung]
        model = adapter.build(case, route, setting)
        adapter.run(model)
        played = adapter.read(model)
        played = replace(played, t=np.minimum(played.t, exact.t[-1]))
        of_reading = errors(exact, SAMPLED[name](case, exact, played, setting), mu)
        of_engine = errors(exact, played, mu)
        print(label, name, route, rung, of_reading, of_engine)
