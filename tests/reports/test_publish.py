"""The published report: what may stand for a release, what is kept of it, and that README and answers are still its."""

from __future__ import annotations

import csv
import json
import math
import os
import re
import shutil
import subprocess
import zipfile
from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd
import pytest

import cases
from cases.files.owned_folder import LIST, digest
from cases.version import RELEASED
from reports import compare_builds, publish
from reports.page import report_folder
from reports.page.manifest import FORMAT
from tests.benchmarks.golden import write_answers

ROOT = Path(__file__).parent.parent.parent
LAST = publish.releases()[-1]
MANIFEST = json.loads((LAST / "manifest.json").read_text(encoding="utf-8"))
README = (ROOT / "README.md").read_text(encoding="utf-8")


def table(name: str) -> pd.DataFrame:
    return pd.read_csv(LAST / "tables" / f"{name}.csv")


# --- the one that is kept ---------------------------------------------------------------------------------------------


def test_the_last_release_is_this_version_or_an_older_one():
    from packaging.version import Version

    assert Version(LAST.name) <= Version(cases.__version__)
    assert MANIFEST["solvers"]["reference"] == LAST.name and re.fullmatch(r"[0-9a-f]{40}", MANIFEST["commit"])


def test_nothing_of_it_was_edited_or_lost():
    names = report_folder.of_report(LAST, "release").names()
    assert {path.relative_to(LAST).as_posix() for path in LAST.rglob("*") if path.is_file()} == {*names, LIST}
    assert all(any(fnmatchcase(name, pattern) for pattern in (*publish.KEPT, publish.DIGESTS)) for name in names)
    listed = (LAST / publish.DIGESTS).read_text(encoding="utf-8").splitlines()
    of_release = {name: value for value, _, name in (line.partition("  ") for line in listed[1:])}
    assert report_folder.PAGE in of_release and of_release.keys() >= {*names} - {publish.DIGESTS}
    assert all(digest(LAST / name) == of_release[name] for name in names if name != publish.DIGESTS)


def test_it_names_no_folder_of_the_machine_it_was_made_on():
    text = (LAST / "manifest.json").read_text(encoding="utf-8")
    assert not re.findall(r"[^\w.:/]((?:/home|/root|/tmp|/var|/Users)/[^\s<\"]*)", text)


def test_the_data_package_tells_its_licence_its_version_and_every_table():
    package = json.loads((LAST / publish.PACKAGE).read_text(encoding="utf-8"))
    assert package["version"] == LAST.name
    (licence,) = package["licenses"]
    said = (ROOT / "docs" / "licences.md").read_text(encoding="utf-8")
    assert licence["name"] == "CC-BY-4.0" and licence["path"] in said
    tables = {one["path"]: one for one in package["resources"]}
    assert tables.keys() >= {file.name for file in (LAST / "tables").glob("*.csv")} >= {"verdict.csv", "truth.csv"}
    for file in (LAST / "tables").glob("*.csv"):
        fields = [field["name"] for field in tables[file.name]["schema"]["fields"]]
        assert fields == file.read_text(encoding="utf-8").partition("\n")[0].split(",")
        assert tables[file.name]["hash"] == f"sha256:{digest(file)}"


def test_the_readme_begins_with_its_picture_and_its_numbers():
    picture = re.search(r"!\[[^]]*\]\((.*?)\)", README)[1]
    assert picture == f"docs/results/{LAST.name}/figures/headline.png" and (ROOT / picture).is_file()
    part = README[README.index(publish.BEGIN) : README.index(publish.END)]
    when, bar = map(float, re.findall(r"(?<![\w./-])\d[\d.]*(?:e-\d+)?(?= m?s\b)", part))
    of_disc = table("truth").query("case == 'disc_in_circle[mu=0.2]' and event == 1").iloc[0]
    assert when == pytest.approx(of_disc["time"], abs=5e-10) and bar == float(f"{of_disc['truth_error_bar']:.0e}")
    rows = table("headline").query("case == 'disc_in_circle[mu=0.2]' and route == 'native'").set_index("solver")
    output = re.findall(r"(pymunk|Exudyn) is ([\d.]+) % off", " ".join(part.split()))
    assert [name.lower() for name, _ in output] == ["pymunk", "exudyn"]
    for name, percent in output:
        assert float(percent) == float(f"{100 * rows.loc[name.lower(), 'default_off']:.2g}")


def test_what_is_cited_and_packed_is_the_last_release():
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (.*)$", cited, flags=re.M)[1] == LAST.name
    date = MANIFEST["made_at"][:10]
    assert re.search(r'^date-released: "(.*)"$', cited, flags=re.M)[1] == date == RELEASED
    packed = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert f"docs/results/{LAST.name}/constraints.txt" in packed
    output = (LAST / "constraints.txt").read_text(encoding="utf-8")
    for name, version in MANIFEST["packages"].items():
        assert f"\n{name}=={version}\n" in output


def test_a_container_has_packages_before_the_source_and_works_in_the_callers_folder():
    lines = (ROOT / "Dockerfile").read_text(encoding="utf-8").splitlines()
    packages, source, home, desk, volume, work = (
        next(i for i, line in enumerate(lines) if line.startswith(start))
        for start in ("RUN pip install --no-cache-dir -r", "COPY . ", "ENV HOME=", "RUN mkdir", "VOLUME", "WORKDIR")
    )
    assert packages < source and desk < volume < work and home > source
    assert lines[volume].split()[1:] == lines[work].split()[1:] == ["/desk"] and "1777 /desk" in lines[desk]
    assert any('--user "$(id -u):$(id -g)" --volume "$PWD:/desk"' in line for line in lines[:5])


@pytest.mark.skipif(not (ROOT / ".venv" / "bin" / "slip-to-roll").exists(), reason="no environment of make")
def test_make_shell_has_the_commands():
    done = subprocess.run(
        ["make", "--no-print-directory", "-o", ".venv/installed", "shell"],
        input="command -v slip-to-roll; echo $VIRTUAL_ENV", cwd=ROOT,
        env={**os.environ, "PATH": "/usr/bin:/bin", "SHELL": "/bin/sh"}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.split() == [str(ROOT / ".venv" / "bin" / "slip-to-roll"), str(ROOT / ".venv")]


# --- the command ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def signed_report(tmp_path_factory):
    """Digests of 8 MB are computed once, for all tests."""
    return made_report(tmp_path_factory.mktemp("signed") / "report")


@pytest.fixture
def report(signed_report, tmp_path):
    return Path(shutil.copytree(signed_report, tmp_path / "report"))


def made_report(made: Path) -> Path:
    """A copy of the published report as a build would have left it, of the version that runs here."""
    output = {name: value for name, value in MANIFEST.items() if name not in ("sha256", "licence", "files")}
    output["solvers"] |= {"reference": cases.__version__}
    output["format"] = FORMAT
    output["cases"] = {case.label: {} for name in cases.names(hard=False) for case in cases.select(name)}
    with report_folder.of_report(made).staging(whole=True) as place:
        ignore = shutil.ignore_patterns("constraints.txt", publish.DIGESTS, LIST)
        shutil.copytree(LAST, place, dirs_exist_ok=True, ignore=ignore)
        (place / "index.html").write_text('<a href="tables/truth.csv">truth</a>')
        (place / "tables" / "time_to_accuracy.csv").write_text("case,level\n")
        package = json.loads((place / publish.PACKAGE).read_text(encoding="utf-8"))
        there = [one for one in package["resources"] if (place / "tables" / one["path"]).is_file()]
        (place / publish.PACKAGE).write_text(json.dumps(package | {"resources": there}))
        (place / "manifest.json").write_text(json.dumps(output))
        (place / "figures" / "headline.svg").write_text(publish.CASE)
    return made


def changed(report: Path, name: str, content: str | bytes | None) -> None:
    """Another content of a file, or none, as if a build had written it so."""
    made = report_folder.of_report(report)
    with made.write_lock():
        made.remove([name])
        if content is not None:
            made.write(name, content if isinstance(content, bytes) else content.encode())


def test_a_report_is_published_again_in_its_own_place_and_whole_in_an_archive(report, tmp_path, capsys):
    for _ in range(2):
        assert publish.main([str(report), "--out", str(tmp_path / "results")]) == 0
        (place,) = publish.releases(tmp_path / "results")
        assert place.name == cases.__version__ and str(place) in capsys.readouterr().out
    (archive,) = (tmp_path / "results").glob("*.zip")
    with zipfile.ZipFile(archive) as packed:
        inside = {name.partition("/")[2] for name in packed.namelist()}
        page = packed.read(f"{archive.stem}/{report_folder.PAGE}")
    assert page == (report / "index.html").read_bytes() and "tables/time_to_accuracy.csv" in inside
    names = report_folder.of_report(place, "release").names()
    assert {*names} - {publish.DIGESTS} < inside and report_folder.PAGE not in names
    assert all((place / name).read_bytes() == (report / name).read_bytes() for name in names if name.endswith(".csv"))


def test_the_readme_has_one_number_for_each_engine(report):
    rows = {"case": publish.CASE, "route": "native"}
    rows = [rows | {"solver": name, "default_off": off} for name, off in (("pymunk", 0.31), ("exudyn", 0.0048))]
    pd.DataFrame(rows).to_csv(report / "tables" / "headline.csv", index=False)
    text = " ".join(publish.headline(report).split())
    assert "With default settings, pymunk is 31 % off and Exudyn is 0.48 % off (100 % off: as bad" in text


def test_a_page_that_refers_to_a_file_that_is_not_published_is_rejected():
    publish._check_page('<a href="tables/a.csv">a</a><a href="#data">data</a>', ["tables/a.csv"])
    with pytest.raises(cases.BadValue, match="refers to figures/e.svg"):
        publish._check_page('<img src="figures/e.svg">', ["tables/a.csv"])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"made_by": "somebody"}, "contains no report"),
        ({"commit": "0" * 40 + "+"}, "differ from their commit"),
        ({"commit": ""}, "name its commit"),
        ({"options": "--quick"}, "--quick"),
        ({"cases": {}}, "has no "),
        ({"lost": ["a run"]}, "ended from outside"),
        ({"installed": {}}, "installed packages"),
        ({"solvers": {"reference": "0.0.1"}}, "is of version 0.0.1"),
    ],
)
def test_what_may_not_stand_for_a_release_is_told_in_one_sentence(change, said, report, tmp_path, capsys):
    changed(report, "manifest.json", json.dumps(json.loads((report / "manifest.json").read_text()) | change))
    assert said in refused(report, tmp_path, capsys)


def refused(report: Path, tmp_path: Path, capsys) -> str:
    """The sentence with which a report is refused; nothing is published."""
    assert publish.main([str(report), "--out", str(tmp_path / "results")]) == 2
    output = capsys.readouterr().err
    assert output.count("\n") == 1 and not list((tmp_path / "results").glob("*/*"))
    return output


# --- a report from anybody --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["../secret.txt", "tables/../../secret.txt", "{}/secret.txt", "figures/link.svg"])
def test_no_file_outside_the_report_is_published(name, report, tmp_path, capsys):
    """Whatever the manifest, the list of files and links say."""
    (tmp_path / "secret.txt").write_text("precious")
    name = name.format(tmp_path)
    if "link" in name:
        (report / name).symlink_to(tmp_path / "secret.txt")
    with (report / LIST).open("a") as file:
        file.write(f"{digest(tmp_path / 'secret.txt')}  {name}\n")
    if "link" in name:
        assert "has changed since it was written" in refused(report, tmp_path, capsys)
    else:
        assert publish.main([str(report), "--out", str(tmp_path / "results")]) == 0
    published = [path for path in (tmp_path / "results").rglob("*") if path.is_file()]
    assert not [path for path in published if path.read_bytes() == b"precious"]


ODD = [None, True, 3, -1.5e300, "", "\ud800", "a\nb==1", [], [[]], ["x"], {}, {"a": {"b": []}}, {"../a": "../b"}]


@pytest.mark.parametrize("odd_values", [ODD[::4], pytest.param(ODD, marks=pytest.mark.slow)], ids=["few", "all"])
@pytest.mark.parametrize("name", [*publish._TYPES, "made_by"])
def test_odd_values_of_a_manifest_give_one_sentence(name, odd_values, report, tmp_path, capsys):
    output = json.loads((report / "manifest.json").read_text())
    right = {"options": [""], "cases": [], "lost": [[]]}.get(name, [])
    for odd in odd_values:
        if odd in right or isinstance(odd, str) and odd.isprintable() and name in ("python", "command", "made_at"):
            continue
        changed(report, "manifest.json", json.dumps(output | {name: odd}))
        refused(report, tmp_path, capsys)
    changed(report, "manifest.json", json.dumps({key: value for key, value in output.items() if key != name}))
    refused(report, tmp_path, capsys)


TEXTS = ["", "[]", "3", "null", "[" * 100_000, "9" * 5000, "\ud800", '{"resources": 3}', '{"resources": [3]}',
         '{"resources": [{"path": "../../secret.txt"}]}', '{"resources": [{"path": ["a"]}]}', b"\xff\x00"]  # fmt: skip
HEADS = ["case,event\n", "case,case\na,b,c,d\n", "case,event,time,truth_error_bar\ndisc_in_circle[mu=0.2],1,soon,nan\n"]


@pytest.mark.parametrize("name", [
    "manifest.json", publish.PACKAGE, "tables/truth.csv",
    pytest.param("tables/headline.csv", marks=pytest.mark.slow),  # read as the truth's is
])  # fmt: skip
def test_an_odd_file_gives_one_sentence(name, report, tmp_path, capsys):
    texts = TEXTS + (HEADS + ['"' + "x" * 200_000] if name.endswith("csv") else [])
    for text in texts:
        changed(report, name, text if isinstance(text, bytes) else text.encode(errors="surrogatepass"))
        refused(report, tmp_path, capsys)
    (report / name).write_text("edited")
    assert "has changed since it was written" in refused(report, tmp_path, capsys)
    (report / name).unlink()
    assert f"is without {name}" in refused(report, tmp_path, capsys)


def test_the_readme_has_the_time_of_the_published_report(report, tmp_path):
    file = tmp_path / "README.md"
    file.write_text(
        f"{publish.BEGIN}{publish.END} On two cores: installation 1 minute, report 99 minutes, tests 4 minutes."
    )
    place = tmp_path / cases.__version__
    shutil.copytree(report, place)
    publish.refresh(file, place)
    whole = sum(phase["wall_s"] for phase in MANIFEST["phases"].values())
    assert f"installation 1 minute, report {whole / 60:.0f} minutes, tests 4 minutes." in file.read_text()


# --- the watch --------------------------------------------------------------------------------------------------------


CHANGES = Path(__file__).parent / "changed_answers.csv"


def changes() -> list[dict[str, str]]:
    """The rows of the answers that have changed: words that a difference has to match, the largest relative change that
    they name (any, if none is given), and the numbers before and now."""
    with CHANGES.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def matches(difference: compare_builds.Difference, rows: list[dict[str, str]]) -> bool:
    words = [difference.table, difference.column, *difference.row.split(", ")]
    return any(
        all(any(w == part or fnmatchcase(w, part) for w in words) for part in row["answers"].split())
        and (not row["within"] or relative_change(difference) <= float(row["within"]))
        for row in rows
    )


def relative_change(difference: compare_builds.Difference) -> float:
    """Of two numbers, as a share of the larger; infinite if one of the values is none."""
    try:
        one, other = float(difference.one), float(difference.other)
    except (TypeError, ValueError):
        return math.inf
    return abs(one - other) / max(abs(one), abs(other)) if math.isfinite(one) and math.isfinite(other) else math.inf


def test_every_row_of_the_changes_has_a_version_and_an_answer():
    rows = changes()
    assert rows and all(row.keys() == {"version", "answers", "within", "quantity", "before", "now"} for row in rows)
    assert all(row["version"] and row["answers"] and row["quantity"] for row in rows)
    assert len({(row["version"], row["answers"], row["quantity"]) for row in rows}) == len(rows)


def other_machine() -> str:
    """What differs between here and where the published report was made, of all that may change a last digit: versions,
    processor, the C library with its sines."""
    from reports.page.manifest import manifest

    here = manifest({})
    for output in (here, there := dict(MANIFEST)):
        output["machine"] = re.findall(r"x86_64|aarch64|arm64|glibc[\d.]+|, .*", output["machine"])
    different = (name for name in ("python", "packages", "machine") if here[name] != there[name])
    return next((f"{name}: {here[name]} here, {there[name]} there" for name in different), "")


@pytest.fixture(scope="module")
def rebuilt(tmp_path_factory) -> Path:
    """The accuracy of a default report, made anew by this commit: no timings, no pictures, no studies."""
    place = tmp_path_factory.mktemp("rebuilt") / "report"
    every = [case for name in cases.names(hard=False) for case in cases.select(name)]
    write_answers(every, place, is_selection=False)  # selected cases would have whole ladders
    return place


@pytest.mark.slow
def test_no_accuracy_changes_without_a_row_and_no_bar_widens(rebuilt):
    """To the last digit; while the version is that of the last release nothing may change at all."""
    if other_machine():
        pytest.skip(f"last digits are those of one kind of machine; {other_machine()}")
    rows = [row for row in changes() if row["version"] != LAST.name] if LAST.name != cases.__version__ else []
    compared = {"headline", "trajectories", "truth"}
    assert compared <= {file.stem for file in (rebuilt / "tables").glob("*.csv")}
    found = compare_builds.compare(LAST, rebuilt).results
    others = [d for d in found if d.one != "missing" and not matches(d, rows)]
    assert not others, compare_builds.summary_lines(
        compare_builds.BuildComparison(others, [], [], [], 0), LAST, rebuilt
    )


@pytest.mark.slow
def test_no_bar_of_the_truth_widens(rebuilt):
    keys = ["case", "event"]
    both = table("truth").merge(pd.read_csv(rebuilt / "tables" / "truth.csv"), on=keys, suffixes=("", "_now"))
    assert len(both) >= len(table("truth"))
    wider = both[both["truth_error_bar_now"] > both["truth_error_bar"]]
    assert wider.empty, wider[[*keys, "truth_error_bar", "truth_error_bar_now"]].to_string()
