"""Compiled integrators that several threads use at once, each one of its own."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, Concatenate, ParamSpec, TypeVar

from cases.derivation import in_one_thread

P = ParamSpec("P")
T = TypeVar("T")


class IntegratorPool:
    """Equal integrators, as many as were ever in use at once.

    An integrator holds the time, state and parameters of the phase that it is at, so that no other phase may use it
    until that one is read. `make` makes one; a thread that works alone never needs a second.
    """

    def __init__(self, make: Callable[[], Any]):
        self._make, self._free = make, [make()]
        self._original: Any = None  # what further ones are copied from: it is never in use

    def call(self, function: Callable[Concatenate[Any, P], T], *args: P.args, **kwargs: P.kwargs) -> T:
        """`function(integrator, …)`, the integrator in no other use until it returns."""
        try:
            integrator = self._free.pop()
        except IndexError:
            integrator = self._another()
        try:
            return function(integrator, *args, **kwargs)
        finally:
            self._free.append(integrator)

    @in_one_thread
    def _another(self) -> Any:
        """One more. A copy takes 2 ms and shares the machine code; to make one takes ten times as long, or more."""
        if self._original is None:
            self._original = self._make()
        return deepcopy(self._original)
