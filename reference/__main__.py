"""`python -m reference` rebuilds the stored truth of the catalogue; with `--prove NAME` it proves a case's motion."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from cases import BadValue
from cases.errors import whole_in
from cases.files.command_line import Parser, status
from cases.version import in_clone


def parser() -> Parser:
    """The options with which certificates are made again."""
    result = Parser(
        prog="python -m reference",
        description="Certify the cases of the catalogue again and store their truth (truth.json).",
        epilog='Example: python -m reference --only disc_in_circle "sliding_loop[ratio=5.1]"\n'
        "To prove a case's motion instead: python -m reference --prove NAME --help",
    )
    result.add_argument(
        "--only",
        metavar="NAME",
        nargs="+",
        action="extend",
        help='cases: a name (all its variants) or "name[parameter=value,…]"; rows of others stay (default: all)',
    )
    result.add_argument("--out", metavar="FILE", help="new file to write (default: truth.json of the clone)")
    result.add_argument("--jobs", metavar="N", help="number of parallel processes (default: one per core)")
    return result


def main(argv: Sequence[str] | None = None, path: Path | None = None) -> int:
    """Run the command on the file of certificates (default: that of the clone); returns its exit status: 0, 1 if an
    ordinary case has no certificate or a proof is incomplete, 2 for invalid arguments, 130 if it was interrupted. The
    file of an installed package stays as it was certified for the release."""
    words = list(sys.argv[1:] if argv is None else argv)
    if any(word == "--prove" or word.startswith("--prove=") for word in words):
        from .proofs import command

        return command.main(words)
    return status("reference", lambda rest: _rebuild(rest, path), words)


def _rebuild(words: list[str], path: Path | None) -> int:
    options = parser().parse_args(words)
    jobs = whole_in("--jobs", options.jobs or str(os.cpu_count() or 1), 1, 1000)
    path = path or _path(options.out)
    from .certification import rebuild  # with SymPy, which help does not need

    return rebuild.certify_cases(options.only, jobs, path)


def _path(out: str | None) -> Path:
    """The file to write: a new one, or that of the clone. Raises BadValue."""
    if out is not None:
        if Path(out).exists():
            raise BadValue(f"{out} exists; give the name of a new file")
        if not Path(out).parent.is_dir():
            raise BadValue(f"there is no folder {Path(out).parent}; create it first")
        return Path(out)
    if not in_clone():
        raise BadValue("the certificates of an installed package are not changed; name a new file: --out mine.json")
    from .certification import TRUTH

    return TRUTH


if __name__ == "__main__":
    sys.exit(main())
