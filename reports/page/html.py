"""Rows, figures and motions -> one self-contained page: style, scripts and pictures inside, no network."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from ..analysis.work_precision import Measured
from ..drawing.colours import colours
from ..drawing.files import Drawn
from ..running.records import REFERENCE, TRUTH_RTOL, Experiment
from . import chapters, cost, first, vendor
from .pieces import command_of as command_of
from .pieces import environment, picture, records, table

if TYPE_CHECKING:
    import pandas as pd

    from ..analysis.columns import Table
    from ..studies import Result

_STATIC = Path(__file__).parent / "static"
# In the order in which they need each other.
_SCRIPTS = ("state.js", "player.js", "plots.js", "precision.js", "tables.js", "chapters.js")
_LIBRARIES = ("uplot.min.js", "datatables.min.js")
# Rows of a table that are shown on the page, where it is shown for itself and where it stands among all; the files hold
# the rest.
_STUDY_ROWS, _SHOWN_ROWS = 600, 30
_SHORT = {
    "stability": "Hard scenes", "effect_costs": "Effects", "error_parts": "Error parts", "formulations": "Formulations",
    "paper": "Paper", "published": "Published", "reference_cost": "Reference", "settings": "Rungs", "maps": "Maps",
    "meanings": "Parameters",
}  # fmt: skip


def render(
    experiment: Experiment,
    measured: Measured,
    frames: Mapping[str, pd.DataFrame],
    words: Mapping[str, Table],
    drawn: Sequence[Drawn],
    studied: Sequence[Result],
    of_studies: Mapping[str, Sequence[Drawn]],
    moving: Sequence[dict[str, Any]],
    figures: Path,
    manifest: dict[str, Any],
) -> str:
    """The page as text. `words` are said of each table, `of_studies` are the studies' pictures by name, `moving` the
    motions for the player; `figures` is the folder with the drawn SVG files; `manifest` as written beside the page."""
    command = manifest["command"]
    solvers = _solvers(experiment)
    shown_by_studies = {name for result in studied for name in result.frames}
    parts = {
        "command": command,
        "style": Markup(_style(solvers)),
        "script": Markup(_script()),
        "chapters": _chapters(studied),
        "solvers": solvers,
        "routes": list(dict.fromkeys(r.route for r in experiment.runs if r.route and r.solver != REFERENCE)),
        **first.screen(experiment, frames, moving, bool(measured.cases), manifest),
        **chapters.cases(experiment, frames, drawn, figures, manifest, {told["label"] for told in moving}),
        "headline": chapters.headline(frames["headline"], drawn, figures),
        "cost": cost.section(measured, frames, drawn, figures),
        "precision_points": _points(frames.get("work_precision"), manifest),
        "studies": [_study(result, of_studies[result.name], figures) for result in studied],
        "failures": chapters.failures(frames["trajectories"]) + chapters.left_out(frames),
        "tables": [
            {"name": n, "holds": words[n].holds, "count": len(f)}
            | ({"rows": []} if n in shown_by_studies else table(f.head(_SHOWN_ROWS), _named(f), words[n].columns))
            for n, f in frames.items()
        ],
        "made": chapters.made(manifest),
        "vendored": [one | {"text": _licence(one)} for one in vendor.vendored()],
        "motions": [{"label": told["label"], "data": Markup(_json(told))} for told in moving],
        "truth_rtol": f"{TRUTH_RTOL:g}",
        "limit": f"{manifest['limit_seconds']:g}",
    }
    return environment().get_template("page.html").render(parts)


def _chapters(studied: Sequence[Result]) -> list[dict[str, str]]:
    """Chapters by their places and short names."""
    named = [("answer", "Answer"), ("motions", "Motion"), ("headline", "All cases"), ("precision", "Cost")]
    named += [(result.name, _SHORT.get(result.name, result.study.TITLE)) for result in studied]
    named += [("failures", "Failures"), ("definitions", "Words"), ("tables", "Tables"), ("made", "Made")]
    return [{"id": place, "name": name} for place, name in named]


def _solvers(experiment: Experiment) -> list[dict[str, str]]:
    """Who took part, with colours; the reference last."""
    chosen = colours(dict.fromkeys(run.solver for run in experiment.runs if run.route))
    told = [{"name": n, "id": first.identifier(n), "light": c.light, "dark": c.dark} for n, c in chosen.items()]
    return sorted(told, key=lambda one: one["name"] == REFERENCE)


def _style(solvers: Sequence[Mapping[str, str]]) -> str:
    own = "".join(f"--of-{one['id']}: light-dark({one['light']}, {one['dark']}); " for one in solvers)
    library = (vendor.FOLDER / "uplot.min.css").read_text(encoding="utf-8")
    return f"{library}\n:root {{ {own}}}\n{(_STATIC / 'page.css').read_text(encoding='utf-8')}"


def _script() -> str:
    """All scripts in one: libraries, then ours, which must see them."""
    texts = [(vendor.FOLDER / name).read_text(encoding="utf-8") for name in _LIBRARIES]
    texts += [(_STATIC / name).read_text(encoding="utf-8") for name in _SCRIPTS]
    return "\n;".join(texts).replace("</script", "<\\/script")


def _licence(package: Mapping[str, Any]) -> str:
    return (vendor.FOLDER / next(n for n in package["files"] if n.endswith("LICENSE"))).read_text(encoding="utf-8")


def _json(told: Any) -> str:
    """For a script of the page: no text in it may end it."""
    return json.dumps(told, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _named(frame: pd.DataFrame) -> dict[str, str]:
    """The columns as a table's heads; versions stand in the last chapter, and in the files."""
    return {str(column): str(column).replace("_", " ") for column in frame.columns if column != "version"}


def _study(result: Result, drawn: Sequence[Drawn], figures: Path) -> dict[str, Any]:
    """A study as its template takes it: question, pictures, tables, or why it failed."""
    told = [
        {"name": name, "holds": result.words[name].holds, "count": len(frame)}
        | table(frame.head(_STUDY_ROWS), _named(frame), result.words[name].columns)
        for name, frame in result.frames.items()
    ]  # fmt: skip
    return {
        "id": result.name,
        "title": result.study.TITLE,
        "question": result.study.QUESTION,
        "failure": result.failure,
        "command": result.command,
        "pictures": [picture(d, figures) for d in drawn],
        "tables": told,
    }


def _points(frame: pd.DataFrame | None, manifest: Mapping[str, Any]) -> Markup | str:
    """What the plot of work and precision shows, for its script."""
    if frame is None or not len(frame):
        return ""
    names = ("case", "solver", "route", "setting", "quantity", "unit", "lead", "cpu_s", "steps", "absolute_error",
             "floor_error")  # fmt: skip
    rows = [[_plain(row[name]) for name in names] for row in records(frame)]
    options = " ".join(["python -m reports.build", manifest["options"]]).strip()
    return Markup(_json({"columns": names, "rows": rows, "command": options}))


def _plain(value: Any) -> Any:
    """What JSON can hold: no number is null, numbers with four digits, as a picture shows them."""
    if isinstance(value, float):
        return float(f"{value:.4g}") if isfinite(value) else None
    return value if isinstance(value, bool | int) else str(value) if not hasattr(value, "item") else value.item()
