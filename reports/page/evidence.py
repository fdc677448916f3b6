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
from .fragments import anchor
from .page_table import LAST, Cell, Head, PageRow, PageTable, table

if TYPE_CHECKING:
    from ..studies import Result

# A statement with more transitions is too long for the page; the command writes it.
_MOST_CLAIMS = 6


_SHARE = "where the slip vanishes without rolling: the friction that rolling needs as a multiple of the cone's"
_HEADS = (
    Head("case"), Head("transitions proved", number=True), Head("the first"), Head("enclosed at", "s"),
    Head("width", "s", number=True), Head("rolling needs ×", number=True, tip=_SHARE),
)  # fmt: skip


def proofs(experiment: Experiment) -> dict[str, Any]:
    """The stored proofs of the cases: how many of their transitions are proved, the first one's enclosure, and the
    whole statement. A case has a row if a transition is proved, or that it has none."""
    stored = catalogue.read()
    truths = {
        label: truth
        for label, truth in experiment.truths.items()
        if label in stored and (PROVED in truth.kinds or _has_none(truth, stored[label]))
    }
    lines = [_line(label, truth, stored[label]) for label, truth in truths.items()]
    kinds = [kind for truth in experiment.truths.values() for kind in truth.kinds]
    return {
        "table": PageTable("proofs", _HEADS, lines, "short"),
        "methods": list(dict.fromkeys(stored[label].method for label in truths)),
        "refuted": any(line.cells[-1].text for line in lines),
        "proved": kinds.count(PROVED),
        "transitions": len(kinds),
    }


def _has_none(truth: Truth, proof: Proof) -> bool:
    """Whether it is proved that the motion has no transition, as the truth has none."""
    return proof.complete and not proof.transitions and not truth.transitions and not truth.failure


def _line(label: str, truth: Truth, proof: Proof) -> PageRow:
    first, many = proof.transitions[0] if proof.transitions else None, len(truth.transitions)
    cells = [
        Cell(label, link=f"#{anchor(label)}"),
        Cell(f"{truth.kinds.count(PROVED)} of {many}" if many else "none, proved", kind="number"),
        Cell(f"{first.before} → {first.after}".replace("_", " ") if first else ""),
        Cell(enclosure(first.time), repr(float(Fraction(first.time.low)))) if first else Cell("", LAST),
        Cell(f"{first.time.width:.0e}".replace("e-0", "e-") if first else "", kind="number"),
        Cell(_share(first) if first else "", kind="number"),
    ]
    return PageRow(cells, tip=proof.statement if len(proof.transitions) <= _MOST_CLAIMS else "")


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
    tables = []
    for name, frame in result.frames.items():
        titles = {str(c): str(c).replace("_", " ") for c in frame.columns if c != "version"}
        one = table(name, frame, titles, result.words[name].columns, file=name)
        tables.append({"holds": result.words[name].holds, "table": one})
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
