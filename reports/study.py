"""`slip-to-roll report study NAME`: make one study and write its tables into a folder."""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path

from cases import BadValue, lookup

from . import options, studies
from .page import report_folder

COMMAND = "reports.study"


@options.runs(
    COMMAND, f"Make one study: {', '.join(studies.names())}.", "out", "case", "case_file", "solver", "engine",
    "full", "jobs", "store", "fresh", words={"NAME": "the study"},
    example=f"python -m {COMMAND} stability --solver reference pymunk",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> None:
    """Check the options and make the study."""
    study = studies.study(arguments.NAME)
    for option, subject in {"case": "case", "solver": "solver", "engine": "solver"}.items():
        if getattr(arguments, option) and subject not in study.TAKES:
            raise BadValue(f"{arguments.NAME} has its own; leave out --{option}")
    files, own = options.load_files(arguments.case_file)
    texts = arguments.case or own
    if own and "case" not in study.TAKES:
        raise BadValue(f"{arguments.NAME} has its own cases; leave out --case-file")
    executables = options.register_engines(arguments.engine)
    solvers = options.choose_solvers([*(arguments.solver or options.solvers()), *executables])
    jobs = options.whole_jobs(arguments.jobs)
    variants = (case for text in texts for case in lookup.case_name(text).every(long=arguments.full))
    selection = tuple({case.label: case for case in variants}.values())
    request = studies.Request(selection, solvers, arguments.full)
    out = options.check_out(arguments.out or arguments.NAME, report_folder.of_study)
    store = options.check_store(arguments.store, out)
    _make(arguments.NAME, request, out, store, arguments.fresh, jobs, options.command(COMMAND, words))


def _make(
    name: str, request: studies.Request, out: Path, store_folder: Path, fresh: bool, jobs: int, command: str
) -> None:
    from .page import table_files, text
    from .page.manifest import manifest
    from .running import versions
    from .running.calls import Calls
    from .running.progress import Display
    from .running.storage.result_store import Store

    store = Store(store_folder, fresh)
    versions.make(request.solvers, lambda text: print(text, file=sys.stderr, flush=True))
    try:
        with Display() as display, Calls(jobs, store=store, progress=display) as calls:
            calls.ask_versions(request.solvers)
            result = studies.run_study(name, request, calls, command)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(store.kept_words()) from None
    if result.failure:
        raise OSError(f"the study failed: {result.failure}")
    with report_folder.of_study(out).staging(whole=True) as place:
        files = table_files.write(table_files.Tables(result.frames, result.words), place, command)
        report_folder.sign(place, manifest(calls.versions) | {"command": command, "store": store.summary()})
    store.trim()
    summary = getattr(result.study, "summary", None)
    print(summary(result.findings) if summary else "\n\n".join(text.plain(frame) for frame in result.frames.values()))
    print("\n".join(f"written: {out / file.name}" for file in files))


if __name__ == "__main__":
    sys.exit(main())
