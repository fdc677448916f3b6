"""The table of the first screen: a row per engine by itself, and what to change for 1 %."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from statistics import median
from typing import Any

from ..analysis import verdict, verdict_text
from ..analysis.number_format import number, seconds
from ..analysis.verdict_text import off_text
from ..drawing.colours import identifier
from ..judging.grades import LIMITS, Grade, percent
from ..running.records import Experiment, Run, default, gives_motion, routes

# What the parameters of settings are, and their units.
_NAMES = {
    "h": "step", "facets": "facets", "k": "stiffness", "vreg": "regularised slip velocity", "iterations": "iterations",
}  # fmt: skip
_UNITS = {"k": " N/m", "vreg": " m/s"}
# Fewest settings of a ladder that says what to change.
_LADDER = 3
_GOOD = LIMITS[Grade.GOOD]


def engine_rows(
    experiment: Experiment,
    verdicts: Sequence[Mapping[str, Any]],
    offs: Mapping[verdict.Key, Mapping[str, verdict.SceneOffs]],
    timings: Sequence[Mapping[str, Any]],
    case: str,
) -> list[dict[str, Any]]:
    """A row for each engine by itself, in the order of the verdict. `offs`: errors by route and scene; `timings`: rows
    of the table work_precision; `case`: the scene whose setting for 1 % is shown."""
    groups = routes(experiment.runs)
    rows = []
    for row in verdicts:
        key = row["solver"], row["route"]
        if not verdict.is_engine(row):
            continue
        own = [t for t in timings if (t["case"], t["solver"], t["route"]) == (case, *key)]
        times = {str(t["setting"]): t["call_s"] for t in own}
        usual, coarsest = _settings(groups.get((case, *key), ()))
        rows.append(
            {
                "solver": key[0],
                "route": key[1],
                "id": identifier(key[0]),
                "version": experiment.versions.get(key[0], "").partition(" ")[0],
                "cells": _cells(row, list(offs[key].values())) | {f"within 1 % in {case}": _within(coarsest, times)},
                "so": _so(key[0], usual, coarsest),
            }
        )
    return rows


def changes(experiment: Experiment, verdicts: Sequence[Mapping[str, Any]]) -> list[tuple[str, list[dict[str, str]]]]:
    """What to change for 1 %, engine by engine, in each scene with a whole ladder."""
    groups, result = routes(experiment.runs), []
    for case in experiment.cases:
        sentences = []
        for row in verdicts:
            group = groups.get((case.label, row["solver"], row["route"]), ())
            has_ladder = verdict.is_engine(row) and sum(map(gives_motion, group)) >= _LADDER
            if has_ladder and (text := _so(row["solver"], *_settings(group))):
                sentences.append({"solver": row["solver"], "route": row["route"], "text": text})
        if sentences:
            result.append((case.label, sentences))
    return result


def _cells(row: Mapping[str, Any], scenes: Sequence[verdict.SceneOffs]) -> dict[str, tuple[str, str]]:
    """Main text and small text by heading."""
    usual = [one.default for one in scenes if isfinite(one.default)]
    many = sum(off > LIMITS[Grade.ROUGH] for off in usual)
    far = f"more than {percent(LIMITS[Grade.ROUGH])} in {many} of {len(usual)} scenes" if usual else ""
    return {
        "default settings": (f"{_median(usual)} off" if usual else "–", far),
        "finest settings": (_median([one.finest.off for one in scenes]), ""),
        "scenes it runs": (verdict_text.cells(row)["answers"], f"{verdict_text.confirmed(row, 'good')} within 1 %"),
        f"the {scenes_of(row['common_cases'])} that all run": (
            f"{off_text(row['common_default_off'])} default", f"{off_text(row['common_finest_off'])} finest",
        ) if usual else ("–", ""),
    }  # fmt: skip


def scenes_of(count: int) -> str:
    """A number of scenes, in words after "the"."""
    return "scene" if count == 1 else f"{count} scenes"


def _settings(group: Sequence[Run]) -> tuple[Run | None, Run | None]:
    """The run with usual settings, and the coarsest from which on the whole ladder is within 1 %, doubt included."""
    ladder, coarsest = [run for run in group if gives_motion(run)], None
    for run in reversed(ladder):
        if run.score is None or run.score.off + run.score.doubt > _GOOD:
            break
        coarsest = run
    return default(group), coarsest


def _within(coarsest: Run | None, times: Mapping[str, float]) -> tuple[str, str]:
    if coarsest is None:
        return "not reached", ""
    time = times.get(str(coarsest.setting), nan)
    steps = f"{coarsest.cost.steps:,} steps" if coarsest.cost.steps else ""
    return _words(dict(coarsest.setting.values)), f"{seconds(time)} a run" if isfinite(time) else steps


def _so(solver: str, usual: Run | None, coarsest: Run | None) -> str:
    """What to change for 1 %, in words; "" where that is not known."""
    if usual is None or usual.score is None:
        return ""
    if usual.score.off + usual.score.doubt <= _GOOD:
        return f"{solver}'s default settings are within 1 %."
    if coarsest is None:
        return f"{solver} does not come within 1 % with the settings tried."
    before, after = dict(usual.setting.values), dict(coarsest.setting.values)
    changes = [
        f"{_of(name, after[name])} instead of {_value(name, value)}"
        for name, value in before.items()
        if name in _NAMES and name in after and after[name] != value
    ]
    if not changes:
        return ""
    return f"{solver} needs {_list(changes)} for 1 % ({percent(usual.score.off)} with default settings)."


def _words(values: Mapping[str, Any]) -> str:
    """The main parameters of a setting in words."""
    return ", ".join(_of(name, values[name]) for name in ("h", "facets") if name in values) or "its finest setting"


def _of(name: str, value: Any) -> str:
    """A parameter with its value: a step of 0.5 ms, 64 facets."""
    is_count = name in ("facets", "iterations")
    return f"{_value(name, value)} {_NAMES[name]}" if is_count else f"a {_NAMES[name]} of {_value(name, value)}"


def _value(name: str, value: Any) -> str:
    if name == "h":
        return seconds(float(value))
    text = f"{value:,}" if isinstance(value, int) else number(float(value)) if isinstance(value, float) else str(value)
    return f"{text}{_UNITS.get(name, '')}"


def _list(texts: Sequence[str]) -> str:
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)


def _median(values: Sequence[float]) -> str:
    return off_text(median(values) if values else nan)
