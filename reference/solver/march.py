"""The loop of every motion: phase after phase, each in the chart of its contacts, until an ending."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from cases import Case, DoesNotFit, Transition
from cases.curves.curve_pieces import TooMuch
from cases.motion.trajectory import CONTACT
from cases.scene.contact_limits import is_general_case, touches_by_features
from cases.scene.piece_case import has_pieces

from ..endings import (
    ACCUMULATION,
    COMPLETION,
    Ending,
    events_without_time,
    no_numbers,
    phase_limit_ending,
    search_limit_ending,
    undecidable,
    work_limit_ending,
)
from ..minimal.decision import Undecidable
from ..minimal.integrators.segment import Segment, Segments
from ..minimal.modes import Regime
from ..scales import MANY, MOST_STEPS, NO_TIME, STUCK, frequency
from ..time_limit import check_time
from .contact_chart import ContactChart, Departure
from .pose_chart import PoseChart
from .watched_plates import MotionEnds

# Limit on the phases of one run: a segment takes 7 kB and more, so that these fill a gigabyte or two.
MOST_PHASES = 200_000


def begins_alone(case: Case) -> bool:
    """Whether a motion begins with at most one contact, in that contact's coordinates."""
    if is_general_case(case) or touches_by_features(case):
        return False
    return case.start.in_contact or not has_pieces(case)


def simulate(
    case: Case, rtol: float, integrate: Callable[..., Segment], regime: Regime | None, no_poses: Callable[[], str]
) -> tuple[Segments, list[Transition], Ending]:
    """The motion of a case from its start: (segments, transitions, (status, sentence)). `regime`: that of the first
    contact, if it is known; `no_poses`: why the motion ends where it departs to poses, in a sentence, or ""."""
    segments, earlier = Segments(), list[Transition]()
    try:
        chart = _first_chart(case, rtol, integrate, regime, no_poses, segments)
    except Undecidable:
        return segments, earlier, undecidable(0.0)
    since, first = 0.0, 0
    for count in range(1, MOST_PHASES + 1):
        check_time()
        before = chart.t
        result = _phase(chart)
        chart.idle = chart.idle + 1 if chart.t == before else 0
        if isinstance(result, Departure):
            if not (reason := no_poses()):
                earlier = [replace(change, contact=CONTACT) for change in chart.transitions]
                chart = PoseChart(case, rtol, integrate, segments, result)
                continue
            result = result.ending[0], f"{result.ending[1]} {reason}"
        if result is None and chart.idle and chart.t >= case.duration:  # an event exactly at the end
            result = COMPLETION
        if result is None and segments.steps >= MOST_STEPS:
            result = work_limit_ending(chart.t, segments.steps)
        if result is None and chart.idle > STUCK:
            result = events_without_time(chart.t, STUCK, "changes of mode")
        if result is None and count % MANY == 0:
            result = ACCUMULATION if take_no_time(segments[first:], chart.t - since) else None
            since, first = chart.t, len(segments)
        if result is not None:
            return segments, [*earlier, *chart.transitions], result
    return segments, [*earlier, *chart.transitions], phase_limit_ending(chart.t, MOST_PHASES)


def take_no_time(some: Sequence[Segment], length: float) -> bool:
    """Whether phases of that total length (s) take no time by the fastest rates at their ends."""
    return not any(length * frequency(one.phase, one.event.time, one.event.state) > NO_TIME for one in some)


def _first_chart(
    case: Case, rtol: float, integrate: Callable[..., Segment], regime: Regime | None, no_poses: Callable[[], str],
    segments: Segments,
) -> ContactChart | PoseChart:  # fmt: skip
    if begins_alone(case):
        chart = ContactChart(case, rtol, integrate, regime, segments)
        is_alone = not has_pieces(case) and chart.is_alone
        if is_alone or no_poses() or chart.touches_once():
            return chart
    return PoseChart(case, rtol, integrate, segments)


def _phase(chart: ContactChart | PoseChart) -> Ending | Departure | None:
    """One phase of a chart, or how the motion ends where none is computed."""
    try:
        return chart.phase()
    except MotionEnds as end:
        return end.ending
    except TooMuch:
        return search_limit_ending(chart.t)
    except Undecidable:
        return undecidable(chart.t)
    except (DoesNotFit, np.linalg.LinAlgError) as problem:
        return no_numbers(chart.t, problem)
