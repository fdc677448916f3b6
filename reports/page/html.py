"""Rows and figures -> one self-contained page: style and pictures inside, no script, no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from math import isfinite
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np

import cases
from cases import Case

from ..analysis import conclusions, tables, work_precision
from ..analysis.quantities import UNITS
from ..analysis.work_precision import Measured
from ..drawing.files import Drawn
from ..running.records import TRUTH_RTOL, Experiment, finest, routes
from .text import error_text, shorten

if TYPE_CHECKING:
    import pandas as pd

    from ..analysis.tables import Table
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
        "warnings": _warnings(experiment),
        "headline": _headline(frames["headline"], drawn, figures, command),
        "precision": _precision(measured, frames, drawn, figures, command),
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
    links = [("headline", "First transition"), ("precision", "What accuracy costs in time")]
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


def _warnings(experiment: Experiment) -> str:
    told = []
    for label, truth in experiment.truths.items():
        if truth.failure:
            told.append(f"<strong>{escape(label)}</strong> has no truth, and was not run: {escape(truth.failure)}.")
    return "\n".join(f'<div class="warning">{text}</div>' for text in told)


# --- sections ---------------------------------------------------------------------------------------------------------


def _headline(frame: pd.DataFrame, drawn: Sequence[Drawn], figures: Path, command: str) -> str:
    """The picture, and a table of cases against routes: finest setting above, the engine as it comes below."""
    picture = "".join(_figure(d, figures, command) for d in drawn if d.name == "headline")
    if frame.empty:
        return picture
    rows = {(str(r["case"]), str(r["solver"]), str(r["route"])): r for r in _records(frame)}
    routes = list(dict.fromkeys(key[1:] for key in rows))
    head = "".join(f"<th>{escape(solver)}<br>{escape(route)}</th>" for solver, route in routes)
    body = ""
    for case in dict.fromkeys(frame["case"]):
        cells = "".join(f"<td>{_headline_cell(rows.get((case, *route)))}</td>" for route in routes)
        body += f'<tr><th><a href="#{_anchor(case)}">{escape(case)}</a></th>{cells}</tr>'
    table = f"<thead><tr><th>case</th>{head}</tr></thead><tbody>{body}</tbody>"
    return (
        f'{picture}<div class="scroll"><table class="short">{table}</table></div>'
        '<p class="note">Above: the finest setting. Below, small: the engine as it comes. Where the truth has no '
        "transition, the largest error of the centre in m stands instead; an error inside the truth's own error bar is "
        'told as below that bar. All of it, with settings and orders: <a href="tables/headline.csv">headline.csv</a>.'
        f"</p>{_remake(command)}"
    )


def _headline_cell(row: dict[str, Any] | None) -> str:
    if row is None:
        return ""
    finest, own = (error_text(row, column) for column in ("finest_error", "default_error"))
    return escape(finest) + (f"<br><small>{escape(own)}</small>" if own else "")


def _study(result: Result, drawn: Sequence[Drawn], figures: Path) -> str:
    """A study's question, pictures and links to its tables, or why it failed."""
    pictures = "".join(_figure(d, figures, result.command) for d in drawn)
    links = ", ".join(f'<a href="tables/{name}.csv">{name}.csv</a>' for name in result.frames)
    told = f"<p>{escape(result.study.QUESTION)}</p>" + (f"<p>Tables: {links}.</p>" if links else "")
    if result.failure:
        told += f'<div class="warning">This study failed: {escape(result.failure)}</div>'
    title = escape(result.study.TITLE)
    return f'<section id="{result.name}"><h2>{title}</h2>{told}{pictures}{_remake(result.command)}</section>'


def _precision(measured: Measured, frames, drawn: Sequence[Drawn], figures: Path, command: str) -> str:
    """The sentences, the picture over all cases, the time to each accuracy, the orders and the null scores."""
    if not measured.cases:
        return "<p>Not measured: a quick report takes no timings. Leave out <code>--quick</code>.</p>"
    told, points = _records(frames["time_to_accuracy"]), _records(frames["work_precision"])
    first, _, rest = conclusions.headline(told).partition(". ")
    picture = "".join(_figure(d, figures, command) for d in drawn if d.name == "work_precision")
    failed = "".join(
        f"<p>{escape(case)} could not be timed: {escape(why)}</p>" for case, why in measured.failures.items()
    )
    fits = frames["work_precision_fits"]
    main = conclusions.main_quantity(told)
    fits = fits[[main.get(row["case"]) == row["quantity"] for row in _records(fits)]] if len(fits) else fits
    hidden = ("settings_used", "settings")
    links = ", ".join(
        f'<a href="tables/{name}.csv">{name}.csv</a>'
        for name in ("time_to_accuracy", "work_precision", "work_precision_fits", "null_scores")
    )
    return (
        f"<p><strong>{escape(first)}.</strong> {escape(rest)} {escape(conclusions.set_up(points))}</p>{failed}{picture}"
        f"<h3>CPU time to an accuracy, and its ratio to the fastest</h3>{_accuracies(told, main)}"
        "<details><summary>Orders, and where the error saturates and why</summary>"
        f"{_table(fits, {c: c.replace('_', ' ') for c in fits.columns if c not in hidden})}</details>"
        "<details><summary>What motions score that know nothing of friction's law</summary>"
        f"{_table(frames['null_scores'], {c: c.replace('_', ' ') for c in frames['null_scores'].columns})}</details>"
        f'<p class="note">All quantities, all digits: {links}.</p>{_remake(command)}'
    )


def _accuracies(told: Sequence[dict[str, Any]], main: dict[str, str]) -> str:
    """Cases and routes against accuracies, in each case's main quantity."""
    head = "".join(f"<th>{accuracy:g}</th>" for accuracy in work_precision.ACCURACIES)
    body = ""
    for (case,), rows in work_precision.groups([r for r in told if main[r["case"]] == r["quantity"]], "case").items():
        unit = f"{escape(case)}<br><small>{main[case].replace('_', ' ')} / {UNITS[main[case]]}</small>"
        routes = work_precision.groups(rows, "solver", "route")
        for place, ((solver, route), levels) in enumerate(routes.items()):
            cells = "".join(f"<td>{_accuracy_cell(level)}</td>" for level in levels)
            first = f'<th rowspan="{len(routes)}">{unit}</th>' if place == 0 else ""
            body += f"<tr{_class('first') if place == 0 else ''}>{first}<td>{solver} {route}</td>{cells}</tr>"
    table = f"<thead><tr><th>case</th><th>solver</th>{head}</tr></thead><tbody>{body}</tbody>"
    return f'<div class="scroll"><table class="short">{table}</table></div>'


def _accuracy_cell(row: dict[str, Any]) -> str:
    if isinstance(row["cpu_s"], str):
        return f"<small>{escape(row['cpu_s'])}</small>"
    ratio = f" <small>{row['ratio']:.3g} ×</small>" if isfinite(row["ratio"]) else ""
    null = "*" if row["null_reaches"] else ""
    return f"{row['cpu_s'] * 1e3:.2g} ms{null}{ratio}"


def _records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    return [{str(column): value for column, value in row.items()} for row in frame.to_dict("records")]


def _case(experiment, case: Case, frames, drawn: Sequence[Drawn], figures: Path, manifest) -> str:
    label, truth = case.label, experiment.truths[case.label]
    command = command_of(label, manifest)
    pictures = "".join(_figure(d, figures, command) for d in drawn if d.case == label and d.name != "headline")
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
            row["case"] == label and (row["solver"], row["route"], row["setting"]) in shown for row in _records(events)
        ]
        chosen = events[keep]
        if len(chosen):
            columns = {c: c.replace("_", " ") for c in events.columns if c not in ("case", "setting")}
            told += "<h3>Transitions at the finest setting</h3>" + _table(chosen, columns) + _remake(command)
    chosen = orders[orders["case"] == label] if len(orders) else orders
    if len(chosen):
        columns = {c: c.replace("_", " ") for c in orders.columns if c not in ("case", "settings_used")}
        told += f"<details><summary>Observed orders</summary>{_table(chosen, columns)}{_remake(command)}</details>"
    return told


def _failures(frame: pd.DataFrame) -> str:
    parts = []
    words = {"refused": "Refused", "crashed": "Crashed", "timed_out": "Timed out", "wrong": "Wrong"}
    columns = {"case": "case", "solver": "solver", "route": "route", "setting": "setting", "reason": "reason"}
    for outcome, title in words.items():
        rows = frame[frame["outcome"] == outcome] if len(frame) else frame
        body = _table(rows, columns) if len(rows) else "<p>None.</p>"
        parts.append(f"<h3>{title} ({len(rows)})</h3>{body}")
    return "\n".join(parts)


def _whole_table(name: str, frame: pd.DataFrame, words: Table, command: str) -> str:
    columns = {c: c for c in frame.columns}
    more = f'<p class="note">The first {_SHOWN_ROWS} of {len(frame)} rows.</p>' if len(frame) > _SHOWN_ROWS else ""
    links = f'<a href="tables/{name}.csv">{name}.csv</a>, <a href="tables/{name}.md">{name}.md</a>'
    return (
        f"<p>{links} — {escape(words.holds)} ({len(frame)} rows)</p>\n"
        f"<details><summary>Show {name}</summary>{more}{_table(frame.head(_SHOWN_ROWS), columns, words.columns)}"
        f"{_remake(command)}</details>"
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


# --- pieces -----------------------------------------------------------------------------------------------------------


def command_of(label: str, manifest: dict[str, Any]) -> str:
    """The command that makes one case's figures and tables again; of all cases for no label."""
    if not label:
        return manifest["command"]
    return f'python -m reports.build {manifest["options"]} --case "{label}"'.replace("  ", " ")


def _figure(drawn: Drawn, folder: Path, command: str) -> str:
    if not drawn.name:
        return f'<div class="warning"><strong>{escape(drawn.title)}.</strong> {escape(drawn.caption)}</div>'
    title = f"{drawn.title}: {drawn.case}" if drawn.case else drawn.title
    return (
        f'<figure><a href="figures/{drawn.name}.svg"><img loading="lazy" alt="{escape(title)}" '
        f'src="{_address((folder / f"{drawn.name}.svg").read_text(encoding="utf-8"))}"></a>'
        f"<figcaption><strong>{escape(drawn.title)}.</strong> {escape(drawn.caption)}</figcaption></figure>"
        f"{_remake(command)}"
    )


# What an address or an attribute of HTML would take for its own. Escaping no more than that keeps a picture a quarter
# smaller than base64 would.
_ESCAPES = str.maketrans({"%": "%25", "#": "%23", "&": "%26", '"': "'", "\n": " "})


def _address(svg: str) -> str:
    """The picture itself as an address. No attribute of ours holds an apostrophe, so that quotes may become such."""
    return f"data:image/svg+xml;charset=utf-8,{svg.strip().translate(_ESCAPES)}"


def _remake(command: str) -> str:
    return f'<p class="remake">Make it again: <code>{escape(command)}</code></p>'


def _table(frame: pd.DataFrame, columns: dict[str, str], words: Mapping[str, str] | None = None) -> str:
    """Some columns of a table as HTML; a line above each new case, and what a column means as its tip."""
    numeric = {c for c in columns if len(frame) and all(isinstance(v, int | float | np.number) for v in frame[c])}
    tips = {column: f' title="{escape(text)}"' for column, text in (words or {}).items()}
    head = "".join(
        f"<th{_class('number' if c in numeric else '')}{tips.get(c, '')}>{escape(title)}</th>"
        for c, title in columns.items()
    )
    rows, before = [], None
    for row in _records(frame):
        new = "case" in columns and before is not None and row["case"] != before
        before = row.get("case")
        cells = "".join(_cell(row[c], c, numeric) for c in columns)
        rows.append(f"<tr{_class('first') if new else ''}>{cells}</tr>")
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'


def _class(name: str) -> str:
    return f' class="{name}"' if name else ""


def _cell(value: Any, column: str, numeric: set[str]) -> str:
    text = shorten(value, column)
    if column in numeric:
        kind = "number"
    elif text in (*tables.OUTCOMES, "matched", "missed", "spurious", "unresolved"):
        kind = text
    elif "setting" in column:
        kind = "setting"
    else:
        kind = "reason" if column in ("reason", "note", "notes") else ""
    return f"<td{_class(kind)}>{escape(text)}</td>"
