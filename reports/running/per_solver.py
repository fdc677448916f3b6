"""Tables and figures of several solvers: where the rows of one make them fail, they are made without it and say so."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple, TypeVar

from .records import legible

T = TypeVar("T")


class LeftOut(NamedTuple):
    """A solver whose rows a table or figure was made without, and why."""

    item: str
    solver: str
    reason: str


def make_per_solver(
    make: Callable[..., T], records: tuple, solvers: Iterable[str], item: str = ""
) -> tuple[T, list[LeftOut]]:
    """What `make(*records)` makes, and the solvers without whose rows it was made.

    A solver is left out if `make` fails on its rows alone; if it fails on no solver's alone, each one without whose
    rows it does not fail. Raises what `make` raises where no solver's rows are the reason, and OSError in any case: a
    full disk is not the fault of a row.
    """
    try:
        return make(*records), []
    except OSError:
        raise
    except Exception as whole:  # whatever rows of a wrong form may raise
        names = tuple(dict.fromkeys(solvers))
        failures = {name: _failure(make, _without(records, {*names} - {name})) for name in names}
        reasons = {name: said for name, said in failures.items() if said}
        if not reasons:
            failures = {name: _failure(make, _without(records, {name})) for name in names}
            reasons = {name: _sentence(whole) for name, said in failures.items() if not said}
        if not reasons:
            raise
        left = [LeftOut(item, name, reason) for name, reason in reasons.items()]
        return make(*_without(records, set(reasons))), left


def _without(records: tuple, solvers: set[str]) -> tuple:
    return tuple(without(each, solvers) for each in records)


def words(left_out: Iterable[LeftOut]) -> str:
    """What a caption says of those who were left out."""
    return " ".join(f"Without {one.solver}, whose results could not be shown: {one.reason}." for one in left_out)


def _failure(make: Callable, records: tuple) -> str:
    """Why `make` fails on these records; "" if it does not."""
    try:
        make(*records)
    except OSError:
        raise
    except Exception as problem:
        return _sentence(problem)
    return ""


def _sentence(problem: Exception) -> str:
    return legible(f"{type(problem).__name__}: {' '.join(str(problem).split())}", 500)


# --- rows of some solvers ---------------------------------------------------------------------------------------------


def solvers_of(records: Any) -> list[str]:
    """The solvers that rows of the records name, in their order."""
    return list(dict.fromkeys(_name(records)))


def without(records: Any, solvers: Collection[str]) -> Any:
    """The same records without what belongs to these solvers: in lists, tuples, tables of pandas and fields of the
    reports' own records the rows that name one as their `solver` or, as tuples, among their elements; in mappings what
    stands under such a tuple."""
    if _is_table(records):
        return records[~records["solver"].isin(solvers)] if "solver" in records.columns else records
    if isinstance(records, Mapping):
        others = {key: value for key, value in records.items() if type(key) is not tuple or not _belongs(key, solvers)}
        return {key: without(value, solvers) for key, value in others.items()}
    if type(records) in (list, tuple):
        return type(records)(without(each, solvers) for each in records if not _belongs(each, solvers))
    fields = {name: without(value, solvers) for name, value in _fields(records).items()}
    return type(records)(**fields) if fields else records


def _name(records: Any) -> Iterator[str]:
    solver = _solver(records)
    if isinstance(solver, str):
        yield solver
    elif _is_table(records):
        yield from records["solver"] if "solver" in records.columns else ()
    elif isinstance(records, Mapping | list | tuple):
        values = records.values() if isinstance(records, Mapping) else records
        for value in values:
            yield from _name(value)
    else:
        for value in _fields(records).values():
            yield from _name(value)


def _belongs(each: Any, solvers: Collection[str]) -> bool:
    if type(each) is tuple:
        return any(_belongs(part, solvers) for part in each)
    named = each if isinstance(each, str) else _solver(each)
    return isinstance(named, str) and named in solvers


def _solver(row: Any) -> Any:
    return row.get("solver") if isinstance(row, dict) else getattr(row, "solver", None)


def _is_table(records: Any) -> bool:
    return hasattr(records, "columns") and hasattr(records, "isin")  # pandas is slow to import, and need not be


def _fields(record: Any) -> dict[str, Any]:
    """The fields of one of the reports' own records; none of anything else, such as a number, an array or a case, which
    holds no solver's rows."""
    if type(record).__module__.partition(".")[0] != __name__.partition(".")[0]:
        return {}
    if dataclasses.is_dataclass(record):
        return {f.name: getattr(record, f.name) for f in dataclasses.fields(record) if f.init}
    return record._asdict() if hasattr(record, "_asdict") else {}
