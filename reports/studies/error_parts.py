"""The parts of an error: those of the time step and of the model, and the parameter to refine next.

An engine's grid (`adapters.interface`) has all combinations of a few steps h and model parameters p. With the finest of
each, h* and p*, a signed error E falls into parts that add up (an expansion about the grid's finest corner):

    E(h, p) = E(h*, p*) + step part + model part + interaction
    step part = E(h, p*) − E(h*, p*),  model part = E(h*, p) − E(h*, p*)

The parameter to refine next is determined by refining each by one level while all others stay fixed;
parameters that increase the error are reported, too. Errors are relative to the reference: first transition in s,
energy lost as a share of the largest true kinetic energy, final centre in m.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from adapters import Setting

from ..analysis.columns import Table, words
from ..analysis.number_format import number
from ..judging.grades import grade, percent
from ..running.calls import Calls
from ..running.experiment import run_cases
from ..running.records import Run, Truth, first_error
from . import Request

TITLE = "The parts of an error"
QUESTION = (
    "Step and model parameters are varied independently: how much of an error is due to the step, the facets, the "
    "penalty or the regularised friction, and which to refine next."
)
TAKES = ("case", "solver")
TAB = "errors"
IN_REPORT = False
TABLES = {
    "error_parts": Table(
        "The parts of an error due to the step and to the model, and the parameter to refine next",
        words("case", "solver", "route")
        | words(
            quantity="first_transition_time, s; energy_lost, over the largest true kinetic energy; final_centre, m",
            setting="the parameters that differ within the grid",
            total="the error at this setting, signed (of the centre: its size)",
            finest_error="the error at the finest value of every parameter",
            step_part="error added by the step with the finest model",
            model_part="error added by the model with the finest step",
            interaction="the remainder of the total",
            model_parts="error added by each parameter of the model alone",
            turn_next="parameter whose next level reduces the error most; all: only together; none: nothing does",
            makes_worse="the parameters whose next level increases the error",
        )
        | words("off", "grade", "outcome")
        | words(reason="transitions that are not paired with the truth's, or the reason of any other outcome"),
    )
}

QUANTITIES = {"first_transition_time": "s", "energy_lost": "share", "final_centre": "m"}
# The study's own cases: the paper's application, in which facets, stiffness and regularisation all matter, and
# a valley whose curvature changes.
CASES = ("disc_in_circle[mu=0.1]", "disc_in_cosine")
# Wall-clock limit of a grid's run: the finest corner takes about a second, but a truth that is not cached takes longer.
LIMIT_SECONDS = 60.0
# A change by less than this fraction of the error is no reason to refine a parameter, nor to warn of it.
_MATTERS = 0.01
# A motion that ends earlier than the truth by more than this many of its own steps has no final centre to compare.
_LAST_STEPS = 2.5


class ErrorCell(NamedTuple):
    """A run of a grid. `errors` are signed, by quantity, arrays of shape (1,) or, for the centre, (2,); NaN if there is
    none."""

    run: Run
    errors: dict[str, np.ndarray] = {}

    @property
    def off(self) -> float:
        """The score of the motion; NaN without one."""
        return self.run.score.off if self.run.score else nan

    @property
    def reason(self) -> str:
        """The transitions that are not paired with the truth's, or the reason of another outcome."""
        if self.run.outcome != "answered":
            return self.run.reason
        others = [row.pairing for row in self.run.ledger if row.pairing != "paired"]
        return ", ".join(f"{others.count(kind)} {kind}" for kind in dict.fromkeys(others))


# --- measuring --------------------------------------------------------------------------------------------------------


def run(request: Request, calls: Calls) -> list[ErrorCell]:
    """Run every grid of every route of the engines on every case."""
    cases = request.cases_or(CASES)
    experiment = run_cases(cases, request.engines, calls, knobs="grid", limit=LIMIT_SECONDS, step="error parts")
    return [cell_of(run, experiment.truths[run.case]) for run in experiment.runs]


def cell_of(run: Run, truth: Truth) -> ErrorCell:
    """The signed errors of a run; those at its end are NaN for a motion that ends early."""
    if run.outcome != "answered" or run.score is None:
        return ErrorCell(run)
    t, energy, centre = run.off["t"], nan, (nan, nan)
    last = float(truth.samples["t"][-1]) - _LAST_STEPS * float(np.max(np.diff(t), initial=0.0))
    if len(t) and (t[-1] >= last or truth.status == "lift_off"):
        energy = run.off["energy_share"][0] - run.off["energy_share"][-1]
        centre = run.off["x"][-1], run.off["y"][-1]
    errors = {"first_transition_time": [first_error(run)], "energy_lost": [energy], "final_centre": centre}
    return ErrorCell(run, {quantity: np.array(values, dtype=float) for quantity, values in errors.items()})


# --- decomposition ----------------------------------------------------------------------------------------------------


class Grid:
    """A route's cells by the indices of their values on each parameter's scale, coarse to fine; `h` is first."""

    def __init__(self, cells: Sequence[ErrorCell]):
        values: dict[str, list] = {}
        for cell in cells:
            for parameter, value in dict(cell.run.setting).items():
                scale = values.setdefault(parameter, [])
                scale += [value] if value not in scale else []
        self.parameters = sorted(
            (k for k, scale in values.items() if len(scale) > 1), key=lambda parameter: parameter != "h"
        )
        self.levels = [values[parameter] for parameter in self.parameters]
        self.cells = {self.place(cell.run.setting): cell for cell in cells}

    def place(self, setting: Setting) -> tuple[int, ...]:
        """The place of a setting: an index for every parameter."""
        return tuple(
            levels.index(setting[parameter]) for parameter, levels in zip(self.parameters, self.levels, strict=True)
        )

    @property
    def finest(self) -> tuple[int, ...]:
        """The place where every parameter is finest."""
        return tuple(len(levels) - 1 for levels in self.levels)

    def error(self, place: Sequence[int], quantity: str) -> np.ndarray:
        """The signed error at a place; NaN if the run gave none, or outside the grid."""
        cell = self.cells.get(tuple(place))
        return (cell.errors if cell else {}).get(quantity, np.full(2 if quantity == "final_centre" else 1, nan))

    def off(self, place: Sequence[int]) -> float:
        """The score of the motion at a place; NaN if there is none."""
        cell = self.cells.get(tuple(place))
        return cell.off if cell else nan

    def partly_finest(self, place: Sequence[int], fixed_parameters: Sequence[str]) -> list[int]:
        """The place with the parameters `unchanged` as they are and all others finest."""
        return [
            at if parameter in fixed_parameters else end
            for parameter, at, end in zip(self.parameters, place, self.finest, strict=True)
        ]

    def neighbour(self, place: Sequence[int], parameter: str) -> list[int]:
        """The place with one parameter refined by one level."""
        return [at + (parameter == other) for other, at in zip(self.parameters, place, strict=True)]


class ErrorParts(NamedTuple):
    """An error's parts, which add up to `total`, along the direction of the total error; in the quantity's unit.

    `parameter_parts`: the part of each model parameter with all others at their finest, defined like the model part.
    """

    total: float
    finest_error: float
    step_part: float
    model_part: float
    interaction: float
    parameter_parts: dict[str, float]


def parts(grid: Grid, place: Sequence[int], quantity: str) -> ErrorParts:
    """The parts of the error at a place of the grid."""
    total = grid.error(place, quantity)
    size = float(np.linalg.norm(total))
    # A signed number keeps its sign; components perpendicular to a vector do not contribute to its size.
    direction = np.ones(1) if total.size == 1 else total / size if size else np.zeros_like(total)
    model = [parameter for parameter in grid.parameters if parameter != "h"]
    base = grid.error(grid.finest, quantity)

    def along(fixed_parameters: Sequence[str]) -> float:
        return float(np.dot(grid.error(grid.partly_finest(place, fixed_parameters), quantity) - base, direction))

    whole, corner = float(np.dot(total, direction)), float(np.dot(base, direction))
    step_part, model_part = along(["h"]), along(model)
    single = {parameter: along([parameter]) for parameter in model}
    return ErrorParts(whole, corner, step_part, model_part, whole - corner - step_part - model_part, single)


def advice(grid: Grid, place: Sequence[int], quantity: str) -> tuple[str, str]:
    """The parameter to refine next ("all": only all together; "none": nothing helps), and those that make it worse."""
    now = float(np.linalg.norm(grid.error(place, quantity)))
    after = {
        parameter: float(np.linalg.norm(grid.error(grid.neighbour(place, parameter), quantity)))
        for parameter in grid.parameters
    }
    # Comparisons with NaN are false: a step outside the grid or to a failed run is neither advised nor warned of.
    better = {parameter: size for parameter, size in after.items() if size < (1 - _MATTERS) * now}
    worse = [parameter for parameter, size in after.items() if size > (1 + _MATTERS) * now]
    if better:
        return min(better, key=lambda parameter: better[parameter]), " ".join(worse)
    together = [min(at + 1, end) for at, end in zip(place, grid.finest, strict=True)]
    helps = float(np.linalg.norm(grid.error(together, quantity))) < (1 - _MATTERS) * now
    return ("all" if helps else "none"), " ".join(worse)


def rows(cells: Sequence[ErrorCell]) -> dict[str, list[dict[str, Any]]]:
    """The table of parts: one row per case, route, quantity and setting; one per unsupported route."""
    table_rows = []
    for key, group in by_route(cells).items():
        common = dict(zip(("case", "solver", "route"), key, strict=True))
        grid = Grid(group)
        for quantity in QUANTITIES if grid.parameters else ("",):
            for cell in group:
                row = {**common, "quantity": quantity, "setting": _vary(grid, cell.run.setting)}
                row |= _reason(grid, cell, quantity)
                row |= {"off": cell.off, "grade": str(grade(cell.off)) if isfinite(cell.off) else ""}
                table_rows.append({**row, "outcome": cell.run.outcome, "reason": cell.reason})
    return {"error_parts": table_rows}


def _reason(grid: Grid, cell: ErrorCell, quantity: str) -> dict[str, Any]:
    if not grid.parameters:
        blank = {name: nan for name in ("total", "finest_error", "step_part", "model_part", "interaction")}
        return {**blank, "model_parts": "", "turn_next": "", "makes_worse": ""}
    place = grid.place(cell.run.setting)
    error_parts = parts(grid, place, quantity)
    turn, worse = advice(grid, place, quantity)
    words = " ".join(f"{parameter}={part:.2g}" for parameter, part in error_parts.parameter_parts.items())
    numbers = {name: value for name, value in error_parts._asdict().items() if name != "parameter_parts"}
    return {**numbers, "model_parts": words, "turn_next": turn, "makes_worse": worse}


def _vary(grid: Grid, setting: Setting) -> Setting:
    """The setting reduced to the parameters that differ within the grid."""
    return Setting.of(**{parameter: setting[parameter] for parameter in setting.keys() if parameter in grid.parameters})


def by_route(cells: Sequence[ErrorCell]) -> dict[tuple[str, str, str], list[ErrorCell]]:
    """The cells of each case, solver and route."""
    groups: dict[tuple[str, str, str], list[ErrorCell]] = {}
    for cell in cells:
        groups.setdefault((cell.run.case, cell.run.solver, cell.run.route), []).append(cell)
    return groups


def summary(cells: Sequence[ErrorCell]) -> str:
    """A sentence for each route: its error at the coarsest setting, and what each parameter changes if it alone is
    refined by one level."""
    sentences = []
    for (case, solver, route), group in by_route(cells).items():
        grid = Grid(group)
        place = [0] * len(grid.parameters)
        now = grid.off(place)
        if not grid.parameters or not isfinite(now):
            sentences.append(f"{solver} {route} in {case}: {group[0].reason or group[0].run.outcome}")
            continue
        changes = []
        for parameter, levels in zip(grid.parameters, grid.levels, strict=True):
            after = grid.off(grid.neighbour(place, parameter))
            change = f"÷ {number(now / after)}" if after > 0.0 else "no answer"
            changes.append(f"{parameter} {_short(levels[0])} to {_short(levels[1])}: {change}")
        sentences.append(f"{solver} {route} in {case}: {percent(now)} off; {'; '.join(changes)}")
    return "\n".join(sentences)


def _short(value: float | int) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
