"""Free flight of the second formulation, and its landing anywhere on outline and track.

The flight is integrated separately. Its landing is found by advancing stretches of the track (`advancement`), and then
by Newton's method for the time and both parameters together.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from .advancement import TooManyRounds
from .equations import ContactScene
from .pairs import Touch, nearest, polish
from .plate_motion import Motion, limits
from .steps import FrequencyLimitedDOP853, StepFailure, WorkBudget, WorkLimit
from .surroundings import Surroundings

# Between two searches no point of the plate moves farther than its reach times this, unless the track is farther away.
STRIDE = 1.0
# Farther away it moves by this part of its distance, so that it does not reach the track even at twice its speed.
FAR = 0.5

# A flight that begins on the track is first evaluated when the plate has moved by FIRST times its reach, or when OF_HOP
# of its hop is over; then at twice the time and so on while the gap is at most ROUNDINGS of a place, or at half the
# time if the gap has closed again; MOST_TRIES times at most.
FIRST, OF_HOP, ROUNDINGS, MOST_TRIES = 1e-3, 0.4, 256 * 2.0**-52, 100


class FreeFlight(NamedTuple):
    """A flight: its end, (x, y, θ, vx, vy, ω) there, and the touch that ended it, if any. A flight that reaches the
    limit on work ends where its last search began."""

    end: float
    body: list[float]
    touch: Touch | None


class FlightCourse:
    """A flight that is integrated step by step on demand and can be evaluated at any time so far."""

    def __init__(
        self,
        scene: ContactScene,
        t: float,
        body,
        end: float,
        rtol: float,
        steps_per_turn: int,
        work: WorkBudget,
    ):
        self.scene = scene
        self.rtol = max(rtol, 1e-13)
        # Without a load a flight is a parabola, for which no step is too long.
        pace = scene.flight_pace if scene.load else lambda t, body: 0.0
        self.solver = FrequencyLimitedDOP853(
            self.rates, t, np.array(body), end, pace=pace, steps_per_turn=steps_per_turn, work=work,
            features=scene.in_time,
            load_allows=scene.load_allows_flight if scene.load_scales else None, rtol=self.rtol, atol=1e-2 * self.rtol,
        )  # fmt: skip
        self.pieces: list[tuple[float, float, Callable]] = []
        self.nodes = [(t, np.array(body))]

    def rates(self, t: float, body) -> np.ndarray:
        ax, ay, spin = self.scene.pull(t, body)
        return np.array([body[3], body[4], body[5], ax, ay, spin * self.scene.m / self.scene.J])

    def until(self, t: float) -> None:
        """Integrate at least to time t."""
        solver = self.solver
        while solver.t < t:
            problem = solver.step()
            if solver.status == "failed" and solver.work.used_up:
                raise WorkLimit
            if solver.status == "failed":
                raise StepFailure(f"the second formulation's flight stopped at t = {solver.t:.9g} s: {problem}")
            self.pieces.append((solver.t_old, solver.t, solver.dense_output()))
            self.nodes.append((solver.t, solver.y.copy()))

    def __call__(self, t: float) -> list[float]:
        self.until(t)
        if t == self.nodes[0][0]:
            return self.nodes[0][1].tolist()
        piece = next(piece for piece in reversed(self.pieces) if piece[0] < t or piece is self.pieces[0])
        return piece[2](t).tolist()

    def states(self, times: np.ndarray) -> np.ndarray:
        """The states at several times within the integrated range, shape (6, n)."""
        if not self.pieces:
            return np.repeat(self.nodes[0][1][:, None], len(times), axis=1)
        which = np.searchsorted([piece[1] for piece in self.pieces[:-1]], times)
        values = np.empty((6, len(times)))
        for i in np.unique(which):
            values[:, which == i] = self.pieces[i][2](times[which == i])
        return values

    def exactly(self, t: float) -> list[float]:
        """The state at t by an integration that ends there: dense output is one order less accurate than a step."""
        start, body = next(node for node in reversed(self.nodes) if node[0] <= t)
        if t == start:
            return body.tolist()
        solution = solve_ivp(
            self.rates, (start, t), body, method="DOP853", rtol=self.rtol, atol=1e-2 * self.rtol, max_step=t - start
        )
        return solution.y[:, -1].tolist()


def fly(
    scene: ContactScene, around: Surroundings, t: float, body, end: float, rtol: float, steps_per_turn: int, hop: float,
    work: WorkBudget,
    place: tuple[float, float] | None,
) -> FreeFlight:  # fmt: skip
    """Integrate a free flight from a pose until the outline meets the track, at most until `end`.

    `steps_per_turn`: least number of steps per turn under a load; `place`: the contact's parameters, if the flight
    begins on the track; `hop`: its rough duration until it lands there again, s (inf: unknown).
    """
    course = FlightCourse(scene, t, body, end, rtol, steps_per_turn, work)
    before, opening, own = t, t, None
    try:
        if place is not None:
            opening, own = _opening(scene, course, around, t, end, hop, place)
            if own is None:
                return FreeFlight(t, list(body), Touch(t, list(body), *place, 0.0))
        while before < end and not work.used_up:
            work.count += 1
            now = course(before)
            away = around.away(*now[:2])
            stride = time_to_move(scene, before, now, around.reach, max(FAR * away, STRIDE * around.reach))
            after = min(max(before + stride, opening, float(np.nextafter(before, end))), end)
            touch = _between(around, course, before, after, opening, own, away)
            if touch is not None:
                touch = polish(scene.case, course.exactly, touch, around.size, t)
                return FreeFlight(touch.time, touch.body, touch)
            before, own = after, None
    except (WorkLimit, TooManyRounds):
        pass
    return FreeFlight(before, course(before), None)


def _between(
    around: Surroundings,
    course: FlightCourse,
    before: float,
    after: float,
    opening: float,
    own: tuple[float, float] | None,
    away: float,
) -> Touch | None:
    """The first touch between two times; on the stretch `own`, where the flight begins, only after `opening`. `away`:
    a lower bound on the distance from the track at first, m."""
    course.until(after)
    motion = Motion(course.states, np.array([time for time, _ in course.nodes]))
    bounds = limits(motion, before, after)
    if (bounds.speed + bounds.spin * around.reach) * (after - before) < away:
        return None
    x, y = course(before)[:2]
    some = around.near(x, y, around.reach + bounds.speed * (after - before))
    since = np.full(some.number, before)
    if own is not None:
        some, inside = around.inside(some, own)
        since = np.where(inside, opening, before)
    return around.search.first(motion, after, some, since)


def _opening(
    scene: ContactScene,
    course: FlightCourse,
    around: Surroundings,
    t: float,
    end: float,
    hop: float,
    place: tuple[float, float],
) -> tuple[float, tuple[float, float] | None]:
    """The time at which the gap of a flight from the track has opened, and the stretch of the track on which no other
    touch is possible until then; None if it does not open."""
    first = min(time_to_move(scene, t, course(t), around.reach, FIRST * around.reach), OF_HOP * hop, end - t)
    wait, longer = first, True
    for _ in range(MOST_TRIES):
        body = course(t + wait)
        rounding = ROUNDINGS * (around.reach + abs(body[0]) + abs(body[1]))
        pair = nearest(scene.case, body, *place)
        gap = pair.gap if pair is not None else -inf
        if pair is not None and (gap > rounding or (longer and t + wait >= end and gap >= -rounding)):
            low, high = sorted((place[0], pair.xi1))
            return t + wait, around.own((low, high), sorted((place[1], pair.xi2))) or around.at(low, high)
        if longer and abs(gap) <= rounding:
            wait = min(2.0 * wait, end - t)
        elif t + 0.5 * wait > t:
            wait, longer = 0.5 * wait, False
        else:
            break
    return t, None


def time_to_move(scene: ContactScene, t: float, body, reach: float, way: float) -> float:
    """The time (s) in which the plate's points cover a distance, with the present speed and acceleration."""
    ax, ay, spin = scene.pull(t, body)
    speed = hypot(body[3], body[4]) + abs(body[5]) * reach
    pull = hypot(ax, ay) + abs(spin) * scene.m / scene.J * reach
    root = sqrt(speed**2 + 2 * pull * way)
    return 2 * way / (speed + root) if root > 0.0 else inf
