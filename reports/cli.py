"""The console command `slip-to-roll`, with all commands of the suite as subcommands.

`slip-to-roll report` is `python -m reports.build`, and so on. A case is named in the same way in all of them
(`cases.lookup`)."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from difflib import get_close_matches
from importlib import import_module

import cases
from cases.files.command_line import PROGRAMS

NAME = "slip-to-roll"
# Subcommand: the module with its `main`, and its description.
COMMANDS = {
    "report": ("reports.build", "run cases through solvers and write the comparison"),
    "cases": ("cases.commands", "list, show, make, check and export cases"),
    "compare": (
        "reports.compare",
        "judge a motion from a file, or compare two reports",
    ),
    "submit": ("reports.submit", "check motions before you submit them"),
    "sweep": ("reports.sweep", "a map over any parameters of a case"),
    "animate": ("reports.animate", "write an animation of a motion, GIF or MP4"),
    "history": ("reports.history", "what changed from version to version of an engine"),
    "study": ("reports.study", "run one of the additional studies"),
    "laws": ("adapters.laws.__main__", "test an engine's adapter against mechanics"),
    "prove": ("reference.proofs.command", "prove the transitions of a case as theorems"),
    "check-proof": ("reference.proof_checker.__main__", "check proof records with an independent program"),
    "publish": ("reports.publish", "publish a report with its release, in a clone"),
    "deposit": ("reports.deposit", "pack a published report for a data repository"),
    "cite": ("reports.cite", "print the citation as BibTeX"),
}

# Older names, for one version: `compare` has what they do.
ALIASES = {"compare-builds": ("reports.compare_builds", ""), "gate": ("reports.gate", "")}
# Commands of older versions: what to type instead.
GONE = {"completion": f"{NAME} --help lists the commands, {NAME} COMMAND --help the options of one"}


def main(argv: Sequence[str] | None = None) -> int:
    """Run a subcommand; returns its exit status, 2 for an unknown name."""
    words = list(sys.argv[1:] if argv is None else argv)
    name, *rest = words or ["--help"]
    if name in ("-h", "--help"):
        print(_help())
    elif name == "--version":
        print(f"{NAME} {cases.__version__}")
    elif name in COMMANDS | ALIASES:
        return _run(name, rest)
    elif name in GONE:
        print(f"{NAME}: {name} is gone; {GONE[name]}", file=sys.stderr)
        return 2
    else:
        near = get_close_matches(name, COMMANDS, 1)
        hint = f"did you mean {near[0]}?" if near else f"give one of {', '.join(COMMANDS)}"
        print(f"{NAME}: there is no command {name!r}; {hint}", file=sys.stderr)
        return 2
    return 0


def _run(name: str, words: Sequence[str]) -> int:
    """Run a subcommand, whose help and messages have the name by which it was called."""
    programs = {
        module.removesuffix(".commands").removesuffix(".__main__"): f"{NAME} {name}"
        for name, (module, _) in (COMMANDS | ALIASES).items()
    }
    before = PROGRAMS.set(programs)
    try:
        return import_module((COMMANDS | ALIASES)[name][0]).main(list(words))
    finally:
        PROGRAMS.reset(before)


def _help() -> str:
    width = max(map(len, COMMANDS))
    lines = [
        f"usage: {NAME} COMMAND …",
        "",
        "How wrong is your friction? A cross-checked benchmark of planar contact.",
        "",
    ]
    lines += [f"  {name:{width}}  {what}" for name, (_, what) in COMMANDS.items()]
    return "\n".join([*lines, "", f"{NAME} COMMAND --help lists the options of a command."])


if __name__ == "__main__":
    sys.exit(main())
