"""The file truth.json with the certificates of the catalogue's cases: the only source of their truth.

Each row has its own digest: a damaged number is detected when the file is read, and rows that were certified on
different machines can be merged.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from cases import Case, CaseError, Mode
from cases.files import owned_folder

from .bars import Bar
from .certificate import Certificate, certify

TRUTH = Path(__file__).with_name("truth.json")
# An error message names at most this many labels.
_LABELS_IN_MESSAGE = 3


class DamagedTruth(CaseError):
    """The stored certificates differ from those that were written."""


def stored_or_new(case: Case, use_file: bool = True) -> Certificate:
    """The stored certificate of a catalogue case, else a new one (always new without `use_file`). Raises
    DamagedTruth."""
    return (read().get(case.label) if use_file else None) or certify(case)


def write(certificates: Sequence[Certificate], path: Path = TRUTH) -> None:
    """Write certificates to a file."""
    rows = [{**certificate.__dict__, "digest": _digest(certificate.__dict__)} for certificate in certificates]
    owned_folder.write(path, json.dumps(rows, indent=1) + "\n")  # atomic, as a rebuild may be stopped at any time


@lru_cache(maxsize=1)
def read(path: Path = TRUTH) -> Mapping[str, Certificate]:
    """Read the stored certificates, by case label; none if there is no file. Raises DamagedTruth."""
    certificates, damaged_labels = sound(path)
    if damaged_labels:
        raise damage(path, damaged_labels)
    return MappingProxyType(certificates)


def damage(path: Path, labels: Sequence[str]) -> DamagedTruth:
    """The error for a file with damaged rows; `labels` are those of their cases."""
    some = ", ".join(labels[:_LABELS_IN_MESSAGE]) + (
        f", … ({len(labels)} in all)" if len(labels) > _LABELS_IN_MESSAGE else ""
    )
    only = " ".join(f'"{label}"' for label in labels) if len(labels) <= _LABELS_IN_MESSAGE else ""
    again = f"python -m reference{f' --only {only}' if only else ''}"
    return DamagedTruth(
        f"{path.name} is damaged: the digest of {some} does not fit the numbers; "
        f"restore the file (install the package again); in a clone, `{again}` certifies again"
    )


def sound(path: Path) -> tuple[dict[str, Certificate], list[str]]:
    """The certificates whose digests match, by case label, and the labels of the others. Raises DamagedTruth for a
    file without readable rows."""
    if not path.exists():
        return {}, []
    certificates, damaged_labels = {}, []
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(rows, list):
            raise TypeError("it is not a list of certificates")
        for row in rows:
            digest = row.pop("digest", "")
            if digest == _digest(row) and row["case"] not in certificates:
                certificates[row["case"]] = _certificate(row)
            else:
                damaged_labels.append(str(row["case"]))
    except (OSError, ValueError, AttributeError, KeyError, TypeError, RecursionError) as problem:
        raise DamagedTruth(
            f"{path.name} cannot be read ({type(problem).__name__}: {problem}); restore the file (install the package "
            "again); in a clone, `python -m reference` certifies all cases again"
        ) from problem
    return certificates, damaged_labels


def _digest(row: Mapping[str, Any]) -> str:
    """The digest of a row's numbers and words, independent of the file's layout."""
    return hashlib.sha256(json.dumps(row, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def _certificate(row: dict[str, Any]) -> Certificate:
    row["end"] = Bar(*row["end"])
    row["transitions"] = tuple((Mode(b), Mode(a), Bar(*t), Bar(*x)) for b, a, t, x in row["transitions"])
    row["times"] = tuple(row["times"])
    row["samples"] = {q: tuple(Bar(*bar) for bar in bars) for q, bars in row["samples"].items()}
    row["witnesses"], row["missing"] = tuple(row["witnesses"]), tuple(row["missing"])
    return Certificate(**row)
