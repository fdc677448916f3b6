"""The section "What accuracy costs in time": the answer first, then how it came about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis import conclusions, cost_tables, which_engine
from ..analysis.reached import ACCURACIES
from ..analysis.time_to_accuracy import REACHED
from ..analysis.words import level, quantity, seconds, times, unit
from ..analysis.work_precision import Measured, groups
from ..drawing.files import Drawn
from .pieces import class_of, figure_of, in_frame, records, remake, table_of

if TYPE_CHECKING:
    import pandas as pd

_PARTS = ("engine_s", "binding_s", "callback_s", "notes_s")


def section(
    measured: Measured, frames: Mapping[str, pd.DataFrame], drawn: Sequence[Drawn], figures: Path, command: str
) -> str:
    """The first sentence and the answers, then the picture over all cases, the time to each accuracy, whose time it is,
    the orders and the null scores."""
    if not measured.cases:
        return (
            "<p>Not measured: a quick report takes no timings. Leave out <code>--quick</code>. Which accuracy each "
            'ladder reaches stands in <a href="tables/headline.csv">headline.csv</a>.</p>'
        )
    answers, told, points = (records(frames[name]) for name in ("which_engine", "time_to_accuracy", "work_precision"))
    said = conclusions.headline(answers, told)
    picture = "".join(figure_of(d, figures, command) for d in drawn if d.name == "work_precision")
    failed = "".join(
        f"<p>{escape(case)} could not be timed: {escape(why)}</p>" for case, why in measured.failures.items()
    )
    lead = [row for row in told if row["lead"]]
    fits, main = frames["work_precision_fits"], {row["case"]: row["quantity"] for row in lead}
    fits = fits[[main.get(row["case"]) == row["quantity"] for row in records(fits)]] if len(fits) else fits
    hidden = ("settings_used", "settings")
    links = ", ".join(f'<a href="tables/{name}.csv">{name}.csv</a>' for name in cost_tables.HOLDS)
    return (
        f"<p><strong>{escape(said.first)}</strong></p>"
        f"<h3>Which engine at {level(conclusions.ASKED)}, at what cost</h3>{_answers(answers)}"
        f"<p>{escape(said.rest)} {escape(conclusions.set_up(points))}</p>{failed}"
        f"<h3>Whose time it is</h3>{_shares(lead)}"
        f"<h3>CPU time of a warm run to an accuracy, and its ratio to the fastest</h3>{_accuracies(lead)}{picture}"
        "<details><summary>Orders, and where the error saturates and why</summary>"
        f"{table_of(fits, {c: c.replace('_', ' ') for c in fits.columns if c not in hidden})}</details>"
        "<details><summary>What motions score that know nothing of friction's law</summary>"
        f"{table_of(frames['null_scores'], {c: c.replace('_', ' ') for c in frames['null_scores'].columns})}</details>"
        f'<p class="note">All quantities, all digits: {links}. What their columns mean: '
        f'<a href="tables/columns.md">columns.md</a>.</p>{remake(command)}'
    )


def _answers(answers: Sequence[dict[str, Any]]) -> str:
    """A row for each case at the accuracy that is asked for: once and a thousand times."""
    body = ""
    for (case,), rows in groups([r for r in answers if r["accuracy"] == conclusions.ASKED], "case").items():
        cells = "".join(_side(row) for row in sorted(rows, key=lambda r: r["runs"]))
        runs = rows[0]["break_even_runs"]
        more = f"{runs:,.0f} runs" if isfinite(runs) else ("never" if rows[0]["cheaper"] else "")
        small = f"<br><small>{escape(quantity(rows[0]['quantity']))}</small>"
        body += f"<tr><th>{escape(case)}{small}</th>{cells}<td>{more}</td></tr>"
    heads = "".join(
        f"<th>{'once, from cold' if runs == 1 else f'{runs:,} times'}<br>best engine</th><th><br>reference</th>"
        for runs in which_engine.RUNS
    )
    head = f"<tr><th>case</th>{heads}<th>reference<br>cheaper from</th></tr>"
    return in_frame("which engine", f"<thead>{head}</thead><tbody>{body}</tbody>", "") + (
        '<p class="note">Whole calls: building, running, reading; the first from cold, the others warm. Strong: the '
        "cheaper one, and by what factor. Below a tenth they are alike.</p>"
    )


def _side(row: dict[str, Any]) -> str:
    """Two cells: engine and reference with their times, the cheaper one strong."""
    cells = []
    for who in ("engine", "reference"):
        if not row[who]:
            cells.append(f"<small>{escape(row['reason'])}</small>")
            continue
        text = f"{escape(row[who])}<br>{seconds(row[f'{who}_total_s'])}"
        ahead = row["cheaper"] == row[who]
        cells.append(f"<strong>{text}</strong> <small>({times(row['factor'])})</small>" if ahead else text)
    return "".join(f"<td>{cell}</td>" for cell in cells)


def _shares(lead: Sequence[dict[str, Any]]) -> str:
    """Of the settings that reach the accuracy asked for: the parts of a warm run, the whole call, the cold one."""
    body = ""
    rows = [r for r in lead if r["award"] == REACHED and r["accuracy"] == conclusions.ASKED]
    for (case, accuracy), group in groups(rows, "case", "accuracy").items():
        for place, row in enumerate(sorted(group, key=lambda r: r["call_s"])):
            asked = f"to {level(accuracy)}{unit(row['unit'])}"
            name = f'<th rowspan="{len(group)}">{escape(case)}<br><small>{asked}</small></th>'
            parts = "".join(f"<td>{seconds(row[p]) if isfinite(row[p]) else ''}</td>" for p in _PARTS)
            wholes = ("cpu_s", "call_s", "first_call_s")
            whole = "".join(f"<td>{seconds(row[c]) if isfinite(row[c]) else ''}</td>" for c in wholes)
            runs = f"{row['break_even_runs']:,.0f}" if isfinite(row["break_even_runs"]) else ""
            who = f"{escape(row['solver'])} {escape(row['route'])}"
            first = class_of("first") if place == 0 else ""
            body += f"<tr{first}>{name if place == 0 else ''}<td>{who}</td>{parts}{whole}<td>{runs}</td></tr>"
    heads = ("case", "as used<br>from Python", "engine<br>alone", "its<br>binding", "our<br>callback", "our<br>notes",
             "run,<br>warm", "whole call,<br>warm", "one call<br>from cold", "reference<br>cheaper from")  # fmt: skip
    head = "".join(f"<th>{text}</th>" for text in heads)
    return (
        "<details open><summary>Engine, binding, callback, notes; whole calls</summary>"
        f"{in_frame('whose time it is', f'<thead><tr>{head}</tr></thead><tbody>{body}</tbody>')}</details>"
        '<p class="note">Of the reference the engine is heyoka and the callback its Python. Empty: counted with the '
        "engine (binding) or the callback (notes), or not measured. Other accuracies: "
        '<a href="tables/time_to_accuracy.csv">time_to_accuracy.csv</a>.</p>'
    )


def _accuracies(lead: Sequence[dict[str, Any]]) -> str:
    """Cases and routes against accuracies, in the quantity that leads each case."""
    head = "".join(f"<th>{level(accuracy)}</th>" for accuracy in ACCURACIES)
    body = ""
    for (case,), rows in groups(lead, "case").items():
        name = f"{escape(case)}<br><small>{quantity(rows[0]['quantity'])} / {rows[0]['unit']}</small>"
        routes = groups(rows, "solver", "route")
        for place, ((solver, route), levels) in enumerate(routes.items()):
            cells = "".join(f"<td>{_accuracy_cell(row)}</td>" for row in levels)
            first = f'<th rowspan="{len(routes)}">{name}</th>' if place == 0 else ""
            body += f"<tr{class_of('first') if place == 0 else ''}>{first}<td>{solver} {route}</td>{cells}</tr>"
    table = f"<thead><tr><th>case</th><th>solver</th>{head}</tr></thead><tbody>{body}</tbody>"
    return in_frame("time to an accuracy", table)


def _accuracy_cell(row: dict[str, Any]) -> str:
    if row["award"] != REACHED:
        return f"<small>{escape(row['award'])}</small>"
    ratio = f" <small>{times(row['ratio'])}</small>" if isfinite(row["ratio"]) else ""
    marks = ("*" if row["null_reaches"] else "") + ("°" if row["finer_rungs"] == 0 else "")
    return f"{seconds(row['cpu_s'])}{marks}{ratio}"
