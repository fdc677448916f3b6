"""Computation of the parts of a sweep in workers of this machine or of a cluster.

A part that ends its worker is halved until the scenario that causes it is isolated; that scenario is a row of failure.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import pyarrow as pa

from ..running.processes.cluster import Cluster
from ..running.processes.workers import WorkerPool
from . import parts
from .parts import SweepWork

# Wall-clock limit of a part in seconds: parts are sized to take seconds.
PATIENCE = 900.0
# Parts submitted to a pool at a time: the pool searches its waiting parts whenever it assigns one.
TOGETHER = 1000


class Part(NamedTuple):
    """A range of scenarios: start … stop − 1."""

    start: int
    stop: int


Progress = Callable[[str, int, Iterator], Iterator]


def run_parts(work: SweepWork, pending: Sequence[Part], pool: WorkerPool | Cluster) -> Iterator[tuple[Part, bytes]]:
    """Yield the bytes of each part as it is completed; closes the pool at the end."""
    try:
        failed_parts = []
        for begin in range(0, len(pending), TOGETHER):
            batch = pending[begin : begin + TOGETHER]
            for i, answer in pool.run(parts.perform, [(work, *part) for part in batch], PATIENCE):
                if answer.outcome == "done":
                    yield batch[i], answer.value
                else:
                    failed_parts.append(batch[i])
        for whole in failed_parts:
            yield whole, _in_halves(pool, work, whole)
    finally:
        pool.close()


def _in_halves(pool: WorkerPool | Cluster, work: SweepWork, whole: Part) -> bytes:
    """Compute a failed part by repeated halving."""
    waiting, tables = [whole], []
    while waiting:
        batch, waiting = waiting, []
        for i, answer in pool.run(parts.perform, [(work, *piece) for piece in batch], PATIENCE):
            start, stop = batch[i]
            if answer.outcome == "done":
                tables.append(answer.value)
            elif stop - start == 1:
                outcome, reason = answer.failure
                tables.append(parts.failure_text(work, start, outcome, reason))
            else:
                middle = (start + stop) // 2
                waiting += [Part(start, middle), Part(middle, stop)]
    return join_parts(tables)


def join_parts(contents: Sequence[bytes]) -> bytes:
    """Join the pieces of a part to one file."""
    from pyarrow import parquet

    tables = [parquet.read_table(pa.BufferReader(content)) for content in contents]
    return parts.pack(pa.concat_tables(tables).sort_by("scenario"))
