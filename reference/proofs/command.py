"""The command `python -m reference --prove NAME`: prove a case's motion and write the proof record."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from cases import BadValue, NotSupported, lookup
from cases.errors import whole_in
from cases.files import owned_folder
from cases.files.command_line import PROGRAMS, Parser, program, status

# As the module of the console command's subcommand.
COMMAND = "reference.proofs.command"


def parser() -> Parser:
    """The command's options. As a subcommand of the console command, the case is its argument."""
    is_subcommand = COMMAND in PROGRAMS.get()
    result = Parser(
        prog=program(COMMAND) if is_subcommand else "python -m reference",
        description="Prove the motion of a case and write the proof record (JSON).",
        epilog=f"Example: {program(COMMAND) if is_subcommand else 'python -m reference --prove'} "
        '"disc_in_circle[mu=0.2]" --digits 50 --transitions 1',
    )
    how: dict[str, Any] = {} if is_subcommand else {"required": True}
    text = 'a case: name, "name[parameter=value,…]", FILE.py or FILE.py:FUNCTION'
    result.add_argument("prove" if is_subcommand else "--prove", metavar="CASE", help=text, **how)
    result.add_argument("--digits", metavar="N", default="20", help="digits of each transition's time (default: 20)")
    result.add_argument("--transitions", metavar="N", help="prove so many transitions only (default: the whole motion)")
    result.add_argument("--out", metavar="FILE", help="the record (default: NAME.proof.json, with _ for [ ] = ,)")
    result.add_argument("--force", action="store_true", help="overwrite the record if it exists")
    return result


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status: 0, 1 if a proof is incomplete, 2 for invalid arguments."""
    return status(COMMAND if COMMAND in PROGRAMS.get() else "reference", _run, argv)


def _run(argv: list[str]) -> int:
    options = parser().parse_args(argv)
    if find_spec("flint") is None:
        raise BadValue('proofs need python-flint, which is not installed; type: pip install "slip-to-roll[proofs]"')
    from .prover import ALL, MOST_DIGITS, prove

    digits = whole_in("--digits", options.digits, 1, MOST_DIGITS)
    transitions = options.transitions and whole_in("--transitions", options.transitions, 1, ALL)
    selection = lookup.case_name(options.prove).every()
    if options.out and len(selection) > 1:
        raise BadValue(
            f"{options.prove} has {len(selection)} variants; name one with --out, for example {selection[0].label}"
        )
    paths = [Path(options.out or _file_name(case.label)) for case in selection]
    for path in paths:
        owned_folder.check_new(path, options.force)
    incomplete = 0
    for case, path in zip(selection, paths, strict=True):
        try:
            proof = prove(case, digits, transitions, report=lambda text: print(f"  {text}", flush=True))
        except NotSupported as problem:
            print(f"not proved: {problem}")
            incomplete += 1
            continue
        owned_folder.write(path, proof.as_json(), options.force)
        print(f"{proof.statement}\nwritten: {path} ({proof.status}, {proof.cpu_s:g} s of CPU time)")
        if proof.status == "unproved":
            print(f"not proved further: {proof.reason}")
            incomplete += 1
    return 1 if incomplete else 0


def _file_name(label: str) -> str:
    return "".join("_" if c in "[]=,/ " else c for c in label).strip("_") + ".proof.json"


if __name__ == "__main__":
    sys.exit(main())
