"""`python -m reference.proof_checker FILE…` checks proof records.

Exit status 1 if one is not confirmed, 2 if one cannot be read or is not covered.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from .check import check
from .steps import NotConfirmed


def main(files: list[str]) -> int:
    if not files or files[0].startswith("-"):
        print("usage: python -m reference.proof_checker FILE…  (records that python -m reference --prove wrote)")
        return 0 if files[:1] in (["-h"], ["--help"]) else 2
    worst = 0
    for file in files:
        try:
            print(check(json.loads(Path(file).read_text(encoding="utf-8"))), flush=True)
        except NotConfirmed as problem:
            print(f"not confirmed: {file}: {problem}", flush=True)
            worst = max(worst, 1)
        except (OSError, ValueError, KeyError, TypeError) as problem:
            print(f"not checked: {file}: {type(problem).__name__}: {problem}", flush=True)
            worst = 2
    return worst


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
