"""The command `python -m adapters.laws`: check any adapter against the laws of mechanics."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence

from cases import BadValue
from cases.errors import unknown_name
from cases.files.command_line import Parser, program, status

HELP = """\
ADAPTER is the name of an adapter (of the suite, or of an installed package in the entry-point group
slip_to_roll.adapters), a Python file, an executable, or a module: exudyn, my_engine.py, ./my_engine,
my_package.my_engine.

Every law is checked on every route, with the second-finest setting of its ladder: kept, broken (and by how much),
refused (not supported, and why), not reported (a law about forces, for an engine that reports none), failed with an
exception, crashed or timed_out (it runs in a process of its own, whose output is not shown). Laws that are refused for
the same reason have one line, after the others. The exit status is 0 if no law is broken and none failed, else 1; 2 if
there is no such adapter, route or law. A broken law names the parameter or effect that it suspects.

The scenes draw gravity, friction, restitution, masses, sizes, loads and starts at random; the same --seed gives the
same scenes.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    return status("adapters.laws", _work, argv)


def _work(words: list[str]) -> int:
    parser = Parser(
        prog=program("adapters.laws"), description="Check any adapter against the laws of mechanics.", epilog=HELP
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("adapter", metavar="ADAPTER", help="the adapter")
    parser.add_argument("--route", metavar="ROUTE", nargs="+", help="only these routes (default: all)")
    parser.add_argument("--law", metavar="LAW", nargs="+", help="only these laws, with all their scenes (default: all)")
    parser.add_argument("--seed", metavar="N", type=_seed, default=0, help="selects the scenes' values (default: 0)")
    options = parser.parse_args(words)
    try:
        return _judge(options.adapter, options.route, options.law, options.seed)
    except ImportError as problem:
        raise BadValue(str(problem)) from problem


def _seed(text: str) -> int:
    """A whole number from 0 on; argparse reports anything else."""
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is no seed; give a whole number of up to nine digits")
    return int(text)


def _judge(name: str, routes: Sequence[str] | None, names: Sequence[str] | None, seed: int) -> int:
    from . import LAWS  # a slow import that --help does not need
    from .law_process import AdapterProcess

    names_of_laws = {*LAWS, *(law.partition("[")[0] for law in LAWS)}
    for law in names or ():
        if law not in names_of_laws:
            raise unknown_name("law", law, names_of_laws)
    selection = [law for law in LAWS if not names or law in names or law.partition("[")[0] in names]
    counts: Counter[str] = Counter()
    with AdapterProcess(name) as adapter:
        for route in routes or ():
            if route not in adapter.face.routes:
                raise unknown_name(f"route of {adapter.face.name}", route, adapter.face.routes)
        for route in routes or adapter.face.routes:
            refusals: dict[str, Counter[str]] = {}
            for law, outcome, reason in adapter.try_laws(route, selection, seed):
                counts[outcome] += 1
                if outcome == "refused":
                    refusals.setdefault(reason, Counter())[law.partition("[")[0]] += 1
                else:
                    print(f"{route}  {law}: {outcome}{': ' if reason else ''}{reason}", flush=True)
            for reason, laws in refusals.items():
                names = ", ".join(law + (f" ({scenes} scenes)" if scenes > 1 else "") for law, scenes in laws.items())
                print(f"{route}  {names}: refused: {reason}")
    print(f"{adapter.face.name}: " + ", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return 0 if counts.keys() <= {"kept", "refused", "not reported"} else 1


if __name__ == "__main__":
    sys.exit(main())
