"""The wheel is whole: built, installed in an empty environment, it makes a report from another folder."""

import json
import os
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ROOMS = ("cases", "reference", "adapters", "reports")
# What a room holds beside code.
DATA = (".csv", ".json", ".html", ".css", ".typed")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel, built from a copy of the sources so that nothing is left beside them."""
    pytest.importorskip("setuptools", minversion="77")  # the first that take a licence by its name
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for room in ROOMS:
        shutil.copytree(ROOT / room, source / room, ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, source)
    build = f"from setuptools import build_meta; print(build_meta.build_wheel({str(out)!r}))"
    subprocess.run([sys.executable, "-c", build], cwd=source, check=True, capture_output=True)
    (built,) = out.glob("*.whl")
    return built


@pytest.mark.slow
def test_every_module_and_every_data_file_is_in_the_wheel(wheel):
    here = {
        file.relative_to(ROOT).as_posix()
        for room in ROOMS
        for file in (ROOT / room).rglob("*")
        if file.suffix in (".py", *DATA)
    }
    assert {Path(name).suffix for name in here} == {".py", *DATA}
    assert here <= set(zipfile.ZipFile(wheel).namelist())


@pytest.mark.slow
def test_the_source_distribution_holds_the_tests_too(tmp_path):
    """What `git` knows of, but for files of the forge and of editors."""
    told = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if told.returncode:
        pytest.skip("this is no clone")
    known = {name for name in told.stdout.splitlines() if not name.startswith((".git", ".pre-commit"))}
    for name in known:
        (tmp_path / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / "source" / name)
    build = f"from setuptools import build_meta; print(build_meta.build_sdist({str(tmp_path)!r}))"
    subprocess.run([sys.executable, "-c", build], cwd=tmp_path / "source", check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        inside = {name.partition("/")[2] for name in packed.getnames()}
    assert known <= inside, known - inside


@pytest.mark.slow
def test_an_installed_suite_works_in_any_folder(wheel, tmp_path):
    """pip installs the wheel into an empty environment; its command makes a report and judges a motion elsewhere."""
    venv.create(tmp_path / "env", with_pip=True)
    scripts = tmp_path / "env" / "bin"
    (packages,) = (tmp_path / "env" / "lib").glob("python*/site-packages")
    # What it depends on comes from here: a path in a .pth file is not searched for further ones, such as ours.
    (packages / "borrowed.pth").write_text("\n".join(path for path in sys.path if path.endswith("site-packages")))
    desk = tmp_path / "desk"
    desk.mkdir()
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def run(*words: str) -> str:
        told = subprocess.run(
            [scripts / words[0], *words[1:]], cwd=desk, env=environment, capture_output=True, text=True
        )
        assert told.returncode == 0, told.stderr
        return told.stdout

    run("python", "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--force-reinstall", str(wheel))
    assert str(packages) in run("python", "-c", "import reports; print(reports.__file__)")
    assert run("slip-to-roll", "--version").split()[1] in wheel.name
    assert "disc_in_circle" in run("slip-to-roll", "cases")
    run("slip-to-roll", "report", "--quick", "--case", "disc_on_line", "--solver", "reference", "pymunk")
    manifest = json.loads((desk / "report" / "manifest.json").read_text())
    assert {p.relative_to(desk / "report").as_posix() for p in (desk / "report").rglob("*.*")} == set(manifest["files"])
    assert "<style>" in (desk / "report" / "index.html").read_text()
    # The kept truth is there: a certificate made anew would have been kept in the store as well, seconds later.
    assert "[mu=0.3]" in (desk / "report" / "tables" / "truth.csv").read_text()
    assert "reference: runs it" in run("slip-to-roll", "cases", "show", "disc_on_line")
    write = (
        "import cases, reference, numpy as np; m = reference.simulate(cases.load('disc_on_line'));"
        "t = np.linspace(0, float(m.t[-1]), 801); s = [m(float(x)) for x in t];"
        "print('t,x,y,theta'); print(*(f'{x!r},{float(q.x)!r},{float(q.y)!r},{float(q.theta)!r}'"
        " for x, q in zip(t.tolist(), s)), sep='\\n')"
    )
    (desk / "mine.csv").write_text(run("python", "-c", write))
    assert "mine.csv on disc_on_line: right" in run("slip-to-roll", "compare", "disc_on_line", "mine.csv")
