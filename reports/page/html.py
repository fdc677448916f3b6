"""The self-contained HTML page made of rows, figures and motions: style, scripts and pictures are inside it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from ..analysis.work_precision import CostMeasurements
from ..drawing.colours import colours
from ..drawing.figure_files import FigureEntry
from ..judging.grades import LIMITS, percent
from ..running.records import REFERENCE, TRUTH_RTOL, Experiment
from . import chapters, cost, front_page, vendor
from .fragments import command_of as command_of
from .fragments import environment, picture, records, table

if TYPE_CHECKING:
    import pandas as pd

    from ..analysis.columns import Table
    from ..studies import Result

_STATIC = Path(__file__).parent / "static"
# In order of their dependencies.
_SCRIPTS = ("state.js", "player.js", "plots.js", "precision.js", "tables.js", "chapters.js")
_LIBRARIES = ("uplot.min.js", "datatables.min.js")
# Rows shown on the page: of a study's table, and of a table in the chapter of all tables. The files hold all rows.
_STUDY_ROWS, _SHOWN_ROWS = 600, 30
_SHORT = {
    "stability": "Hard scenes", "effect_costs": "Effects", "error_parts": "Error parts", "formulations": "Formulations",
    "paper": "Paper", "published": "Published", "reference_cost": "Reference", "settings": "Rungs", "maps": "Maps",
    "meanings": "Parameters",
}  # fmt: skip


def render(
    experiment: Experiment,
    measurements: CostMeasurements,
    frames: Mapping[str, pd.DataFrame],
    words: Mapping[str, Table],
    figure_entries: Sequence[FigureEntry],
    results: Sequence[Result],
    of_studies: Mapping[str, Sequence[FigureEntry]],
    moving: Sequence[dict[str, Any]],
    figures: Path,
    manifest: dict[str, Any],
) -> str:
    """Return the page as HTML text.

    `words`: descriptions of each table; `of_studies`: the studies' pictures by name; `moving`: motions for the player;
    `figures`: folder of the SVG files; `manifest`: as written next to the page.
    """
    command = manifest["command"]
    solvers = _solvers(experiment)
    study_tables = {name for result in results for name in result.frames}
    parts = {
        "command": command,
        "style": Markup(_style(solvers)),
        "script": Markup(_script()),
        "chapters": _chapters(results),
        "solvers": solvers,
        "routes": list(dict.fromkeys(r.route for r in experiment.runs if r.route and r.solver != REFERENCE)),
        **front_page.screen(experiment, frames, moving, manifest),
        **chapters.cases(experiment, frames, figure_entries, figures, manifest, {motion["label"] for motion in moving}),
        "headline": chapters.headline(frames["headline"], figure_entries, figures),
        "cost": cost.section(measurements, frames, figure_entries, figures),
        "precision_points": _points(frames.get("work_precision"), manifest),
        "studies": [_study(result, of_studies[result.name], figures) for result in results],
        "failures": chapters.failures(frames["trajectories"]) + chapters.left_out(frames),
        "tables": [
            {"name": n, "holds": words[n].holds, "count": len(f)}
            | ({"rows": []} if n in study_tables else table(f.head(_SHOWN_ROWS), _name(f), words[n].columns))
            for n, f in frames.items()
        ],
        "made": chapters.provenance(manifest),
        "vendored": [entry | {"text": _licence(entry)} for entry in vendor.libraries()],
        "motions": [{"label": motion["label"], "data": Markup(_json(motion))} for motion in moving],
        "truth_rtol": f"{TRUTH_RTOL:g}",
        "grades": ", ".join(f"{name} up to {percent(limit)}" for name, limit in LIMITS.items()),
        "limit": f"{manifest['limit_seconds']:g}",
    }
    return environment().get_template("page.html").render(parts)


def _chapters(results: Sequence[Result]) -> list[dict[str, str]]:
    """Chapters with their anchors and short names."""
    names = [("answer", "Answer"), ("motions", "Motion"), ("headline", "All cases"), ("precision", "Cost")]
    names += [(result.name, _SHORT.get(result.name, result.study.TITLE)) for result in results]
    names += [("failures", "Failures"), ("definitions", "Words"), ("tables", "Tables"), ("made", "Made")]
    return [{"id": place, "name": name} for place, name in names]


def _solvers(experiment: Experiment) -> list[dict[str, str]]:
    """Solvers of the experiment with their colours; the reference last."""
    by_solver = colours(dict.fromkeys(run.solver for run in experiment.runs if run.route))
    entries = [
        {"name": n, "id": front_page.identifier(n), "light": c.light, "dark": c.dark} for n, c in by_solver.items()
    ]
    return sorted(entries, key=lambda entry: entry["name"] == REFERENCE)


def _style(solvers: Sequence[Mapping[str, str]]) -> str:
    colour_variables = "".join(
        f"--of-{entry['id']}: light-dark({entry['light']}, {entry['dark']}); " for entry in solvers
    )
    library = (vendor.FOLDER / "uplot.min.css").read_text(encoding="utf-8")
    return f"{library}\n:root {{ {colour_variables}}}\n{(_STATIC / 'page.css').read_text(encoding='utf-8')}"


def _script() -> str:
    """All scripts joined: the libraries first, because our scripts use them."""
    texts = [(vendor.FOLDER / name).read_text(encoding="utf-8") for name in _LIBRARIES]
    texts += [(_STATIC / name).read_text(encoding="utf-8") for name in _SCRIPTS]
    return "\n;".join(texts).replace("</script", "<\\/script")


def _licence(package: Mapping[str, Any]) -> str:
    return (vendor.FOLDER / next(n for n in package["files"] if n.endswith("LICENSE"))).read_text(encoding="utf-8")


def _json(data: Any) -> str:
    """JSON for a script element; "<" is escaped, so that no text can close the element."""
    return json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _name(frame: pd.DataFrame) -> dict[str, str]:
    """Headings by column; versions are left out, because the last chapter and the files have them."""
    return {str(column): str(column).replace("_", " ") for column in frame.columns if column != "version"}


def _study(result: Result, figure_entries: Sequence[FigureEntry], figures: Path) -> dict[str, Any]:
    """Data of a study for its template: question, pictures and tables, or the reason why it failed."""
    tables = [
        {"name": name, "holds": result.words[name].holds, "count": len(frame)}
        | table(frame.head(_STUDY_ROWS), _name(frame), result.words[name].columns)
        for name, frame in result.frames.items()
    ]  # fmt: skip
    return {
        "id": result.name,
        "title": result.study.TITLE,
        "question": result.study.QUESTION,
        "failure": result.failure,
        "command": result.command,
        "pictures": [picture(d, figures) for d in figure_entries],
        "tables": tables,
    }


def _points(frame: pd.DataFrame | None, manifest: Mapping[str, Any]) -> Markup | str:
    """The points of the work-precision plot as JSON for its script."""
    if frame is None or not len(frame):
        return ""
    names = ("case", "solver", "route", "setting", "quantity", "unit", "cpu_s", "steps", "absolute_error",
             "floor_error")  # fmt: skip
    rows = [[_plain(row[name]) for name in names] for row in records(frame)]
    options = " ".join(["python -m reports.build", manifest["options"]]).strip()
    return Markup(_json({"columns": names, "rows": rows, "command": options}))


def _plain(value: Any) -> Any:
    """A value for JSON: null if it is not finite, otherwise with the four digits that a plot can show."""
    if isinstance(value, float):
        return float(f"{value:.4g}") if isfinite(value) else None
    return value if isinstance(value, bool | int) else str(value) if not hasattr(value, "item") else value.item()
