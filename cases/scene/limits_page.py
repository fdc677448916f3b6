"""The page of limits, and the README's lines about them, from the table of `limits`.

`python -m cases.scene.limits_page > docs/limits.md` writes the page; a test compares.
"""

from __future__ import annotations

from .limits import LIMITS, Limit, Reason, Scope

_HEAD = """# Limits

What the reference does not compute, or computes without a certificate, and why: *mechanics* decides it, or it is *not
built yet*. A case that has a limit is rejected in one sentence before anything runs. Where the limit is for several
contacts, a plate on its track alone runs until it touches in a second place: the motion ends there with the status
`second_contact`. Motions without a certificate are checked by the laws of mechanics only.
"""
# What no row of the table decides.
_TAIL = """## Where a simulation stops

- Rigid Coulomb contact has paradoxes (Painlevé), and states with several motions. The simulation stops there and
  reports the place, with the status `paradox` or `not_unique`.
- Impacts have no duration. Newton's law of restitution can create energy where friction reverses the slip; the
  simulation then stops and reports it. With Moreau's law, which engines with a fixed step use, it continues.
- Decisions at a bound are made with an error of 1e-11: a box on an incline within 1e-11 rad of its friction angle
  rests.
- Contacts of a group of plates that touch have modes that are tried together. Of more than six contacts with friction a
  mixed-integer program leaves those of all solutions; where it does not, or leaves more than 65,536, the motion ends as
  `unfinished`. A row of eight dominoes falls; a pile of many boxes may not run.
- No contact is computed on the ends of an open curve: the motion of a plate that meets one ends there, with the status
  `track_end`. A `Chain` with a corner in place of the end has contacts there.
- The paper's own matrix (method `augmented`) is solved at corners at single instants only.

## Engines, platforms and times

- `slip-to-roll cases show CASE` lists which engines support a case, with the reason of each that does not. All adapters
  reject rolling resistance at several contacts.
- heyoka (the Taylor method) has wheels for Linux only. Elsewhere DOP853 is used, which is about ten times slower and
  has errors of 1e-14 s instead of 1e-15 s.
- Times in the tables are from one machine and one run. Compare only ratios within a run.
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
    return "\n".join([*lines, _TAIL, "Made by `python -m cases.scene.limits_page > docs/limits.md`; a test compares."])


def in_three_lines() -> str:
    """The limits in three items of a list, for the README."""
    rows = [row for row in LIMITS if row.scope in _OF_SIMULATION]
    later = [f"{row.feature.partition(' (')[0]} ({row.scope})" for row in rows if row.reason is Reason.NOT_BUILT]
    scenes = sum(row.scope is Scope.SHAPES for row in LIMITS)
    items = (
        f"Not built yet: {'; '.join(later) or 'nothing'}.",
        f"Mechanics excludes {len(rows) - len(later)} combinations of effects; several contacts in {scenes} kinds of "
        "scenes have no certificate.",
        "Where rigid contact has no motion, or several, a simulation stops and says so: [all limits](docs/limits.md).",
    )
    return "\n".join(f"- {item}" for item in items)


def _cells(row: Limit) -> tuple[str, ...]:
    return _capital(row.feature), row.reason, row.why, row.sentence.format("it").rpartition("; ")[2]


def _capital(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}"


if __name__ == "__main__":
    print(as_page())
