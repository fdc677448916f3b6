"""Tables and figures of several solvers: if they fail with the rows of one, they are made without it and report it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple, TypeVar

from .names import legible

T = TypeVar("T")


class LeftOut(NamedTuple):
    """A solver whose rows a table or figure (`item`) omits, and the reason."""

    item: str
    solver: str
    reason: str


def make_per_solver(
    make: Callable[..., T], records: tuple, solvers: Iterable[str], item: str = ""
) -> tuple[T, list[LeftOut]]:
    """The result of `make(*records)`, and the solvers whose rows were omitted because `make` fails with them.

    A solver is omitted if `make` fails on its rows alone. If it fails on no solver's rows alone, each solver is omitted
    without which `make` succeeds. If no solver is the cause, the error of `make` is raised; OSError is always raised,
    because rows do not cause a full disk.
    """
    try:
        return make(*records), []
    except OSError:
        raise
    except Exception as whole:  # rows of a wrong form can raise anything
        names = tuple(dict.fromkeys(solvers))
        failures = {name: _failure(make, _without(records, {*names} - {name})) for name in names}
        reasons = {name: reason for name, reason in failures.items() if reason}
        if not reasons:
            failures = {name: _failure(make, _without(records, {name})) for name in names}
            reasons = {name: _sentence(whole) for name, reason in failures.items() if not reason}
        if not reasons:
            raise
        omissions = [LeftOut(item, name, reason) for name, reason in reasons.items()]
        return make(*_without(records, set(reasons))), omissions


def _without(records: tuple, solvers: set[str]) -> tuple:
    return tuple(without(each, solvers) for each in records)


def words(left_out: Iterable[LeftOut]) -> str:
    """The sentence of a caption about omitted solvers."""
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
    """The solvers in the rows of the records, in their order."""
    return list(dict.fromkeys(_name(records)))


def without(records: Any, solvers: Collection[str]) -> Any:
    """The records without the rows of these solvers.

    In lists, tuples, pandas tables and fields of the reports' own records, rows whose `solver` (in tuples, any element)
    is one of them are omitted; in mappings, entries whose key is such a tuple."""
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
    name = each if isinstance(each, str) else _solver(each)
    return isinstance(name, str) and name in solvers


def _solver(row: Any) -> Any:
    return row.get("solver") if isinstance(row, dict) else getattr(row, "solver", None)


def _is_table(records: Any) -> bool:
    return hasattr(records, "columns") and hasattr(records, "isin")  # without importing pandas, which is slow


def _fields(record: Any) -> dict[str, Any]:
    """The fields of one of the reports' own records; none for other values (numbers, arrays, cases), which contain no
    rows of solvers."""
    if type(record).__module__.partition(".")[0] != __name__.partition(".")[0]:
        return {}
    if dataclasses.is_dataclass(record):
        return {f.name: getattr(record, f.name) for f in dataclasses.fields(record) if f.init}
    return record._asdict() if hasattr(record, "_asdict") else {}
