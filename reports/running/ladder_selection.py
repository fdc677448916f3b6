"""Which cases and settings a report runs: whole ladders or a selection of rungs, by effort (quick, default, full)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .names import REFERENCE

if TYPE_CHECKING:
    from adapters import Setting
    from cases import Case

# The case families of a quick report, which every solver can run.
QUICK_CASES = ("disc_in_circle", "disc_on_incline", "disc_on_line")
# The paper's application: all its settings are shown in motion, if a report contains it.
PAPER_CASE = "disc_in_circle[mu=0.2]"
# Cases with whole ladders in a default report, so that they can be timed: typical scenes of engines, a lift-off, a
# plate that is not a disc, and a flight with an impact.
WHOLE_LADDERS = (
    PAPER_CASE,
    "disc_on_line[mu=0.1]",
    "disc_rolling_off_hill",
    "ellipse_in_circle",
    "disc_onto_incline[mu=0.5]",
)
# The reference's route with the paper's matrix.
LITERAL = "augmented"


def select_rungs(
    effort: str, is_selection: bool, case: str, solver: str, route: str, settings: tuple[Setting, ...]
) -> tuple[Setting, ...]:
    """The rungs to run: all, after the grid of default settings; in a quick report the first default setting and three
    others; for most cases of the catalogue the first default setting and one.

    For these the reference runs at its finest tolerance, because the truth needs the same compiled equations; with the
    paper's matrix, which takes fifteen times as long, at its two coarsest. `is_selection`: whether the user selected
    the cases, which then have whole ladders.
    """
    if effort == "full" or (effort == "default" and (is_selection or case in WHOLE_LADDERS)):
        return settings
    if effort == "default" and (solver, route) == (REFERENCE, LITERAL):
        return settings[:2]
    rungs = sum(not setting.is_default for setting in settings)
    third = rungs // 3
    one = rungs - 1 if solver == REFERENCE else 2 * third
    return default_and(settings, *sorted({0, third, 2 * third} if effort == "quick" else {one}))


def default_and(settings: Sequence[Setting], *places: int) -> tuple[Setting, ...]:
    """The first default setting, and the rungs of the ladder at these places; the finest for a place beyond it."""
    ladder = [setting for setting in settings if not setting.is_default]
    rungs = (ladder[min(place, len(ladder) - 1)] for place in places if ladder)
    return (*[setting for setting in settings if setting.is_default][:1], *rungs)


def ladder_case(cases: Sequence[Case]) -> str:
    """The label of the case whose motions are kept at every setting: the paper's application, else the first case."""
    labels = [case.label for case in cases]
    return PAPER_CASE if PAPER_CASE in labels else labels[0] if labels else ""


def sentence(effort: str, is_selection: bool) -> str:
    """Which settings are run, for the page; "" if all are."""
    if effort == "full" or (effort == "default" and is_selection):
        return ""
    if effort == "quick":
        return "Three settings of each ladder and the default settings; --full runs all."
    return (
        f"Whole ladders for {', '.join(WHOLE_LADDERS)}. Other cases run with default settings and one fine setting, "
        f"the reference at its finest tolerance, and its route {LITERAL!r}, which takes fifteen times as long, at its "
        "two coarsest tolerances; --full runs all."
    )
