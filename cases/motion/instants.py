"""The list of changes of mode at one instant."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import groupby

from .trajectory import Mode, Transition


def one_per_instant(changes: Iterable[Transition]) -> tuple[Transition, ...]:
    """The changes of mode in the order of their times, at each instant one per contact, by its name.

    Impacts that follow each other at one instant may be found one after the other, or together. A contact then changes
    from its mode before the first one to its mode after the last one. It is left out if both are the same, unless it is
    hit in flight and flies on.
    """
    listed = list[Transition]()
    for _, group in groupby(changes, key=lambda change: change.time):
        first, last = dict[str, Transition](), dict[str, Transition]()
        for change in group:
            first.setdefault(change.contact, change)
            last[change.contact] = change
        net = (replace(last[name], before=first[name].before) for name in sorted(last))
        listed += [change for change in net if change.before is not change.after or change.after is Mode.FLIGHT]
    return tuple(listed)
