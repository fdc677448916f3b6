"""Data for the template of the evidence: which transitions are proved, and the studies."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from reference.certification import PROVED
from reference.proofs import catalogue
from reference.proofs.record import DecimalInterval, Proof, ProvedTransition

from .. import studies
from ..running.records import Experiment, Truth
from .fragments import anchor, table

if TYPE_CHECKING:
    from ..studies import Result

# A statement with more transitions is too long for the page; the command writes it.
_MOST_CLAIMS = 6


def proofs(experiment: Experiment) -> dict[str, Any]:
    """The stored proofs of the cases: how many of their transitions are proved, the first one's enclosure, and the
    whole statement. A case has a row if a transition is proved, or that it has none."""
    stored = catalogue.read()
    rows = [
        _row(label, truth, stored[label])
        for label, truth in experiment.truths.items()
        if label in stored and (PROVED in truth.kinds or _has_none(truth, stored[label]))
    ]
    kinds = [kind for truth in experiment.truths.values() for kind in truth.kinds]
    methods = list(dict.fromkeys(stored[row["case"]].method for row in rows))
    return {"rows": rows, "methods": methods, "proved": kinds.count(PROVED), "transitions": len(kinds)}


def _has_none(truth: Truth, proof: Proof) -> bool:
    """Whether it is proved that the motion has no transition, as the truth has none."""
    return proof.complete and not proof.transitions and not truth.transitions and not truth.failure


def _row(label: str, truth: Truth, proof: Proof) -> dict[str, Any]:
    count = truth.kinds.count(PROVED)
    first = proof.transitions[0] if proof.transitions else None
    return {
        "case": label,
        "anchor": anchor(label),
        "proved": count,
        "transitions": len(truth.transitions),
        "change": _change(first) if first else "",
        "share": _share(first) if first else "",
        "time": enclosure(first.time) if first else "",
        "width": f"{first.time.width:.0e}".replace("e-0", "e-") if first else "",
        "order": repr(float(Fraction(first.time.low))) if first else "1e308",
        "statement": proof.statement if len(proof.transitions) <= _MOST_CLAIMS else "",
        "is_whole": proof.complete and count == len(truth.transitions),
    }


def _change(transition: ProvedTransition) -> str:
    return f"{transition.before} → {transition.after}".replace("_", " ")


def _share(transition: ProvedTransition) -> str:
    """Where the slip vanishes without rolling: the friction that rolling needs as a multiple of the cone's."""
    share = transition.rolling_share
    return "" if share is None or Fraction(share.low) <= 1 else f"{float(Fraction(share.low)):.5g}"


def enclosure(interval: DecimalInterval) -> str:
    """A time as its two ends, the digits that they have in common written once: 0.63[07, 08]."""
    low, high = interval
    length = next((i for i, (one, other) in enumerate(zip(low, high, strict=False)) if one != other), len(low) - 1)
    length = min(length, len(low) - 1, len(high) - 1)
    return f"{low[:length]}[{low[length:]}, {high[length:]}]"


def on_request(results: Sequence[Result]) -> list[str]:
    """The names of the studies that the report does not have."""
    made = {result.name for result in results}
    return [name for name in studies.names() if name not in made]


def study(result: Result) -> dict[str, Any]:
    """Data of a study for its template: question, texts of its scenes and tables, or the reason why it failed."""
    in_words = getattr(result.study, "in_words", None)
    texts = in_words(result.findings) if in_words and not result.failure else {}
    tables = [
        {"name": name, "holds": result.words[name].holds}
        | table(frame, {str(c): str(c).replace("_", " ") for c in frame.columns if c != "version"},
                result.words[name].columns, file=name)
        for name, frame in result.frames.items()
    ]  # fmt: skip
    return {
        "id": result.name,
        "title": result.study.TITLE,
        "question": result.study.QUESTION,
        "failure": result.failure,
        "command": result.command,
        "tab": result.study.TAB,
        "texts": list(texts.items()),
        "tables": tables,
    }
