"""`python -m reports.publish REPORT`: keep a report with the release it was made of, in docs/results/VERSION.

The tables are copied as they are; the page, too, but without its links to the figures of single cases, which are twice
as large as all else and made again by one command. The data package gets version, licence and digests, constraints.txt
says what was installed. In a clone the README's first picture and numbers are written from it. Nothing is run.

Exit status: 0; 2, with one sentence, if the folder holds no report that may stand for a release; 1 if files cannot be
written.
"""

from __future__ import annotations

import csv
import hashlib
import json
import re
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cases
from cases import BadValue, files
from cases.words import status

from . import options
from .page import folder

COMMAND = "reports.publish"
ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
PACKAGE = "tables/datapackage.json"
CONSTRAINTS = "constraints.txt"
# Of what the suite makes: docs/licences.md.
LICENCE = {
    "name": "CC-BY-4.0",
    "title": "Creative Commons Attribution 4.0 International",
    "path": "https://creativecommons.org/licenses/by/4.0/",
}
# The paper's application, and who stands in the README: as they come, but for the reference.
CASE = "disc_in_circle[mu=0.2]"
PICTURE = "figures/headline.png"
_FIGURES = (PICTURE, "figures/headline.svg")
BEGIN, END = "<!-- written by `python -m reports.publish` -->", "<!-- until here -->"


def publish(report: Path, results: Path) -> Path:
    """Keep the report in `results`/VERSION, in the place of one that is there; returns that folder.

    Raises BadValue for what may not stand for a release, OSError if the folder cannot be written.
    """
    told = _manifest(report)
    _check(told, report)
    place = results / cases.__version__
    with folder.written_whole(place) as partial:
        kept = [name for name in told["files"] if not name.startswith("figures/") or name in _FIGURES]
        for name in kept:
            (partial / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(report / name, partial / name)
        page = _by_itself((report / "index.html").read_text(encoding="utf-8"), kept)
        (partial / "index.html").write_text(page, encoding="utf-8")
        package = _described(json.loads((report / PACKAGE).read_text(encoding="utf-8")), told, partial)
        (partial / PACKAGE).write_text(json.dumps(package, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        (partial / CONSTRAINTS).write_text(_constraints(told), encoding="utf-8")
        digests = {name: digest(partial / name) for name in sorted({*kept, CONSTRAINTS} - {"manifest.json"})}
        folder.sign(partial, told | {"licence": LICENCE["name"], "sha256": digests})
    return place


def digest(file: Path) -> str:
    """SHA-256 of a file, in hexadecimal digits."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


def releases(results: Path = RESULTS) -> list[Path]:
    """The folders of published reports, the last release last."""
    from packaging.version import Version

    found = [path.parent for path in results.glob("*/manifest.json")]
    return sorted(found, key=lambda path: Version(path.name))


# --- what may be published --------------------------------------------------------------------------------------------


def _manifest(report: Path) -> dict[str, Any]:
    try:
        told = json.loads((report / "manifest.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        told = {}
    if not isinstance(told, dict) or told.get("made_by") != folder.MADE_BY or told.get("unfinished"):
        raise BadValue(f"{report} holds no report; give a folder that `python -m reports.build` wrote")
    return told


def _check(told: Mapping[str, Any], report: Path) -> None:
    """Raises BadValue unless it is a whole default report of this version, of a commit, with nothing lost."""
    absent = [name for name in told["files"] if not (report / name).is_file()]
    lacking = sorted(
        {case.label for name in cases.names(hard=False) for case in cases.select(name)} - set(told["cases"])
    )
    version, commit = told["solvers"].get("reference"), told["commit"]
    problems = {
        f"is without {', '.join(absent[:3])}": absent,
        f"is of version {version}, and this is {cases.__version__}": version != cases.__version__,
        f"has no {', '.join(lacking[:3])}": lacking,
        f"was made with {told['options']}": told["options"],
        "has no timings": "tables/time_to_accuracy.csv" not in told["files"],
        "lost calls to something outside": told["lost"],
        "does not say which commit it is of": not commit,
        "was made of files that differ from their commit": commit.endswith("+"),
        "does not say what was installed": not told.get("installed"),
        f"has no headline picture of {CASE}": CASE not in (report / _FIGURES[1]).read_text(encoding="utf-8"),
    }
    problem = next((words for words, is_so in problems.items() if is_so), "")
    if problem:
        raise BadValue(f"the report in {report} {problem}; give a whole one: commit, and `python -m reports.build`")


# --- what is written beside it ----------------------------------------------------------------------------------------


# What a page says of figures beside it: those of readers without scripts, links around those inside it, lines of links.
_LINE = re.compile(r'<p>(?:<a href="figures/[^"]*">[^<]*</a>(?:, )?)+, as figures of their own\.</p>')
_LINK = re.compile(r'<a href="figures/[^"]*">(.*?)</a>', re.DOTALL)
_WITHOUT_SCRIPTS = re.compile(r"<noscript>.*?</noscript>", re.DOTALL)
_INSTEAD = (
    "<noscript><p>Scene and motion are drawn by scripts here, and as figures by a report of your own.</p></noscript>"
)
_REFERENCE = re.compile(r'(?:href|src)="((?:figures|tables)/[^"]+|[\w.]+)"')


def _by_itself(page: str, kept: Sequence[str]) -> str:
    """The page without what it says of figures beside it; raises BadValue if it refers to a file that is not kept."""
    page = _LINK.sub(r"\1", _LINE.sub("", _WITHOUT_SCRIPTS.sub(_INSTEAD, page)))
    lost = sorted({*_REFERENCE.findall(page)} - {*kept})
    if lost:
        raise BadValue(f"the page refers to {lost[0]}, which is not kept; mend what {COMMAND} leaves out")
    return page


def _described(package: dict[str, Any], told: Mapping[str, Any], place: Path) -> dict[str, Any]:
    """The data package with version, licence and the digests of its tables."""
    head = {
        "$schema": "https://datapackage.org/profiles/2.0/datapackage.json",
        "name": package["name"],
        "title": "slip-to-roll: how wrong is your friction?",
        "description": f"Tables of the report of version {cases.__version__}, made by `{told['command']}`.",
        "version": cases.__version__,
        "created": told["made_at"],
        "licenses": [LICENCE],
    }
    tables = place / "tables"
    resources = [
        one | {"bytes": (tables / one["path"]).stat().st_size, "hash": f"sha256:{digest(tables / one['path'])}"}
        for one in package["resources"]
    ]
    return head | {"resources": resources}


def _constraints(told: Mapping[str, Any]) -> str:
    head = f"# What the report of version {cases.__version__} was made with, by Python {told['python']}.\n"
    return head + "".join(f"{name}=={version}\n" for name, version in told["installed"].items())


# --- the README -------------------------------------------------------------------------------------------------------


def headline(place: Path) -> str:
    """The README's picture and three numbers, of a published report."""
    when, bar, pymunk, exudyn = numbers(place)
    at = f"docs/results/{place.name}"
    alt = "Slip velocity of a disc inside a circle, and how far each solver is from the truth"
    lines = (
        f"{BEGIN}\n![{alt}]({at}/{PICTURE})\n",
        f"When does a disc let go inside a circle begin to roll? After {when} s, sure to {bar} s. As they come,",
        f"pymunk misses that by {pymunk} ms and Exudyn by {exudyn} ms: [the page]({at}/index.html) and",
        f"[all tables]({at}/tables) of version {place.name}.\n{END}",
    )
    return "\n".join(lines)


def numbers(place: Path) -> tuple[str, str, str, str]:
    """The time (s) at which the paper's disc begins to roll and its error bar (s), and by how much pymunk and Exudyn,
    native and as they come, miss it (ms)."""
    truth = _row(place, "truth", case=CASE, event="1")
    errors = [_row(place, "headline", case=CASE, solver=name, route="native") for name in ("pymunk", "exudyn")]
    told = [abs(float(row["default_first_error"])) for row in errors]
    pymunk, exudyn = (f"{1e3 * error:.2g}" for error in told)
    return f"{float(truth['time']):.9f}", f"{float(truth['truth_error_bar']):.0e}", pymunk, exudyn


def _row(place: Path, table: str, **wanted: str) -> dict[str, str]:
    with (place / "tables" / f"{table}.csv").open(encoding="utf-8", newline="") as file:
        return next(row for row in csv.DictReader(file) if wanted.items() <= row.items())


def refresh(readme: Path, place: Path) -> None:
    """Write the README's part that comes from the published report; raises BadValue if it has no room for it."""
    text = readme.read_text(encoding="utf-8")
    new, count = re.subn(f"{re.escape(BEGIN)}.*?{re.escape(END)}", lambda _: headline(place), text, flags=re.DOTALL)
    if count != 1:
        raise BadValue(f"{readme} has no part between {BEGIN} and {END}; put both lines where the picture belongs")
    readme.write_text(new, encoding="utf-8")


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit status."""

    def work(words: list[str]) -> None:
        positional = {"REPORT": "the folder of a default report"}
        parser = options.parser(
            COMMAND, "Keep a report with its release.", "out", words=positional, out="docs/results",
            example=f"python -m {COMMAND} report",
        )  # fmt: skip
        given = parser.parse_args(words)
        results = files.place("folder of --out", given.out).resolve()
        place = publish(files.place("report", given.REPORT), results)
        if results == RESULTS:
            refresh(ROOT / "README.md", place)
        size = sum(path.stat().st_size for path in place.rglob("*") if path.is_file())
        print(f"{place}, {size / 1e6:.1f} MB")

    return status(COMMAND, work, argv)


if __name__ == "__main__":
    sys.exit(main())
