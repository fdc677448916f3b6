"""`python -m tests.benchmarks.golden FOLDER [OTHER]`: the answers of twelve scenes, and what differs from OTHER.

Twelve scenes of every kind run with every installed solver at every setting, without times, pictures and studies. The
tables are written to the folder, and compared cell by cell with those in OTHER, which an earlier build wrote: a change
of the code that should change no answer changes no cell. Takes about 150 s of CPU time.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import cases
from cases import Case
from reports import compare_builds, options
from reports.analysis import table_list
from reports.analysis.columns import with_version
from reports.analysis.table_list import Results
from reports.page.manifest import manifest
from reports.page.table_files import inert, with_short_numbers
from reports.running import experiment, ladder_selection
from reports.running.calls import Calls
from reports.running.progress import Display

SCENES = (
    "bouncing_disc[e=0.5]", "box_on_shaken_table", "dominoes", "disc_in_circle[mu=0.2]", "ellipse_in_circle",
    "block_into_bowl", "disc_off_free_block", "disc_in_v_of_belts", "disc_rocking_in_groove", "hopping_rod",
    "ladder_at_wall", "disc_over_edge",
)  # fmt: skip


def write_answers(scenes: Sequence[Case], folder: Path, is_selection: bool) -> None:
    """Write the tables of a default report of these scenes, without the store: whole ladders, of a selection."""

    def rungs(*where):
        return ladder_selection.select_rungs("default", is_selection, *where)

    with Display() as display, Calls(progress=display) as calls:
        calls.begin(options.solvers())
        ran = experiment.run_cases(scenes, options.solvers(), calls, rungs)
    (folder / "tables").mkdir(parents=True)
    for name, frame in table_list.frames(Results(ran, ran)).items():
        short = with_short_numbers(inert(with_version(frame, ran.versions)))
        short.to_csv(folder / "tables" / f"{name}.csv", index=False)
    (folder / "manifest.json").write_text(json.dumps(manifest(ran.versions)))


def main(folder: str, other: str = "") -> int:
    """Write the answers, and compare them; returns 1 if a cell differs."""
    write_answers([cases.load(name) for name in SCENES], Path(folder), is_selection=True)
    if not other:
        return 0
    comparison = compare_builds.compare(Path(other), Path(folder))
    print(compare_builds.summary_lines(comparison, Path(other), Path(folder)))
    return int(not comparison.same)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
