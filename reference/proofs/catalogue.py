"""The stored proofs of the catalogue's cases, one record a line, and the command that writes them.

`python -m reference.proofs.catalogue [NAME …]` proves the named cases (default: all) again; other records stay.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import cases
from cases import Case, NotSupported
from cases.files import owned_folder
from cases.files.command_line import status

from .record import Proof

CATALOGUE = Path(__file__).with_name("catalogue.json")
DIGITS = 15


@lru_cache(maxsize=1)
def read(path: Path = CATALOGUE) -> Mapping[str, Proof]:
    """The stored proofs by case label."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    proofs = [Proof.from_data(json.loads(line)) for line in lines]
    return MappingProxyType({proof.case: proof for proof in proofs})


def write(proofs: Sequence[Proof], path: Path = CATALOGUE) -> None:
    """Write proofs to the file."""
    lines = [json.dumps(proof.as_data(), ensure_ascii=False, separators=(",", ":")) for proof in proofs]
    owned_folder.write(path, "".join(f"{line}\n" for line in lines))


def main(argv: Sequence[str] | None = None) -> int:
    """Prove cases again; each proof is stored as soon as it is finished. Returns the exit status."""
    return status("reference.proofs.catalogue", _run, argv)


def _run(names: list[str]) -> int:
    selection: list[Case] = [case for name in names or cases.names() for case in cases.select(name)]
    from .prover import prove

    proofs, order = dict(read()), [case.label for name in cases.names() for case in cases.select(name)]
    for n, case in enumerate(selection, start=1):
        proofs.pop(case.label, None)
        try:
            proof = prove(case, DIGITS)
        except NotSupported as problem:
            print(f"{n}/{len(selection)} {problem}", flush=True)
            continue
        print(f"{n}/{len(selection)} {case.label}: {proof.status}, {len(proof.transitions)} transitions, "
              f"{proof.cpu_s:g} s; {proof.reason}", flush=True)  # fmt: skip
        proofs[case.label] = proof
        write([proofs[label] for label in order if label in proofs])
    read.cache_clear()
    return 0


if __name__ == "__main__":
    sys.exit(main())
