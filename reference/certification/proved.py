"""Which transitions of a certificate are proved: enclosed by a stored proof inside the certificate's error bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..proofs import catalogue

if TYPE_CHECKING:
    from .certificate import Certificate

PROVED, WITNESSED = "proved", "witnessed"


def kinds(certificate: Certificate) -> tuple[str, ...]:
    """For each transition "proved" or "witnessed".

    Proved: the stored proof of the catalogue's case of that name has the same modes up to there, and its intervals of
    time and place lie inside the certificate's bars.
    """
    proof = catalogue.read().get(certificate.case)
    count = 0
    for claim, (before, after, time, xi1) in zip(
        proof.transitions if proof else (), certificate.transitions, strict=False
    ):
        if (claim.before, claim.after) != (str(before), str(after)):
            break
        if not (claim.time.inside(*time) and claim.xi1.inside(*xi1)):
            break
        count += 1
    return (PROVED,) * count + (WITNESSED,) * (len(certificate.transitions) - count)
