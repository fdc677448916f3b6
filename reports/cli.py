"""The console command `slip-to-roll`: the suite's commands under one name. `slip-to-roll report` is
`python -m reports.build`, and so on; nothing is done here."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from difflib import get_close_matches
from importlib import import_module
from io import StringIO

import cases

NAME = "slip-to-roll"
# Sub-command: the module whose `main` it is, and what it does.
COMMANDS = {
    "report": ("reports.build", "run cases through solvers and write the comparison"),
    "cases": ("cases.commands", "list, show, make, check and export cases"),
    "compare": ("reports.compare", "judge a motion from a file"),
    "submit": ("reports.submit", "check motions that are to be handed in"),
    "sweep": ("reports.sweep", "a map over any parameters of a case"),
    "animate": ("reports.animate", "a film of a motion, GIF or MP4"),
    "study": ("reports.study", "one of the studies beside the comparison"),
    "laws": ("adapters.laws.__main__", "test an engine's adapter against mechanics"),
    "completion": ("", "print what completes words in bash, zsh or fish"),
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
    """Run a sub-command; returns its exit status: 2 if there is none of that name."""
    words = list(sys.argv[1:] if argv is None else argv)
    name, *rest = words or ["--help"]
    if name in ("-h", "--help"):
        print(_help())
    elif name == "--version":
        print(f"{NAME} {cases.__version__}")
    elif name == "complete":  # asked by the shell at every press of a key
        print("\n".join(following(rest)))
    elif name == "completion":
        return _completion(rest)
    elif name in COMMANDS:
        return import_module(COMMANDS[name][0]).main(rest)
    else:
        near = get_close_matches(name, COMMANDS, 1)
        hint = f"did you mean {near[0]}?" if near else f"give one of {', '.join(COMMANDS)}"
        print(f"{NAME}: there is no command {name!r}; {hint}", file=sys.stderr)
        return 2
    return 0


def _help() -> str:
    width = max(map(len, COMMANDS))
    lines = [
        f"usage: {NAME} COMMAND …",
        "",
        "How wrong is your friction? A cross-checked benchmark of planar contact.",
        "",
    ]
    lines += [f"  {name:{width}}  {what}" for name, (_, what) in COMMANDS.items()]
    return "\n".join([*lines, "", f"{NAME} COMMAND --help tells the options of each."])


def _completion(words: Sequence[str]) -> int:
    if len(words) != 1 or words[0] not in _SHELLS:
        print(f"{NAME}: give one of {', '.join(_SHELLS)}, for example: {NAME} completion bash", file=sys.stderr)
        return 2
    print(_SHELLS[words[0]].format(name=NAME), end="")
    return 0


def following(words: Sequence[str]) -> list[str]:
    """What may come after these words of a command line: sub-commands, cases, solvers, options."""
    if not words:
        return list(COMMANDS)
    if words[0] == "completion":
        return list(_SHELLS)
    if words[0] not in COMMANDS:
        return []
    if words == ["cases"]:
        return ["new", "check", "show", "export"]
    if words[-1] in ("--case", "compare", "show", "export"):
        return cases.names()
    if words[-1] == "--solver":
        from .options import solvers

        return list(solvers())
    told = StringIO()
    with redirect_stdout(told):
        try:
            import_module(COMMANDS[words[0]][0]).main(["--help"])
        except SystemExit:  # argparse ends so
            pass
    return sorted(set(re.findall(r"--[a-z][a-z-]*", told.getvalue())))


if __name__ == "__main__":
    sys.exit(main())
