"""Operations of every catalogue case's equations, and its transitions to the last bit, as JSON on standard output.

`python -m tests.operations > before.json` in one version and `python -m tests.operations before.json` in another print
the cases whose equations or transitions differ: an effect that a scene does not have must cost it nothing.
"""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path

import cases
import reference
from cases import Case
from cases.formulas.expression_graph import Node, in_order
from cases.moving_frame import relative_case
from reference.minimal.modes import FLIGHT, candidates, phase_at, start_pieces, start_state


def equations(case: Case) -> str:
    """A digest of the operations, parameters and constants of all regimes of a case."""
    whole, case = hashlib.sha256(), relative_case(case)
    here, start = start_pieces(case), start_state(case)
    for regime in (*candidates(case), FLIGHT):
        now = phase_at(here, regime, start)
        system = now.system
        named = (system.conditions, system.condition_rates, system.guards)
        outputs = [*system.rates, *system.outputs, *(e for some in named for e in some.values())]
        outputs += system.load_quantities
        numbers = {node: i for i, node in enumerate(in_order(outputs))}
        lines = [(node.op, *(numbers[a] if isinstance(a, Node) else repr(a) for a in node.args)) for node in numbers]
        names = (regime, system.names, *(tuple(some) for some in named), tuple(v.name for v in system.variables))
        parameters = [value.hex() for value in now.parameters]
        whole.update(repr((names, lines, [numbers[e] for e in outputs], parameters)).encode())
    return whole.hexdigest()


def transitions(case: Case) -> list[list[str]]:
    """The transitions of a case, times and places in hexadecimal digits, and its ending."""
    motion = reference.simulate(case)
    rows = [[t.time.hex(), t.before, t.after, float(t.xi1).hex(), float(t.xi2).hex()] for t in motion.transitions]
    return [*rows, [motion.status, motion.reason]]


def record() -> dict[str, list]:
    """Equations and transitions of all cases of the catalogue."""
    every = [case for name in cases.names() for case in cases.select(name)]
    return {case.label: [equations(case), transitions(case)] for case in every}


def main() -> int:
    """Write the record, or compare it with an older one; returns the number of cases that differ."""
    now = json.loads(json.dumps(record()))
    if len(sys.argv) < 2:
        json.dump(now, sys.stdout, indent=0)
        return 0
    before = json.loads(Path(sys.argv[1]).read_text())
    changed = [label for label in before if label in now and now[label] != before[label]]
    for label in changed:
        what = ["equations", "transitions"]
        print(f"{label}: {', '.join(what[i] for i in (0, 1) if now[label][i] != before[label][i])}")
    print(f"{len(changed)} of {len(before)} cases differ")
    return len(changed)


if __name__ == "__main__":
    raise SystemExit(main())
