"""What a build of the suite says of drawn scenes: `python -m tests.composition.judge --seconds 20 0-199`.

It prints a line of JSON per scene and imports only public names, so that an older build, installed in an environment of
its own, answers the same questions of the same scenes. Exit status 0.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from collections.abc import Sequence
from types import FrameType
from typing import Any

import numpy as np

import reference
from cases import Case, CaseError, Trajectory
from cases.scene.limits import LIMITS

from .build import ATTEMPTS, scene
from .confirm import contradictions
from .draw import Spec, draw

# Instants at which poses are compared, from the start to the end.
INSTANTS = 9
POSE = ("x", "y", "theta", "vx", "vy", "omega")


class OutOfTime(Exception):
    """The scene's time is over."""


def answer_to(seed: int, seconds: float) -> dict[str, Any]:
    """The outcome of the first scene of a seed that begins where it can, or of the last attempt."""
    for attempt in range(ATTEMPTS):
        outcome = answer(draw(seed, attempt), seconds)
        if outcome["outcome"] != "rejected" or "limit" in outcome:
            break
    return outcome


def answer(spec: Spec, seconds: float, rtol: float = 1e-10) -> dict[str, Any]:
    """The outcome of a scene: rejected (with its row of the table of limits, or else for its start), out of time, a
    Python error, or a motion with status, transitions, poses and what contradicts it."""
    began = time.process_time()
    signal.signal(signal.SIGVTALRM, _stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        case = scene(spec)
        # Without heyoka there is one method.
        method = spec["method"] if spec["method"] in reference.METHODS else None
        motion = reference.simulate(case, rtol=rtol, method=method)
        outcome = {"outcome": "motion", **describe(case, motion), "cpu_of_motion": time.process_time() - began}
        signal.setitimer(signal.ITIMER_VIRTUAL, seconds)  # a confirmation has its own time
        outcome["contradictions"] = contradictions(spec, case, motion)
    except CaseError as problem:
        row = next((row for row in LIMITS if row.matches(str(problem))), None)
        outcome = {"outcome": "rejected", "kind": type(problem).__name__, "sentence": str(problem)}
        outcome |= {"limit": row.feature, "reason": row.reason.value} if row else {}
    except OutOfTime:
        outcome = {"outcome": "out of time"}
    except Exception as problem:  # a fault of the build is an outcome
        outcome = {"outcome": "error", "kind": type(problem).__name__, "sentence": str(problem)}
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    return {"seed": spec["seed"], "attempt": spec["attempt"], **outcome, "cpu": time.process_time() - began}


def describe(case: Case, motion: Trajectory) -> dict[str, Any]:
    """Status, end (s), transitions, and the poses and velocities of each plate at `INSTANTS` instants."""
    end = float(motion.t[-1])
    times = np.linspace(0.0, end, INSTANTS)
    states = [motion(times), *(motion.plate(other.name)(times) for other in case.others)]
    return {
        "status": motion.status,
        "reason": motion.reason,
        "end": end,
        "transitions": [(t.time, t.contact, t.before.value, t.after.value) for t in motion.transitions],
        "poses": [[np.asarray(getattr(state, name)).tolist() for name in POSE] for state in states],
    }


def _stop(number: int, frame: FrameType | None) -> None:
    raise OutOfTime


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition(":")[0])
    parser.add_argument("seeds", nargs="+", help="a seed, or a range such as 0-199")
    parser.add_argument("--seconds", type=float, default=20.0, help="CPU time of a scene (default: 20)")
    given = parser.parse_args(argv)
    for text in given.seeds:
        first, _, last = text.partition("-")
        for seed in range(int(first), int(last or first) + 1):
            print(json.dumps(answer_to(seed, given.seconds)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
