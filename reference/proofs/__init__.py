"""Proofs: transitions of a case enclosed by theorems, with existence, uniqueness and no earlier event.

`prove` needs python-flint (ball arithmetic): `pip install "slip-to-roll[proofs]"`. Stored proofs are read without it.
The equations are derived again in `equations`; nothing of the two formulations is used.
"""

from typing import TYPE_CHECKING, Any

from .record import DecimalInterval, Proof, ProvedPhase, ProvedTransition

if TYPE_CHECKING:
    from .prover import prove

__all__ = ["DecimalInterval", "Proof", "ProvedPhase", "ProvedTransition", "prove"]


def __getattr__(name: str) -> Any:
    """Import the prover on first use: it needs python-flint."""
    if name == "prove":
        from importlib import import_module

        return import_module(".prover", __name__).prove
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
