"""The reference as a solver of the report: its rows are the motions that `reference.simulate` returns."""

import pytest

import cases
import reference
from adapters.interface import refusal
from cases import Trajectory
from reports.running import reference_adapter
from tests.sampling import quick_every

RTOL = 1e-11
# One plate on one track, driven tracks, corners, supports, supports with belts, several plates.
EVERY_KIND = (
    "disc_on_line", "disc_on_shaken_table", "disc_in_swinging_bowl", "sliding_box", "ladder_at_wall",
    "disc_between_belt_and_wall", "row_of_discs",
)  # fmt: skip


def row(case: cases.Case, method: str) -> Trajectory:
    """The motion that a row of the report is judged by."""
    model = reference_adapter.build(case, method, reference_adapter.Setting.of(rtol=RTOL))
    reference_adapter.run(model)
    return reference_adapter.read(model)


@quick_every(3)
@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("name", EVERY_KIND)
def test_a_row_of_the_reference_is_its_motion(name, method):
    case = cases.load(name)
    ours, motion = row(case, method), reference.simulate(case, rtol=RTOL, method=method)
    assert (ours.status, ours.reason) == (motion.status, motion.reason)
    assert [(t.contact, t.after, t.time) for t in ours.transitions] == [
        (t.contact, t.after, t.time) for t in motion.transitions
    ]
    for name in ("t", "x", "y", "theta", "vx"):
        assert getattr(ours, name).tolist() == getattr(motion, name).tolist()


@pytest.mark.parametrize("method", reference.METHODS)
def test_no_case_of_the_catalogue_is_rejected(method):
    every = [case for name in cases.names() for case in cases.select(name, long=True)]
    assert {case.label: why for case in every if (why := refusal(reference_adapter, case, method))} == {}
