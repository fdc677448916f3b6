"""The archive of a published report for a data repository: its files unchanged, and metadata that agree with them."""

import hashlib
import json
import re
import shutil
import zipfile

import pytest

from reports import deposit, publish

LAST = publish.releases()[-1]
ROOT = f"slip-to-roll-results-{LAST.name}"


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    return zipfile.ZipFile(deposit.pack(LAST, tmp_path_factory.mktemp("deposit") / "a.zip"))


def test_the_archive_has_the_files_of_the_release_and_metadata_and_nothing_else(packed):
    files = {path.relative_to(LAST).as_posix() for path in LAST.rglob("*") if path.is_file()}
    inside = {name.removeprefix(f"{ROOT}/") for name in packed.namelist()}
    assert inside == files | {".zenodo.json", "datacite.json", "CITATION.cff"}
    listed = re.findall(r"^([0-9a-f]{64})  (.*)$", (LAST / "slip-to-roll.sha256").read_text(), flags=re.M)
    assert {name for _, name in listed} | {"slip-to-roll.sha256"} == files
    for digest, name in listed:
        assert hashlib.sha256(packed.read(f"{ROOT}/{name}")).hexdigest() == digest, name


def test_all_metadata_have_the_version_date_and_licence_of_the_data_package(packed):
    package = json.loads(packed.read(f"{ROOT}/tables/datapackage.json"))
    zenodo, datacite = (json.loads(packed.read(f"{ROOT}/{name}")) for name in (".zenodo.json", "datacite.json"))
    cited = packed.read(f"{ROOT}/CITATION.cff").decode()
    date = package["created"][:10]
    assert zenodo["version"] == datacite["version"] == package["version"] == LAST.name
    assert zenodo["publication_date"] == datacite["dates"][0]["date"] == date
    assert datacite["publicationYear"] == date[:4]
    assert zenodo["license"] == "cc-by-4.0" and datacite["rightsList"][0]["rightsIdentifier"] == "CC-BY-4.0"
    for line in (f'version: "{LAST.name}"', f'date-released: "{date}"', "license: CC-BY-4.0", "type: dataset"):
        assert line in cited.splitlines()
    # The fields that Zenodo and DataCite require, without what the repository assigns: identifier, publisher.
    assert {"title", "upload_type", "description", "creators"} <= zenodo.keys()
    assert {"titles", "creators", "publicationYear", "types", "schemaVersion"} <= datacite.keys()


def copy(place):
    shutil.copytree(LAST, place)
    return place


def test_a_changed_file_is_one_sentence(tmp_path, capsys):
    folder = copy(tmp_path / "changed")
    with (folder / "tables" / "headline.csv").open("a") as file:
        file.write("1\n")
    assert deposit.main([str(folder), "--out", str(tmp_path / "a.zip")]) == 2
    error = capsys.readouterr().err
    assert "tables/headline.csv" in error and "has changed since it was written" in error and error.count("\n") == 1
    assert not (tmp_path / "a.zip").exists()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"version": "../../etc"}, "is not valid"),
        ({"version": 1}, "contains no published report"),
        ({"created": "yesterday"}, "is not valid"),
        ({"licenses": []}, "contains no published report"),
    ],
)
def test_an_odd_data_package_is_one_sentence(tmp_path, capsys, change, reason):
    folder = copy(tmp_path / "odd")
    file = folder / deposit.PACKAGE
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    assert deposit.main([str(folder)]) == 2
    error = capsys.readouterr().err
    assert reason in error and error.count("\n") == 1
