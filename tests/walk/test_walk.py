"""README and docs as a reader follows them: the wheel in an empty environment, an empty folder, every command in turn.

`make walk` runs README's; the slow tests run all pages.
"""

import re
import resource
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest

import cases

from .installed import CONSTRAINTS, ROOMS, ROOT, Environment, wheel
from .pages import PAGES, WALK, Left, Page, Step, commands

# What a room holds beside code.
DATA = (".csv", ".json", ".html", ".css", ".typed")


@pytest.fixture(scope="session")
def environment(tmp_path_factory) -> Environment:
    pytest.importorskip("setuptools", minversion="77")  # the first that take a licence by its name
    return Environment(tmp_path_factory.mktemp("walk") / "env")


def test_every_command_of_every_page_is_walked_or_says_why_not():
    output = {page.name: commands(page) for page in PAGES if commands(page)}
    assert output.keys() == WALK.keys() and len(output) > 10
    for name, page in WALK.items():
        assert [step.command for step in page.steps] == output[name], name


def test_a_step_that_is_left_out_has_a_reason_and_one_that_is_run_says_what_it_prints():
    for page in WALK.values():
        for step in page.steps:
            assert step.why if isinstance(step, Left) else step.prints


def block(page: str, language: str, pages: Sequence[Path] = PAGES) -> str:
    """The first block of a language on a page."""
    (path,) = [path for path in pages if path.name == page]
    found = re.search(rf"```{language}\n(.*?)```", path.read_text(encoding="utf-8"), flags=re.S)
    assert found, f"{page} has a block of {language}"
    return found[1]


def walk(page: Page, environment: Environment, desk: Path, pages: Sequence[Path] = PAGES) -> None:
    """Every command of a page in a folder: it ends well, prints what is expected and writes what is expected."""
    for file, place in page.files.items():
        (desk / file).parent.mkdir(parents=True, exist_ok=True)
        (desk / file).write_text(block(*place, pages))
        (desk / file).chmod(0o755)
    for step in page.steps:
        if isinstance(step, Left):
            continue
        if step.needs and not works(step.needs, environment, desk):
            print(f"left out, for there is no {step.needs}: {step.command}")
            continue
        check_step(step, environment, desk)


def works(program: str, environment: Environment, desk: Path) -> bool:
    """Whether a program is installed and starts: the launcher of a compiler may be there without the compiler."""
    return bool(shutil.which(program)) and environment.run(f"{program} --version", desk).returncode == 0


def check_step(step: Step, environment: Environment, desk: Path) -> None:
    began = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    if step.before:
        assert environment.run(step.before, desk).returncode == 0, step.before
    before = {path: path.stat().st_mtime_ns for path in desk.rglob("*")}
    if step.clone:
        # The tests are the clone's, and so is the environment that has pytest.
        output = subprocess.run(
            [sys.executable, "-m", *step.command.replace("=", f"={desk}/").split(), "-p", "no:cacheprovider"],
            cwd=ROOT, capture_output=True, text=True,
        )  # fmt: skip
    else:
        output = environment.run(step.command, desk)
    said = f"$ {step.command}\n{output.stdout}\n{output.stderr}"
    assert output.returncode == 0 and "Traceback" not in said, said
    place = 0
    for pattern in step.prints:
        found = re.compile(pattern, re.M).search(output.stdout, place)
        assert found, f"not printed (or not after what is expected before it): {pattern}\n{said}"
        place = found.start()
    for pattern in step.writes:
        new = [path for path in desk.glob(pattern) if before.get(path) != path.stat().st_mtime_ns]
        assert new and all(path.stat().st_size for path in new), f"not written: {pattern}\n{said}"
    print(f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - began:6.1f} s of CPU: {step.command}")


@pytest.mark.slow
def test_what_is_installed_is_the_wheel_alone(environment, tmp_path):
    output = environment.run("python -c 'import reports; print(reports.__file__)'; slip-to-roll --version", tmp_path)
    place, version = output.stdout.splitlines()
    assert Path(place).is_relative_to(environment.folder) and version == f"slip-to-roll {cases.__version__}"
    output = environment.run("python -m pip check", tmp_path)
    assert output.returncode == 0, output.stdout


@pytest.mark.slow
def test_the_readme_is_walked(environment, tmp_path):
    walk(WALK["README.md"], environment, tmp_path)


@pytest.mark.slow
def test_the_code_of_the_readme_gives_what_its_comments_say(environment, tmp_path):
    """Each expression of the first block with a comment of values: they are what it evaluates to."""
    lines = block("README.md", "python").splitlines()
    shown = [line.partition("  # ") for line in lines if "  # " in line and "=" not in line.partition("  # ")[0]]
    code = "\n".join(lines) + "\n" + "\n".join(f"print(repr(({expression})))" for expression, _, _ in shown)
    (tmp_path / "readme.py").write_text(code)
    output = environment.run("python readme.py", tmp_path)
    assert output.returncode == 0, output.stderr
    values = dict(zip([expression for expression, _, _ in shown], output.stdout.splitlines(), strict=True))
    comments = {expression: comment for expression, _, comment in shown}
    first = "motion.transitions[0]"
    assert values[first] == comments[first]
    assert values["motion.status, motion.reason"].startswith("('completed', 'The motion ran to its end.")


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in WALK if name != "README.md"])
def test_a_page_is_walked(name, environment, tmp_path):
    walk(WALK[name], environment, tmp_path)


@pytest.mark.slow
def test_every_module_and_every_data_file_is_in_the_wheel():
    here = {
        file.relative_to(ROOT).as_posix()
        for room in ROOMS
        for file in (ROOT / room).rglob("*")
        if file.suffix in (".py", *DATA)
    }
    assert {Path(name).suffix for name in here} == {".py", *DATA}
    assert here <= set(zipfile.ZipFile(wheel()).namelist())


def copy_sources(folder: Path) -> set[str]:
    """Copy what `git` knows of, but for files of the forge and of editors; returns the names."""
    output = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if output.returncode:
        pytest.skip("this is no clone")
    known = {name for name in output.stdout.splitlines() if not name.startswith((".git", ".pre-commit"))}
    for name in known:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    return known


@pytest.mark.slow
def test_the_tutorial_is_followed_from_top_to_bottom(tmp_path):
    """Its commands and its code, in a copy of the sources with an environment of its own."""
    copy_sources(tmp_path)
    (page,) = [path for path in PAGES if path.name == "tutorial.md"]
    code = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.S)
    (tmp_path / "tutorial.py").write_text("\n".join(code), encoding="utf-8")
    # The versions that were tried together, as `make` installs them.
    more = {"PIP_CONSTRAINT": str(CONSTRAINTS), "PIP_QUIET": "1", "PIP_NO_COMPILE": "1"}
    script = f"set -e\n{block('tutorial.md', 'sh')}python tutorial.py"
    output = Environment.existing(Path(sys.prefix)).run(script, tmp_path, more)
    assert output.returncode == 0, output.stderr
    for text in ("slides forward for 0.63 s, then rolls", "0.1 slides forward", "good"):
        assert text in output.stdout
    assert (tmp_path / ".venv").is_dir() and (tmp_path / "mine.csv").is_file()


@pytest.mark.slow
def test_the_source_distribution_holds_the_tests_too(tmp_path):
    known = copy_sources(tmp_path / "source")
    build = f"from setuptools import build_meta; print(build_meta.build_sdist({str(tmp_path)!r}))"
    subprocess.run([sys.executable, "-c", build], cwd=tmp_path / "source", check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        inside = {name.partition("/")[2] for name in packed.getnames()}
    assert known <= inside, known - inside
