"""Parameter sweeps: one case with many sets of parameter values. For a single motion use `reference.simulate`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from .plan import Axis, Plan, plan

if TYPE_CHECKING:
    import pandas as pd

    from cases import Case

    from .sweep_table import SweepTable

    Scene = str | Case | Callable[..., Case]

__all__ = ["Axis", "Plan", "plan", "sweep", "sweep_chunks"]

# Scenarios per chunk: enough to spread Python's overhead over, and some megabytes of memory.
CHUNK = 4000
# From this many scenarios on, optimised compilation (a second or two) pays for itself.
MANY = 20_000


def sweep(
    case: Scene, sample: str = "grid", number: int | None = None, seed: int = 0, rtol: float = 1e-10, **vary: Any
) -> SweepTable:
    """Simulate a case for many parameter values; returns a DataFrame, one row per scenario, NaN where it has no number;
    its `plot_map` draws two parameters, and `to_xarray` gives a grid.

    `case` is a name, a case of the catalogue or a function that returns a Case. Each further argument is a parameter
    with its values: numbers, or text such as "0.01:0.5:200" or "0.01:0.5:200:log". Several parameters form a grid, the
    last one varying fastest; with `sample` "random" or "sobol", `number` points are drawn from their ranges
    (low, high). The columns after the parameters are those of `reference.sweeping.table.COLUMNS`. A scenario with
    invalid parameters also gets a row. Raises CaseError with one sentence for invalid arguments.
    """
    import pandas as pd

    from .sweep_table import SweepTable

    rows = SweepTable(pd.concat(sweep_chunks(case, sample, number, seed, rtol, **vary), ignore_index=True))
    rows.parameters = tuple(vary)
    return rows


def sweep_chunks(
    case: Scene, sample: str = "grid", number: int | None = None, seed: int = 0, rtol: float = 1e-10, **vary: Any
) -> Iterator[pd.DataFrame]:
    """Same as `sweep`, but yields CHUNK rows at a time, so that memory does not grow with the sweep."""
    from . import table

    request = plan(case, vary, sample, number, seed, rtol)
    table.check_names(request)
    return _frames(request)


def _frames(request: Plan) -> Iterator[pd.DataFrame]:
    from pyarrow import Table
    from pyarrow.types import is_dictionary

    from . import table

    for start in range(0, len(request), CHUNK):
        rows = table.scenario_rows(request, start, min(start + CHUNK, len(request)), len(request) >= MANY)
        # Words as they are: as categories each chunk would have its own.
        columns = (one.cast(one.type.value_type) if is_dictionary(one.type) else one for one in rows.columns)
        yield Table.from_arrays(list(columns), rows.column_names).to_pandas()
