"""Maps instead of motions: one case with many parameters at once. Who asks for one motion asks `reference.simulate`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .plan import Axis, Plan, plan

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Axis", "Plan", "plan", "sweep", "sweep_chunks"]

# Scenarios to a chunk: enough to share Python's time among, and some megabytes.
CHUNK = 4000
# From so many scenarios on it is worth a second or two to compile for speed.
MANY = 20_000


def sweep(case: Any, sample: str = "grid", number: int | None = None, seed: int = 0, rtol: float = 1e-10, **vary: Any):
    """The motions of a case over parameters, as a DataFrame on Arrow's columns: one row a scenario.

    `case` is a name, a catalogue's Case or a function that makes one; each further argument is a parameter and its
    values: numbers, or text such as "0.01:0.5:200" or "0.01:0.5:200:log". Several make a grid, the last one running
    fastest; with `sample` "random" or "sobol" `number` points are drawn from their ranges (low, high). After the
    parameters the columns are those of `reference.sweeping.table.COLUMNS`. A scenario that no scene can be is a row.
    Raises CaseError, in one sentence, for what makes no sense.
    """
    import pandas as pd

    return pd.concat(sweep_chunks(case, sample, number, seed, rtol, **vary), ignore_index=True)


def sweep_chunks(
    case: Any, sample: str = "grid", number: int | None = None, seed: int = 0, rtol: float = 1e-10, **vary: Any
) -> Iterator[pd.DataFrame]:
    """The same, CHUNK rows at a time: memory does not grow with the sweep."""
    from . import table

    request = plan(case, vary, sample, number, seed, rtol)
    table.check_names(request)
    return _frames(request)


def _frames(request: Plan) -> Iterator[pd.DataFrame]:
    import pandas as pd

    from . import table

    for start in range(0, len(request), CHUNK):
        rows = table.scenario_rows(request, start, min(start + CHUNK, len(request)), len(request) >= MANY)
        yield rows.to_pandas(types_mapper=pd.ArrowDtype)
