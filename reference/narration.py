"""A motion in one line of words: what `python -m cases check` says of each case, after it has run it."""

from __future__ import annotations

from cases import BadValue, Case, CaseError, Mode, Trajectory

from .solve import simulate

DOES = {
    Mode.SLIDE: "slides without friction",
    Mode.SLIP_FORWARD: "slides forward",
    Mode.SLIP_BACKWARD: "slides backward",
    Mode.ROLL: "rolls",
    Mode.REST: "rests",
    Mode.FLIGHT: "flies",
}
# More changes than a reader takes in at a glance are counted.
MOST_CHANGES = 4


def check(case: Case) -> str:
    """Run the case by the best method and say what happens; raises CaseError, in one sentence, if it cannot run."""
    try:
        return in_words(simulate(case))
    except CaseError:
        raise
    except Exception as problem:  # whatever else the author's curves and loads bring up
        raise BadValue(f"the motion fails: {type(problem).__name__}: {problem}") from problem


def in_words(motion: Trajectory) -> str:
    """The modes one after the other with their durations, and how the motion ends: "slides forward for 0.34 s, then
    rolls to the end of 1 s"."""
    end = float(motion.t[-1])
    changes = motion.transitions
    starts = [0.0, *(t.time for t in changes)]
    modes = [motion.first_mode or (changes[0].before if changes else None), *(t.after for t in changes)]
    phases = [f"{DOES[m]} for {b - a:.3g} s" for m, a, b in zip(modes, starts, starts[1:], strict=False) if m]
    if len(phases) > MOST_CHANGES:
        phases = [*phases[:MOST_CHANGES], f"… ({len(changes)} changes in all)"]
    if motion.status != Trajectory.status:
        last = [f"{DOES[modes[-1]]} until {end:.3g} s"] if modes[-1] and end > starts[-1] else []
        return f"{', then '.join([*phases, *last]) or 'does not move'}; ends there: {motion.status}. {motion.reason}"
    last = [f"{DOES[modes[-1]]} to the end of {end:.3g} s"] if modes[-1] else []
    return ", then ".join([*phases, *last])
