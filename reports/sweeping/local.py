"""The parts of a sweep, in workers of this machine or of a cluster: a part that ends its worker is halved until the
scenario that does it stands alone, and is a row."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import pyarrow as pa

from ..running.cluster import Cluster
from ..running.workers import Pool
from . import parts
from .parts import Work

# Wall seconds that a part may take before it counts as lost: parts are made to take seconds.
PATIENCE = 900.0
# Parts a pool is given at a time: it looks through what waits whenever it hands one out.
TOGETHER = 1000


class Part(NamedTuple):
    """Scenarios start … stop − 1."""

    start: int
    stop: int


Progress = Callable[[str, int, Iterator], Iterator]


def done(work: Work, wanted: Sequence[Part], pool: Pool | Cluster) -> Iterator[tuple[Part, bytes]]:
    """The bytes of each part as they come; the pool is closed at the end."""
    try:
        failed = []
        for begin in range(0, len(wanted), TOGETHER):
            some = wanted[begin : begin + TOGETHER]
            for i, answer in pool.run(parts.perform, [(work, *part) for part in some], PATIENCE):
                if answer.outcome == "done":
                    yield some[i], answer.value
                else:
                    failed.append(some[i])
        for whole in failed:
            yield whole, _in_halves(pool, work, whole)
    finally:
        pool.close()


def _in_halves(pool: Pool | Cluster, work: Work, whole: Part) -> bytes:
    """A part that failed, by ever smaller pieces."""
    waiting, tables = [whole], []
    while waiting:
        some, waiting = waiting, []
        for i, answer in pool.run(parts.perform, [(work, *piece) for piece in some], PATIENCE):
            start, stop = some[i]
            if answer.outcome == "done":
                tables.append(answer.value)
            elif stop - start == 1:
                outcome, reason = answer.failure
                tables.append(parts.failed(work, start, outcome, reason))
            else:
                middle = (start + stop) // 2
                waiting += [Part(start, middle), Part(middle, stop)]
    return joined(tables)


def joined(contents: Sequence[bytes]) -> bytes:
    """Pieces of a part as one file."""
    from pyarrow import parquet

    tables = [parquet.read_table(pa.BufferReader(content)) for content in contents]
    return parts.packed(pa.concat_tables(tables).sort_by("scenario"))
