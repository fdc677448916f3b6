"""Which transitions of a certificate are proved: enclosed by a stored proof inside the certificate's error bars."""

from __future__ import annotations

from collections.abc import Sequence

from cases import Mode

from ..proofs import catalogue
from .bars import Bar

PROVED, WITNESSED = "proved", "witnessed"


def kinds(label: str, transitions: Sequence[tuple[Mode, Mode, Bar, Bar]]) -> tuple[str, ...]:
    """For each transition (modes, time, ξ₁) of the case "proved" or "witnessed".

    Proved: the stored proof of the catalogue's case of that label has the same modes up to there, and its intervals of
    time and place lie inside the bars.
    """
    proof = catalogue.read().get(label)
    count = 0
    for claim, (before, after, time, xi1) in zip(proof.transitions if proof else (), transitions, strict=False):
        if (claim.before, claim.after) != (str(before), str(after)):
            break
        if not (claim.time.inside(*time) and claim.xi1.inside(*xi1)):
            break
        count += 1
    return (PROVED,) * count + (WITNESSED,) * (len(transitions) - count)
