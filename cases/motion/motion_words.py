"""A motion in words: what each contact does, one mode after the other."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..moving_surface import Drive
from ..scene.contact_names import CONTACT

Trajectory = Any  # of `cases.motion.trajectory`, which has its words from here

# Changes listed in words; the text gives the total of a longer list.
MOST_CHANGES = 4
# A plate that never moves faster than this part of the fastest speed is still: what roundings of velocities leave.
STILL = 1e-9
# Instants inside a phase at which its velocities are compared with that.
LOOKS = np.array([0.1, 0.35, 0.5, 0.65, 0.9])

# By the names of modes.
VERBS = {
    "slide": "slides without friction",
    "slip_forward": "slides forward",
    "slip_backward": "slides backward",
    "roll": "rolls",
    "rest": "rests",
    "flight": "flies",
}


def in_words(motion: Trajectory) -> str:
    """The modes one after the other with their durations, and how the motion ends: "slides forward for 0.34 s, then
    rolls to the end of 1 s". Of several contacts each has its own; the same words are given once. For a motion with
    unknown modes, the number of samples."""
    why = motion.reason.removesuffix(".")
    ends = "" if motion.status == type(motion).status else f"; ends there: {motion.status}. {why}"
    several = len(motion.contact_names) > 1
    by_words: dict[str, list[str]] = {}
    for name in motion.contact_names:
        alone = motion.of(name) if several else motion
        by_words.setdefault(_phases(motion, alone, name, bool(ends)), []).append(name)
    if not several:
        return f"{next(iter(by_words))}{ends}"
    return "; ".join(f"{' and '.join(names)}: {words}" for words, names in by_words.items()) + ends


def _phases(motion: Trajectory, alone: Trajectory, name: str, is_cut: bool) -> str:
    """What one contact does; `alone`: the motion of that contact."""
    end, changes = float(motion.t[-1]), alone.transitions
    starts = [0.0, *(t.time for t in changes)]
    modes = [alone.first_mode or (changes[0].before if changes else None), *(t.after for t in changes)]
    spans = zip(modes, starts, [*starts[1:], end], strict=True)
    verbs = [_verb(motion, name, mode, a, b) if mode and b > a else "" for mode, a, b in spans]
    phases = [f"{verb} for {b - a:.3g} s" for verb, a, b in zip(verbs, starts, starts[1:], strict=False) if verb]
    if len(phases) > MOST_CHANGES:
        phases = [*phases[:MOST_CHANGES], f"… ({len(changes)} changes in all)"]
    if is_cut:
        last = [f"{verbs[-1]} until {end:.3g} s"] if verbs[-1] else []
        return ", then ".join([*phases, *last]) or "does not move"
    does = (verbs[-1] or VERBS[modes[-1]]) if modes[-1] else f"{len(motion.t)} samples"
    return ", then ".join([*phases, f"{does} to the end of {end:.3g} s"])


def _verb(motion: Trajectory, contact: str, mode: str, start: float, end: float) -> str:
    """What a plate does in a mode of contact from one time (s) to another: one that does not slip may also rest, or
    move without turning."""
    if mode not in ("slide", "roll", "rest") or motion.dense is None:
        return VERBS[mode]
    moves = turns = False
    for plate in _plates_at(motion, contact):
        fastest, now = _speeds(plate, motion.t), _speeds(plate, start + (end - start) * LOOKS)
        moves, turns = moves or now[0] > STILL * fastest[0], turns or now[1] > STILL * fastest[1]
    if not moves and not turns:
        return "rests"
    return "sticks" if mode == "roll" and not turns else VERBS[mode]


def _speeds(motion: Trajectory, times: np.ndarray) -> tuple[float, float]:
    """The largest speed (m/s) and rotation (rad/s) of a plate at some times, as its track sees it, which may move."""
    x, y, _, vx, vy, omega, *_ = motion(times)
    drive = motion.case.effect(Drive) if motion.case is not None else None
    if drive is not None:
        *_, vx, vy, omega = drive.at_times(times).seen_from_track(x, y, vx, vy, omega)
    return float(np.hypot(vx, vy).max()), float(np.abs(omega).max())


def _plates_at(motion: Trajectory, contact: str) -> list[Trajectory]:
    """The motions of the plates that take part in a contact."""
    if len(motion.plate_names) < 2:
        return [motion]
    sides = contact.split("/") if contact != CONTACT else [motion.plate_names[0]]
    return [motion.plate(name) for name in motion.plate_names if name in {side.split(" ")[0] for side in sides}]
