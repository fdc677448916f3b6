"""`slip-to-roll release deposit docs/results/VERSION`: pack a published report for a data repository.

The archive contains the files of the published report as they are, and metadata: `.zenodo.json` for Zenodo,
`datacite.json` with the properties of DataCite 4 for other repositories, and `CITATION.cff`. The repository adds the
DOI and, in DataCite, the publisher. The same report gives the same bytes.

Exit status: 0; 2, with one sentence, if the folder contains no published report.
"""

from __future__ import annotations

import json
import re
import sys
from argparse import Namespace
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from cases import BadValue
from cases.files import user_files
from cases.files.owned_folder import LIST, atomic_path, check_new

from . import options
from .page import report_folder

COMMAND = "reports.deposit"
PACKAGE = "tables/datapackage.json"
AUTHORS = "the slip-to-roll authors"
# The name of an archive, before its version.
ARCHIVE = "slip-to-roll-results"
KEYWORDS = ("multibody dynamics", "Coulomb friction", "contact", "benchmark", "physics engines")
_ABSTRACT = (
    "Errors and costs of physics engines for rigid plates on planar curves with Coulomb friction, compared with "
    "certified times of slip, roll, reversal, lift-off and impact. Tables with the unit and meaning of each column "
    "(tables/datapackage.json), the report's page, and the versions of all packages."
)
# The time of each file in the archive: ZIP has no earlier one, and equal reports give equal archives.
_TIME = (1980, 1, 1, 0, 0, 0)
_LARGEST = 100 * 2**20  # size limit of a file, bytes, as of a published report


class _Release(NamedTuple):
    """What the data package of a published report says of it."""

    version: str
    date: str  # YYYY-MM-DD
    licence: dict[str, str]


def pack(folder: Path, archive: Path, replace: bool = False) -> Path:
    """Write the archive of a published report; returns its path.

    Raises BadValue if the folder contains no published report or its files have changed, FileExistsError if the archive
    exists and may not be replaced.
    """
    names = report_folder.of_report(folder, "release").names()
    release = _release(folder)
    root = f"{ARCHIVE}-{release.version}"
    size = sum((folder / name).stat().st_size for name in names)
    metadata = {
        ".zenodo.json": _as_json(_zenodo(release)),
        "datacite.json": _as_json(_datacite(release, len(names), size)),
        "CITATION.cff": _citation(release),
    }
    with atomic_path(archive, replace) as partial, ZipFile(partial, "w", ZIP_DEFLATED) as zipped:
        for name, text in metadata.items():
            zipped.writestr(entry(f"{root}/{name}"), text)
        for name in (LIST, *names):
            zipped.writestr(entry(f"{root}/{name}"), (folder / name).read_bytes())
    return archive


def entry(name: str) -> ZipInfo:
    """The entry of a name in an archive whose bytes depend on its content only."""
    entry = ZipInfo(name, _TIME)
    entry.compress_type = ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    return entry


def _release(folder: Path) -> _Release:
    """Version, date and licence from the data package; raises BadValue for a report that was not published."""
    try:
        package = json.loads(user_files.text("data package", folder / PACKAGE, _LARGEST))
        version, date, licence = package["version"], package["created"][:10], package["licenses"][0]
        name, title, path = (licence[key] for key in ("name", "title", "path"))
    except (ValueError, LookupError, TypeError, RecursionError):
        version = date = name = title = path = None
    if not all(isinstance(word, str) and word.isprintable() for word in (version, date, name, title, path)):
        raise BadValue(
            f"{folder} contains no published report; give a folder that `slip-to-roll release publish` wrote"
        )
    if not re.fullmatch(r"[0-9][A-Za-z0-9.+]*", version) or not re.fullmatch(r"\d{4}-\d\d-\d\d", date):
        raise BadValue(f"version {version!r} or date {date!r} in {folder / PACKAGE} is not valid; publish it again")
    return _Release(version, date, {"name": name, "title": title, "path": path})


def _title(release: _Release) -> str:
    return (
        f"slip-to-roll {release.version}: errors and costs of physics engines in planar contact with Coulomb friction"
    )


def _zenodo(release: _Release) -> dict[str, Any]:
    """The metadata in the names of Zenodo's deposit interface."""
    return {
        "title": _title(release),
        "upload_type": "dataset",
        "description": _ABSTRACT,
        "creators": [{"name": AUTHORS}],
        "access_right": "open",
        "license": release.licence["name"].lower(),
        "version": release.version,
        "publication_date": release.date,
        "keywords": list(KEYWORDS),
        "language": "eng",
    }


def _datacite(release: _Release, count: int, size: int) -> dict[str, Any]:
    """The metadata in the names of DataCite's JSON, without identifier and publisher, which the repository gives."""
    return {
        "schemaVersion": "http://datacite.org/schema/kernel-4",
        "titles": [{"title": _title(release)}],
        "creators": [{"name": AUTHORS, "nameType": "Organizational"}],
        "publicationYear": release.date[:4],
        "types": {"resourceTypeGeneral": "Dataset", "resourceType": "Benchmark results"},
        "version": release.version,
        "dates": [{"date": release.date, "dateType": "Created"}],
        "language": "en",
        "subjects": [{"subject": word} for word in KEYWORDS],
        "rightsList": [
            {
                "rights": release.licence["title"],
                "rightsUri": release.licence["path"],
                "rightsIdentifier": release.licence["name"],
                "rightsIdentifierScheme": "SPDX",
            }
        ],
        "descriptions": [{"description": _ABSTRACT, "descriptionType": "Abstract"}],
        "formats": ["text/csv", "application/json", "text/html", "image/svg+xml"],
        "sizes": [f"{count} files", f"{size} bytes"],
    }


def _citation(release: _Release) -> str:
    """The citation of the data in the Citation File Format."""
    lines = [
        "cff-version: 1.2.0",
        "message: If you use these numbers, please cite them.",
        f'title: "{_title(release)}"',
        "type: dataset",
        f'version: "{release.version}"',
        f'date-released: "{release.date}"',
        f"license: {release.licence['name']}",
        "authors:",
        f"  - name: {AUTHORS}",
    ]
    return "\n".join(lines) + "\n"


def _as_json(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


@options.runs(
    COMMAND, "Pack a published report, with metadata, for a data repository.", "out file", "force",
    words={"FOLDER": "the folder of a published report"}, example=f"python -m {COMMAND} docs/results/0.2.0",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> None:
    """Pack the report and print the archive's path."""
    folder = user_files.place("folder", arguments.FOLDER).resolve()
    release = _release(folder)
    archive = user_files.place("file of --out", arguments.out or f"{ARCHIVE}-{release.version}.zip")
    if archive.suffix != ".zip":
        raise BadValue(f"--out is {str(archive)!r}; give a file that ends in .zip")
    check_new(archive, arguments.force)
    options.check_writable("--out", archive, archive.parent)
    archive.parent.mkdir(parents=True, exist_ok=True)
    pack(folder, archive, arguments.force)
    print(f"{archive}, {archive.stat().st_size / 1e6:.1f} MB: upload it; .zenodo.json and datacite.json describe it")


if __name__ == "__main__":
    sys.exit(main())
