"""`python -m reports.publish REPORT`: publish a report with its release, in docs/results/VERSION.

The tables and the page are copied; links to the figures of single cases are removed from the page, because these are
twice as large as all other files, and one command makes them again. The data package gets version, licence and digests;
constraints.txt lists the installed packages. In a clone, the README's first picture and numbers are updated
from the report. Nothing is run.

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
from io import StringIO
from pathlib import Path
from typing import Any

import cases
from cases import BadValue
from cases.errors import finite
from cases.files import user_files
from cases.files.owned_folder import digest, write

from . import options
from .page import report_folder

COMMAND = "reports.publish"
ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
PACKAGE = "tables/datapackage.json"
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
BEGIN, END = "<!-- written by `python -m reports.publish` -->", "<!-- until here -->"


def publish(report: Path, results: Path) -> Path:
    """Copy the report to `results`/VERSION, replacing an earlier one; returns that folder.

    Raises BadValue for a report that is not suitable for a release, OSError if the folder cannot be written.
    """
    names = report_folder.of_report(report).names()
    manifest = _manifest(report)
    _check(manifest, report, names)
    place = report_folder.of_report(results / cases.__version__, "release")
    place.check()
    with place.staging(whole=True) as partial:
        files = [name for name in names if not name.startswith("figures/") or name in _FIGURES]
        for name in files:
            (partial / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(report / name, partial / name)
        page = _by_itself(_text(report / report_folder.PAGE), files)
        (partial / report_folder.PAGE).write_text(page, encoding="utf-8")
        package = _describe(_json(report / PACKAGE), manifest, partial, names)
        (partial / PACKAGE).write_text(json.dumps(package, indent=1) + "\n", encoding="utf-8")
        (partial / CONSTRAINTS).write_text(_constraints(manifest), encoding="utf-8")
        report_folder.sign(partial, manifest | {"licence": LICENCE["name"]})
        numbers(partial)
    return place.path


def releases(results: Path = RESULTS) -> list[Path]:
    """The folders of published reports, the latest release last."""
    from packaging.version import Version

    folders = [path.parent for path in results.glob("*/manifest.json")]
    return sorted(folders, key=lambda path: Version(path.name))


# --- conditions of publication ----------------------------------------------------------------------------------------


_AGAIN = "give a report that `python -m reports.build` wrote"
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
        raise BadValue(f"the report in {report} {problem}; give a complete one: commit, then `python -m reports.build`")


# --- files of the published report ------------------------------------------------------------------------------------


# References of a page to separate figures: for readers without scripts, links around embedded figures, lines of links.
_LINE = re.compile(r'<p>(?:<a href="figures/[^"]*">[^<]*</a>(?:, )?)+, as separate figures\.</p>')
_LINK = re.compile(r'<a href="figures/[^"]*">(.*?)</a>', re.DOTALL)
_SEPARATE = re.compile(r'<div class="printed">.*?</div>', re.DOTALL)
_INSTEAD = "<noscript><p>The plot is drawn by scripts here, and as figures by a report of your own.</p></noscript>"
_REFERENCE = re.compile(r'(?:href|src)="((?:figures|tables)/[^"]+|[\w.]+)"')


def _by_itself(page: str, files: Sequence[str]) -> str:
    """The page without references to separate figures; raises BadValue if it refers to a file that is not published."""
    page = _LINK.sub(r"\1", _LINE.sub("", _SEPARATE.sub(_INSTEAD, page)))
    missing = sorted({*_REFERENCE.findall(page)} - {*files})
    if missing:
        raise BadValue(f"the page refers to {missing[0]}, which is not published; correct {COMMAND}")
    return page


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
    see = f"[The page]({at}/index.html) and [all tables]({at}/tables) are of version {place.name}."
    text = textwrap.fill(f"{numbers(place)} {see}", 120, break_long_words=False, break_on_hyphens=False)
    return f"{BEGIN}\n{picture}\n\n{text}\n{END}"


# Engines of the README, and what the grid of their default settings combines.
_ENGINES = {"pymunk": ("pymunk", "steps and facets"), "exudyn": ("Exudyn", "steps, stiffnesses and regularisations")}


def numbers(place: Path) -> str:
    """Sentences with the time at which the paper's disc starts to roll, and the errors of two engines, native, with
    default settings."""
    when, bar = (_number(place, "truth", name, case=CASE, event="1") for name in ("time", "truth_error_bar"))
    start = f"A disc released inside a circle starts to roll after {when:.9f} s; the error bar is {bar:.0e} s."
    engines = " and ".join(_default_words(place, *engine) for engine in _ENGINES.items())
    words = f"{start} With default settings, {engines} (100 % off: as bad as ignoring friction's law)"
    return f"{words}{_friction(place)}.{_in_common(place)}"


def _in_common(place: Path) -> str:
    """The errors of the engines over the cases that all of them answer; "" up to version 0.2.0."""
    from .judging.grades import percent

    rows = list(csv.DictReader(StringIO(_text(place / "tables" / "verdict.csv"), newline="")))
    own = [row for row in rows if not row.get("our_part") and row.get("common_finest_off")]
    if not own or not own[0].get("common_default_off"):
        return ""
    try:
        errors = "; ".join(
            " and ".join((f"{row['solver']} {percent(usual)}", percent(finest)))
            for row in own
            for usual, finest in [(float(row["common_default_off"]), float(row["common_finest_off"]))]
        )
    except ValueError:
        raise BadValue(f"tables/verdict.csv of the report has an error that is no number; {_AGAIN}") from None
    many = own[0]["common_cases"]
    return f" On the {many} cases that all engines answer, by default and at the finest setting: {errors}."


def _friction(place: Path) -> str:
    """What 1 % off means in friction, over the published cases that rank engines."""
    from .analysis.verdict import cost_of_friction

    rows = csv.DictReader(StringIO(_text(place / "tables" / "truth.csv"), newline=""))
    values = {row["case"]: row["friction_sensitivity"] for row in rows if not row.get("not_ranked")}
    try:
        words = cost_of_friction([finite("friction_sensitivity", float(value)) for value in values.values() if value])
    except ValueError:
        raise BadValue(f"tables/truth.csv of the report has no friction_sensitivity; {_AGAIN}") from None
    return f". {words}" if words else ""


def _default_words(place: Path, solver: str, words: tuple[str, str]) -> str:
    """An engine's off with default settings: the median and range over its grid of usual values."""
    columns = ("default_off", "default_off_best", "default_off_worst", "default_settings")
    keys = {"case": CASE, "solver": solver, "route": "native"}
    median, low, high, count = (_number(place, "headline", column, **keys) for column in columns)
    from .judging.grades import percent

    bounds = f"{percent(low).removesuffix(' %')} to {percent(high)}"
    name, parameters = words
    return f"{name} is {percent(median)} off (median; {bounds} over {count:.0f} usual combinations of {parameters})"


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
    place = publish(user_files.place("report", arguments.REPORT), results)
    if results == RESULTS:
        refresh(ROOT / "README.md", place)
    size = sum(path.stat().st_size for path in place.rglob("*") if path.is_file())
    print(f"{place}, {size / 1e6:.1f} MB")


if __name__ == "__main__":
    sys.exit(main())
