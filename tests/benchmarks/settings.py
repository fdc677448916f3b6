"""Whether every rung is worth its cost: each route's ladder compared with a grid of all its parameters, over scenes.

Over the scenes for which it gives a motion, a setting has a mean error and a mean cost (geometric means; the cost is
relative to the scene's median). The error is off (`judging.score`). A setting of the grid beats a rung if it is faster
by MARGIN and at least as accurate, or at most as slow and by MARGIN² more accurate. Default settings are not compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, isfinite, log, nan
from statistics import median
from typing import Any, NamedTuple

from adapters import Setting
from adapters.processes.worker import CallResult
from cases import Case, NotSupported
from reports.judging.grades import grade
from reports.judging.score import score
from reports.running.calls import Calls
from reports.running.clocked_run import run_on_clock
from reports.running.experiment import find_truths, offers
from reports.running.records import Offer, Truth, one_default
from reports.running.solvers import solver
from reports.running.true_motions import true_motion
from reports.studies import Request

# Slip that ends, that begins, and that begins at once; on a line, in a circle and on a hill; with a turning load.
CASES = (
    "disc_in_circle[mu=0.1]",
    "disc_in_circle[mu=0.2]",
    "disc_on_line[mu=0.1]",
    "rolling_loop[ratio=3.5]",
    "disc_rolling_off_hill",
    "eccentric_disc_on_line",
    "driven_disc",
)
# Times of one run are accurate to about 10 %, the minimum of three to less: smaller differences do not count.
MARGIN, REPEATS = 1.25, 3
# Smallest off that counts: 4 digits, as in a ranking; finer differences are those of the samples.
LEAST_OFF = 1e-4
LIMIT_SECONDS = 120.0
# Place of a cell whose route offers no setting.
_PLACES = {"rung": "ladder", "grid": "grid"}


class SettingCell(NamedTuple):
    """One setting of a route in one case: its place ("rung 3" or "grid 17"), CPU time (s) of the fastest run, and off.

    If a route offers no setting, it has one cell with the place "ladder" or "grid". `reason`: why there is no motion.
    """

    case: str
    solver: str
    route: str
    place: str
    setting: Setting
    outcome: str
    cpu_s: float = nan
    off: float = nan
    reason: str = ""


class SettingPoint(NamedTuple):
    """A setting over all cases: geometric means of its relative cost and of off, the largest off, the number of
    cases."""

    place: str
    settings: tuple[Setting, ...]
    cost: float
    off: float
    worst: float
    cases: int


def measure(case_list: Sequence[Case], solvers: Sequence[str], calls: Calls) -> list[SettingCell]:
    """Run ladder and grid of every route on every case, one run at a time; a failure is a cell with the reason."""
    truths, by_label = find_truths(case_list, calls), {case.label: case for case in case_list}
    cells: list[SettingCell] = []
    todo: list[tuple[str, tuple[Case, str, str, Setting, Truth]]] = []
    for table_kind, word in (("ladder", "rung"), ("grid", "grid")):
        for (label, name), of_routes in offers(case_list, solvers, calls, table_kind).items():
            case, truth = by_label[label], truths[label]
            for offer in of_routes:
                outcome, reason = _excuse(offer, truth, word)
                failed_cell = SettingCell(label, name, offer.route, _PLACES[word], Setting.of(), outcome, reason=reason)
                if outcome and not any(cell[:3] == failed_cell[:3] for cell in cells):
                    cells.append(failed_cell)
                for place, setting in enumerate(() if outcome else one_default(offer.settings)):
                    if not setting.is_default:
                        todo.append((f"{word} {place}", (case, name, offer.route, setting, truth)))
    with calls.alone() as alone:
        answers = alone.all("settings", run_setting, [call for _, call in todo], limit=LIMIT_SECONDS)
    return cells + [_cell(where, call, answer) for (where, call), answer in zip(todo, answers, strict=True)]


def _excuse(offer: Offer, truth: Truth, word: str) -> tuple[str, str]:
    """Outcome and reason if there is nothing to run; empty otherwise, and for a route without a grid."""
    if offer.outcome:
        return offer.outcome, offer.reason
    if truth.failure:
        return "unsupported", f"there is no truth to compare it with: {truth.failure}"
    return ("", "") if offer.settings or word == "grid" else ("unsupported", "it offers no setting for this case")


def _cell(place: str, call: tuple[Case, str, str, Setting, Truth], answer: CallResult) -> SettingCell:
    case, name, route, setting, _ = call
    if answer.outcome == "done":
        return SettingCell(case.label, name, route, place, setting, *answer.value)
    outcome, reason = answer.failure
    return SettingCell(case.label, name, route, place, setting, outcome, reason=reason)


def run_setting(case: Case, name: str, route: str, setting: Setting, truth: Truth) -> tuple[str, float, float]:
    """Outcome, CPU time (s) of the fastest of some runs, and off; in a worker. Raises NotSupported for an executable
    that does not report its CPU time, which its own process has used."""
    module = solver(name)
    motion = run_on_clock(module, case, route, setting)
    if not isfinite(motion.cost.cpu_s):
        raise NotSupported("It reports no CPU time (the line `# cost` in docs/process_protocol.md).")
    # The first run also loads code and fills caches.
    seconds = [run_on_clock(module, case, route, setting).cost.cpu_s for _ in range(REPEATS)]
    assert truth.scale is not None, "a case with a truth has a scale"
    return "answered", min(seconds), score(case, motion, true_motion(case, truth.method), truth.scale).off


def points(cells: Sequence[SettingCell]) -> dict[tuple[str, str], list[SettingPoint]]:
    """For each solver and route, the settings that ran in all cases: rungs and grid, by place."""
    by_route: dict[tuple[str, str], list[SettingPoint]] = {}
    for route_key in dict.fromkeys(cell[1:3] for cell in cells):
        route_cells = [cell for cell in cells if cell[1:3] == route_key and isfinite(cell.cpu_s)]
        usual = {case: median(c.cpu_s for c in route_cells if c.case == case) for case in {c.case for c in route_cells}}
        # If ladders or grids differ from case to case, only their common places are compared.
        places = [
            p
            for p in dict.fromkeys(c.place for c in route_cells)
            if sum(c.place == p for c in route_cells) == len(usual)
        ]
        by_route[route_key] = [_point([c for c in route_cells if c.place == place], usual) for place in places]
    return by_route


def _point(cells: Sequence[SettingCell], usual: dict[str, float]) -> SettingPoint:
    return SettingPoint(
        cells[0].place,
        tuple(c.setting for c in cells),
        _mean([max(c.cpu_s, 1e-9) / max(usual[c.case], 1e-9) for c in cells]),
        _mean([max(c.off, LEAST_OFF) for c in cells]),
        max(c.off for c in cells),
        len(cells),
    )


def _mean(values: Sequence[float]) -> float:
    return exp(sum(map(log, values)) / len(values))


def beats(candidate: SettingPoint, other: SettingPoint) -> bool:
    """Whether a setting beats another (see the module)."""
    cost, error = candidate.cost / other.cost, candidate.off / other.off
    return (cost <= 1 / MARGIN and error <= 1.0) or (cost <= 1.0 and error <= 1 / MARGIN**2)


def table(cells: Sequence[SettingCell]) -> list[dict[str, Any]]:
    """A row for every rung and every setting of a grid; for a rung also the setting that beats it, if there is one.

    A setting without a motion in some case has a row with the reason in the first such case.
    """
    table_rows: list[dict[str, Any]] = []
    for (name, route), route_points in points(cells).items():
        grid = [point for point in route_points if point.place.startswith("grid")]
        for point in route_points:
            better = min((other for other in grid if beats(other, point)), key=lambda p: p.cost, default=None)
            rung = point.place.startswith("rung")
            table_rows.append(
                {
                    "solver": name,
                    "route": route,
                    "place": point.place,
                    "setting": str(point.settings[0]),
                    "outcome": "answered",
                    "reason": "",
                    "cost": point.cost,
                    "off": point.off,
                    "grade": str(grade(point.off)),
                    "worst_off": point.worst,
                    "cases": point.cases,
                    "on_envelope": better is None,
                    "beaten_by": str(better.settings[0]) if rung and better else "",
                }
            )
    failed_cells = {cell[1:4]: cell for cell in reversed(cells) if not isfinite(cell.cpu_s)}
    return table_rows + [_failed_row(cell) for cell in reversed(failed_cells.values())]


def _failed_row(cell: SettingCell) -> dict[str, Any]:
    return {
        "solver": cell.solver,
        "route": cell.route,
        "place": cell.place,
        "setting": str(cell.setting),
        "outcome": cell.outcome,
        "reason": f"{cell.case}: {cell.reason}",
        "cost": nan,
        "off": nan,
        "grade": "",
        "worst_off": nan,
        "cases": 0,
        "on_envelope": "",
        "beaten_by": "",
    }


def run(request: Request, calls: Calls) -> list[SettingCell]:
    """The cells of all ladders and grids."""
    return measure(request.cases_or(CASES), request.engines, calls)


def rows(cells: list[SettingCell]) -> dict[str, list[dict[str, Any]]]:
    """The table of settings."""
    return {"settings": table(cells)}
