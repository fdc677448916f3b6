"""Motions with several contacts from their start, or from where a plate with one contact meets a second one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, Transition
from cases.contact import start_motion
from cases.motion.trajectory import CONTACT
from cases.scene.contact_limits import has_features
from cases.scene.contact_pairs import WatchedPair, pairs, pairs_in_pose

from ..contact_frame.drive import in_fixed_frame
from .contacts import all_pairs, friction_of, is_watched_always, on_surface, pair_at
from .motion import Simulation
from .phase import STICKS, WatchedContact
from .plate_state import OPEN_NAME, TOUCHES

# A slip velocity below this part of the outline's own speed is rounding.
NO_SLIP = 1e-11


class SeveralMotion(NamedTuple):
    """Transitions, status, end (s), and (x, y, θ, vx, vy, ω, slip) at the requested times, shape (7, n): the slip is
    that of the first closed contact. NaN after the end."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    motions: np.ndarray


def touches_at_start(case: Case) -> bool:
    """Whether the plate touches its track in several places in its start, to rounding."""
    if not case.start.in_contact:
        return False
    begin = case.start.motion(case.track, case.plate.outline)
    body = [begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega]
    size = abs(begin.x) + abs(begin.y) + case.plate.reach
    track = pairs(case)[0]
    gaps = [pair_at(track, body, pair).gap for pair in all_pairs(track, body, begin.xi1)]
    return sum(abs(gap) <= 1e-12 * size for gap in gaps) > 1


def mode_of(case: Case, slip: float, omega: float) -> Mode:
    """The mode of a contact with that slip velocity (m/s); a slip of a few roundings of the spin is none."""
    if friction_of(case)[0] == 0.0:
        return Mode.SLIDE
    if abs(slip) <= NO_SLIP * (case.plate.reach * abs(omega) + abs(slip)):
        return Mode.ROLL
    return Mode.SLIP_FORWARD if slip > 0.0 else Mode.SLIP_BACKWARD


def continue_motion(
    case: Case, t: float, body: Sequence[float] | np.ndarray, own: tuple[float, float] | None, mode: Mode,
    rtol: float = 1e-13, times: Sequence[float] | np.ndarray = (),
) -> SeveralMotion:  # fmt: skip
    """Continue a motion whose plate (x, y, θ, vx, vy, ω) has a contact at the pair `own` in that mode, and touches its
    track in further places at time t (s)."""
    motion = Simulation(case, t, body, rtol)
    body = motion.body  # as the track sees it
    if has_features(case):
        _watch_features(motion)
        _close_own(motion, own, mode)
        return _complete(motion, times)
    if own is not None:
        motion.contacts.append(WatchedContact(CONTACT, pairs(case)[0], own, mode))
        motion.touching.add(CONTACT)
        if mode in STICKS:
            motion.stuck = {CONTACT}
    around, track = own[0] if own is not None else case.start.xi1, pairs(case)[0]
    for pair in all_pairs(track, body, around):
        place = case.track.point(pair[0])
        known = [case.track.point(contact.pair[0]) for contact in motion.contacts]
        is_new = all(np.hypot(*(place - other)) > 1e-6 * case.plate.reach for other in known)
        if is_new and pair_at(track, body, pair).gap <= 1e-9 * case.plate.reach:
            motion.add(track, pair)
    return _complete(motion, times)


def from_start(case: Case, rtol: float = 1e-13, times: Sequence[float] | np.ndarray = ()) -> SeveralMotion:
    """The motion of a case whose contacts are pairs of a support and a feature from its start on."""
    begin = start_motion(case)
    body = [float(v) for v in (begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega)]
    motion = Simulation(case, 0.0, body, rtol)
    motion.is_start = True
    _watch_features(motion)
    return _complete(motion, times)


def _watch_features(motion: Simulation) -> None:
    """Watch all pairs of a support and a feature that have unique nearest points, and others that touch."""
    pose = motion.body[:3]
    some = pairs_in_pose(motion.case, *pose)
    for pair in pairs(motion.case):
        if pair.is_point_on_curve:
            some.append(WatchedPair(pair, pair.guess(*pose), False))
        elif not pair.has_unique_points:
            some += [WatchedPair(pair, near, False) for near in pair.touching_points(*pose)]
    for pair, near, is_away in sorted(some, key=lambda one: one.pair.number):
        place = sum(contact.case == pair for contact in motion.contacts)  # a smooth outline may touch in several
        name = f"{OPEN_NAME}{pair.number}" + "+" * place
        motion.contacts.append(WatchedContact(name, pair, near, Mode.FLIGHT, is_away))


def _close_own(motion: Simulation, own: tuple[float, float] | None, mode: Mode) -> None:
    """Close the contact at the pair `own`, in that mode, and all others that touch."""
    now = motion.pairs()
    touching = [
        k for k, (c, pair) in enumerate(zip(motion.contacts, now, strict=True))
        if abs(pair.gap) <= TOUCHES * motion.size() and not c.is_away
    ]  # fmt: skip
    if own is not None and touching:
        track = motion.case.track
        nearest = min(touching, key=lambda k: np.hypot(*(track.point(now[k].xi1) - track.point(own[0]))))
        motion.contacts[nearest] = motion.contacts[nearest]._replace(name=CONTACT, mode=mode)
        motion.stuck = {CONTACT} if mode in STICKS else set()
    motion.touching = {motion.contacts[k].name for k in touching}


def _complete(motion: Simulation, times: Sequence[float] | np.ndarray) -> SeveralMotion:
    with np.errstate(all="ignore"):
        status = motion.simulate()
    return SeveralMotion(
        motion.impacts.all,
        status,
        motion.t,
        _sample(motion, np.asarray(times, dtype=float)),
    )


def _sample(motion: Simulation, times: np.ndarray) -> np.ndarray:
    motions = np.full((7, len(times)), np.nan)
    starts = np.array([stretch.start for stretch in motion.stretches])
    for i, t in enumerate(times.tolist()):
        if not motion.stretches or not starts[0] <= t <= motion.t:
            continue
        number = max(int(np.searchsorted(starts, t, side="right")) - 1, 0)
        stretch = motion.stretches[number]
        motions[:6, i] = stretch.states(t)
        for contact in stretch.phase.contacts:
            if contact.is_closed:
                near = contact.case.guess(*motions[:3, i]) if is_watched_always(contact.case) else contact.pair
                now = on_surface(pair_at(contact.case, motions[:6, i], near), t)
                motions[6, i] = 0.0 if stretch.phase.rests else now.slip
                break
    if motion.drive:
        motions[:6] = in_fixed_frame(motion.drive.at_times(times), motions[:6])
    return motions
