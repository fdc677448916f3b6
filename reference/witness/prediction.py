"""The second formulation's answer to a case: with one contact, several contacts, or several plates."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases import Case, Drive, Impact, Mode, NotSupported, Transition
from cases.contact import start_motion
from cases.motion.trajectory import CONTACT
from cases.moving_frame import relative_case
from cases.scene.contact_limits import has_features, touches_by_features
from cases.scene.contact_names import contact_name
from cases.scene.contact_pairs import WatchedPair, pairs, pairs_in_pose
from cases.scene.couples import couples
from cases.scene.limits import has_spinning_plate, without_certificate
from cases.scene.piece_case import PieceCase, has_pieces, pieces_at

from .contacts import is_watched_always, on_whole_curves, pair_at
from .motion import Simulation
from .pairs import in_round
from .phase import STICKS, WatchedContact
from .plate_state import OPEN_NAME
from .watched_pairs import PieceEnd, is_by_pieces, piece_end, start_of_plates, watched_pairs

# A slip velocity below this part of the outline's own speed is rounding.
NO_SLIP = 1e-15


class Prediction(NamedTuple):
    """The sequence of modes, the status and the time of the end (s), and (x, y, θ) of all plates there, then their
    (vx, vy, ω), and ξ₁, ξ₂ and the slip (m/s) of each closed contact."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    body: tuple[float, ...]
    contacts: tuple[tuple[float, float, float], ...] = ()


def predict(case: Case, rtol: float = 1e-13) -> Prediction:
    """The motion of a case by the second formulation. Raises NotSupported for what it does not have, and
    FloatingPointError if it starts and cannot continue."""
    if (case.others or has_spinning_plate(case)) and (reason := without_certificate(case)):
        raise NotSupported(reason)
    drive, case = case.effect(Drive), relative_case(case)
    begin = start_motion(case)
    motion = Simulation(case, 0.0, start_of_plates(case), rtol)
    if case.others:
        _watch_plates(motion)
    elif is_by_pieces(case):
        _watch_pieces(motion, (begin.xi1, begin.xi2))
    else:
        _watch_features(motion, (begin.xi1, begin.xi2))
        motion.is_start = case.start.in_contact or touches_by_features(case)
    if case.start.in_contact and not case.others:
        _begin_slip(motion, begin.slip, begin.omega)
    with np.errstate(all="ignore"):
        status = motion.simulate()
    if status == "second_contact" and is_by_pieces(case) and case.effect(Impact) is not None:
        raise NotSupported(without_certificate(case))  # it follows one contact from piece to piece
    transitions = motion.impacts.all
    if not (case.others or motion.is_several or touches_by_features(case) or (has_pieces(case) and case.start.gap > 0)):
        transitions = tuple(replace(event, contact="") for event in transitions)
    each = motion.body.reshape(2, -1, 3)
    if drive:
        place, ((x, y, theta), (vx, vy, omega)) = drive.at(motion.t), each.swapaxes(1, 2)
        x, y, vx, vy, omega = place.seen_from_outside(x, y, vx, vy, omega)
        each = np.array([[x, y, theta + place.angle], [vx, vy, omega]]).swapaxes(1, 2)
    now = zip(motion.contacts, motion.pairs(), strict=True)
    left = motion.touching if status == "lift_off" else set()
    points = list[tuple[float, float, float]]()
    for c, p in now:
        if c.is_closed or c.name in left:
            xi1, xi2 = on_whole_curves(c.case, (p.xi1, p.xi2))
            if not (case.others or case.supports):
                xi2 = in_round(motion.case, float(motion.body[2]), xi1, xi2)
            points.append((xi1, xi2, 0.0 if c.mode in STICKS else p.slip))
    return Prediction(transitions, status, motion.t, tuple(map(float, each.ravel())), tuple(points))


def _begin_slip(motion: Simulation, slip: float, omega: float) -> None:
    """A contact slips in the start however slowly, but for a few roundings of the spin."""
    if abs(slip) > NO_SLIP * motion.case.plate.reach * abs(omega):
        motion.slow = {CONTACT}
        motion.begins = dict.fromkeys(motion.slow, float(np.sign(slip)))


def _watch_plates(motion: Simulation) -> None:
    """Watch the contacts that plates may have with track, supports and each other."""
    for couple in couples(motion.case):
        plate, _, base = couple.pair_name.partition("/")
        for number, (pair, near) in enumerate(watched_pairs(couple, motion.body[: motion.half]), 1):
            motion.contacts.append(WatchedContact(contact_name(plate, base, number), pair, near, Mode.FLIGHT))


def _watch_pieces(motion: Simulation, own: tuple[float, float]) -> None:
    """Watch the contact in the start, on the pieces on which it goes on."""
    case = motion.case
    if case.start.gap > 0.0:
        return
    pieces = pieces_at(case, *own)
    points = (own[0] - pieces.first.shift, own[1] - pieces.second.shift)
    for _ in pieces.pieces:  # an end towards which the contact moves belongs to the next piece
        now, end = pair_at(pieces, motion.body, points), piece_end(pieces, points)
        rate = (now.xi1_rate, now.xi2_rate)[end.curve]
        if end.following is None or end.distance > 0.0 or not rate * (points[end.curve] - _middle(pieces, end)) > 0.0:
            break
        pieces, points = end.following, end.points
    motion.contacts.append(WatchedContact(CONTACT, pieces, points, Mode.FLIGHT))


def _middle(pieces: PieceCase, end: PieceEnd) -> float:
    return 0.5 * sum(pieces.pieces[end.curve].span)


def _watch_features(motion: Simulation, own: tuple[float, float]) -> None:
    """Watch all pairs of a support and a feature that have unique nearest points, and others that touch; `own`: the
    parameters of a contact in the start."""
    pose = motion.body[:3]
    some = pairs_in_pose(motion.case, *pose)
    for pair in pairs(motion.case):
        is_own = pair.number == 0 and motion.case.start.in_contact and not has_features(motion.case)
        if is_watched_always(pair) and not is_own and not pair.has_unique_points:
            some.append(WatchedPair(pair, pair.guess(*pose), False))
        elif is_own:
            place = pair.track.point(own[0])
            more = [xi for xi in pair.touching_points(*pose)
                    if np.hypot(*(pair.track.point(xi[0]) - place)) > 1e-6 * pair.plate.reach]  # fmt: skip
            some += [WatchedPair(pair, xi, False) for xi in (own, *more)]
        elif not pair.has_unique_points:
            some += [WatchedPair(pair, near, False) for near in pair.touching_points(*pose)]
    for pair, near, is_away in sorted(some, key=lambda one: one.pair.number):
        number = sum(contact.case == pair for contact in motion.contacts)  # a smooth outline may touch in several
        name = CONTACT if near == own and not number else f"{OPEN_NAME}{pair.number}" + "+" * number
        motion.contacts.append(WatchedContact(name, pair, near, Mode.FLIGHT, is_away))
