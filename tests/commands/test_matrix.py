"""The versions that are promised, and the command that tries them."""

import os
import re
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests import matrix
from tests.matrix import Command, Environment, Outcome, Python, Row

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
P11, P12, P13 = (Python(Path(f"/python3.{minor}"), (3, minor, 1)) for minor in (11, 12, 13))


def pins(name: str, python: str) -> dict[str, str]:
    """The versions of a constraints file for that Python on Linux, by package."""
    found = {}
    for line in (ROOT / "constraints" / f"{name}.txt").read_text(encoding="utf-8").splitlines():
        text = line.partition("#")[0].strip()
        if not text:
            continue
        one = Requirement(text)
        machine = dict(python_version=python, python_full_version=f"{python}.7", platform_system="Linux",
                       sys_platform="linux", platform_machine="x86_64")  # fmt: skip
        if one.marker is None or one.marker.evaluate(machine):
            assert one.name not in found, f"{one.name} stands twice for Python {python}"
            (found[one.name],) = (one.version for one in one.specifier)
    return found


def needed(*extras: str) -> list[Requirement]:
    """What the project asks for, with those extras."""
    texts = [*PROJECT["dependencies"], *(text for extra in extras for text in PROJECT["optional-dependencies"][extra])]
    return [Requirement(text) for text in texts if not text.startswith("slip-to-roll")]


def test_the_lowest_versions_are_the_declared_ones():
    lowest = pins("lowest", "3.11")
    for one in needed("taylor", "dask", "test"):
        (bound,) = one.specifier
        assert bound.operator == ">=" and bound.contains(lowest[one.name]), one
        # 2.0 and 2.0.0 are one version.
        assert Requirement(f"x=={bound.version}").specifier.contains(lowest[one.name]), one


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13", "3.14"])
def test_both_constraints_have_all_that_is_needed_for_every_python(python):
    current, lowest = pins("current", python), pins("lowest", python)
    for one in needed("taylor", "dask", "test"):
        assert one.specifier.contains(current[one.name]) and one.specifier.contains(lowest[one.name]), one
    assert f"Programming Language :: Python :: {python}" in PROJECT["classifiers"]


def test_the_published_report_was_made_with_the_current_versions():
    from reports import publish

    place = publish.releases()[-1]
    text = (place / publish.CONSTRAINTS).read_text(encoding="utf-8")
    python = re.search(r"with Python (3\.\d+)", text)[1]
    published = dict(line.split("==") for line in text.splitlines() if "==" in line)
    current = pins("current", python)
    assert {name: current[name] for name in published} == published


# --- the command ------------------------------------------------------------------------------------------------------


def test_all_environments_and_the_part_of_them_that_every_commit_gets():
    names = [one.name for one in matrix.whole([P11, P13])]
    assert len(names) == len(set(names)) == 8 and "3.13.1-lowest-without-heyoka" in names
    assert matrix.part([P11, P12, P13], (3, 11)) == [Environment(P13, "current", False)]
    assert matrix.part([P11, P12, P13], (3, 13))[0].python == P12
    assert matrix.part([P11], (3, 11)) == [Environment(P11, "current", False)]


@pytest.mark.parametrize(
    ("words", "passed", "text"),
    [
        (
            ("sh", "-c", "echo '== 3 passed, 1 skipped, 2 deselected in 0.10s (0:00:00) =='"),
            True,
            "3 passed, 1 skipped",
        ),
        (("sh", "-c", "echo '1 failed, 3 passed in 0.1s'; exit 1"), False, "1 failed, 3 passed"),
        (
            ("sh", "-c", "printf 'FAILED t.py::a - x\\nFAILED t.py::b\\n2 failed in 0.1s\\n'; exit 1"),
            False,
            "2 failed: `t.py::a`, `t.py::b`",
        ),
        (("sh", "-c", "echo $HOME >&2; exit 4"), False, "failed (exit status 4)"),
    ],
)
def test_a_command_that_fails_is_a_row_in_its_own_words(words, passed, text, tmp_path):
    outcome = matrix.run(Command("tests", words), tmp_path, tmp_path / "home", tmp_path / "log")
    assert (outcome.passed, outcome.text) == (passed, text)
    assert words[-1] in (tmp_path / "log").read_text() and not str(Path.home()) == str(tmp_path / "home")


def test_the_table_has_a_row_for_each_environment_and_is_kept_in_its_place(tmp_path):
    done = {"heyoka": Outcome(True, "yes", 1.0), "tests": Outcome(True, "3 passed", 61.2)}
    rows = [
        Row(Environment(P11, "newest", True), done, "abc", "2026-11-22"),
        Row(Environment(P12, "lowest", False), done),
    ]
    rows.append(Row(Environment(P13, "lowest", True), {"installation": Outcome(False, "failed (exit status 2)", 3.0)}))
    lines = matrix.table(rows).splitlines()
    assert lines[0] == "| Python | versions | heyoka | tests | installation | commit | date |"
    assert lines[2] == "| 3.11.1 | newest | yes | 3 passed, 61 s | – | abc | 2026-11-22 |"
    assert "yes, though left out" in lines[3] and "| – | – | failed (exit status 2), 3 s |" in lines[4]
    page = tmp_path / "page.md"
    page.write_text(f"before\n{matrix.BEGIN}\nold\n{matrix.END}\nafter\n")
    matrix.keep("new\n", page)
    matrix.keep("newer\n", page)
    assert page.read_text() == f"before\n{matrix.BEGIN}\nnewer\n{matrix.END}\nafter\n"
    page.write_text("nothing")
    with pytest.raises(ValueError, match="put both lines"):
        matrix.keep("new", page)


def test_an_interrupted_matrix_goes_on_with_the_environments_that_have_no_row(tmp_path, monkeypatch):
    tried, head, ends_at = [], ["abc"], ["3.12.1-lowest-with-heyoka"]

    def row(environment, partly, log, commit):
        if environment.name in ends_at:
            raise KeyboardInterrupt
        tried.append(environment.name)
        return Row(environment, {"tests": Outcome(True, "3 passed", 1.0)}, commit, "2026-11-22")

    kept: list[str] = []
    monkeypatch.setattr(matrix, "WORK", tmp_path / "work")
    monkeypatch.setattr(matrix, "pythons", lambda paths: [P11, P12])
    monkeypatch.setattr(matrix, "row", row)
    monkeypatch.setattr(matrix, "keep", kept.append)
    monkeypatch.setattr(matrix, "_git", lambda *words: "" if words[0] == "status" else head[0])
    with pytest.raises(KeyboardInterrupt):
        matrix.main([], kept.append)
    ends_at.clear()
    first, names = list(tried), [one.name for one in matrix.whole([P11, P12])]
    assert first == names[:4]
    assert matrix.main([], kept.append) == 0 and tried == names
    assert all(f"| {one.python.text} | {one.versions} |" in kept[-1] for one in matrix.whole([P11, P12]))
    assert matrix.main([], kept.append) == 0 and tried == names
    head[0] = "def"
    assert matrix.main(["--only", "3.12.1-newest"], kept.append) == 0 and tried == [*names, *names[-2:]]
    assert kept[-1].count("| abc |") == 6 and kept[-1].count("| def |") == 2
    assert matrix.main(["--only", "newest-with-", "--fresh"], kept.append) == 0 and len(tried) == 12
    assert matrix.main(["--only", "3.10"], kept.append) == 2 and "3.11.1-lowest-with-heyoka" in kept[-1]


@pytest.mark.slow
def test_the_lowest_versions_install_together_and_give_exact_values(tmp_path, monkeypatch):
    """Of the last commit: an environment is a clone."""
    monkeypatch.setattr(matrix, "WORK", tmp_path)
    (own,) = matrix.pythons([Path(os.path.realpath(sys.executable))])
    row = matrix.row(Environment(own, "lowest", True), True, tmp_path / "log")
    assert row.passed, (tmp_path / "log").read_text()
