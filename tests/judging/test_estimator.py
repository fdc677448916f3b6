"""How well transitions are read from samples like an engine's: the reading's own error is below the engine's.

The reference's motion is sampled at the engine's own times, and with what the engine does to velocities and forces. The
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
from reports.judging import ledger, slip_phases
from tests.adapters.engines import play
from tests.sampling import quick_every

SCENES = ("disc_in_circle[mu=0.1]", "disc_in_circle[mu=0.2]", "disc_in_parabola", "disc_in_ellipse")


@lru_cache(maxsize=4)
def scene(label: str) -> tuple[Case, Trajectory]:
    """The case and the reference's motion."""
    [case] = cases.select(label)
    # The parabola's last transition comes 3 ms before its end, too late for any reading from a handful of samples.
    case = replace(case, duration=min(case.duration, 1.9))
    return case, reference.simulate(case, rtol=1e-13)


def regularised(case: Case, exact: Trajectory, played: Trajectory, setting: Setting) -> Trajectory:
    """As exudyn samples: what sticks creeps, with the share of vreg that friction has of its bound."""
    state, mu = exact(played.t), _mu(case)
    # Where nothing presses (a release with N = 0) there is no friction to creep for.
    pressed = np.where(state.normal_force > 0.0, state.normal_force, np.inf)
    creep = -setting["vreg"] * np.clip(state.friction_force / (mu * pressed), -1.0, 1.0)
    sticks = np.abs(state.slip) <= setting["vreg"]
    return _given(played, state._replace(slip=np.where(sticks, creep, state.slip)))


def half_stepped(case: Case, exact: Trajectory, played: Trajectory, setting: Setting) -> Trajectory:
    """As pymunk samples: velocities live half a step after the poses, forces are means over the step around a pose."""
    from adapters.common.half_steps import rates_at_poses

    # The last pose has no half step after it within the exact motion.
    played = _cut(played, len(played.t) - 1)
    h = float(played.t[1] - played.t[0])
    state, before, after = (exact(np.maximum(played.t + shift, 0.0)) for shift in (0.0, -0.5 * h, 0.5 * h))
    sides = [np.column_stack([each.vx, each.vy, each.omega]) for each in (before, after)]
    rates = rates_at_poses(*sides, size=0.1)
    vx, vy, omega = rates.T
    slip = slip_velocity(case, state.x, state.y, vx, vy, omega, state.xi1)
    # The mean over the step, by Simpson's rule.
    names = ("normal_force", "friction_force")
    force = {n: (getattr(before, n) + 4 * getattr(state, n) + getattr(after, n)) / 6 for n in names}
    return _given(played, state._replace(vx=vx, vy=vy, omega=omega, slip=slip, **force))


def _mu(case: Case) -> float:
    friction = case.effect(CoulombFriction)
    assert friction
    return friction.mu


def _given(played: Trajectory, state: State) -> Trajectory:
    """The state as if the engine that `played` had given it."""
    return Trajectory(t=played.t, **state._asdict(), slip_resolution=played.slip_resolution)


def _cut(moved: Trajectory, count: int) -> Trajectory:
    return replace(moved, t=moved.t[:count], **{name: getattr(moved, name)[:count] for name in State._fields})


SAMPLED = {"exudyn": regularised, "pymunk": half_stepped}
# Rungs of the ladders, by solver and route: a middle one and a fine one.
RUNGS = {("exudyn", "native"): (3, 5), ("exudyn", "integrator"): (3, 5), ("pymunk", "native"): (3, 5),
         ("pymunk", "assisted"): (2, 5)}  # fmt: skip


def errors(exact: Trajectory, moved: Trajectory, mu: float) -> np.ndarray:
    """Errors of the transitions' times; fails unless each is found and none invented."""
    rows = ledger.match(exact.transitions, slip_phases.read_contact(moved, mu).transitions)
    assert [row.pairing for row in rows] == ["paired"] * len(exact.transitions)
    return np.array([row.error for row in rows])


@quick_every(5)
@pytest.mark.parametrize("rung", (0, pytest.param(1, marks=pytest.mark.slow)), ids=("middle", "fine"))
@pytest.mark.parametrize("label", SCENES)
@pytest.mark.parametrize(("name", "route"), RUNGS)
def test_reading_is_more_accurate_than_what_it_reads(label, name, route, rung, accuracy):
    adapter = pytest.importorskip(f"adapters.{name}")
    case, exact = scene(label)
    refusal = adapter.refuses(case, route)
    if refusal:
        pytest.skip(refusal)
    setting = adapter.ladder(case, route)[RUNGS[name, route][rung]]
    played = play(name, route, case, setting=setting)
    played = replace(played, t=np.minimum(played.t, exact.t[-1]))
    of_reading = np.abs(errors(exact, SAMPLED[name](case, exact, played, setting), _mu(case))).max()
    of_engine = np.abs(errors(exact, played, _mu(case))).max()
    # Measured: 1e-6 of the engine's error or less for exudyn and for pymunk's facets, up to a third for the second
    # order of pymunk assisted (the onset of slip, from forces that are means over a step).
    accuracy(case=case.label, solver="reading", route=f"of {name} {route}", error=of_reading,
             quantity=f"transitions, h = {setting['h']:g} (s)", tolerance=0.5 * of_engine)  # fmt: skip
