"""SymPy, imported when the first of its names is used: what has no formula of a user needs none of it, and it takes
longer to import than all the rest.

`from cases.formulas import late_sympy as sp` stands for `import sympy as sp`. Names at the head of a
module would import it at once.
"""

from importlib import import_module
from typing import Any


def __getattr__(name: str) -> Any:
    if name.startswith("__"):  # Python's own questions about a module
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module("sympy"), name)
    return value
