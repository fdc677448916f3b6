"""Sequences of modes: the time in which two differ, and down to which duration they agree."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases import Mode, Transition
from reports.judging.phases import ModePhase, agreement, outside, phases_of, time_by_mode, time_in_another_mode

F, R, B, A = Mode.SLIP_FORWARD, Mode.ROLL, Mode.SLIP_BACKWARD, Mode.FLIGHT


def sequence(*parts) -> tuple[ModePhase, ...]:
    """Phases of (mode, duration), one after the other."""
    ends = np.cumsum([duration for _, duration in parts]).tolist()
    return tuple(ModePhase(mode, end - duration, end) for (mode, duration), end in zip(parts, ends, strict=True))


sequences = st.lists(st.tuples(st.sampled_from([F, R, B, A]), st.integers(1, 50)), min_size=1, max_size=8).map(
    lambda parts: sequence(*((mode, float(duration)) for mode, duration in parts))
)


def test_phases_join_flights_between_impacts_and_end_with_the_motion():
    events = (Transition(1.0, R, A), Transition(2.0, A, A), Transition(3.0, A, F), Transition(9.0, F, R))
    assert phases_of(R, events, 4.0) == (ModePhase(R, 0.0, 1.0), ModePhase(A, 1.0, 3.0), ModePhase(F, 3.0, 4.0))
    assert phases_of(None, (), 4.0) == () and phases_of(None, events, 1.0)[0].mode is R


@given(sequences, sequences)
def test_time_in_another_mode_is_what_a_sum_over_small_steps_finds(ours, truth):
    end = truth[-1].end
    middle = np.arange(0.5, end)

    def at(phases, time):
        return next((p.mode for p in phases if p.begin <= time < p.end), None)

    expected = sum(at(ours, time) != at(truth, time) for time in middle)
    assert time_in_another_mode(ours, truth, end) == pytest.approx(expected)
    assert sum(time_by_mode(truth).values()) == pytest.approx(end)


@given(sequences, st.integers(0, 20), st.integers(1, 20))
def test_what_is_cut_out_counts_as_another_mode(phases, begin, length):
    end = phases[-1].end
    left = outside(phases, [(float(begin), float(begin + length))])
    lost = max(min(begin + length, end) - min(begin, end), 0.0)
    assert time_in_another_mode(left, phases, end) == pytest.approx(lost)


@given(sequences)
def test_a_sequence_agrees_with_itself(phases):
    assert agreement(phases, phases) == (0.0, False)


def test_agreement_is_down_to_the_longest_phase_that_only_one_has():
    truth = sequence((F, 1.0), (R, 2.0))
    assert agreement(sequence((F, 1.0), (B, 6e-6), (R, 2.0)), truth) == (pytest.approx(6e-6), False)
    assert agreement(truth, sequence((F, 1.0), (R, 1.0), (B, 3e-3), (R, 1.0))) == (pytest.approx(3e-3), True)
    # A phase that is split by a short one is one phase.
    assert agreement(sequence((F, 0.5), (R, 1e-3), (F, 0.5), (R, 2.0)), truth) == (pytest.approx(1e-3), False)
    assert agreement(sequence((R, 3.0)), truth)[0] == 1.0
    assert agreement(sequence((B, 3.0)), truth) == (inf, False)
    assert agreement((), truth) == (inf, False)


def test_agreement_of_chatter_ends():
    chatter = sequence(*((F, 1e-3), (R, 1.5e-3)) * 1000)
    assert agreement(chatter, sequence((F, 1.0), (R, 1.5))) == (pytest.approx(1.0), True)
