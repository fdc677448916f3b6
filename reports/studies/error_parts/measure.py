"""The parts of an error: how much is the time step's, how much the model's, and which knob to turn next.

An engine's grid (`adapters.interface`) holds every combination of a few steps h and model knobs p. With the finest of
each, h* and p*, a signed error E falls into parts that add up (an expansion about the grid's finest corner):

    E(h, p) = E(h*, p*) + step part + model part + interaction
    step part = E(h, p*) − E(h*, p*),  model part = E(h*, p) − E(h*, p*)

The knob to turn next is found by turning each by one notch, all others held; what makes the error grow is named too.
Errors are relative to the reference: first transition in s, energy lost in J, final centre in m.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import adapters
import cases
import reference
from adapters import Setting
from cases import Case, CaseError, Trajectory

from ...judging import distances
from ...judging import slip_phases as metrics
from ...running import tasks as trial
from ...running import workers
from ...running.records import TRUTH_RTOL, CaseKey, Truth

if TYPE_CHECKING:
    import pandas as pd

QUANTITIES = {"first_transition_time": "s", "energy_lost": "J", "final_centre": "m"}
# The cases of a default report: the paper's application, where facets, stiffness and regularisation all show, and a
# valley whose curvature changes.
CASES = ("disc_in_circle[mu=0.1]", "disc_in_cosine")
# Wall time a grid's run may take: its finest corner takes about a second, but a truth that is not kept takes longer.
LIMIT_SECONDS = 60.0
# A change of less than this share of the error is no reason to turn a knob, nor to warn of it.
_MATTERS = 0.01
# A motion that ends this many of its own steps before the truth's has no final centre to compare.
_LAST_STEPS = 2.5

Tell = Callable[[str, int, Iterator], Iterator]


@dataclass(frozen=True)
class Cell:
    """One setting of a grid and what came of it: "right", "wrong", "refused", "crashed" or "timed_out".

    `errors` are signed, by quantity, arrays of shape (1,) or, for the centre, (2,); NaN where there is none.
    """

    case: str
    solver: str
    route: str
    setting: Setting
    outcome: str
    reason: str = ""
    errors: dict[str, np.ndarray] = field(default_factory=dict)


def chosen(asked: Sequence[Case]) -> list[Case]:
    """The cases of a report whose errors are taken apart: CASES if they are among them, else the first."""
    usual = [case for case in asked if case.label in CASES]
    return usual or list(asked[:1])


# --- measuring --------------------------------------------------------------------------------------------------------


def measure(
    asked: Sequence[Case],
    solvers: Sequence[str],
    files: tuple[str, ...] = (),
    jobs: int = 2,
    tell: Tell = lambda step, total, answers: answers,
    calls: Callable = workers.run,
) -> list[Cell]:
    """Run every grid of every route of the solvers on every case, each run in a process of its own.

    `calls` makes them: `workers.run`, or what stands in for it."""
    keys = [CaseKey.of(case, files) for case in asked]

    def step(name: str, function: Callable, arguments: list[tuple]) -> list[workers.Answer]:
        coming = calls(function, arguments, jobs, LIMIT_SECONDS)
        return [answer for _, answer in sorted(tell(name, len(arguments), coming), key=lambda pair: pair[0])]

    found = step("truth", trial.find_truth, [(key,) for key in keys])
    truths = [a.value if a.outcome == "done" else Truth(failure=a.reason) for a in found]
    pairs = [(key, truth, name) for key, truth in zip(keys, truths, strict=True) for name in solvers]
    cells: list[Cell] = []
    todo: list[tuple[CaseKey, str, str, Setting, Truth]] = []
    offers = step("grids", grids, [(key, name) for key, _, name in pairs])
    for (key, truth, name), answer in zip(pairs, offers, strict=True):
        label = trial.load(key).label
        if answer.outcome != "done":
            cells.append(_cell(Cell(label, name, "", Setting.of(), ""), answer))
            continue
        for route, settings, refusal in answer.value:
            excuse = refusal or truth.failure
            if excuse:
                cells.append(Cell(label, name, route, Setting.of(), "refused", excuse))
            else:
                todo += [(key, name, route, setting, truth) for setting in settings]
    for task, answer in zip(todo, step("error parts", errors, todo), strict=True):
        key, name, route, setting, _ = task
        cells.append(_cell(Cell(trial.load(key).label, name, route, setting, ""), answer))
    return cells


def _cell(empty: Cell, answer: workers.Answer) -> Cell:
    if answer.outcome == "done":
        outcome, reason, found = answer.value
        return Cell(empty.case, empty.solver, empty.route, empty.setting, outcome, reason, found)
    outcome = "timed_out" if answer.outcome == "timed_out" else "crashed"
    return Cell(empty.case, empty.solver, empty.route, empty.setting, outcome, answer.reason)


def grids(key: CaseKey, name: str) -> list[tuple[str, tuple[Setting, ...], str]]:
    """Each route's grid, or the reason why it has none; no row for an adapter without grids."""
    try:
        module = trial.solver(name)
    except ImportError as problem:
        return [("", (), f"{name} is not installed here ({problem})")]
    if not hasattr(module, "grid"):
        return []
    case, found = trial.load(key), []
    for route in module.routes:
        refusal = module.refuses(case, route) or ""
        settings = () if refusal else tuple(module.grid(case, route))
        found.append((route, settings, refusal if settings or refusal else "its model has no knob but the step"))
    return found


def errors(
    key: CaseKey, name: str, route: str, setting: Setting, truth: Truth
) -> tuple[str, str, dict[str, np.ndarray]]:
    """One run of the grid, in a worker: outcome, reason, and its signed errors by quantity."""
    case = trial.load(key)
    motion = trial.timed(trial.solver(name), case, route, setting)
    ledger = metrics.match(truth.transitions, trial.read(case, motion).transitions)
    first = next((row.error for row in ledger if row.event == 1 and row.verdict != "spurious"), nan)
    wrong = [row.verdict for row in ledger if row.verdict != "matched"]
    found = {"first_transition_time": np.array([first]), **_final(case, motion, _true_motion(key, truth.method))}
    reason = ", ".join(f"{wrong.count(kind)} {kind}" for kind in dict.fromkeys(wrong))
    return ("wrong" if wrong else "right"), reason, found


@lru_cache(maxsize=2)
def _true_motion(key: CaseKey, method: str) -> Trajectory:
    return reference.simulate(trial.load(key), rtol=TRUTH_RTOL, method=method)


def _final(case: Case, motion: Trajectory, truth: Trajectory) -> dict[str, np.ndarray]:
    """Errors of the energy lost and of the centre at the end of the common time; NaN for a motion that ends early."""
    end = min(float(motion.t[-1]), float(truth.t[-1]))
    if end < truth.t[-1] - _LAST_STEPS * float(np.max(np.diff(motion.t))) and truth.status != "lift_off":
        return {"energy_lost": np.array([nan]), "final_centre": np.array([nan, nan])}
    lost = []
    for each in (motion, truth):
        ends = Trajectory(t=np.array([0.0, end]), **each(np.array([each.t[0], end]))._asdict())
        lost.append(-float(np.diff(distances.energy(case, ends))[0]))
    here, there = motion(end), truth(end)
    centre = np.array([here.x - there.x, here.y - there.y], dtype=float)
    return {"energy_lost": np.array([lost[0] - lost[1]]), "final_centre": centre}


# --- taking apart -----------------------------------------------------------------------------------------------------


class Grid:
    """A route's cells, by the places of their values on each knob's scale, coarse to fine; the knob `h` comes first."""

    def __init__(self, cells: Sequence[Cell]):
        values: dict[str, list] = {}
        for cell in cells:
            for knob, value in cell.setting.values:
                known = values.setdefault(knob, [])
                known += [value] if value not in known else []
        self.knobs = sorted((k for k, known in values.items() if len(known) > 1), key=lambda knob: knob != "h")
        self.levels = [values[knob] for knob in self.knobs]
        self.cells = {self.place(cell.setting): cell for cell in cells}

    def place(self, setting: Setting) -> tuple[int, ...]:
        """Where a setting stands: an index for every knob."""
        return tuple(levels.index(setting[knob]) for knob, levels in zip(self.knobs, self.levels, strict=True))

    @property
    def finest(self) -> tuple[int, ...]:
        """The place where every knob is finest."""
        return tuple(len(levels) - 1 for levels in self.levels)

    def error(self, place: Sequence[int], quantity: str) -> np.ndarray:
        """The signed error there; NaN where nothing came of the run, or off the grid."""
        cell = self.cells.get(tuple(place))
        return (cell.errors if cell else {}).get(quantity, np.full(2 if quantity == "final_centre" else 1, nan))

    def mixed(self, place: Sequence[int], kept: Sequence[str]) -> list[int]:
        """The place with the knobs `kept` as they are and all others finest."""
        return [at if knob in kept else end for knob, at, end in zip(self.knobs, place, self.finest, strict=True)]

    def notch(self, place: Sequence[int], knob: str) -> list[int]:
        """The place with one knob turned by one notch."""
        return [at + (knob == other) for other, at in zip(self.knobs, place, strict=True)]


class Parts(NamedTuple):
    """An error's parts, which add up to `total`, along the direction of the total error; in the quantity's unit.

    `knob_parts`: what each model knob would leave if all others were at their finest, as the model part.
    """

    total: float
    finest_error: float
    step_part: float
    model_part: float
    interaction: float
    knob_parts: dict[str, float]


def parts(grid: Grid, place: Sequence[int], quantity: str) -> Parts:
    """The parts of the error at a place of the grid."""
    total = grid.error(place, quantity)
    size = float(np.linalg.norm(total))
    # A signed number keeps its sign; of a vector's parts, what is at right angles to it adds nothing to its size.
    direction = np.ones(1) if total.size == 1 else total / size if size else np.zeros_like(total)
    model = [knob for knob in grid.knobs if knob != "h"]
    base = grid.error(grid.finest, quantity)

    def along(kept: Sequence[str]) -> float:
        return float(np.dot(grid.error(grid.mixed(place, kept), quantity) - base, direction))

    whole, corner = float(np.dot(total, direction)), float(np.dot(base, direction))
    step_part, model_part = along(["h"]), along(model)
    single = {knob: along([knob]) for knob in model}
    return Parts(whole, corner, step_part, model_part, whole - corner - step_part - model_part, single)


def advice(grid: Grid, place: Sequence[int], quantity: str) -> tuple[str, str]:
    """The knob to turn next ("all": only together they help; "none": nothing does), and those that make it worse."""
    now = float(np.linalg.norm(grid.error(place, quantity)))
    after = {knob: float(np.linalg.norm(grid.error(grid.notch(place, knob), quantity))) for knob in grid.knobs}
    # Comparisons with NaN are false: what leads off the grid or to a failed run is neither advised nor warned of.
    better = {knob: size for knob, size in after.items() if size < (1 - _MATTERS) * now}
    worse = [knob for knob, size in after.items() if size > (1 + _MATTERS) * now]
    if better:
        return min(better, key=lambda knob: better[knob]), " ".join(worse)
    together = [min(at + 1, end) for at, end in zip(place, grid.finest, strict=True)]
    helps = float(np.linalg.norm(grid.error(together, quantity))) < (1 - _MATTERS) * now
    return ("all" if helps else "none"), " ".join(worse)


def rows(cells: Sequence[Cell]) -> list[dict[str, Any]]:
    """One row per case, route, quantity and setting; one per route that was refused."""
    found = []
    for (case, solver, route), group in by_route(cells).items():
        common = {"case": case, "solver": solver, "route": route}
        grid = Grid(group)
        for quantity in QUANTITIES if grid.knobs else ("",):
            for cell in group:
                row = {**common, "quantity": quantity, "setting": _varied(grid, cell.setting)}
                row |= _told(grid, cell, quantity)
                found.append({**row, "outcome": cell.outcome, "reason": cell.reason})
    return found


def _told(grid: Grid, cell: Cell, quantity: str) -> dict[str, Any]:
    if not grid.knobs:
        blank = {name: nan for name in ("total", "finest_error", "step_part", "model_part", "interaction")}
        return {**blank, "model_parts": "", "turn_next": "", "makes_worse": ""}
    place = grid.place(cell.setting)
    told = parts(grid, place, quantity)
    turn, worse = advice(grid, place, quantity)
    words = " ".join(f"{knob}={part:.2g}" for knob, part in told.knob_parts.items())
    numbers = {name: value for name, value in told._asdict().items() if name != "knob_parts"}
    return {**numbers, "model_parts": words, "turn_next": turn, "makes_worse": worse}


def _varied(grid: Grid, setting: Setting) -> str:
    """The setting's knobs that differ within the grid."""
    return str(Setting(tuple((knob, value) for knob, value in setting.values if knob in grid.knobs)))


def by_route(cells: Sequence[Cell]) -> dict[tuple[str, str, str], list[Cell]]:
    """The cells of each case, solver and route."""
    groups: dict[tuple[str, str, str], list[Cell]] = {}
    for cell in cells:
        groups.setdefault((cell.case, cell.solver, cell.route), []).append(cell)
    return groups


def frame(cells: Sequence[Cell]) -> pd.DataFrame:
    """The table `error_parts`."""
    import pandas as pd

    return pd.DataFrame(rows(cells))


# --- the command ------------------------------------------------------------------------------------------------------


def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print, or write, the table; returns 0, or 2 if what was asked for makes no sense."""
    parser = argparse.ArgumentParser(prog="python -m reports.error_parts", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--case", metavar="NAME", nargs="+", default=list(CASES), help=f"cases (default: {' '.join(CASES)})")
    add("--solver", metavar="NAME", nargs="+", default=list(adapters.engines()), help="engines (default: all)")
    add("--out", metavar="FILE", type=Path, help="write the table as CSV, and a picture of each case beside it")
    options = parser.parse_args(argv)
    try:
        asked = [case for text in options.case for case in cases.select(text)]
        for name in options.solver:
            if name not in adapters.engines():
                raise cases.errors.unknown("engine", name, adapters.engines())
    except CaseError as problem:
        print(f"reports.error_parts: {problem}", file=sys.stderr)
        return 2
    cells = measure(asked, options.solver, tell=_progress)
    if options.out is None:
        print(frame(cells).to_string(index=False))
        return 0
    from . import figure as error_parts_figure

    written = frame(cells)
    written.to_csv(options.out, index=False)
    for drawn in error_parts_figure.draw(cells, options.out.parent):
        print(options.out.parent / f"{drawn.name}.svg")
    print(options.out)
    return 0


def _progress(step: str, total: int, answers: Iterator) -> Iterator:
    from tqdm import tqdm

    return iter(tqdm(answers, desc=step, total=total, mininterval=0.2, dynamic_ncols=True))


if __name__ == "__main__":
    raise SystemExit(main())
