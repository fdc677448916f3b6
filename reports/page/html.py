"""The self-contained HTML page made of rows, figures and motions: style, scripts and pictures are inside it."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from ..analysis.work_precision import CostMeasurements
from ..drawing.colours import GRADES, LineStyles, colours, identifier
from ..drawing.figure_files import FigureEntry
from ..drawing.figures import headline, looks_of
from ..judging.grades import LIMITS, percent
from ..running.names import REFERENCE
from ..running.records import TRUTH_RTOL, Experiment
from . import chapters, cost, evidence, front_page, motions, vendor
from .fragments import anchor, compress, environment, figure_of
from .fragments import command_of as command_of
from .page_table import PageTable, table

if TYPE_CHECKING:
    import pandas as pd

    from ..analysis.columns import Table
    from ..studies import Result

_STATIC = Path(__file__).parent / "static"
# In order of their dependencies.
_SCRIPTS = ("state.js", "player.js", "plots.js", "tables.js", "case_tables.js", "chapters.js")
_LIBRARIES = ("uplot.min.js", "datatables.min.js")
_TABS = {
    "answer": "Answer", "cases": "Cases", "cost": "Cost", "evidence": "How we know", "errors": "Why engines err",
    "data": "Data",
}  # fmt: skip


def render(
    experiment: Experiment,
    measurements: CostMeasurements,
    frames: Mapping[str, pd.DataFrame],
    words: Mapping[str, Table],
    figure_entries: Sequence[FigureEntry],
    results: Sequence[Result],
    moving: Sequence[dict[str, Any]],
    folder: Path,
    manifest: dict[str, Any],
) -> str:
    """Return the page as HTML text.

    `words`: descriptions of each table; `figure_entries`: the figures that are files; `moving`: motions for the player;
    `folder`: that of the report; `manifest`: as written next to the page.
    """
    command = manifest["command"]
    solvers, looks = _solvers(experiment), looks_of(experiment)
    parts = {
        "command": command,
        "style": Markup(_style(solvers)),
        "script": Markup(_script()),
        "chapters": [{"id": place, "name": name} for place, name in _TABS.items()],
        "solvers": solvers,
        "routes": list(dict.fromkeys(r.route for r in experiment.runs if r.route and r.solver != REFERENCE)),
        **front_page.screen(experiment, frames, moving, manifest, looks),
        **chapters.cases(experiment, manifest, {motion["label"] for motion in moving}),
        "slip": _slip(experiment, figure_entries, looks),
        "cost": cost.section(measurements, frames, looks),
        "proofs": evidence.proofs(experiment),
        "studies": [evidence.study(result) for result in results],
        "on_request": evidence.on_request(results),
        "failures": chapters.failures(frames["trajectories"]),
        "tables": [(_data_table(name, frame, words[name]), words[name].holds) for name, frame in frames.items()],
        "files": [{"name": name, "data": Markup(_columns(folder / "tables" / f"{name}.csv"))} for name in frames],
        "made": chapters.provenance(manifest),
        "vendored": vendor.libraries(),
        "motions": [{"label": motion["label"], "data": Markup(motions.script(motion))} for motion in moving],
        "truth_rtol": f"{TRUTH_RTOL:g}",
        "grades": ", ".join(f"{name} up to {percent(limit)}" for name, limit in LIMITS.items()),
        "limit": f"{manifest['limit_seconds']:g}",
    }
    return environment().get_template("page.html").render(parts)


def _slip(experiment: Experiment, figure_entries: Sequence[FigureEntry], looks: LineStyles) -> dict[str, Any] | None:
    """The slip velocity in one scene, or why its figure could not be drawn; None without one."""
    entry = next(iter(figure_entries), None)
    if entry is None:
        return None
    where = {"label": entry.case, "anchor": anchor(entry.case)}
    if not entry.name:
        return where | {"failure": entry.caption}
    case = next(case for case in experiment.cases if case.label == entry.case)
    return where | {"failure": ""} | (figure_of(headline(experiment, case), looks, 230.0) or {})


def _solvers(experiment: Experiment) -> list[dict[str, str]]:
    """Solvers of the experiment with their colours; the reference last."""
    by_solver = colours(dict.fromkeys(run.solver for run in experiment.runs if run.route))
    entries = [{"name": n, "id": identifier(n), "light": c.light, "dark": c.dark} for n, c in by_solver.items()]
    return sorted(entries, key=lambda entry: entry["name"] == REFERENCE)


def _style(solvers: Sequence[Mapping[str, str]]) -> str:
    colour_variables = "".join(
        f"--of-{entry['id']}: light-dark({entry['light']}, {entry['dark']}); " for entry in solvers
    )
    library = (vendor.FOLDER / "uplot.min.css").read_text(encoding="utf-8")
    style = (_STATIC / "page.css").read_text(encoding="utf-8")
    for grade, colour in GRADES.items():
        style = style.replace(f"GRADE_{grade.upper().replace(' ', '_')}", colour)
    return f"{library}\n:root {{ {colour_variables}}}\n{style}"


def _script() -> str:
    """All scripts joined: the libraries first, because our scripts use them, each with its licence as a comment."""
    texts = [f"/*! {_licence(package)} */" for package in vendor.libraries()]
    texts += [(vendor.FOLDER / name).read_text(encoding="utf-8") for name in _LIBRARIES]
    texts += [(_STATIC / name).read_text(encoding="utf-8") for name in _SCRIPTS]
    return "\n;".join(texts).replace("</script", "<\\/script")


def _licence(package: Mapping[str, Any]) -> str:
    file = vendor.FOLDER / next(n for n in package["files"] if n.endswith("LICENSE"))
    return f"{package['package']} {package['version']}\n{file.read_text(encoding='utf-8')}".replace("*/", "* /")


def _data_table(name: str, frame: pd.DataFrame, words: Table) -> PageTable:
    """A table of the list of all: its headings, without versions; a script reads its rows from the file."""
    titles = {str(column): str(column).replace("_", " ") for column in frame.columns if column != "version"}
    return table(name, frame, titles, words.columns, file=name, most=0)


# A number with more digits than the page's copy of a file has; times have all.
_LONG, _DIGITS, _EXACT = re.compile(r"-?[\d.]{11,}(e[-+]\d+)?"), 9, ("time", "reference_time")


def _columns(file: Path) -> str:
    """A file's columns, each its name and its cells, as text of compressed data: a third smaller than its rows."""
    with file.open(newline="", encoding="utf-8") as lines:
        names, *rows = csv.reader(lines)
    columns = zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True)
    texts = (
        "\x1f".join([name, *(cell if name in _EXACT else _short(cell) for cell in cells)]) for name, cells in columns
    )
    return compress("\x1e".join(texts).encode())


def _short(cell: str) -> str:
    return repr(float(f"{float(cell):.{_DIGITS}g}")) if _LONG.fullmatch(cell) else cell
