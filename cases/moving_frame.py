"""The frame of a driven track: a case and its motions, seen from there and from the fixed frame.

In the track's frame the track rests, and a plate of mass m and inertia J at r moves as under the loads

    −m (Qᵀ c̈ + α̈ U r − α̇² r + 2 α̇ U ṙ)    and    −J α̈,

with the track's place c(t), its rotation Q by the angle α(t), and U, a quarter turn; the spin of a plate of infinite
inertia changes by −α̈ whatever forces act. Contact, slip and the contact's
forces along tangent and normal are the same in both frames.
"""

from __future__ import annotations

from dataclasses import fields, replace
from functools import lru_cache
from math import inf
from typing import Any

import numpy as np

from .contact import track_place
from .derivation import in_one_thread
from .effects import Drive, Effect, Gravity, Load
from .errors import BadValue
from .formulas import formula_symbols
from .formulas import late_sympy as sp
from .motion.trajectory import State, Trajectory
from .scene.case_class import Case
from .scene.free_plates import loads_of, plates_of, start_poses
from .scene.plate import Plate, SpinningPlate
from .scene.start_pose import StartPose


def relative_case(case: Case) -> Case:
    """The case as its track sees it: without Drive, with the loads of the track's motion; the case itself if its track
    is at rest."""
    drive = case.effect(Drive)
    return case if drive is None else _from_track(case, drive)


@lru_cache(maxsize=256)
def _from_track(case: Case, drive: Drive) -> Case:
    try:
        load, *loads = (
            _load(case, drive, plate, own) for plate, own in zip(plates_of(case), loads_of(case), strict=True)
        )
    except BadValue as problem:
        raise BadValue(
            f"the formulas of Drive and Load are too long together for the load in the track's frame ({problem}); give "
            "shorter ones, or a track that does not turn"
        ) from problem
    poses = start_poses(case)[1:].tolist()
    further = tuple(
        replace(other, plate=_plate_in_frame(other.plate, drive), start=StartPose(*pose), load=one)
        for other, pose, one in zip(case.others, poses, loads, strict=True)
    )
    others: list[Effect] = [e for e in case.effects if not isinstance(e, Drive | Load)]
    if drive.is_turning:
        others = [e for e in others if not isinstance(e, Gravity)]
    effects = (*others, *([load] if load else []))
    start = replace(case.start, omega=case.start.omega - drive.at(0.0).spin)
    return replace(case, plate=_plate_in_frame(case.plate, drive), effects=effects, start=start, others=further)


def _plate_in_frame(plate: Plate, drive: Drive) -> Plate:
    """The plate as the track sees it: one of infinite inertia turns against a track that turns."""
    return SpinningPlate(plate.outline, plate.mass, inf) if drive.is_turning and not plate.turns else plate


@in_one_thread
def _load(case: Case, drive: Drive, plate: Plate, own: Load | None) -> Load | None:
    """All loads on a plate in the track's frame, with its `own` in the fixed frame; None if there are none. Gravity is
    one of them if the track turns."""
    t, x, y, theta, vx, vy, omega = formula_symbols.MOTION
    X, Y, A, X1, Y1, A1, X2, Y2, A2 = drive.rates
    c, s = (sp.cos(A), sp.sin(A)) if drive.is_turning else (sp.Integer(1), sp.Integer(0))
    from_track = {
        x: X + c * x - s * y,
        y: Y + s * x + c * y,
        theta: theta + A,
        vx: X1 + c * vx - s * vy - A1 * (s * x + c * y),
        vy: Y1 + s * vx + c * vy + A1 * (c * x - s * y),
        omega: omega + A1,
    }
    gravity, mass = case.effect(Gravity), plate.mass
    fx, fy, moment = (e.subs(from_track, simultaneous=True) for e in own.expression) if own else (sp.Integer(0),) * 3
    if gravity and drive.is_turning:
        gx, gy = gravity.vector
        fx, fy = fx + mass * gx, fy + mass * gy
    along = c * fx + s * fy - mass * (c * X2 + s * Y2 - A2 * y - A1**2 * x - 2 * A1 * vy)
    across = c * fy - s * fx - mass * (c * Y2 - s * X2 + A2 * x - A1**2 * y + 2 * A1 * vx)
    if drive.is_turning:
        moment = moment - plate.inertia * A2 if plate.turns else -A2
    parts = [sp.sympify(part) for part in (along, across, moment)]
    return Load(*parts) if any(not part.is_zero for part in parts) else None


def in_track_frame(motion: Trajectory) -> Trajectory:
    """The motion of a driven case as its track sees it, with that case: for pictures and films of it."""
    if motion.case is None:
        raise BadValue("the motion has no case; give it one: dataclasses.replace(…, case=case)")
    return _in_frame(motion, relative_case(motion.case), _View(motion.case, motion, from_track=True))


def in_fixed_frame(case: Case, motion: Trajectory) -> Trajectory:
    """A motion of `relative_case(case)` in the fixed frame."""
    return _in_frame(motion, case, _View(case, motion, from_track=False))


def _in_frame(motion: Trajectory, case: Case, view: _View) -> Trajectory:
    others: dict[str, Any] = {f.name: getattr(motion, f.name) for f in fields(motion) if f.name not in _SAMPLES}
    dense = view if motion.dense is not None else None
    if motion.plate_columns is not None:
        others |= dict(plate_columns=view.plate)
    return Trajectory.on_demand(view.samples, **others | dict(case=case, dense=dense))


_SAMPLES = ("t", *State._fields)


class _View:
    """A motion of a case in one frame, as it is from the track's frame or from the fixed one: times (n,) ↦ State."""

    def __init__(self, case: Case, motion: Trajectory, from_track: bool):
        self.case, self.motion, self.from_track = case, motion, from_track

    def __call__(self, when: np.ndarray) -> State:
        return self.move(when, self.motion(when))

    def samples(self) -> tuple[np.ndarray, State]:
        """Times and states of the motion's own samples."""
        motion = self.motion
        return motion.t, self.move(motion.t, State(*(np.asarray(getattr(motion, name)) for name in State._fields)))

    def plate(self, name: str, times: np.ndarray | None) -> State:
        """One of the plates, as `plate_columns` of a Trajectory."""
        assert self.motion.plate_columns is not None
        return self.move(self.motion.t if times is None else times, self.motion.plate_columns(name, times))

    def move(self, when: np.ndarray, state: State) -> State:
        """The states in the other frame."""
        place = track_place(self.case, when)
        move, turn = (place.seen_from_track, -1) if self.from_track else (place.seen_from_outside, 1)
        x, y, vx, vy, omega = move(state.x, state.y, state.vx, state.vy, state.omega)
        return state._replace(x=x, y=y, theta=state.theta + turn * place.angle, vx=vx, vy=vy, omega=omega)
