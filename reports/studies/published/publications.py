"""Numbers published by other programs, compared with ours.

`rows(publications)` computes their motions with the reference and returns one row per number; `COLUMNS` has the
headings. A number agrees if ours lies within the publisher's own accuracy. If a published number is known to be wrong
by more, its record gives the amount and the reason, and this claim is tested instead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import reference
from cases import Case, Trajectory

from ...running.records import Row

Reading = Callable[[Trajectory], float]

# The finest tolerance that both integrators reach; all publishers' accuracies except one (1e-12) are far coarser.
RTOL = 1e-13

COLUMNS = {
    "program": "program",
    "scene": "scene",
    "quantity": "quantity",
    "published": "published",
    "ours": "ours",
    "difference": "difference",
    "accuracy": "publisher's own accuracy",
    "verdict": "verdict",
    "note": "why they differ",
    "source": "source",
}


@dataclass(frozen=True)
class Number:
    """One published number: `read` computes it from our motion, in the same unit; `accuracy` is absolute.

    `off` > 0: the published number is known to be wrong by more than its accuracy, but at most by `off`; the reason is
    in the publication's `explanation`.
    """

    quantity: str
    value: float
    read: Reading
    accuracy: float
    off: float = 0.0


@dataclass(frozen=True)
class Publication:
    """One motion computed by another program: our case for it, its source, and its numbers.

    `accuracy` describes the origin of the publisher's accuracy. `whole`: the numbers cover the motion through its
    transitions from start to end. `explanation`: the reason of numbers that are known to be wrong.
    """

    name: str
    program: str
    source: str
    accuracy: str
    case: Callable[[], Case]
    numbers: tuple[Number, ...]
    whole: bool = False
    explanation: str = ""


def motion_of(publication: Publication) -> Trajectory:
    """Our motion of a publication's case."""
    return reference.simulate(publication.case(), rtol=RTOL)


def verdict(number: Number, ours: float) -> str:
    """ "agrees" within the publisher's accuracy; "known" within `off`; otherwise "differs"."""
    difference = abs(ours - number.value)
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
        "published": number.value,
        "ours": ours,
        "difference": ours - number.value,
        "accuracy": number.accuracy,
        "verdict": verdict_word,
        "note": publication.explanation if verdict_word == "known" else "",
        "source": publication.source,
    }


def rows(publications: Sequence[Publication]) -> list[Row]:
    """The table of some publications: one row per number, in their order."""
    table = []
    for publication in publications:
        motion = motion_of(publication)
        table += [row(publication, number, number.read(motion)) for number in publication.numbers]
    return table
