"""Calls in workers whose finished answers are kept: `Recall.run` stands where `workers.run` would.

For what has no key of its own: the key is made of the function's code, its arguments and the solvers they name.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from functools import lru_cache
from typing import Any, get_type_hints

from . import workers
from .fingerprint import Key, content, made_with, plain, record_digest, sources
from .records import CaseKey
from .store import Store
from .tasks import load
from .workers import Answer

# The store's word for these.
_KIND = "trial"


class Recall:
    """Takes from a store what was finished before. `versions`: what each solver told of itself."""

    def __init__(self, store: Store, versions: Mapping[str, str]):
        self._store, self._versions = store, versions

    def run(
        self,
        function: Callable,
        arguments: Sequence[tuple],
        jobs: int = 1,
        limit: float = 60.0,
        instead: Callable[[int], Answer | None] = lambda index: None,
    ) -> Generator[tuple[int, Answer]]:
        """As `workers.run`, but for what is kept, which comes first. What a call returned is kept; a failure is not.

        The function's annotation says what it returns; it must not depend on anything but its arguments.
        """
        record = get_type_hints(function)["return"]
        keys = [self._key(function, args) for args in arguments]
        left = []
        for i, key in enumerate(keys):
            kept = self._store.get(_KIND, key, record)
            if kept is None:
                left.append(i)
            else:
                yield i, Answer("done", value=kept)
        if not left:
            return
        calls = [arguments[i] for i in left]
        with closing(workers.run(function, calls, jobs, limit, lambda k: instead(left[k]))) as coming:
            for k, answer in coming:
                if answer.outcome == "done":
                    self._store.put(_KIND, keys[left[k]], answer.value)
                yield left[k], answer

    def _key(self, function: Callable, arguments: tuple) -> Key | None:
        solvers = [a for a in arguments if isinstance(a, str) and a in self._versions]
        cases = [a for a in arguments if isinstance(a, CaseKey)]
        told = [_told(argument) for argument in arguments]
        engines = made_with(self._versions, solvers)
        if engines is None or any(_content(case) is None for case in cases):
            return None
        what = {"function": f"{function.__module__}.{function.__qualname__}", "arguments": told}
        return {
            "case": ", ".join(load(case).label for case in cases),
            **what,
            "code": sources(function.__module__),
            **engines,
        }


def _told(argument: Any) -> Any:
    if isinstance(argument, CaseKey):
        return [_content(argument), bool(argument.files)]
    try:
        return plain(argument)
    except TypeError:
        return record_digest(argument)  # what holds arrays


@lru_cache(maxsize=256)
def _content(key: CaseKey) -> str | None:
    return content(load(key))
