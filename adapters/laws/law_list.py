"""All laws by name, and the verdicts of an adapter."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable, Iterator
from importlib import import_module
from typing import Any, NamedTuple

from cases import NotSupported
from cases.own_effects import registered

from . import runs
from .runs import Law, MissingQuantity, Route


def _own_laws() -> dict[str, Law]:
    """The laws of effects of installed packages, by the name of their function."""
    texts = [text for effect in registered().values() for text in effect.laws]
    laws = [pkgutil.resolve_name(text) for text in texts]
    return {law.__name__: law for law in laws}


# Each module adds its laws when it is imported, in this order.
for _module in ("mechanics", "equations", "effects", "free_plates"):
    import_module(f".{_module}", __package__)
LAWS: dict[str, Law] = {**runs.LAWS, **_own_laws()}


class Verdict(NamedTuple):
    """The outcome of one law on one route: "kept", "broken", "refused", "not reported" or "failed", and the reason."""

    route: str
    law: str
    outcome: str
    reason: str = ""


def judge(
    adapter: Any, laws: Iterable[str] = tuple(LAWS), routes: Iterable[str] | None = None, seed: int = 0
) -> Iterator[Verdict]:
    """The verdicts of these laws on the routes (default: all of the adapter), one after another.

    `seed` selects the values that the scenes draw at random.
    `adapter` is a module, or any object with an adapter's functions. An exception is a verdict too; an adapter that
    ends the process ends this one.
    """
    laws = tuple(laws)
    for route in adapter.routes if routes is None else routes:
        for law in laws:
            yield Verdict(route, law, *_try(law, Route(adapter, route, seed)))


def _try(law: str, route: Route) -> tuple[str, str]:
    try:
        LAWS[law](route)
    except NotSupported as refusal:
        return "refused", str(refusal)
    except MissingQuantity as silence:
        return "not reported", str(silence)
    except AssertionError as violation:
        return "broken", str(violation)
    except Exception as problem:
        return "failed", f"{type(problem).__name__}: {problem}"
    return "kept", ""
