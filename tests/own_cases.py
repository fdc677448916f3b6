"""The cases of `pytest --case-file=FILE`, and the parametrisation over them or, without any, over the catalogue."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import pytest

import cases
from cases import Case
from tests.sampling import quick_every

CASES: list[Case] = []  # conftest adds those of the files before a test is imported


def variants(names: Iterable[str]) -> list[Case]:
    """All variants of these cases."""
    return [case for name in names for case in cases.select(name)]


def any_case(every: int = 1, first: int = 0) -> Callable:
    """A test for each variant of each case of the catalogue (hard ones have `test_atlas`), of which every so many-th is
    quick (see `quick_every`), or for all of the files."""
    some = CASES or variants(cases.names(hard=False))
    rows = pytest.mark.parametrize("any_case", some, ids=[case.label for case in some])
    sampled = quick_every(1) if CASES else quick_every(every, first)
    return lambda test: sampled(rows(test))
