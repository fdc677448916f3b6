"""What contradicts a motion of a drawn scene: a law of mechanics, or the same motion by another way of use."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np

import reference
from cases import Case, StartPose, Trajectory

from .draw import Spec

# Poses of one motion by two ways differ by the tolerance of 1e-10, times what impacts and the ends of slips make of it.
# In parts of 1 m and 1 rad: the plates are of 0.05 to 0.4 m.
APART = 1e-6
# Scenes with these loads and tracks have formulas in time: the rest of their motion is no scene of its own.
IN_TIME = ("periodic", "belt_in_time", "shaken", "tilted")


def contradictions(spec: Spec, case: Case, motion: Trajectory) -> list[str]:
    """What contradicts a motion, in words; empty if nothing does."""
    if motion.dense is None:  # it ended where it began
        return []
    ways = {"resumed": resumed, "exported": _exported, "swept": _swept}
    use, effects = spec["use"], spec["effects"]
    if use == "resumed" and {effects["load"]["kind"], effects["motion"]["kind"]} & {*IN_TIME}:
        use = "simulated"
    text = ways[use](case, motion) if use in ways else ""
    return [*map(str, reference.check(case, motion)), *([f"{use}: {text}"] if text else [])]


def resumed(case: Case, motion: Trajectory) -> str:
    """How the rest of a motion, from the middle of its longest time without a change, differs as a scene of its own; ""
    if it does not, or if the motion ended early. A scene with formulas in time has none."""
    end = float(motion.t[-1])
    if motion.status != "completed":
        return ""
    changes = [0.0, *(change.time for change in motion.transitions), end]
    longest = int(np.argmax(np.diff(changes)))
    middle = 0.5 * (changes[longest] + changes[longest + 1])
    places = [_pose(plate(middle)) for plate in _plates(case, motion)]
    others = tuple(replace(other, start=pose) for other, pose in zip(case.others, places[1:], strict=True))
    rest = reference.simulate(replace(case, start=places[0], others=others, duration=end - middle))
    if rest.status != motion.status:
        return f"ends with {rest.status} at {middle + rest.t[-1]:.9g} s: {rest.reason}"
    return _difference(case, motion, rest)


def _pose(state) -> StartPose:
    return StartPose(*(float(getattr(state, name)) for name in ("x", "y", "theta", "vx", "vy", "omega")))


def _exported(case: Case, motion: Trajectory) -> str:
    """The motion as another process receives it."""
    return _difference(case, motion, pickle.loads(pickle.dumps(motion)))


def _swept(case: Case, motion: Trajectory) -> str:
    """The scene as a scenario of a sweep of its duration."""

    def scenario(duration: float) -> Case:
        return replace(case, duration=duration)

    row = reference.sweep(scenario, duration=[case.duration, 0.5 * case.duration]).to_dict("records")[0]
    output, expected = (row["outcome"], row["transitions"]), (motion.status, len(motion.transitions))
    return "" if output == expected else f"{output}, not {expected}: {row['reason']}"


def _plates(case: Case, motion: Trajectory) -> list[Trajectory]:
    return [motion, *(motion.plate(other.name) for other in case.others)]


def _difference(case: Case, one: Trajectory, other: Trajectory) -> str:
    """How far the plates' last poses are apart, if they are."""
    pairs = zip(_plates(case, one), _plates(case, other), strict=True)
    apart = max(
        abs(float(getattr(a, name)[-1] - getattr(b, name)[-1])) for a, b in pairs for name in ("x", "y", "theta")
    )
    return f"the last poses are {apart:.3g} apart" if apart > APART else ""
