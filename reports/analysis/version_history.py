"""How the answers of an engine changed from version to version: rows of runs, and one line per scene and setting.

A version's answer to a scene, on one route with one setting, is compared with that of the version before it. It changed
if the outcome is another one, if the sequence of transitions is another one, or if the error (off) differs by more than
CHANGE of the larger one. Smaller differences are counted as changes of digits: another compiler, or another order of
operations, makes them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import isfinite, nan
from typing import NamedTuple

from packaging.version import Version

from ..judging.ledger import LedgerRow
from ..running.records import Row, Run, first_error
from ..running.versions import split_version
from .columns import Table, words
from .number_format import number

# A smaller relative change of off is one of digits. It is a hundredth of what separates neighbouring rungs of a ladder,
# and far above the rounding of single precision.
CHANGE = 0.01
# An error below this is none: 4 digits, as in a ranking.
LEAST_OFF = 1e-4
# The smallest error that is shown as a number.
_SHOWN_OFF = 1e-6

_ENGINE = {"engine": "the engine"}
_VERSION = {"version": "version of its package"}
TABLES = {
    "history": Table(
        "Every run of every version of an engine",
        {**_ENGINE, **_VERSION, **words("case", "route", "setting")}
        | {"outcome": "answered, unsupported, crashed, timed_out or not_installed"}
        | {**words("off"), "first_transition_error": "error of the first transition's time, s"}
        | {"sequence": "the transitions that the run has, in their order", **words("grade", "reason")}
        | {"change": "compared with the version before: changed, digits, same, or first"},
    ),
    "history_lines": Table(
        "One line per case, route and setting: the error in the oldest version, and each release that changed it",
        {**_ENGINE, **words("case", "route", "setting")}
        | {
            "oldest": "answer of the oldest version that was run: off in percent, or the outcome",
            "changes": "each release with another answer, and that answer; empty: no release changed it",
            "digits": "releases that changed digits only",
        },
    ),
    "history_releases": Table(
        "One line per version of an engine: what changed with it",
        {**_ENGINE, **_VERSION}
        | {
            "runs": "number of runs with an answer",
            "changed": "answers that changed with this release",
            "better": "of these, answers with a smaller error, or with an answer where there was none",
            "worse": "of these, answers with a larger error, or without an answer where there was one",
            "digits": "further answers whose digits changed by less than one percent of the error",
            "note": "why the version was not run; empty: it was",
        },
    ),
}


class HistoryLine(NamedTuple):
    """A case on a route with a setting, and the run of each version, oldest first."""

    engine: str
    case: str
    route: str
    setting: str
    answers: dict[str, Run]

    @property
    def changes(self) -> dict[str, str]:
        """ "first", "same", "digits" or "changed" by version."""
        versions = list(self.answers)
        labels = {versions[0]: "first"} if versions else {}
        return labels | {new: change(self.answers[old], self.answers[new]) for old, new in pairwise(versions)}


def off(run: Run) -> float:
    """Its error; NaN without a motion."""
    return run.score.off if run.score else nan


def in_words(run: Run) -> str:
    """Off in percent, or the outcome."""
    if run.outcome != "answered" or not isfinite(off(run)):
        return run.outcome
    return f"{number(100 * off(run))} %" if off(run) >= _SHOWN_OFF else f"under {100 * _SHOWN_OFF:.4f} %"


def _sequence(run: Run) -> str:
    """The transitions that the run has, in their order."""
    return ", ".join(f"{row.before} to {row.after}" for row in sorted(_events(run), key=lambda row: row.time))


def _events(run: Run) -> list[LedgerRow]:
    return [row for row in run.ledger if row.pairing in ("paired", "spurious")]


def _digits(run: Run) -> str:
    """Every number of the run, to see whether a digit changed; NaN stands for a number that it does not have."""
    return repr([float(x) for x in (off(run), *run.distance, *(row.time for row in _events(run)))])


def change(old: Run, new: Run) -> str:
    """ "changed", "digits" or "same"."""
    if old.outcome != new.outcome:
        return "changed"
    if old.outcome != "answered":
        return "same"
    larger = max(off(old), off(new))
    if _sequence(old) != _sequence(new) or (abs(off(new) - off(old)) > CHANGE * larger and larger > LEAST_OFF):
        return "changed"
    return "same" if _digits(old) == _digits(new) else "digits"


def is_better(old: Run, new: Run) -> bool:
    """Whether a changed answer is the better one."""
    if old.outcome != new.outcome:
        return new.outcome == "answered"
    return off(new) < off(old)


def lines(runs: Iterable[Run]) -> list[HistoryLine]:
    """One line per engine, case, route and setting, in the order of the runs; versions in their order.

    A route that a version does not support at all has one run without a setting; it is its answer at every setting that
    other versions have.
    """
    answers: dict[tuple[str, str, str, str], dict[str, Run]] = {}
    without_setting: dict[tuple[str, str, str], dict[str, Run]] = {}
    for run in runs:
        engine, version = split_version(run.solver)
        if run.setting.values:
            answers.setdefault((engine, run.case, run.route, str(run.setting)), {})[version] = run
        else:
            without_setting.setdefault((engine, run.case, run.route), {})[version] = run
    result = []
    for key, by_version in answers.items():
        whole = without_setting.get(key[:3], {}) | by_version
        result.append(HistoryLine(*key, {version: whole[version] for version in sorted(whole, key=Version)}))
    return result


def run_rows(all_lines: Sequence[HistoryLine]) -> list[Row]:
    """The rows of the table `history`."""
    return [
        {
            "engine": line.engine, "version": version, "case": line.case, "route": line.route, "setting": line.setting,
            "outcome": each.outcome, "off": off(each), "first_transition_error": first_error(each),
            "sequence": _sequence(each), "grade": each.grade, "reason": each.reason, "change": line.changes[version],
        }
        for line in all_lines
        for version, each in line.answers.items()
    ]  # fmt: skip


def line_rows(all_lines: Sequence[HistoryLine]) -> list[Row]:
    """The rows of the table `history_lines`."""
    rows: list[Row] = []
    for line in all_lines:
        kinds, oldest = line.changes, next(iter(line.answers.values()))
        answers = [f"{v}: {in_words(line.answers[v])}" for v, kind in kinds.items() if kind == "changed"]
        rows.append(
            {
                "engine": line.engine, "case": line.case, "route": line.route, "setting": line.setting,
                "oldest": in_words(oldest), "changes": "; ".join(answers),
                "digits": ", ".join(v for v, kind in kinds.items() if kind == "digits"),
            }
        )  # fmt: skip
    return rows


def release_rows(all_lines: Sequence[HistoryLine], missing: dict[str, str]) -> list[Row]:
    """The rows of the table `history_releases`; `missing`: why a version (ENGINE@VERSION) was not run."""
    keys = {(line.engine, version) for line in all_lines for version in line.answers}
    keys |= {split_version(name) for name in missing}
    engines = list(dict.fromkeys([*(line.engine for line in all_lines), *(split_version(n)[0] for n in missing)]))
    rows: list[Row] = []
    for engine, version in sorted(keys, key=lambda key: (engines.index(key[0]), Version(key[1]))):
        counts = dict.fromkeys(("runs", "changed", "better", "worse", "digits"), 0)
        for line in all_lines:
            if line.engine == engine and version in line.answers:
                _count(line, version, counts)
        note = missing.get(f"{engine}@{version}", "")
        rows.append({"engine": engine, "version": version, **counts, "note": note})
    return rows


def _count(line: HistoryLine, version: str, counts: dict[str, int]) -> None:
    versions = list(line.answers)
    kind, place = line.changes[version], versions.index(version)
    counts["runs"] += line.answers[version].outcome == "answered"
    counts["digits"] += kind == "digits"
    if kind == "changed":
        better = is_better(line.answers[versions[place - 1]], line.answers[version])
        counts["changed"] += 1
        counts["better" if better else "worse"] += 1
