"""Comparison of solvers in a script or notebook: `compare(case, pymunk="assisted", mine="motion.csv")`.

The criteria are those of the report. Engines run in separate processes, so that a crash does not affect this one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import adapters
from adapters import EngineFailure, Setting
from cases import BadValue, Case, DoesNotFit, NotSupported, Trajectory
from cases.errors import instance, unknown_name

from .running import external_motions, tasks
from .running.calls import Calls
from .running.records import Run, Truth, first_error

if TYPE_CHECKING:
    import pandas as pd

    from cases.pictures.style import Picture


def motion_of(case: Case, solver: str, route: str, setting: Setting | Mapping | None = None) -> Trajectory:
    """Simulate a case with an engine, at a setting of its route (None: the finest of its ladder).

    Raises UnknownName for an unknown engine or route, NotSupported if the route does not support the case or is not
    installed, EngineFailure if it crashed or timed out.
    """
    if solver not in adapters.engines():
        raise unknown_name("engine", solver, adapters.engines())
    with Calls(jobs=1) as calls:
        (answer,) = calls.all("survey", tasks.survey, [(case, solver)])
        offers = answer.value if answer.outcome == "done" else ()
        if answer.outcome != "done":
            raise EngineFailure(f"{solver} does not answer: {answer.reason}")
        offer = next((offer for offer in offers if offer.route in (route, "")), None)
        if offer is None:
            raise unknown_name(f"route of {solver}", route, [offer.route for offer in offers])
        if offer.outcome or not offer.settings:
            raise NotSupported(f"{solver}, {route}: {offer.reason or 'it offers no setting'}")
        rung = offer.settings[-1] if setting is None else _setting(setting)
        (result,) = calls.all("run", tasks.motion_of, [(case, solver, route, rung)])
    if result.outcome != "done":
        raise EngineFailure(f"{solver}, {route}: {result.failure[1]}")
    return replace(result.value, case=case)


def _setting(knobs: Setting | Mapping) -> Setting:
    return knobs if isinstance(knobs, Setting) else Setting.of(**knobs)


def compare(case: Case, **solvers: str | Path | Trajectory) -> Comparison:
    """Judge motions by the certified truth.

    `solvers`: by name, a Trajectory, the path of an exported one (ending in .csv), or a route of the engine of that
    name, run at its finest setting. Raises CaseError if there is no truth, or a motion is not one of the case.
    """
    truth = tasks.find_truth(instance("case", case, Case))
    if truth.failure:
        raise DoesNotFit(f"there is no truth to judge by: {truth.failure}")
    motions, runs = {}, []
    for name, what in solvers.items():
        motions[name], run = _judge(case, truth, name, what)
        runs.append(run)
    return Comparison(case, truth, motions, tuple(runs))


def _judge(case: Case, truth: Truth, name: str, what: str | Path | Trajectory) -> tuple[Trajectory, Run]:
    """The motion of one argument of `compare`, and its row."""
    row = Run(case.label, name, "", Setting.of(), 0, outcome="")
    if not isinstance(what, Trajectory | str | Path):
        raise BadValue(f"{name} is {what!r}; give a Trajectory, the path of a .csv, or a route of the engine {name}")
    if str(what).endswith(".csv"):
        external = external_motions.read(name, case, Path(str(what)), route="")
        return external.motion, external_motions.judge_motion(external, 1, truth)
    if isinstance(what, Trajectory):
        motion = what
    else:
        motion, row = motion_of(case, name, str(what)), replace(row, route=str(what))
    row = replace(row, status=motion.status)
    return motion, tasks.judge(row, case, motion, tasks.true_motion(case, truth.method), truth)


@dataclass(frozen=True, repr=False)
class Comparison:
    """Motions of one case and its truth; `runs`: their rows as in the report, in the order of the arguments."""

    case: Case
    truth: Truth
    motions: Mapping[str, Trajectory]
    runs: tuple[Run, ...]

    def __repr__(self) -> str:
        outcomes = "; ".join(f"{run.solver} {run.grade or run.outcome}" for run in self.runs)
        return f"<Comparison on {self.case.label}: {outcomes}>"

    def _repr_html_(self) -> str:
        from html import escape

        from .page.text import shorten

        frame = self.to_frame()
        head = "".join(f"<th>{escape(str(name))}</th>" for name in frame)
        rows = [[escape(shorten(row[name], str(name))) for name in frame] for row in frame.to_dict("records")]
        lines = "".join("<tr>" + "".join(f"<td>{text}</td>" for text in row) + "</tr>" for row in rows)
        return f"<b>{escape(self.case.label)}</b><table><tr>{head}</tr>{lines}</table>"

    def to_frame(self) -> pd.DataFrame:
        """A row per motion: outcome, grade, score, error of the first transition (s), distances from the truth (m, rad,
        m/s)."""
        import pandas as pd

        rows = []
        for run in self.runs:
            row: dict[str, Any] = {
                "solver": run.solver,
                "route": run.route,
                "outcome": run.outcome,
                "grade": run.grade,
                "off": run.score.off if run.score else nan,
                "off_doubt": run.score.doubt if run.score else nan,
                "friction_factor": run.friction_factor,
                "law_error": run.law.median,
                "reason": run.reason,
            }
            rows.append(row | {"first_transition_error": first_error(run)} | run.distance._asdict())
        return pd.DataFrame(rows)

    def plot(self, quantity: str = "slip") -> Picture:
        """Plot a quantity of all motions against time, and below its difference from the truth."""
        from cases.pictures.style import apply_style

        from .drawing import figures, matplotlib_writer
        from .drawing.colours import LineStyles

        diagram = figures.comparison(self.case.label, self.truth, self.runs, quantity)
        with apply_style():
            return matplotlib_writer.draw(diagram, LineStyles((run.solver, run.route) for run in self.runs))
