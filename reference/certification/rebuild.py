"""The command `python -m reference`: certify the catalogue's cases again and store the certificates in truth.json.

Each certificate is stored as soon as it is computed, so an interrupted rebuild keeps all finished ones. Rows of cases
that were not named stay unchanged.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from multiprocessing import resource_tracker
from pathlib import Path

import cases
from cases import BadValue, CaseError
from cases.command_line import Parser
from cases.errors import whole

from .certificate import Certificate, NotCertified, certify
from .truth_file import TRUTH, DamagedTruth, damage, read, sound, write


def parser() -> Parser:
    """The command's options."""
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
    result.add_argument("--jobs", metavar="N", help="number of parallel processes (default: one per core)")
    return result


def main(argv: Sequence[str] | None = None, path: Path = TRUTH) -> int:
    """Run the command; returns its exit status: 0, 1 if an ordinary case has no certificate, 2 for invalid arguments,
    130 if it was interrupted."""
    try:
        options = parser().parse_args(sys.argv[1:] if argv is None else argv)
        labels = _labels(options.only)
        jobs = _jobs(options.jobs)
        certificates = _rows_that_stay(labels, path, whole_catalogue=options.only is None)
    except CaseError as problem:
        print(f"reference: {problem}", file=sys.stderr)
        return 2
    try:
        return _rebuild(labels, jobs, path, certificates)
    except KeyboardInterrupt:
        print("\nreference: stopped; finished certificates are stored", file=sys.stderr)
        return 130


def _jobs(text: str | None) -> int:
    cores = os.cpu_count() or 1
    try:
        return cores if text is None else whole("--jobs", int(text), 1, 1000)
    except ValueError as problem:
        raise BadValue(f"--jobs is {text!r}; give a whole number, for example {cores}") from problem


def _labels(names: Sequence[str] | None) -> list[str]:
    """The labels of the selected cases, each once."""
    return list(dict.fromkeys(case.label for name in names or cases.names() for case in cases.select(name)))


def _rows_that_stay(labels: list[str], path: Path, whole_catalogue: bool) -> dict[str, Certificate]:
    """The rows of the file to start from. Raises DamagedTruth if a damaged row would not be certified again."""
    try:
        certificates, damaged_labels = sound(path)
    except DamagedTruth:
        if whole_catalogue:
            return {}
        raise
    if set(damaged_labels) - {*labels} and not whole_catalogue:
        raise damage(path, damaged_labels)
    return {label: row for label, row in certificates.items() if not whole_catalogue or label in labels}


def _rebuild(labels: list[str], jobs: int, path: Path, certificates: dict[str, Certificate]) -> int:
    """Certify the cases and store the certificates; returns the exit status."""
    order, failures = cases.names(), 0
    for n, (label, outcome) in enumerate(_outcomes(labels, jobs), start=1):
        if isinstance(outcome, Certificate):
            certificates[label] = outcome
            widest = max((t[2].bar for t in outcome.transitions), default=0.0)
            message = f"{label}: {len(outcome.transitions)} transitions, widest bar {widest:.1e} s"
            message += "".join(f"; {sentence}" for sentence in outcome.missing)
        else:
            certificates.pop(label, None)
            # Some hard scenes depend on the last bit; an ordinary one without truth is an error.
            failures += not cases.entry(label.partition("[")[0]).hard
            message = f"not certified: {outcome}"
        print(f"{n}/{len(labels)} {message}", flush=True)
        write(sorted(certificates.values(), key=lambda row: _place(order, row.case)), path)
    read.cache_clear()
    print(f"written: {path.name}, {len(certificates)} cases")
    return 1 if failures else 0


def _place(order: list[str], label: str) -> int:
    """The sort position of a row: the catalogue's order; names that are no longer in the catalogue come last."""
    name = label.partition("[")[0]
    return order.index(name) if name in order else len(order)


def _outcomes(labels: list[str], jobs: int) -> Iterator[tuple[str, Certificate | str]]:
    """Yield each label with its certificate, or with a sentence why there is none, as soon as it is finished."""
    if jobs == 1 or len(labels) < 2:
        yield from map(_outcome, labels)
        return
    # Only the main process handles Ctrl-C and ends the others: they inherit the blocked signal from their start.
    resource_tracker.ensure_running()  # started before, because it unblocks Ctrl-C when it starts
    blocked_signals = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        # Fresh processes: a fork would copy threads of the compiler.
        pool = multiprocessing.get_context("spawn").Pool(min(jobs, len(labels)))
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked_signals)
    with pool:
        yield from pool.imap_unordered(_outcome, labels)


def _outcome(label: str) -> tuple[str, Certificate | str]:
    try:
        return label, certify(cases.load(label))
    except NotCertified as problem:
        return label, str(problem)
