"""The page of limits, and the README's lines about them, from the table of `limits`.

`python -m cases.scene.limits_page > docs/limits.md` writes the page; a test compares.
"""

from __future__ import annotations

from textwrap import fill

from .limits import LIMITS, Limit, Reason, Scope

_HEAD = """# Limits

What the reference does not compute, or computes without a certificate, and why: *mechanics* decides it, or it is *not
built yet*. A case that has a limit is rejected in one sentence before anything runs. Where the limit is for several
contacts, a plate on its track alone runs until it touches in a second place: the motion ends there with the status
`second_contact`. Motions without a certificate are checked by the laws of mechanics only.
"""
_COLUMNS = ("not possible", "why", "reason", "instead")
# Scopes of `reference.simulate`.
_OF_SIMULATION = (Scope.ANY, Scope.SEVERAL_CONTACTS, Scope.SEVERAL_PLATES)


def as_page() -> str:
    """The page, in Markdown."""
    lines = [_HEAD]
    for scope in Scope:
        lines += [f"## {_capital(scope)}", "", f"| {' | '.join(_COLUMNS)} |", "|---" * len(_COLUMNS) + "|"]
        lines += [f"| {' | '.join(_cells(row))} |" for row in LIMITS if row.scope is scope]
        lines.append("")
    return "\n".join([*lines, "Made by `python -m cases.scene.limits_page > docs/limits.md`; a test compares."])


def in_three_lines() -> str:
    """The limits in three items of a list, for the README."""
    rows = [row for row in LIMITS if row.scope in _OF_SIMULATION]
    later = [row for row in rows if row.reason is Reason.NOT_BUILT]
    scenes = sum(row.scope is Scope.SHAPES for row in LIMITS)
    items = (
        f"Not built yet, and rejected in one sentence. {_capital(_in_short(later))}.",
        f"Mechanics excludes {len(rows) - len(later)} combinations of effects, such as Impact without Flight. Motions "
        f"with several contacts in {scenes} kinds of scenes are checked by their laws only, and have no certificate.",
        "[Limits](docs/limits.md) has each of them with its reason and what to give instead.",
    )
    return "\n".join(fill(item, 120, initial_indent="- ", subsequent_indent="  ") for item in items)


def _cells(row: Limit) -> tuple[str, ...]:
    return _capital(row.feature), row.reason, row.why, row.sentence.format("it").rpartition("; ")[2]


def _in_short(rows: list[Limit]) -> str:
    scopes = dict.fromkeys(row.scope for row in rows)
    parts = {scope: ", ".join(row.feature for row in rows if row.scope is scope) for scope in scopes}
    return "; ".join(f"{scope}: {text}" for scope, text in parts.items())


def _capital(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}"


if __name__ == "__main__":
    print(as_page())
