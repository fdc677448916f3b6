"""The second formulation's answer to a case: with one contact, several contacts, or several plates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, NotSupported, Transition
from cases.contact import start_motion
from cases.motion.trajectory import CONTACT
from cases.scene.contact_limits import has_features, limitation, touches_by_features
from cases.scene.contact_pairs import WatchedPair, pairs, pairs_in_pose
from cases.scene.couples import couples
from cases.scene.free_plates import contact_name
from cases.scene.limits import Scope, limit, without_certificate
from cases.scene.piece_case import has_pieces

from .contacts import all_pairs, friction_of, pair_at
from .drive import in_fixed_frame
from .motion import Simulation
from .phase import STICKS, WatchedContact
from .plate_state import OPEN_NAME, TOUCHES
from .second_formulation import STOPS, solve
from .watched_pairs import start_of_plates, watched_pairs

# A slip velocity below this part of the outline's own speed is rounding.
NO_SLIP = 1e-11
# Least number of steps of one contact: with 300 their errors are 1e-14, with the default 60 up to 1e-11.
STEPS_PER_TURN = 300


class Prediction(NamedTuple):
    """The sequence of modes, the status and the time of the end (s), and (x, y, θ) of all plates there, then their
    (vx, vy, ω)."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    body: tuple[float, ...]


def predict(case: Case, rtol: float = 1e-13) -> Prediction:
    """The motion of a case by the second formulation. Raises NotSupported for what it does not have, and
    FloatingPointError if it starts and cannot continue."""
    if case.others:
        if reason := without_certificate(case):
            raise NotSupported(reason)
        motion = Simulation(case, 0.0, start_of_plates(case), rtol)
        _watch_plates(motion)
        return _complete(motion)
    begin, may_continue = start_motion(case), not limitation(case)
    if touches_by_features(case):
        if reason := limit(case, Scope.EFFECTS):
            raise NotSupported(reason)
        motion = Simulation(case, 0.0, begin[:6], rtol)
        _watch_features(motion)
        return _complete(motion)
    if may_continue and touches_at_start(case):
        own, mode = (begin.xi1, begin.xi2), _mode_of(case, begin.slip, begin.omega)
        return continue_motion(case, 0.0, begin[:6], own, mode, rtol)
    first = solve(case, rtol=rtol, steps_per_turn=STEPS_PER_TURN, overlaps=True)
    (*body, slip), own = first.last.motion, first.last.points
    before = tuple(replace(event, contact=CONTACT) for event in first.transitions)
    if not may_continue or first.status != STOPS["elsewhere"]:
        has_names = has_pieces(case) and not case.start.in_contact  # it may touch in any number of places
        return Prediction(before if has_names else first.transitions, first.status, first.end, tuple(body))
    if np.isnan(slip):  # in flight
        later = continue_motion(case, first.end, body, None, Mode.FLIGHT, rtol)
    else:
        mode = before[-1].after if before else _mode_of(case, slip, body[5])
        later = continue_motion(case, first.end, body, own, mode, rtol)
    return later._replace(transitions=(*before, *later.transitions))


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


def _mode_of(case: Case, slip: float, omega: float) -> Mode:
    """The mode of a contact with that slip velocity (m/s); a slip of a few roundings of the spin is none."""
    if friction_of(case)[0] == 0.0:
        return Mode.SLIDE
    if abs(slip) <= NO_SLIP * (case.plate.reach * abs(omega) + abs(slip)):
        return Mode.ROLL
    return Mode.SLIP_FORWARD if slip > 0.0 else Mode.SLIP_BACKWARD


def continue_motion(
    case: Case, t: float, body: Sequence[float] | np.ndarray, own: tuple[float, float] | None, mode: Mode, rtol: float
) -> Prediction:
    """Continue a motion whose plate (x, y, θ, vx, vy, ω) has a contact at the pair `own` in that mode, and touches its
    track in further places at time t (s)."""
    motion = Simulation(case, t, body, rtol)
    body = motion.body  # as the track sees it
    if has_features(case):
        _watch_features(motion)
        _close_own(motion, own, mode)
        return _complete(motion)
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
    answer = _complete(motion)
    if t == 0.0 and motion.names == {CONTACT}:  # a contact that is the only one has no name
        unnamed = tuple(replace(event, contact="") for event in answer.transitions)
        return answer._replace(transitions=unnamed)
    return answer


def _watch_plates(motion: Simulation) -> None:
    """Watch the contacts that plates may have with track, supports and each other."""
    for couple in couples(motion.case):
        plate, _, base = couple.pair_name.partition("/")
        for number, (pair, near) in enumerate(watched_pairs(couple, motion.body[: motion.half]), 1):
            motion.contacts.append(WatchedContact(contact_name(plate, base, number), pair, near, Mode.FLIGHT))


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


def _complete(motion: Simulation) -> Prediction:
    with np.errstate(all="ignore"):
        status = motion.simulate()
    each = motion.body.reshape(2, -1, 3)
    if motion.drive:
        place = motion.drive.at(motion.t)
        fixed = [in_fixed_frame(place, np.ravel(each[:, i])) for i in range(each.shape[1])]
        each = np.reshape(fixed, (-1, 2, 3)).swapaxes(0, 1)
    return Prediction(motion.impacts.all, status, motion.t, tuple(map(float, each.ravel())))
