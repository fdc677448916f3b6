"""The form of every answer, whichever solver gave it. SI units; components along the track as in `cases.contact`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields
from enum import StrEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .errors import BadValue


class Mode(StrEnum):
    """What the contact does."""

    SLIDE = "slide"  # without friction
    SLIP_FORWARD = "slip_forward"  # the plate's point moves along the track's increasing parameter
    SLIP_BACKWARD = "slip_backward"
    ROLL = "roll"
    REST = "rest"  # neither slips nor turns: held by friction and rolling resistance
    FLIGHT = "flight"


@dataclass(frozen=True)
class Transition:
    """One change of mode: when (s), from what to what, where on the two curves, and why (one phrase)."""

    time: float
    before: Mode
    after: Mode
    xi1: float = np.nan
    xi2: float = np.nan
    cause: str = ""


@dataclass(frozen=True)
class Cost:
    """What an answer cost: seconds of CPU and wall for the run alone, set-up apart; steps and evaluations."""

    cpu_s: float = np.nan
    wall_s: float = np.nan
    setup_s: float = np.nan
    steps: int = 0
    evaluations: int = 0


class State(NamedTuple):
    """Everything at one instant (numbers), or at many (arrays of one length)."""

    x: np.ndarray | float
    y: np.ndarray | float
    theta: np.ndarray | float
    vx: np.ndarray | float
    vy: np.ndarray | float
    omega: np.ndarray | float
    slip: np.ndarray | float
    normal_force: np.ndarray | float
    friction_force: np.ndarray | float
    xi1: np.ndarray | float
    xi2: np.ndarray | float


# The columns of a trajectory.
_SAMPLES = ("t", *State._fields)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion, sampled at times `t` (increasing; two equal times mark both sides of a jump), arrays of one length.

    `x`, `y`, `theta`: pose of the centre of mass; `vx`, `vy`, `omega`: its velocities; `slip`: slip velocity along
    the track's tangent; `normal_force`, `friction_force`: along its left normal and tangent, NaN where a solver
    cannot tell; `xi1`, `xi2`: contact parameters. In flight there is no contact: both forces are 0, and slip and
    contact parameters NaN.
    `status` is "completed" or names what ended the motion early; `reason` says it in one sentence.
    `slip_resolution` (m/s) is the creep below which this solver cannot tell stick from slip (0: exact).
    `dense` maps a time or an array of times inside the range to a State; without it the samples are interpolated.
    """

    t: np.ndarray
    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omega: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    transitions: tuple[Transition, ...] = ()
    status: str = "completed"
    reason: str = "The motion ran to its end."
    cost: Cost = Cost()
    slip_resolution: float = 0.0
    first_mode: Mode | None = None
    dense: Callable[[np.ndarray], State] | None = field(default=None, repr=False)

    @classmethod
    def on_demand(cls, sample: Callable[[], tuple[np.ndarray, State]], **rest) -> Trajectory:
        """A trajectory whose samples, times and State, are made when one of them is first asked for; `rest`: all other
        fields. Who asks for its transitions alone does not pay for samples."""
        motion = object.__new__(cls)
        others = {f.name: f.default for f in fields(cls) if f.default is not MISSING}
        vars(motion).update(others | rest, _sample=sample)
        return motion

    if not TYPE_CHECKING:  # a checker knows the fields by their types

        def __getattr__(self, name):
            # Only what is not there comes here: samples on demand, or a mistake.
            sample = vars(self).get("_sample")
            if sample is None or name not in _SAMPLES:
                raise AttributeError(f"a {type(self).__name__} has no {name!r}", name=name, obj=self)
            times, state = sample()
            vars(self).update(state._asdict(), t=times)
            del vars(self)["_sample"]
            self.__post_init__()
            return vars(self)[name]

    def __getstate__(self) -> dict[str, Any]:
        """A trajectory travels and is kept with its samples."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def __post_init__(self):
        length = len(self.t)
        for name in State._fields:
            if np.shape(getattr(self, name)) != (length,):
                raise ValueError(f"{name} has shape {np.shape(getattr(self, name))}, t has ({length},)")

    def __call__(self, t) -> State:
        """The state at a time, or at each of an array (n,) of times; raises BadValue outside the motion's span and for
        what is no time."""
        try:
            times = np.asarray(t, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise BadValue(f"the time is {t!r}; give a number of seconds, or an array of them") from None
        if times.ndim > 1:
            raise BadValue(f"the times have shape {times.shape}; give a number, or an array of shape (n,)")
        if times.size and not (self.t[0] <= times.min() and times.max() <= self.t[-1]):
            raise BadValue(f"time {t} is outside the motion, which lasts from {self.t[0]:g} s to {self.t[-1]:g} s")
        state = (self.dense or self._interpolate)(np.atleast_1d(times))
        return State(*(float(np.asarray(v)[0]) for v in state)) if times.ndim == 0 else state

    def _interpolate(self, times: np.ndarray) -> State:
        """Pose by cubic Hermite interpolation with the velocities, everything else linearly."""
        from scipy.interpolate import CubicHermiteSpline

        keep = np.concatenate([np.diff(self.t) > 0, [True]])
        values = {name: np.interp(times, self.t[keep], getattr(self, name)[keep]) for name in State._fields}
        for name, rate in (("x", "vx"), ("y", "vy"), ("theta", "omega")):
            if keep.sum() > 1:
                spline = CubicHermiteSpline(self.t[keep], getattr(self, name)[keep], getattr(self, rate)[keep])
                values[name] = spline(times)
        return State(**values)
