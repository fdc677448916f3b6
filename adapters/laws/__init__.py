"""Laws of mechanics that adapters are checked against, in the tests and by the command `python -m adapters.laws`.

`LAWS` maps names to laws, plain functions of a `Route`. A law raises AssertionError, which begins with its name, if the
route breaks it, `cases.NotSupported` if the route cannot model its scene, and `MissingQuantity` if the route does not
report a quantity that the law needs. `judge` checks them all. For tests of other adapters there are the laws themselves
(`adapters.laws.mechanics`), their scenes (`scene`, drawn from a seed), `mirror` and `turn_gravity`, and `hold` with the
scales of an error.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .law_list import LAWS, Verdict, judge
    from .mechanics import mirror
    from .runs import Law, LawRun, MissingQuantity, Route, hold
    from .scenes import MORE_SCENES, SCENES, scene, turn_gravity

__all__ = [
    "LAWS",
    "MORE_SCENES",
    "SCENES",
    "Law",
    "MissingQuantity",
    "Route",
    "LawRun",
    "Verdict",
    "hold",
    "judge",
    "mirror",
    "scene",
    "turn_gravity",
]

# The modules of these names, which are imported at their first use: help needs none.
_MODULES = {
    "law_list": ("LAWS", "Verdict", "judge"), "mechanics": ("mirror",),
    "runs": ("Law", "LawRun", "MissingQuantity", "Route", "hold"),
    "scenes": ("MORE_SCENES", "SCENES", "scene", "turn_gravity"),
}  # fmt: skip
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)
