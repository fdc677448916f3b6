"""Numbers published by other programs, compared with ours.

`rows(publications)` computes their motions with the reference and returns one row per number; `COLUMNS` has the
headings. A number agrees if ours lies within the publisher's own accuracy. If a published number is known to be wrong
by more, its record gives the amount and the reason, and this claim is tested instead. If the publisher prints how far
its number is from the exact one, that distance is what is compared.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import floor, log10

import reference
from cases import Case, Trajectory
from reports.running.records import Row
from reports.studies.published import study as published

Reading = Callable[[Trajectory], float]

# The finest tolerance that both integrators reach; all publishers' accuracies except one (1e-12) are far coarser.
RTOL = 1e-13

COLUMNS = published.TABLES["published"].columns


@dataclass(frozen=True)
class Number:
    """One published number: `read` computes it from our motion, in the same unit; `accuracy` is absolute.

    `off` > 0: the published number is known to be wrong by more than its accuracy, but at most by `off`, for the
    `reason`. `distance` > 0: the publisher's own printed distance from the exact number; ours must be that far away,
    within the accuracy of the printed numbers.
    """

    quantity: str
    value: float
    read: Reading
    accuracy: float
    off: float = 0.0
    reason: str = ""
    distance: float = 0.0


@dataclass(frozen=True)
class Publication:
    """One motion computed by another program: our case for it, its source, and its numbers.

    `accuracy` describes the origin of the publisher's accuracy. `whole`: the numbers cover the motion through its
    transitions from start to end.
    """

    name: str
    program: str
    source: str
    accuracy: str
    case: Callable[[], Case]
    numbers: tuple[Number, ...]
    whole: bool = False


def motion_of(publication: Publication) -> Trajectory:
    """Our motion of a publication's case."""
    return reference.simulate(publication.case(), rtol=RTOL)


def verdict(number: Number, ours: float) -> str:
    """ "agrees" within the publisher's accuracy; "reproduces its error" if ours is as far from the published number as
    the publisher's exact one; "known" within `off`; otherwise "differs"."""
    difference = abs(ours - number.value)
    if number.distance:
        return "reproduces its error" if abs(difference - number.distance) <= number.accuracy else "differs"
    if difference <= number.accuracy:
        return "agrees"
    return "known" if difference <= number.off else "differs"


def row(publication: Publication, number: Number, ours: float) -> Row:
    """One row of the table; keys as in COLUMNS."""
    verdict_word = verdict(number, ours)
    return {
        "program": publication.program,
        "scene": publication.name,
        "quantity": number.quantity,
        "published": _digits(number.value, number.accuracy),
        "ours": _digits(ours, number.accuracy),
        "difference": ours - number.value,
        "accuracy": number.accuracy,
        "verdict": verdict_word,
        "note": _note(number, verdict_word),
        "source": publication.source,
    }


def _note(number: Number, verdict_word: str) -> str:
    """The reason of a known disagreement, or what is compared if it is not the number itself."""
    if number.distance:
        return f"compared: its printed distance from the exact number, {number.distance:.3g}"
    return number.reason if verdict_word == "known" else ""


def _digits(value: float, accuracy: float) -> str:
    """A number with one digit more than its accuracy, so that a table shows how far two numbers agree."""
    return f"{value:.{max(0, 1 - floor(log10(accuracy)))}f}"


def rows(publications: Sequence[Publication]) -> list[Row]:
    """The table of some publications: one row per number, in their order."""
    table = []
    for publication in publications:
        motion = motion_of(publication)
        table += [row(publication, number, number.read(motion)) for number in publication.numbers]
    return table
