"""Certify the catalogue's cases again and store the certificates in truth.json, as `python -m reference` does.

Each certificate is stored as soon as it is computed, so an interrupted rebuild keeps all finished ones. Rows of cases
that were not named stay unchanged.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator, Sequence
from multiprocessing import resource_tracker
from pathlib import Path

import cases

from .certificate import Certificate, NotCertified, certify
from .truth_file import DamagedTruth, damage, read, sound, write


def certify_cases(names: Sequence[str] | None, jobs: int, path: Path) -> int:
    """Certify the named cases (None: all) again in so many processes; returns 0, or 1 if an ordinary case has no
    certificate. Raises CaseError for an unknown case or a damaged row that stays, before anything is certified."""
    labels = _labels(names)
    certificates = _rows_that_stay(labels, path, whole_catalogue=names is None)
    try:
        return _certify_all(labels, jobs, path, certificates)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("finished certificates are stored") from None


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


def _certify_all(labels: list[str], jobs: int, path: Path, certificates: dict[str, Certificate]) -> int:
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
