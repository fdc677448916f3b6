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
# Commands in their order, of one or two words: the module with the `main` of each, and its description.
COMMANDS = {
    "report": ("reports.build", "run cases through solvers and write the comparison"),
    "report study": ("reports.study", "run one of the additional studies"),
    "compare": ("reports.compare", "judge motions from a file or a folder, or compare two reports"),
    "sweep": ("reports.sweep", "a map over any parameters of a case"),
    "history": ("reports.history", "what changed from version to version of an engine"),
    "laws": ("adapters.laws.__main__", "test an engine's adapter against mechanics"),
    "cases": ("cases.commands", "list, show, check, begin (new) and export cases"),
    "cases film": ("reports.animate", "write an animation of a motion, GIF or MP4"),
    "prove": ("reference.proofs.command", "prove the transitions of a case as theorems"),
    "prove check": ("reference.proof_checker.__main__", "check proof records with an independent program"),
    "release publish": ("reports.publish", "publish a report with its release, in a clone"),
    "release deposit": ("reports.deposit", "pack a published report for a data repository"),
    "release benchmark": ("reports.benchmark", "write the canonical friction benchmark for engines in any language"),
    "release cite": ("reports.cite", "print the citation as BibTeX"),
}
# Older names, for one version.
ALIASES = {
    "animate": "cases film", "study": "report study", "check-proof": "prove check",
    "publish": "release publish", "deposit": "release deposit", "cite": "release cite",
}  # fmt: skip
# Older names of commands with options of their own, for one version: `compare` has what they do.
_OLDER = {"compare-builds": "reports.compare_builds", "gate": "reports.gate", "submit": "reports.submit"}
# Commands of older versions: what to type instead.
GONE = {"completion": f"{NAME} --help lists the commands, {NAME} COMMAND --help the options of one"}
_MODULES = {name: module for name, (module, _) in COMMANDS.items()} | _OLDER


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; returns its exit status, 2 for an unknown name."""
    words = list(sys.argv[1:] if argv is None else argv) or ["--help"]
    words[:1] = ALIASES.get(words[0], words[0]).split()
    name = next((name for name in (" ".join(words[:2]), words[0]) if name in _MODULES), "")
    if name:
        return _run(name, words[len(name.split()) :])
    if words[0] in ("-h", "--help"):
        print(_help())
        return 0
    if words[0] == "--version":
        print(f"{NAME} {cases.__version__}")
        return 0
    if words[0] in GONE:
        print(f"{NAME}: {words[0]} is gone; {GONE[words[0]]}", file=sys.stderr)
        return 2
    near = get_close_matches(" ".join(words[:2]), COMMANDS, 1) or get_close_matches(words[0], COMMANDS, 1)
    hint = f"did you mean {near[0]}?" if near else f"give one of {', '.join(COMMANDS)}"
    print(f"{NAME}: there is no command {words[0]!r}; {hint}", file=sys.stderr)
    return 2


def _run(name: str, words: Sequence[str]) -> int:
    """Run a command, whose help and messages have the name of the console command."""
    programs = {
        module.removesuffix(".commands").removesuffix(".__main__"): f"{NAME} {name}"
        for name, module in _MODULES.items()
    }
    before = PROGRAMS.set(programs)
    try:
        return import_module(_MODULES[name]).main(list(words))
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
