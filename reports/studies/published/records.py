"""Numbers that other people's programs publish, and ours beside them.

`rows(publications)` computes their motions by the reference and gives one row per number; `COLUMNS` has the columns'
words. A number counts as met when ours lies within the publisher's own accuracy. Where a
publisher is known to be off by more, the number tells by how much and why, and that claim is tested in its place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import reference
from cases import Case, Trajectory

from ...running.records import Row

Reading = Callable[[Trajectory], float]

# The finest tolerance that both integrators reach; every publisher's accuracy but one (1e-12) is far coarser.
RTOL = 1e-13

COLUMNS = {
    "program": "whose number",
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
    """One published number: `read` takes it from our motion, in the same unit; `accuracy` is absolute.

    `off` > 0: the published number is known to be wrong by more than its accuracy, by `off` at most; the publication's
    `known` says why.
    """

    quantity: str
    published: float
    read: Reading
    accuracy: float
    off: float = 0.0


@dataclass(frozen=True)
class Publication:
    """One motion that somebody else's program computes: the case it is here, where it stands, and its numbers.

    `accuracy` says in a phrase where the publisher's accuracy comes from. `whole` is true where the numbers follow the
    motion through its transitions, from start to end.
    """

    name: str
    program: str
    source: str
    accuracy: str
    case: Callable[[], Case]
    numbers: tuple[Number, ...]
    whole: bool = False
    known: str = ""


def motion_of(publication: Publication) -> Trajectory:
    """Our motion of a publication's case."""
    return reference.simulate(publication.case(), rtol=RTOL)


def verdict(number: Number, ours: float) -> str:
    """ "agrees" within the publisher's accuracy; "known" within `off`; else "differs"."""
    difference = abs(ours - number.published)
    if difference <= number.accuracy:
        return "agrees"
    return "known" if difference <= number.off else "differs"


def row(publication: Publication, number: Number, ours: float) -> Row:
    """One row of the table; keys as in COLUMNS."""
    found = verdict(number, ours)
    return {
        "program": publication.program,
        "scene": publication.name,
        "quantity": number.quantity,
        "published": number.published,
        "ours": ours,
        "difference": ours - number.published,
        "accuracy": number.accuracy,
        "verdict": found,
        "note": publication.known if found == "known" else "",
        "source": publication.source,
    }


def rows(publications: Sequence[Publication]) -> list[Row]:
    """The table of some publications: one row per number, in their order."""
    table = []
    for publication in publications:
        motion = motion_of(publication)
        table += [row(publication, number, number.read(motion)) for number in publication.numbers]
    return table
