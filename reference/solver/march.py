"""The loop of every motion: phase after phase, each in the chart of its contacts, until an ending."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cases import Case, DoesNotFit, Transition
from cases.curves.curve_pieces import TooMuch
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
from .hops import NestedSeries
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
    contact, if it is known; `no_poses`: why contacts are not integrated in poses, in a sentence, or ""."""
    segments, hops = Segments(), NestedSeries()
    contact = ContactChart(case, rtol, integrate, segments, hops) if begins_alone(case) else None
    poses: PoseChart | None = None

    def in_poses(before: Departure | None) -> PoseChart:
        nonlocal poses
        quick = contact if not has_pieces(case) else None
        poses = poses or PoseChart(case, rtol, integrate, segments, hops, quick, no_poses)
        return poses.begin(before)

    def changes() -> list[Transition]:
        # A contact alone has no impacts, whose changes at one instant would be one.
        return hops.all if poses is not None else hops.outer.ordinary

    try:
        is_quick = contact is not None and case.start.in_contact and _begins_in_contact(contact, regime, no_poses)
    except Undecidable:
        return segments, [], undecidable(0.0)
    chart: ContactChart | PoseChart = contact if is_quick and contact is not None else in_poses(None)
    since, first = 0.0, 0
    for count in range(1, MOST_PHASES + 1):
        check_time()
        before = chart.t
        result = _phase(chart)
        chart.idle = chart.idle + 1 if chart.t == before else 0
        if isinstance(result, ContactChart):
            chart = result
            continue
        if isinstance(result, Departure):
            if result.opens or not (reason := no_poses()):
                chart = in_poses(result)
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
            return segments, changes(), result
    return segments, changes(), phase_limit_ending(chart.t, MOST_PHASES)


def take_no_time(some: Sequence[Segment], length: float) -> bool:
    """Whether phases of that total length (s) take no time by the fastest rates at their ends."""
    return not any(length * frequency(one.phase, one.event.time, one.event.state) > NO_TIME for one in some)


def _begins_in_contact(chart: ContactChart, regime: Regime | None, no_poses: Callable[[], str]) -> bool:
    """Whether a motion begins in the coordinates of its only contact."""
    chart.begin(regime)
    return (not has_pieces(chart.whole) and chart.is_alone) or bool(no_poses()) or chart.touches_once()


def _phase(chart: ContactChart | PoseChart) -> Ending | Departure | ContactChart | None:
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
