"""No command deletes or overwrites a file of the user's: every command that writes, with every option that may matter,
in folders that hold files of the user's and of ours."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import HealthCheck, Phase, event, example, given, settings
from hypothesis import strategies as st

from cases import commands
from cases.files.command_line import status
from cases.files.owned_folder import LIST
from cases.pictures import animation
from reports import animate, build, deposit, export, options, publish, show, study, sweep
from reports.drawing.figure_files import FigureEntry, readable_name
from reports.page import pictures

from . import test_publish

QUICK = settings.get_current_profile_name() == "same"
CASE = "disc_on_line[mu=0.1]"
RELEASE = publish.releases()[-1]
BUILD = ["--quick", "--case", CASE, "--solver", "reference"]
SWEEP = ["disc_on_line", "--vary", "v0=1:2:2", "--vary"]
STUDY = ["error_parts", "--case", CASE, "--solver", "reference", "--out", "x"]


def in_cases(run) -> Callable[[list[str]], int]:
    """A command of `python -m cases`."""
    return lambda words: status("cases", run, words)


def no_headline(experiment, folder, paper) -> FigureEntry:
    """A headline that takes no time."""
    for name in ("headline.svg", "headline.png"):
        (folder / name).write_text("<svg></svg>")
    return FigureEntry("headline", experiment.cases[0].label, "A line", "")


class Command(NamedTuple):
    """A command in a folder "x". It may write the files that it has listed itself, in a folder `at` of a `kind`, and
    those that `--force` names."""

    main: Callable[[list[str]], int]
    words: list[str]
    kind: str = ""
    at: str = ""
    forced: tuple[str, ...] = ()
    inside: str = "."


COMMANDS = {
    "build": Command(build.main, [*BUILD, "--out", "x"], "report"),
    "build fresh": Command(build.main, [*BUILD, "--out", "x", "--fresh", "--paper"], "report"),
    "build in it": Command(build.main, BUILD, "report", at="report", inside="x"),
    "build store": Command(build.main, [*BUILD, "--out", "y", "--store", "x"]),
    "study": Command(study.main, STUDY, "study"),
    "study fresh": Command(study.main, [*STUDY, "--fresh", "--paper"], "study"),
    "sweep": Command(sweep.main, [*SWEEP, "mu=0.1:0.2:2", "--out", "x"], "sweep"),
    "sweep fresh": Command(sweep.main, [*SWEEP, "mu=0.1:0.2:2", "--out", "x", "--fresh"], "sweep"),
    "another sweep": Command(sweep.main, [*SWEEP, "mu=0.1:0.3:2", "--out", "x", "--refine", "0.05"], "sweep"),
    "another sweep fresh": Command(sweep.main, [*SWEEP, "mu=0.1:0.3:2", "--out", "x", "--fresh"], "sweep"),
    "publish": Command(publish.main, ["made", "--out", "."], "release"),
    "deposit": Command(deposit.main, [str(RELEASE), "--out", "x/results.zip"]),
    "deposit force": Command(
        deposit.main, [str(RELEASE), "--out", "x/results.zip", "--force"], forced=("results.zip",)
    ),
    "show": Command(in_cases(show.run), [CASE, "--out", "x/map.png"]),
    "show force": Command(in_cases(show.run), [CASE, "--out", "x/map.png", "--force"], forced=("map.png",)),
    "show in it": Command(in_cases(show.run), [CASE], inside="x"),
    "animate": Command(animate.main, [CASE, "--out", "x/film.gif"]),
    "animate force": Command(animate.main, [CASE, "--out", "x/film.gif", "--force"], forced=("film.gif",)),
    "animate in it": Command(animate.main, [CASE], inside="x"),
    "export": Command(in_cases(export.run), [CASE, "--out", "x"]),
    "export force": Command(in_cases(export.run), [CASE, "--out", "x", "--force"], forced=export.FILES),
    "new": Command(commands.main, ["new", "my_valley"], inside="x"),
    "new force": Command(commands.main, ["new", "my_valley", "--force"], forced=("my_valley.py",), inside="x"),
}  # fmt: skip
# What may lie in a folder: names that we write, names like those, and others of the user's.
NAMES = [
    "index.html", "manifest.json", "tables/headline.csv", "tables/mine.csv", "figures/mine.svg", "tables",
    "error_parts.csv", "sweep.json", "map.svg", "map.png", "rows/part-000000000000.parquet", "rows/mine",
    "boundary.parquet", "film.gif", "scene.json", "motion.csv", "disc_on_line.png", "my_valley.py", "report/notes.txt",
    "report/index.html", ".gitignore", ".slip-to-roll", ".slip-to-roll/notes.txt", "constraints.txt", "thesis.tex",
    f"run-{64 * '0'}.npz", "results.zip", ".unfinished-a", ".report.mine.partial", f"{readable_name(CASE)}.gif", LIST,
]  # fmt: skip


# Of these, such as no command writes, and such as some do.
FREE = ["tables/mine.txt", "figures/mine.txt", "rows/mine", "report/notes.txt", ".slip-to-roll/notes.txt", "thesis.tex"]
TAKEN = [name for name in NAMES if name not in (LIST, "tables", ".slip-to-roll")]


@pytest.fixture(scope="module")
def briefly(in_process):
    """Calls are made in this process, and films are short."""
    with in_process(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(animation, "FRAMES_A_SECOND", 1)
        if QUICK:  # the headline is most of the rest
            patch.setattr(pictures, "draw_headline", no_headline)
        yield


# What those without further options leave in a folder.
LEAVE = [name for name in COMMANDS if not name.endswith((" fresh", " force"))]


@pytest.fixture(scope="module")
def made(briefly, tmp_path_factory) -> dict[str, Path]:
    """What each command leaves in an empty folder, and the report that is published."""
    folders = {"made": tmp_path_factory.mktemp("report") / "report"}
    test_publish.made_report(folders["made"])
    with pytest.MonkeyPatch.context() as patch:
        for name in LEAVE:
            command, place = COMMANDS[name], tmp_path_factory.mktemp("made")
            (place / "x").mkdir()
            (place / "made").symlink_to(folders["made"])
            patch.chdir(place / command.inside)
            patch.setattr(options, "STORE", ".slip-to-roll")
            assert command.main(command.words) == 0, name
            folders[name] = place / publish.cases.__version__ if command.kind == "release" else place / "x"
            assert any(folders[name].iterdir()), name
    return folders


def contents(folder: Path) -> dict[Path, bytes]:
    """All ordinary files below a folder; links are not followed."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and not path.is_symlink()}


def ours(folder: Path, kind: str) -> set[Path]:
    """The files that a command of a kind may delete or overwrite: the list, and what is as it says."""
    list_ = folder / LIST
    lines = list_.read_text().split("\n") if list_.is_file() else [""]
    if lines[0] != f"# slip-to-roll {kind}":
        return set()
    pairs = [line.split("  ", 1) for line in lines[1:] if line]
    files = [folder / name for known, name in pairs if digest_of(folder / name) == known]
    return {list_, *(file for file in files if not any(above.is_symlink() for above in (file, *file.parents)))}


def digest_of(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else ""


# Quick: the examples that are written down. Drawn ones as well: where another profile is chosen, as with a seed.
PHASES = (Phase.explicit,) if QUICK else (Phase.explicit, Phase.reuse, Phase.generate)


@pytest.mark.parametrize("name", COMMANDS)
@settings(
    max_examples=100, deadline=None, phases=PHASES,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow, HealthCheck.data_too_large],
)  # fmt: skip
@given(
    before=st.lists(st.sampled_from(LEAVE), max_size=2, unique=True),
    own=st.booleans(),
    theirs=st.lists(st.sampled_from(NAMES), max_size=4, unique=True),
    edited=st.integers(0, 9),
    linked=st.sampled_from(["", "", "tables", "figures", "rows", "report", ".slip-to-roll"]),
)
@example(before=[], own=True, theirs=FREE, edited=0, linked="")
@example(before=[], own=True, theirs=[], edited=9, linked="")
@example(before=[], own=True, theirs=TAKEN, edited=0, linked="tables")
def test_every_file_of_the_users_survives(name, made, monkeypatch, capsys, before, own, theirs, edited, linked):
    """`before`: whose files are copied there first (`own`: this command's last of all), `edited`: how many of them the
    user has changed, `linked`: a folder that has become a link."""
    command = COMMANDS[name]
    with tempfile.TemporaryDirectory() as desk:
        root = Path(desk)
        work, outside = root / "desk", root / "outside"
        x = work / (publish.cases.__version__ if command.kind == "release" else "x")
        x.mkdir(parents=True)
        outside.mkdir()
        for other in [*before, *([name.removesuffix(" fresh").removesuffix(" force")] if own else [])]:
            shutil.copytree(made[other], x, dirs_exist_ok=True, symlinks=True)
        for file in sorted(contents(x).keys() - {x / LIST})[:: max(1, len(contents(x)) // 9)][:edited]:
            file.write_bytes(file.read_bytes() + b"\n")
        for file in theirs:
            path = x / file
            if not path.is_dir() and not any(above.is_file() for above in path.parents):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text("precious")
        if linked and (x / linked).is_dir():
            (x / linked).rename(outside / linked)
            (x / linked).symlink_to(outside / linked)
        shutil.copytree(made["made"], work / "made")
        there = contents(root)
        # A folder of --out that is a link is the folder that it leads to; links inside are not followed.
        free = ours((x / command.at).resolve(), command.kind) | {x / file for file in command.forced}
        monkeypatch.chdir(work / command.inside)
        monkeypatch.setattr(options, "STORE", ".slip-to-roll" if command.inside == "x" else str(root / "store"))
        ended = command.main(command.words)
        event(f"{name}: status {ended}")
        output = capsys.readouterr().err
        assert ended == 0 or output.count("\n") <= 2 and "Traceback" not in output
        after = contents(root)
        lost = [path.relative_to(root) for path in there if path not in free and after.get(path) != there[path]]
        assert not lost, f"{name}: {lost}"
        left = [path for path in after if ".partial" in path.name and path not in there]
        assert not left


def test_a_report_is_written_to_the_folder_that_out_links_to(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(options, "STORE", str(tmp_path / "store"))
    shutil.copytree(made["build"], tmp_path / "disk" / "report")
    (tmp_path / "disk" / "report" / "thesis.tex").write_text("precious")
    (tmp_path / "x").symlink_to("disk/report")
    assert build.main([*BUILD, "--out", "x"]) == 0
    there = tmp_path / "disk" / "report"
    assert (tmp_path / "x").is_symlink() and ours(there, "report") == contents(there).keys() - {there / "thesis.tex"}
    assert (there / "thesis.tex").read_text() == "precious"
