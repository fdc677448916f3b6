"""`python -m reports.study NAME`: one study by itself, its tables and pictures in a folder."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from cases import BadValue, lookup
from cases.command_line import status

from . import options, studies
from .page import folder

COMMAND = "reports.study"


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit status."""
    return status(COMMAND, _work, argv)


def _work(words: list[str]) -> None:
    from .drawing.figure_files import for_print

    parser = options.parser(
        COMMAND, f"Make one study: {', '.join(studies.names())}.", "out", "case", "case_file", "solver", "full", "jobs",
        "store", "fresh", "paper", words={"NAME": "the study"},
        example=f"python -m {COMMAND} stability --solver reference pymunk",
    )  # fmt: skip
    given = parser.parse_args(words)
    study = studies.study(given.NAME)
    for option in ("case", "solver"):
        if getattr(given, option) and option not in study.TAKES:
            raise BadValue(f"{given.NAME} has its own; leave out --{option}")
    files, own = options.load_files(given.case_file)
    texts = given.case or own
    if own and "case" not in study.TAKES:
        raise BadValue(f"{given.NAME} has its own cases; leave out --case-file")
    solvers, jobs = options.choose_solvers(given.solver), options.whole_jobs(given.jobs)
    made = (case for text in texts for case in lookup.case_name(text).every(long=given.full))
    chosen = tuple({case.label: case for case in made}.values())
    request = studies.Request(chosen, solvers, given.full)
    out = options.check_out(given.out or given.NAME, folder.of_study)
    store = options.check_store(given.store, out)
    with for_print(given.paper):
        _make(given.NAME, request, out, store, given.fresh, jobs, options.command(COMMAND, words))


def _make(
    name: str, request: studies.Request, out: Path, store_folder: Path, fresh: bool, jobs: int, command: str
) -> None:
    from .drawing.figure_files import embed_command, writes_pdf
    from .page import dictionary, text
    from .page.manifest import manifest
    from .running import versions
    from .running.calls import Calls
    from .running.processes.progress import Display
    from .running.storage.result_store import Store

    store = Store(store_folder, fresh)
    versions.make(request.solvers, lambda text: print(text, file=sys.stderr, flush=True))
    try:
        with Display() as display, Calls(jobs, store=store, progress=display) as calls:
            calls.ask_versions(request.solvers)
            result = studies.run(name, request, calls, command)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(store.kept_words()) from None
    if result.failure:
        raise OSError(f"the study failed: {result.failure}")
    with folder.of_study(out).staged(whole=True) as place:
        files = text.write(result.frames, result.words, place, command, writes_pdf())
        files += dictionary.write(result.frames, result.words, place, command)
        for drawn in result.draw(place):
            embed_command(place, drawn, command)
            print(f"{drawn.title}: {out / f'{drawn.name}.svg'}" if drawn.name else f"{drawn.title}. {drawn.caption}")
        folder.sign(place, manifest(calls.versions) | {"command": command, "store": store.told()})
    store.trim()
    summary = getattr(result.study, "summary", None)
    print(summary(result.findings) if summary else "\n\n".join(text.plain(frame) for frame in result.frames.values()))
    print("\n".join(f"written: {out / file.name}" for file in files))


if __name__ == "__main__":
    sys.exit(main())
