"""The laws of mechanics that adapters are held to: this suite's in its tests, anybody's by `python -m adapters.laws`.

`LAWS` maps names to laws, plain functions of a `Route`. A law raises AssertionError, which begins with its name, if the
route breaks it, `Unsupported` if the route cannot model its scene, and `NotReported` if the route does not report what
the law is about. `judge` tries them all. For tests of one's own there are the laws themselves
(`adapters.laws.mechanics`), their scenes, `mirror` and `turn_gravity`, and `hold` with the scales of an error.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from . import effects, mechanics
from .mechanics import SCENES, Law, mirror, turn_gravity
from .runs import LawRun, NotReported, Route, Unsupported, hold

__all__ = [
    "LAWS",
    "SCENES",
    "Law",
    "NotReported",
    "Unsupported",
    "Route",
    "LawRun",
    "Verdict",
    "hold",
    "judge",
    "mirror",
    "turn_gravity",
]


LAWS: dict[str, Law] = {**mechanics.LAWS, **effects.LAWS}


class Verdict(NamedTuple):
    """What came of one law on one route: "kept", "broken", "refused", "not told" or "failed", and why in a sentence."""

    route: str
    law: str
    outcome: str
    reason: str = ""


def judge(adapter: Any, laws: Iterable[str] = tuple(LAWS), routes: Iterable[str] | None = None) -> Iterator[Verdict]:
    """The verdicts of these laws on the routes (default: the adapter's own), one after another.

    `adapter` is a module, or anything else with an adapter's functions. An exception is a verdict too; what ends the
    process ends it here.
    """
    laws = tuple(laws)
    for route in adapter.routes if routes is None else routes:
        for law in laws:
            yield Verdict(route, law, *_try(law, Route(adapter, route)))


def _try(law: str, route: Route) -> tuple[str, str]:
    try:
        LAWS[law](route)
    except Unsupported as refusal:
        return "refused", str(refusal)
    except NotReported as silence:
        return "not told", str(silence)
    except AssertionError as violation:
        return "broken", str(violation)
    except Exception as problem:
        return "failed", f"{type(problem).__name__}: {problem}"
    return "kept", ""
