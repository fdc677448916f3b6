"""HTML of cases and motions for notebooks: a picture and a small table. All text is escaped."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from io import BytesIO
from typing import Any

import numpy as np

from . import drawn_scene as scenes
from .layout import DrawnScene, Instant, shown_poses
from .style import Picture, apply_style

# Largest number of transitions in a notebook's table; the others are only counted.
_MOST = 12


def of_case(case: Any) -> str:
    """The plate at its start and the facts of the case, as HTML."""
    start = case.start.motion(case.track, case.plate.outline)
    at = Instant(start.x, start.y, start.theta, start.xi1 if case.start.in_contact else np.nan, 1.0)
    facts = {
        "plate": repr(case.plate),
        "track": repr(case.track),
        "effects": case.effects_text,
        "start": case.start_text,
        "duration": f"{case.duration:g} s",
    }
    others = [
        (
            case.scene.of(o.plate),
            [Instant(o.start.x, o.start.y, o.start.theta, np.nan, 1.0)],
        )
        for o in case.others
    ]
    facts |= {other.name: repr(other.plate) for other in case.others}
    return _side_by_side(_scene(case.scene, at, others=others), f"<b>{escape(case.label)}</b>{table(facts.items())}")


def of_motion(motion: Any) -> str:
    """A motion in words, its transitions, and the scene if its case is available, as HTML."""
    head = f"<b>{escape(motion.case.label)}</b><br>" if motion.case else ""
    rows = [
        (f"{t.time:.9g} s", t.contact, f"{t.before} → {t.after}", t.cause, *_impulse(motion, t))
        for t in motion.transitions[:_MOST]
    ]
    remaining = len(motion.transitions) - len(rows)
    more = f"<p>… and {remaining} more</p>" if remaining else ""
    words = f"{head}{escape(motion.in_words())}{table(rows) if rows else ''}{more}"
    if motion.case is None:
        return words
    times = motion.times()
    state = motion(times)
    poses, others = shown_poses(motion, times, state, most=_MOST)
    path = np.array([state.x, state.y])
    return _side_by_side(_scene(motion.case.scene, *poses, path=path, xi1=state.xi1, others=others), words)


def _impulse(motion: Any, change: Any) -> list[str]:
    """The impulses of an impact in words; none for another change."""
    impulse = motion.impulse_at(change)
    return [] if impulse is None else [impulse.in_words()]


def table(rows: Any) -> str:
    """Rows of texts as an HTML table without headings."""
    cell = '<td style="text-align:left;vertical-align:top">'
    lines = "".join("<tr>" + "".join(f"{cell}{escape(str(text))}</td>" for text in row) + "</tr>" for row in rows)
    return f"<table>{lines}</table>"


def _side_by_side(picture: str, words: str) -> str:
    return (
        f'<div style="display:flex;flex-wrap:wrap;gap:1.5em;align-items:flex-start">{picture}<div>{words}</div></div>'
    )


def _scene(
    scene: DrawnScene,
    *poses: Instant,
    path: np.ndarray | None = None,
    xi1: np.ndarray | None = None,
    others: Sequence[tuple[DrawnScene, Sequence[Instant]]] = (),
) -> str:
    first = poses[0]
    path = np.array([[first.x], [first.y]]) if path is None else path
    xi1 = np.array([first.xi1]) if xi1 is None else xi1
    buffer = BytesIO()
    with apply_style():
        figure = Picture(figsize=(3.4, 2.8), layout="constrained")
        scenes.draw(figure.subplots(), scene, path, xi1, poses, others)
        figure.savefig(buffer, format="png", dpi=100)
    data = b64encode(buffer.getvalue()).decode()
    return f'<img alt="{escape(scene.label)}: the plate on its track" src="data:image/png;base64,{data}">'
