"""Rows and figures -> one self-contained page: style and pictures inside, no script, no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import cases
from cases import Case

from ..analysis import tables
from ..analysis.work_precision import Measured
from ..drawing.files import Drawn
from ..running.records import TRUTH_RTOL, Experiment, finest, routes
from . import cost
from .pieces import command_of as command_of
from .pieces import figure_of, records, remake, table_of
from .text import error_text, lead_text, lost_words, reached_text

if TYPE_CHECKING:
    import pandas as pd

    from ..analysis.columns import Table
    from ..studies import Result

_PAGE = Path(__file__).parent / "template"
# Rows of a table that are shown on the page; the files hold the rest.
_SHOWN_ROWS = 150


def render(
    experiment: Experiment,
    measured: Measured,
    frames: Mapping[str, pd.DataFrame],
    words: Mapping[str, Table],
    drawn: Sequence[Drawn],
    studied: Sequence[Result],
    of_studies: Mapping[str, Sequence[Drawn]],
    figures: Path,
    manifest: dict[str, Any],
) -> str:
    """The page as text. `words` are said of each table, `of_studies` are the studies' pictures by name; `figures` is
    the folder with the drawn SVG files; `manifest` as written beside the page."""
    command = manifest["command"]
    parts = {
        "style": (_PAGE / "style.css").read_text(encoding="utf-8"),
        "summary": escape(_summary(experiment)),
        "contents": _contents(experiment, studied),
        "warnings": _warnings(experiment, manifest["lost"]),
        "headline": _headline(frames["headline"], drawn, figures, command),
        "precision": cost.section(measured, frames, drawn, figures, command),
        "cases": "\n".join(_case(experiment, case, frames, drawn, figures, manifest) for case in experiment.cases),
        "studies": "\n".join(_study(result, of_studies[result.name], figures) for result in studied),
        "failures": _failures(frames["trajectories"]),
        "tables": "\n".join(_whole_table(name, frame, words[name], command) for name, frame in frames.items()),
        "manifest": _manifest(manifest),
        "truth_rtol": f"{TRUTH_RTOL:g}",
        "limit": f"{manifest['limit_seconds']:g}",
    }
    return Template((_PAGE / "page.html").read_text(encoding="utf-8")).substitute(parts)


def _summary(experiment: Experiment) -> str:
    counts = tables.outcome_counts(experiment)
    told = "; ".join(
        f"{solver}: " + ", ".join(f"{count[o]} {o}" for o in tables.OUTCOMES if count[o])
        for solver, count in counts.items()
    )
    count = len(experiment.cases)
    return f"{count} case{'s' * (count != 1)}, {len(experiment.runs)} runs. {told}."


def _contents(experiment: Experiment, studied: Sequence[Result]) -> str:
    links = [("headline", "Transitions"), ("precision", "What accuracy costs in time")]
    links += [(result.name, result.study.TITLE) for result in studied]
    links += [(_anchor(case.label), case.label) for case in experiment.cases]
    links += [
        ("failures", "What did not work"),
        ("definitions", "Definitions"),
        ("tables", "Tables"),
        ("made", "How it was made"),
    ]
    return "\n".join(f'<a href="#{anchor}">{escape(text)}</a>' for anchor, text in links)


def _anchor(label: str) -> str:
    return "case-" + "".join(c if c.isalnum() else "-" for c in label).strip("-")


def _warnings(experiment: Experiment, lost: Sequence[str]) -> str:
    told = [f"{escape(lost_words(lost))}."] if lost else []
    for label, truth in experiment.truths.items():
        if truth.failure:
            told.append(f"<strong>{escape(label)}</strong> has no truth, and was not run: {escape(truth.failure)}.")
    return "\n".join(f'<div class="warning">{text}</div>' for text in told)


# --- sections ---------------------------------------------------------------------------------------------------------


def _headline(frame: pd.DataFrame, drawn: Sequence[Drawn], figures: Path, command: str) -> str:
    """The picture, and a table of cases against routes: finest setting above, the engine as it comes below."""
    picture = "".join(figure_of(d, figures, command) for d in drawn if d.name == "headline")
    if frame.empty:
        return picture
    rows = {(str(r["case"]), str(r["solver"]), str(r["route"])): r for r in records(frame)}
    routes = list(dict.fromkeys(key[1:] for key in rows))
    head = "".join(f"<th>{escape(solver)}<br>{escape(route)}</th>" for solver, route in routes)
    body = ""
    for case in dict.fromkeys(frame["case"]):
        cells = "".join(f"<td>{_headline_cell(rows.get((case, *route)))}</td>" for route in routes)
        body += f'<tr><th><a href="#{_anchor(case)}">{escape(case)}</a></th>{cells}</tr>'
    table = f"<thead><tr><th>case</th>{head}</tr></thead><tbody>{body}</tbody>"
    return (
        f'{picture}<div class="scroll"><table class="short">{table}</table></div>'
        '<p class="note">Above: the worst of all transitions in s where there are several, else the final pose in m, '
        "at the finest setting, and the accuracy the ladder reaches in it. Small: the error of the first transition's "
        "time in s, solver minus truth, at the finest setting and for the engine as it comes; where the truth has no "
        "transition, the largest error of the centre in m; an error inside the truth's own error bar is told as below "
        'that bar. All of it, with settings and orders: <a href="tables/headline.csv">headline.csv</a>.'
        f"</p>{remake(command)}"
    )


def _headline_cell(row: dict[str, Any] | None) -> str:
    if row is None:
        return ""
    finest, own = (error_text(row, which) for which in ("finest", "default"))
    lead, level = lead_text(row, "finest"), reached_text(row)
    if lead == finest:  # a word, the same for both
        return escape(lead)
    small = [f"reaches {level}" if level else "reaches none", f"first: {finest}", f"as it comes: {own}" if own else ""]
    return "<br>".join([escape(lead), *(f"<small>{escape(text)}</small>" for text in small if text)])


def _study(result: Result, drawn: Sequence[Drawn], figures: Path) -> str:
    """A study's question, pictures and links to its tables, or why it failed."""
    pictures = "".join(figure_of(d, figures, result.command) for d in drawn)
    links = ", ".join(f'<a href="tables/{name}.csv">{name}.csv</a>' for name in result.frames)
    told = f"<p>{escape(result.study.QUESTION)}</p>" + (f"<p>Tables: {links}.</p>" if links else "")
    if result.failure:
        told += f'<div class="warning">This study failed: {escape(result.failure)}</div>'
    title = escape(result.study.TITLE)
    return f'<section id="{result.name}"><h2>{title}</h2>{told}{pictures}{remake(result.command)}</section>'


def _case(experiment, case: Case, frames, drawn: Sequence[Drawn], figures: Path, manifest) -> str:
    label, truth = case.label, experiment.truths[case.label]
    command = command_of(label, manifest)
    pictures = "".join(figure_of(d, figures, command) for d in drawn if d.case == label and d.name != "headline")
    body = "" if truth.failure else _case_tables(experiment, label, frames, command)
    return (
        f'<section id="{_anchor(label)}">\n<h2>{escape(label)}</h2>\n<p>{escape(_said_of(case))}</p>\n'
        f"{pictures}{body}</section>"
    )


def _said_of(case: Case) -> str:
    """The first line of a case function's docstring; of a case made by hand nothing is said."""
    return cases.entry(case.name).summary if case.name in cases.names() else ""


def _case_tables(experiment: Experiment, label: str, frames, command: str) -> str:
    groups = routes(run for run in experiment.runs if run.case == label).values()
    shown = {(r.solver, r.route, r.setting) for r in map(finest, groups) if r}
    events, orders = frames["transitions"], frames["convergence"]
    told = ""
    if len(events):
        keep = [
            row["case"] == label and (row["solver"], row["route"], row["setting"]) in shown for row in records(events)
        ]
        chosen = events[keep]
        if len(chosen):
            columns = {c: c.replace("_", " ") for c in events.columns if c not in ("case", "setting")}
            told += "<h3>Transitions at the finest setting</h3>" + table_of(chosen, columns) + remake(command)
    chosen = orders[orders["case"] == label] if len(orders) else orders
    if len(chosen):
        columns = {c: c.replace("_", " ") for c in orders.columns if c not in ("case", "settings_used")}
        told += f"<details><summary>Observed orders</summary>{table_of(chosen, columns)}{remake(command)}</details>"
    return told


def _failures(frame: pd.DataFrame) -> str:
    parts = []
    words = {"refused": "Refused", "crashed": "Crashed", "timed_out": "Timed out", "wrong": "Wrong"}
    columns = {"case": "case", "solver": "solver", "route": "route", "setting": "setting", "reason": "reason"}
    for outcome, title in words.items():
        rows = frame[frame["outcome"] == outcome] if len(frame) else frame
        body = table_of(rows, columns) if len(rows) else "<p>None.</p>"
        parts.append(f"<h3>{title} ({len(rows)})</h3>{body}")
    return "\n".join(parts)


def _whole_table(name: str, frame: pd.DataFrame, words: Table, command: str) -> str:
    columns = {c: c for c in frame.columns}
    more = f'<p class="note">The first {_SHOWN_ROWS} of {len(frame)} rows.</p>' if len(frame) > _SHOWN_ROWS else ""
    links = f'<a href="tables/{name}.csv">{name}.csv</a>, <a href="tables/{name}.md">{name}.md</a>'
    return (
        f"<p>{links} — {escape(words.holds)} ({len(frame)} rows)</p>\n"
        f"<details><summary>Show {name}</summary>{more}{table_of(frame.head(_SHOWN_ROWS), columns, words.columns)}"
        f"{remake(command)}</details>"
    )


def _manifest(manifest: dict[str, Any]) -> str:
    rows = [("command", f"<code>{escape(manifest['command'])}</code>"), ("when", escape(manifest["made_at"]))]
    rows.append(("took", f"{manifest['seconds']:.0f} s"))
    for key in (
        "commit",
        "machine",
        "python",
        "solvers",
        "not installed",
        "packages",
        "settings",
        "ladders",
        "compiled",
    ):
        value = manifest[key]
        if not value:
            continue
        text = ", ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, dict) else str(value)
        rows.append((key, escape(text)))
    body = "".join(f"<tr><th>{key}</th><td>{text}</td></tr>" for key, text in rows)
    return (
        f'<div class="scroll"><table>{body}</table></div><p class="note">All of it: '
        '<a href="manifest.json">manifest.json</a>.</p>'
    )
