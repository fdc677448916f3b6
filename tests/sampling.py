"""One claim over many scenes: of a parametrisation every so many-th row is quick, and the others are slow tests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

import pytest


def quick_every(every: int, first: int = 0) -> Callable:
    """A decorator above all `parametrize` of a test: of the combinations without a slow value, in the order in which
    pytest runs them, number `first`, `first + every`, … stay quick; the others are marked slow."""

    def sampled(test: Callable) -> Callable:
        axes = [mark for mark in test.pytestmark if mark.name == "parametrize"]
        test.pytestmark = [mark for mark in test.pytestmark if mark.name != "parametrize"]
        # pytest varies the uppermost decorator fastest, which is the last in this list.
        names = [name for mark in axes for name in _names(mark.args[0])]
        named = any(mark.kwargs.get("ids") or any(row.id for row in _rows(mark)) for mark in axes)
        number, rows = 0, []
        for row in reduce(lambda one, other: [_joined(a, b) for a in one for b in other], map(_rows_with_ids, axes)):
            marks = list(row.marks)
            if not any(mark.name == "slow" for mark in marks):
                marks += [] if number % every == first else [pytest.mark.slow]
                number += 1
            rows.append(pytest.param(*row.values, marks=marks, id=row.id if named else None))
        return pytest.mark.parametrize(names, rows)(test)

    return sampled


def _names(names: str | Sequence[str]) -> list[str]:
    return [name.strip() for name in names.split(",")] if isinstance(names, str) else list(names)


def _rows(mark: pytest.Mark) -> list[Any]:
    """The rows of one `parametrize`, each as `pytest.param` makes it."""
    single = len(_names(mark.args[0])) == 1
    known = type(pytest.param())
    rows = [row if isinstance(row, known) else pytest.param(*((row,) if single else row)) for row in mark.args[1]]
    return rows


def _rows_with_ids(mark: pytest.Mark) -> list[Any]:
    """The rows of one `parametrize`, each with its identification."""
    rows, ids, names = _rows(mark), mark.kwargs.get("ids"), _names(mark.args[0])
    given: list[Any] = [None] * len(rows) if ids is None or callable(ids) else list(ids)
    return [
        pytest.param(*row.values, marks=row.marks, id=row.id or own or "-".join(_ids(row, i, names, ids)))
        for i, (row, own) in enumerate(zip(rows, given, strict=True))
    ]


def _ids(row: Any, number: int, names: Sequence[str], ids: Any) -> list[str]:
    """What pytest would write for the values of a row: plain values as they are, others by name and number."""
    texts = []
    for name, value in zip(names, row.values, strict=True):
        said = ids(value) if callable(ids) else value
        texts.append(str(said) if isinstance(said, str | int | float | bool | None) else f"{name}{number}")
    return texts


def _joined(one: Any, other: Any) -> Any:
    return pytest.param(*one.values, *other.values, marks=[*one.marks, *other.marks], id=f"{one.id}-{other.id}")
