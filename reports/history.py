"""`slip-to-roll history ENGINE…`: the answers of an engine over its released versions, as pages and tables.

Every version that the package index has and the adapter supports is installed into an environment of its own
(`running.versions`) and runs the same scenes, with default settings and with one fine setting. Finished runs are stored
per version, so that a further version adds its own runs only. A version without a wheel for this Python is a row with
the reason, or is compiled with --from-source.
"""

from __future__ import annotations

import platform
import sys
from argparse import Namespace
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases import BadValue
from cases.errors import UnknownName

from . import options
from .page import report_folder

if TYPE_CHECKING:
    from adapters import Setting
    from cases import Case

    from .analysis.version_history import HistoryLine
    from .running.records import Row, Run
    from .running.storage.result_store import Store

COMMAND = "reports.history"

# Scenes of many kinds that the engines' routes support: every shape of track, discs and other plates, loads, flights,
# impacts, belts.
SCENES = (
    "disc_on_line[mu=0.1]",
    "disc_on_incline[mu=0.1]",
    "disc_in_circle[mu=0.1]",
    "disc_in_circle[mu=0.2]",
    "rough_disc_in_circle",
    "frictionless_pendulum",
    "disc_in_parabola",
    "disc_in_cosine",
    "disc_in_catenary",
    "disc_in_ellipse",
    "disc_rolling_off_hill",
    "disc_sliding_off_hill",
    "disc_onto_incline[mu=0.5]",
    "driven_disc",
    "disc_rolling_to_rest",
    "eccentric_disc_on_line",
    "ellipse_in_circle",
    "ellipse_on_incline",
    "disc_on_conveyor",
    "thrown_with_spin",
)


@options.runs(
    COMMAND, "Run every released version of engines on the same scenes: what changed, and with which release.",
    "out", "case", "case_file", "from_source", "jobs", "store", "fresh", words={"ENGINE*": "engines, by name"},
    out="history", example=f"python -m {COMMAND} pymunk exudyn box2d",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> None:
    """Check the options, install and run the versions, and write the folder."""
    if not arguments.ENGINE:
        raise BadValue("name an engine, for example pymunk")
    if wrong := next((name for name in arguments.ENGINE if "@" in name or name == "reference"), ""):
        raise BadValue(f"{wrong} has no history of releases; give an engine without a version, for example pymunk")
    engines = options.choose_solvers(arguments.ENGINE or None)
    _, own = options.load_files(arguments.case_file)
    cases, _ = options.choose_cases(arguments.case or own or SCENES, "quick" if not (arguments.case or own) else "")
    from .running.storage.result_store import Store

    jobs = options.whole_jobs(arguments.jobs)
    out = options.check_out(arguments.out, report_folder.of_history)
    store = options.check_store(arguments.store, out)
    names = _install(engines, arguments.from_source)
    _make(names, cases, out, Store(store, arguments.fresh), jobs, options.command(COMMAND, words))


def _settings(case: str, solver: str, route: str, settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
    """The default settings, and one at two thirds of the ladder."""
    from .running.ladder_selection import default_and

    return default_and(settings, 2 * sum(not setting.is_default for setting in settings) // 3)


def _make(
    versions: tuple[list[str], dict[str, str]], cases: Sequence[Case], out: Path, store: Store, jobs: int, command: str
) -> None:
    """Run the versions of `_install`, and write the folder."""
    from .analysis import version_history
    from .page.manifest import manifest
    from .running.calls import Calls
    from .running.experiment import run_cases
    from .running.progress import Display

    names, missing = versions
    if not names:
        raise BadValue(f"no version can be installed: {next(iter(missing.values()))}")
    runs: list[Run] = []
    try:
        with Display() as display, Calls(jobs, store=store, progress=display) as calls:
            for name in names:  # one version at a time, so that an interrupted run keeps whole versions
                runs += run_cases(cases, [name], calls, _settings).runs
    except KeyboardInterrupt:
        raise KeyboardInterrupt(store.kept_words()) from None
    lines = version_history.lines(runs)
    releases = version_history.release_rows(lines, missing)
    _write(lines, releases, out, manifest(calls.versions) | {"command": command, "store": store.summary()})
    store.trim()
    print(summary(releases))
    print(out / report_folder.PAGE)


def _install(engines: Sequence[str], from_source: bool) -> tuple[list[str], dict[str, str]]:
    """The versions (ENGINE@VERSION) that have an environment, oldest first, and the reasons why others have none."""
    from .running import versions

    names: list[str] = []
    missing: dict[str, str] = {}
    for name in [f"{engine}@{number}" for engine in engines for number in versions.releases(engine)]:
        versions.check(name)
        try:
            versions.make([name], lambda text: print(text, file=sys.stderr, flush=True), from_source)
            reason = versions.failure(name)
        except UnknownName as problem:
            reason = str(problem)
        if reason:
            missing[name] = reason
        else:
            names.append(name)
    return names, missing


def _write(lines: Sequence[HistoryLine], releases: Sequence[Row], out: Path, about: dict[str, Any]) -> None:
    """Write the page, tables and manifest."""
    import pandas as pd

    from .analysis import version_history
    from .page import history_text, table_files

    words, line_rows = version_history.TABLES, version_history.line_rows(lines)
    frames = {
        "history_releases": pd.DataFrame(releases),
        "history_lines": pd.DataFrame(line_rows),
        "history": pd.DataFrame(version_history.run_rows(lines)),
    }
    with report_folder.of_history(out).staging(whole=True) as place:
        tables = place / "tables"
        table_files.write(table_files.Tables(frames, words), tables, about["command"])
        markdown = history_text.render(line_rows, releases, _origin(), about["command"])
        (place / report_folder.HISTORY).write_text(markdown, encoding="utf-8")
        report_folder.sign(place, about)


def _origin() -> str:
    """When and where the runs were made, in words."""
    today = datetime.now(tz=UTC)
    return f"{today:%B} {today.year}, {platform.system()}, CPython {platform.python_version()}"


def summary(releases: Sequence[Row]) -> str:
    """A line per release that changed an answer, and the number of versions, for the terminal."""
    lines = []
    for engine in dict.fromkeys(row["engine"] for row in releases):
        own = [row for row in releases if row["engine"] == engine]
        ran = [row for row in own if not row["note"]]
        span = f", {ran[0]['version']} to {ran[-1]['version']}" if ran else ""
        lines.append(f"{engine}: {len(ran)} versions run{span}")
        changes = [row for row in ran if row["changed"]]
        for row in changes:
            counts = f"{row['changed']} answers changed, {row['better']} better, {row['worse']} worse"
            lines.append(f"  {row['version']}: {counts}")
        lines += [] if changes else ["  no release changed an answer"]
        lines += [f"  {row['version']}: not run: {row['note']}" for row in own if row["note"]]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
