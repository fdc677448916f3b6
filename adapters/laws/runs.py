"""One run of a route for the laws of mechanics, and the scales of its error.

Tolerances. They follow from the rung that is run (the second finest) and from the case, never from measured errors:

- `kick`, a·h: the velocity that the case's accelerations give within one step of h. Every engine here is at least of
  first order, and a first-order step acts up to one step early or late.
- `loss`, ½ m (a h)²·T/h: the energy lost if every step removes a velocity a·h that it had added.
- `tilt`: the largest angle between the direction of a facet, or of a step, and the curve's: the turn of track and plate
  within a step, and 2π over the `vertices` or `facets` where the setting has them.
- `grain`: the force that corresponds to the rounding of velocities; engines in single precision define `ROUNDING`.
- `motion.slip_resolution`: the creep that a solver cannot distinguish from stick, as it reports.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, partial, wraps
from math import pi
from typing import Any

import numpy as np

from cases import Case, Load, NotSupported, Plate, Trajectory
from cases.motion.mechanics import gravity

from ..interface import Setting, other_laws, refusal
from .scenes import Draw, draw, scene

# Each engine's own tests use the finest rung; the one before costs half, and every tolerance follows it.
RUNG = -2
# Polygons of more vertices than this take minutes per run; such rungs are left out.
MOST_VERTICES = 500


class MissingQuantity(Exception):
    """The route does not report a quantity of the law, which the text names. The law is neither kept nor broken."""


@dataclass(frozen=True)
class Route:
    """One route of an adapter; `adapter` is a module or any object with an adapter's functions."""

    adapter: Any
    name: str

    # Selects the values that the scenes of the laws draw at random.
    seed: int = 0

    def draw(self, key: str) -> Draw:
        """The random values for one law or scene."""
        return draw(self.seed, key)

    def simulate(self, case: Case) -> LawRun:
        """The motion at the second-finest rung; raises NotSupported."""
        return _run(self.adapter, self.name, case)


@dataclass(frozen=True, eq=False)
class LawRun:
    """A motion, its case and setting, and the scales of its error (see the module)."""

    case: Case
    setting: Setting
    motion: Trajectory
    rounding: float  # relative, of the engine's numbers

    @property
    def forces(self) -> tuple[np.ndarray, np.ndarray]:
        """Normal and friction force, N; raises MissingQuantity if the route reports none."""
        for name in ("normal_force", "friction_force"):
            if not np.isfinite(getattr(self.motion, name)).any():
                raise MissingQuantity(f"it reports no {name.replace('_', ' ')}")
        return self.motion.normal_force, self.motion.friction_force

    @property
    def step(self) -> float:
        """The longest step between samples, s."""
        return float(np.max(np.diff(self.motion.t)))

    @property
    def speed(self) -> float:
        """The largest speed of the centre or, by spin, of the outline, m/s."""
        size = float(np.hypot(*self.case.plate.outline.point(0.0)))
        return float(np.max(np.hypot(self.motion.vx, self.motion.vy) + size * np.abs(self.motion.omega)))

    @property
    def bend(self) -> float:
        """The largest curvature of the traversed track, 1/m."""
        bends = np.abs(self.case.track.curvature(self.motion.xi1))
        return float(bends[np.isfinite(bends)].max(initial=0.0))

    @property
    def acceleration(self) -> float:
        """The acceleration, m/s²: by gravity, a load, the track's curvature and the distance of the centre of mass."""
        plate, load = self.case.plate, self._load
        pushed = (
            float(np.hypot(load[0], load[1]).max()) / plate.mass
            + float(np.abs(load[2]).max()) * plate.reach / plate.inertia
        )
        swing = float(np.abs(self.motion.omega).max()) ** 2 * (plate.reach - plate.inner)
        return float(np.hypot(*gravity(self.case))) + pushed + self.speed**2 * self.bend + swing

    @property
    def _load(self) -> np.ndarray:
        """The load's components at about a hundred samples, (3, n) in N and N m."""
        load, motion = self.case.effect(Load), self.motion
        some = slice(None, None, max(1, len(motion.t) // 100))
        columns = (motion.t, motion.x, motion.y, motion.theta, motion.vx, motion.vy, motion.omega)
        if load is None:
            return np.zeros((3, 1))
        return np.array([load.at(*map(float, row)) for row in zip(*(c[some] for c in columns), strict=True)]).T

    @property
    def kick(self) -> float:
        """The velocity that the acceleration gives in one step, m/s."""
        return self.acceleration * self.step

    @property
    def loss(self) -> float:
        """The energy lost if every step removes the velocity `kick`, J."""
        return 0.5 * self.case.plate.mass * self.kick**2 * float(self.motion.t[-1]) / self.step

    @property
    def grain(self) -> float:
        """The rounding of a force that is a difference of velocities over a step, N."""
        return 10 * self.rounding * self.case.plate.mass * self.speed / self.step

    @property
    def corners(self) -> float:
        """The part of `tilt` due to facets, rad."""
        setting = self.setting
        return sum(2 * pi / float(setting[name]) for name in ("vertices", "facets") if name in setting)

    @property
    def tilt(self) -> float:
        """The largest error of a direction, rad."""
        turn = self.speed * self.bend + float(np.abs(self.motion.omega).max())
        return turn * self.step + self.corners


@lru_cache(maxsize=64)
def _run(adapter, route: str, case: Case) -> LawRun:
    reason = refusal(adapter, case, route)
    if reason:
        raise NotSupported(reason)
    differences = other_laws(adapter, case, route)
    if differences:
        raise NotSupported("; ".join(differences))
    ladder = adapter.ladder(case, route)
    setting = [rung for rung in ladder if rung.get("vertices", 0) <= MOST_VERTICES][RUNG]
    model = adapter.build(case, route, setting)
    adapter.run(model)
    return LawRun(case, setting, adapter.read(model), getattr(adapter, "ROUNDING", float(np.finfo(float).eps)))


# A check of a law: what is compared, its error, the tolerance, and the suspects (see `hold`).
Check = tuple[Any, ...]
# A law as steps: it yields the cases to be run, is sent each run, and yields its checks.
Steps = Generator[Case | Check, LawRun, None]
MakeSteps = Callable[[Any], Steps]
Law = Callable[[Route], None]


# All laws by the name of their function, those in scenes with the scene's name in brackets.
LAWS: dict[str, Law] = {}


def law(name: str, scenes: Iterable[str] = (), key: str = "") -> Callable[[MakeSteps], Callable[..., None]]:
    """Add steps to `LAWS`: in each of the scenes or, without any, with values that are drawn for the key (default: the
    name). The law, a function of a route and a scene, raises AssertionError, which begins with the name, for the first
    check that fails."""

    def add(steps: MakeSteps) -> Callable[..., None]:
        @wraps(steps)
        def check(route: Route, scene: Case | None = None) -> None:
            todo = steps(scene or route.draw(key or name))
            with suppress(StopIteration):
                step = next(todo)
                while True:
                    if isinstance(step, Case):
                        step = todo.send(route.simulate(step))
                    else:
                        hold(name, *step)
                        step = next(todo)

        LAWS.update({f"{steps.__name__}[{own}]": partial(_in_scene, check, own) for own in scenes})
        return check if scenes else LAWS.setdefault(steps.__name__, check)

    return add


def _in_scene(check: Callable[..., None], name: str, route: Route) -> None:
    check(route, scene(name, route.seed))


def ease(plate: Plate) -> float:
    """The ratio of the contact point's velocity change to the centre's: 1 + m ρ²/J with the largest lever ρ."""
    return 1 + plate.mass * plate.reach**2 / plate.inertia


def hold(law: str, what: str, error, tolerance, suspect: str | Callable[[], str] = "") -> None:
    """Raise AssertionError, with the law's name, if the error exceeds its tolerance or is not finite.

    Error and tolerance are numbers or arrays. `suspect`: the parameters or effects that such an error points to, or a
    function that finds them.
    """
    error, tolerance = np.broadcast_arrays(np.abs(np.asarray(error, dtype=float)), tolerance)
    not_finite = ~np.isfinite(error - tolerance)
    if not_finite.any():
        raise AssertionError(f"{law}: {what} is no number ({not_finite.sum()} samples of {not_finite.size})")
    bad = error > tolerance
    if bad.any():
        at = int(np.argmax(error - tolerance))
        cause = suspect() if callable(suspect) else suspect
        raise AssertionError(
            f"{law}: {what} is off by {error.flat[at]:.3g}, allowed {tolerance.flat[at]:.3g} ({bad.sum()} samples)"
            + (f"; suspect {cause}" if cause else "")
        )
