"""`slip-to-roll release publish REPORT`: publish a report with its release.

docs/results/VERSION has what a clone keeps: the tables of the verdict, the accuracies that a test computes again, the
README's picture, the manifest, constraints.txt with the installed packages, and the digests of all files. The whole
release, with its page and all tables, is one archive next to that folder, for a data repository. In a clone, the
README's first picture and numbers are updated from the report. Nothing is run.

Exit status: 0; 2, with one sentence, if the folder contains no report suitable for a release; 1 if files cannot be
written.
"""

from __future__ import annotations

import csv
import json
import re
import shutil
import sys
import textwrap
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from io import StringIO
from pathlib import Path
from typing import Any

import cases
from cases import BadValue
from cases.errors import finite
from cases.files import user_files
from cases.files.owned_folder import LIST, OwnedFolder, TemporaryFolder, digest, write

from . import deposit, options
from .deposit import PACKAGE
from .page import report_folder

COMMAND = "reports.publish"
ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
CONSTRAINTS = "constraints.txt"
# Licence of the results: docs/licences.md.
LICENCE = {
    "name": "CC-BY-4.0",
    "title": "Creative Commons Attribution 4.0 International",
    "path": "https://creativecommons.org/licenses/by/4.0/",
}
# The case in the README: the paper's application. Its engines run with default settings.
CASE = "disc_in_circle[mu=0.2]"
PICTURE = "figures/headline.png"
_FIGURES = (PICTURE, "figures/headline.svg")
# Files of a release that a clone keeps, and the list with the digests of all.
KEPT = (
    report_folder.MANIFEST, CONSTRAINTS, PACKAGE, *_FIGURES, "tables/columns.md", "tables/verdict.*",
    "tables/pairs.csv", "tables/headline.csv", "tables/levels.csv", "tables/truth.csv", "tables/trajectories.csv",
    "tables/impacts.csv",
)  # fmt: skip
DIGESTS = "release.sha256"
BEGIN, END = "<!-- written by `slip-to-roll release publish` -->", "<!-- until here -->"


def publish(report: Path, results: Path) -> tuple[Path, Path]:
    """Write `results`/VERSION, replacing an earlier one, and the archive of the whole release; returns both paths.

    Raises BadValue for a report that is not suitable for a release, OSError if the files cannot be written.
    """
    names = report_folder.of_report(report).names()
    manifest = _manifest(report)
    _check(manifest, report, names)
    place = _folder(results / cases.__version__)
    place.check()
    with TemporaryFolder() as temporary, place.staging(whole=True) as partial:
        whole = report_folder.of_report(temporary / "release", "release")
        with whole.staging(whole=True) as files:
            _write(report, names, manifest, files)
        numbers(whole.path)
        archive = deposit.pack(whole.path, results / f"{deposit.ARCHIVE}-{cases.__version__}.zip", replace=True)
        keep(whole.path, partial)
    return place.path, archive


def keep(release: Path, place: Path) -> None:
    """Copy those files of a whole release into a folder that a clone keeps."""
    for name in report_folder.of_report(release, "release").names():
        if any(fnmatchcase(name, pattern) for pattern in KEPT):
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(release / name, place / name)
    shutil.copyfile(release / LIST, place / DIGESTS)


def _folder(path: Path) -> OwnedFolder:
    return OwnedFolder(path, "release", (report_folder.MANIFEST, "tables/*", "figures/*"), (report_folder.MANIFEST,))


def _write(report: Path, names: Sequence[str], manifest: dict[str, Any], place: Path) -> None:
    """Write all files of the release of a report."""
    files = [name for name in names if not name.startswith("figures/") or name in _FIGURES]
    for name in files:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(report / name, place / name)
    _check_page(_text(report / report_folder.PAGE), files)
    package = _describe(_json(report / PACKAGE), manifest, place, names)
    (place / PACKAGE).write_text(json.dumps(package, indent=1) + "\n", encoding="utf-8")
    (place / CONSTRAINTS).write_text(_constraints(manifest), encoding="utf-8")
    report_folder.sign(place, manifest | {"licence": LICENCE["name"]})


def releases(results: Path = RESULTS) -> list[Path]:
    """The folders of published reports, the latest release last."""
    from packaging.version import Version

    folders = [path.parent for path in results.glob("*/manifest.json")]
    return sorted(folders, key=lambda path: Version(path.name))


# --- conditions of publication ----------------------------------------------------------------------------------------


_AGAIN = "give a report that `slip-to-roll report` wrote"
_LARGEST = 100 * 2**20  # size limit of a file, bytes; the largest of a full report has a tenth of it
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+!-]*")


def _is_line(value: Any) -> bool:
    return isinstance(value, str) and value.isprintable()


def _are_packages(value: Any) -> bool:
    """Whether the value maps names of packages to versions, for the lines of the constraints."""
    words = [word for pair in value.items() for word in pair] if isinstance(value, dict) else [None]
    return all(isinstance(word, str) and _NAME.fullmatch(word) for word in words)


# A report is untrusted input: the values of its manifest must have the types that a build writes.
_TYPES: dict[str, Callable[[Any], bool]] = {
    **dict.fromkeys(("options", "commit", "python", "command", "made_at"), _is_line),
    **dict.fromkeys(("cases", "solvers"), lambda value: isinstance(value, dict)),
    "lost": lambda value: isinstance(value, list),
    "installed": _are_packages,
}


def _manifest(report: Path) -> dict[str, Any]:
    """The manifest of a report; raises BadValue if a value has a wrong type."""
    manifest = _json(report / report_folder.MANIFEST)
    if not isinstance(manifest, dict) or manifest.get("made_by") != report_folder.MADE_BY:
        raise BadValue(f"{report} contains no report; {_AGAIN}")
    wrong = next((name for name, fits in _TYPES.items() if not fits(manifest.get(name))), "")
    if wrong:
        raise BadValue(f"{wrong} in {report / report_folder.MANIFEST} has a wrong type; {_AGAIN}")
    return manifest


def _json(file: Path) -> Any:
    try:
        return json.loads(_text(file))
    except (ValueError, RecursionError) as problem:
        raise BadValue(f"{file} is not JSON ({type(problem).__name__}); {_AGAIN}") from None


def _text(file: Path) -> str:
    return user_files.text("file of the report", file, _LARGEST)


def _check(manifest: Mapping[str, Any], report: Path, names: Sequence[str]) -> None:
    """Raises BadValue unless it is a complete default report of a commit of this version, without interrupted calls."""
    from .page.manifest import FORMAT

    absent = [name for name in (report_folder.PAGE, PACKAGE, *_FIGURES) if name not in names]
    lacking = sorted(
        {case.label for name in cases.names(hard=False) for case in cases.select(name)} - set(manifest["cases"])
    )
    version, commit = manifest["solvers"].get("reference"), manifest["commit"]
    problems = {
        f"is without {', '.join(absent)}": absent,
        "has another format": manifest.get("format") != FORMAT,
        f"is of version {version}, but this is {cases.__version__}": version != cases.__version__,
        f"has no {', '.join(lacking[:3])}": lacking,
        f"was made with {manifest['options']}": manifest["options"],
        "has no timings": "tables/time_to_accuracy.csv" not in names,
        "has calls that were ended from outside": manifest["lost"],
        "does not name its commit": not commit,
        "was made from files that differ from their commit": commit.endswith("+"),
        "does not list the installed packages": not manifest["installed"],
        f"has no headline picture of {CASE}": not absent and CASE not in _text(report / _FIGURES[1]),
    }
    problem = next((words for words, is_so in problems.items() if is_so), "")
    if problem:
        raise BadValue(f"the report in {report} {problem}; give a complete one: commit, then `slip-to-roll report`")


# --- files of the published report ------------------------------------------------------------------------------------


_REFERENCE = re.compile(r'(?:href|src)="((?:figures|tables)/[^"]+|[\w.]+)"')


def _check_page(page: str, files: Sequence[str]) -> None:
    """Raises BadValue if the page refers to a file that is not published."""
    missing = sorted({*_REFERENCE.findall(page)} - {*files})
    if missing:
        raise BadValue(f"the page refers to {missing[0]}, which is not published; correct {COMMAND}")


def _describe(package: Any, manifest: Mapping[str, Any], place: Path, names: Sequence[str]) -> dict[str, Any]:
    """The data package with version, licence and the digests of its tables; raises BadValue if it contains anything but
    a list of tables."""
    entries = package.get("resources") if isinstance(package, dict) else None
    if not isinstance(entries, list) or not all(
        isinstance(one, dict) and f"tables/{one.get('path')}" in names for one in entries
    ):
        raise BadValue(f"{PACKAGE} does not have the form that a build writes; {_AGAIN}")
    head = {
        "$schema": "https://datapackage.org/profiles/2.0/datapackage.json",
        "name": package.get("name"),
        "title": "slip-to-roll: how wrong is your friction?",
        "description": f"Tables of the report of version {cases.__version__}, made by `{manifest['command']}`.",
        "version": cases.__version__,
        "created": manifest["made_at"],
        "licenses": [LICENCE],
    }
    tables = place / "tables"
    resources = [
        one | {"bytes": (tables / one["path"]).stat().st_size, "hash": f"sha256:{digest(tables / one['path'])}"}
        for one in entries
    ]
    return head | {"resources": resources}


def _constraints(manifest: Mapping[str, Any]) -> str:
    head = f"# Packages of the report of version {cases.__version__}, made with Python {manifest['python']}.\n"
    return head + "".join(f"{name}=={version}\n" for name, version in manifest["installed"].items())


# --- the README -------------------------------------------------------------------------------------------------------


def headline(place: Path) -> str:
    """The README's picture and numbers from a published report."""
    at = f"docs/results/{place.name}"
    alt = "Slip velocity of a disc inside a circle, and the error of each solver"
    picture = f"![{alt}]({at}/{PICTURE})"
    see = f"[Tables]({at}/tables) and [page](docs/published.md) are of version {place.name}."
    text = textwrap.fill(f"{numbers(place)} {see}", 120, break_long_words=False, break_on_hyphens=False)
    return f"{BEGIN}\n{picture}\n\n{text}\n{END}"


_ENGINES = {"pymunk": "pymunk", "exudyn": "Exudyn"}


def numbers(place: Path) -> str:
    """Sentences with the time at which the paper's disc starts to roll, and one number for each engine of the README:
    how far it is off by itself with default settings."""
    from .judging.grades import percent

    when, bar = (_number(place, "truth", name, case=CASE, event="1") for name in ("time", "truth_error_bar"))
    errors = {
        name: percent(_number(place, "headline", "default_off", case=CASE, solver=solver, route="native"))
        for solver, name in _ENGINES.items()
    }
    engines = " and ".join(f"{name} is {error} off" for name, error in errors.items())
    start = f"A disc released inside a circle starts to roll after {when:.9f} s; the error bar is {bar:.0e} s."
    return f"{start} With default settings, {engines} (100 % off: as bad as ignoring friction's law)."


def _number(place: Path, table: str, column: str, **keys: str) -> float:
    """One number of a table; raises BadValue if it is missing."""
    name = f"tables/{table}.csv"
    rows = csv.DictReader(StringIO(_text(place / name), newline=""))
    try:
        row = next((row for row in rows if keys.items() <= row.items()), {})
        return finite(column, float(row.get(column) or ""))
    except (ValueError, csv.Error):
        raise BadValue(f"{name} of the report has no {column} for {', '.join(keys.values())}; {_AGAIN}") from None


# The README's sentence on the times of the commands.
_MINUTES = re.compile(r"\breport \d+ minutes?\b")


def refresh(readme: Path, place: Path) -> None:
    """Update the README's part and the report's time from the published report; raises BadValue if the README has no
    such part."""
    before, after = around(readme)
    phases = _manifest(place)["phases"].values()
    minutes = max(1, round(sum(phase["wall_s"] for phase in phases) / 60.0))
    write(readme, before + headline(place) + _MINUTES.sub(f"report {minutes} minute{'s' * (minutes > 1)}", after))


def around(readme: Path) -> tuple[str, str]:
    """The README's text before and after the part from the published report; raises BadValue unless it has exactly one
    such part."""
    parts = re.split(f"{re.escape(BEGIN)}.*?{re.escape(END)}", readme.read_text(encoding="utf-8"), flags=re.DOTALL)
    if len(parts) != 2:
        raise BadValue(
            f"{readme} has {len(parts) - 1} parts between {BEGIN} and {END}; put both lines once, at its picture"
        )
    return parts[0], parts[1]


@options.runs(
    COMMAND, "Publish a report with its release.", "out", words={"REPORT": "the folder of a default report"},
    out="docs/results", example=f"python -m {COMMAND} report",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> None:
    """Publish the report, update the README of a clone, and print the folder's size."""
    results = user_files.place("folder of --out", arguments.out).resolve()
    if results == RESULTS:
        around(ROOT / "README.md")  # before anything is written
    place, archive = publish(user_files.place("report", arguments.REPORT), results)
    if results == RESULTS:
        refresh(ROOT / "README.md", place)
    for path in (place, archive):
        files = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
        print(f"{path}, {sum(file.stat().st_size for file in files) / 1e6:.1f} MB")


if __name__ == "__main__":
    sys.exit(main())
