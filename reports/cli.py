"""The console command `slip-to-roll`, with all commands of the suite as subcommands.

`slip-to-roll report` is `python -m reports.build`, and so on. A case is named in the same way in all of them
(`cases.lookup`)."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from difflib import get_close_matches
from importlib import import_module
from io import StringIO

import cases
from cases import registry
from cases.files.command_line import PROGRAMS

NAME = "slip-to-roll"
# Subcommand: the module with its `main`, and its description.
COMMANDS = {
    "report": ("reports.build", "run cases through solvers and write the comparison"),
    "cases": ("cases.commands", "list, show, make, check and export cases"),
    "compare": ("reports.compare", "judge a motion from a file"),
    "compare-builds": ("reports.compare_builds", "show the differences between two reports"),
    "submit": ("reports.submit", "check motions before you submit them"),
    "sweep": ("reports.sweep", "a map over any parameters of a case"),
    "animate": ("reports.animate", "write an animation of a motion, GIF or MP4"),
    "history": ("reports.history", "what changed from version to version of an engine"),
    "gate": ("reports.gate", "whether a report is worse than a baseline, for continuous integration"),
    "study": ("reports.study", "run one of the additional studies"),
    "laws": ("adapters.laws.__main__", "test an engine's adapter against mechanics"),
    "prove": ("reference.proofs.command", "prove the transitions of a case as theorems"),
    "check-proof": ("reference.proof_checker.__main__", "check proof records with an independent program"),
    "publish": ("reports.publish", "publish a report with its release, in a clone"),
    "deposit": ("reports.deposit", "pack a published report for a data repository"),
    "cite": ("reports.cite", "print the citation as BibTeX"),
    "completion": ("", "print the completion script for bash, zsh or fish"),
}

_BASH = """\
_slip_to_roll() {{
    local IFS=$'\\n'
    local following=$({name} complete "${{COMP_WORDS[@]:1:COMP_CWORD-1}}" 2>/dev/null)
    COMPREPLY=($(compgen -W "$following" -- "${{COMP_WORDS[COMP_CWORD]}}"))
}}
complete -o default -F _slip_to_roll {name}
"""
_SHELLS = {
    "bash": _BASH,
    "zsh": "autoload -U +X bashcompinit && bashcompinit\n" + _BASH,
    "fish": "complete -c {name} -a '({name} complete (commandline -opc)[2..-1] 2>/dev/null)'\n",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run a subcommand; returns its exit status, 2 for an unknown name."""
    words = list(sys.argv[1:] if argv is None else argv)
    name, *rest = words or ["--help"]
    if name in ("-h", "--help"):
        print(_help())
    elif name == "--version":
        print(f"{NAME} {cases.__version__}")
    elif name == "complete":  # called by the shell at every completion
        print("\n".join(following(rest)))
    elif name == "completion":
        return _completion(rest)
    elif name in COMMANDS:
        return _run(name, rest)
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
        for name, (module, _) in COMMANDS.items()
    }
    before = PROGRAMS.set(programs)
    try:
        return import_module(COMMANDS[name][0]).main(list(words))
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


def _completion(words: Sequence[str]) -> int:
    if len(words) != 1 or words[0] not in _SHELLS:
        print(f"{NAME}: give one of {', '.join(_SHELLS)}, for example: {NAME} completion bash", file=sys.stderr)
        return 2
    print(_SHELLS[words[0]].format(name=NAME), end="")
    return 0


def following(words: Sequence[str]) -> list[str]:
    """The completions of a command line: subcommands, cases, solvers, options."""
    if not words:
        return list(COMMANDS)
    if words[0] == "completion":
        return list(_SHELLS)
    if words[0] not in COMMANDS:
        return []
    if words == ["cases"]:
        return ["new", "check", "show", "export"]
    if words[-1] in ("--case", "compare", "show", "export", "check", "sweep", "animate", "prove"):
        return [case.name for case in registry.summaries()]
    if words[-1] == "--solver":
        from .options import solvers

        return list(solvers())
    output = StringIO()
    with redirect_stdout(output):
        try:
            _run(words[0], ["--help"])
        except SystemExit:  # argparse exits after the help
            pass
    return sorted(set(re.findall(r"--[a-z][a-z-]*", output.getvalue())))


if __name__ == "__main__":
    sys.exit(main())
