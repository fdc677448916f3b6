"""A pool of compiled integrators for several threads, each of which uses its own."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, Concatenate, ParamSpec, TypeVar

from cases.derivation import in_one_thread

P = ParamSpec("P")
T = TypeVar("T")


class IntegratorPool:
    """Identical integrators, as many as were ever in use at the same time.

    An integrator stores the time, state and parameters of its present phase, so that no other phase may use it until
    the results are read. `make` makes one; a single thread never needs a second.
    """

    def __init__(self, make: Callable[[], Any]):
        self._make, self._free = make, [make()]
        self._original: Any = None  # the source of copies, never in use itself

    def call(self, function: Callable[Concatenate[Any, P], T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call `function(integrator, …)` with an integrator that is not used elsewhere until it returns."""
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
        """One more integrator. A copy takes 2 ms and shares the machine code; making one takes at least ten times as
        long."""
        if self._original is None:
            self._original = self._make()
        return deepcopy(self._original)
