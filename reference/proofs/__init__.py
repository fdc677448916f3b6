"""Proofs: transitions of a case enclosed by theorems, with existence, uniqueness and no earlier event.

Needs python-flint (ball arithmetic): `pip install "slip-to-roll[proofs]"`. The equations are derived again in
`equations`; nothing of the two formulations is used.
"""

from .prove import prove
from .record import DecimalInterval, Proof, ProvedPhase, ProvedTransition

__all__ = ["DecimalInterval", "Proof", "ProvedPhase", "ProvedTransition", "prove"]
