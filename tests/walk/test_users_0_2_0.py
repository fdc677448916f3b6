"""Files of users of version 0.2.0, unchanged, with the package that is installed: code, commands, engines, motions.

`users_0_2_0.zip` was written with the code of commit 43ab33a3. It has README and docs, `starter/`, `examples/`, scripts
of four new users, labels of all cases, a case file, exported scenes with their motions, and a submission.

All of them run unchanged. One that cannot any more must end with one line that says what to type, and be in
CHANGELOG.md; at most five may.
"""

import json
import re
import sys
import zipfile
from dataclasses import replace
from math import isclose
from pathlib import Path

import pytest

import cases
from reports import export
from reports.comparison import compare

from ..docs.test_docs import cells_shown, codes, desk  # noqa: F401 - a fixture
from . import replay
from .installed import Environment
from .pages import WALK, Left, Page, Step, commands
from .test_walk import check_step, environment, walk, works  # noqa: F401 - a fixture

ARCHIVE = Path(__file__).with_name("users_0_2_0.zip")
# Exported with 101 points of each curve: one scene with each kind of track, plate, effect and number of contacts.
EXPORTS = (
    "disc_in_circle[mu=0.2]", "disc_on_line[mu=0.1]", "disc_in_cosine", "disc_on_conveyor", "disc_rolling_to_rest",
    "stribeck_disc", "pebble_on_incline", "sliding_box", "dropped_box", "box_on_shaken_table", "disc_in_v_of_belts",
    "pile_of_discs",
)  # fmt: skip
POINTS = 101
SUBMISSION = "submissions/my_engine/2.1.0"


def page_names(language: str = "") -> set[str]:
    """The names of the pages in the archive, or of those with blocks of a language."""
    root = zipfile.Path(ARCHIVE)
    pages = [root / "README.md", *(path for path in (root / "docs").iterdir() if path.name.endswith(".md"))]
    return {page.name for page in pages if not language or codes(page, language)}


def unpack(folder: Path) -> None:
    """Put the files of the archive into a folder."""
    with zipfile.ZipFile(ARCHIVE) as archive:
        archive.extractall(folder)


# Commands, patterns of what they print: each of the user's files with the command that reads it.
VALLEY = (
    r"^my_valley: fits; slides forward for 0\.87 s, then rolls for 0\.022 s, then slides backward to the end of 2 s"
)
WHEEL = "cd examples/magnetic_wheel && "
STEPS = {
    "a template": Step("python -m cases check my_valley.py", (VALLEY,)),
    "an effect of a package": Step(
        f"{WHEEL}python -m cases check magnetic_wheel.py", (r"^magnetic_wheel_in_loop: fits; rolls to the end of 2 s$",)
    ),
    "its law": Step(
        f"{WHEEL}python -c 'import magnetic_wheel_laws as laws, adapters.laws; print(laws.magnet_braking.__doc__)'",
        (r"^A wheel that slides on a level line",),
    ),
    "a submission": Step(
        f"python -m reports.submit {SUBMISSION}",
        (
            r"^my_engine 2\.1\.0, by Ada Example",
            r"^disc_in_circle\[mu=0\.2\] +answered +excellent",
            r"^disc_on_incline\[slope=0\.4\] +answered +excellent",
            r"^disc_on_line\[mu=0\.1\] +answered +excellent",
        ),
    ),
    "engines": Step(
        "pytest -q -p no:cacheprovider --slip-to-roll-engine ./engine_py --slip-to-roll-engine ./engine_c",
        (r"\b10 passed, 4 skipped in ",),
        needs="cc",
        before="cc -O2 -o engine_c starter/engine.c -lm && cp starter/engine.py engine_py && chmod +x engine_py",
    ),
    "an engine in JavaScript": Step(
        "pytest -q -p no:cacheprovider --slip-to-roll-engine ./engine_js",
        (r"\b5 passed, 2 skipped in ",),
        needs="node",
        before="cp starter/engine.js engine_js && chmod +x engine_js",
    ),
    "an engine in Rust": Step(
        "pytest -q -p no:cacheprovider --slip-to-roll-engine ./engine_rs",
        (r"\b5 passed, 2 skipped in ",),
        needs="rustc",
        before="rustc -O -o engine_rs starter/engine.rs",
    ),
}
# The commands of its pages by the names that today's pages have. What is run is the older form.
TODAY = {
    "python -m reports.build": "slip-to-roll report",
    "python -m reports.compare": "slip-to-roll compare",
    "python -m reports.animate": "slip-to-roll cases film",
    "python -m reports.study": "slip-to-roll report study",
    "python -m reports.submit": "slip-to-roll compare",
    "python -m reports.sweep": "slip-to-roll sweep",
    "python -m reports.publish": "slip-to-roll release publish",
    "python -m adapters.laws": "slip-to-roll laws",
    "python -m reference.proof_checker": "slip-to-roll prove check",
    "python -m reference --prove": "slip-to-roll prove",
    "python -m cases": "slip-to-roll cases",
}
# Commands of its pages that today's pages do not have any more.
ONLY_THERE: dict[str, Step | Left] = {
    "python -m reports.compare_builds report report --solver pymunk@6.11.1 --solver pymunk@7.3.1": Left(
        "python -m reports.compare report report --solver pymunk@6.11.1 --solver pymunk@7.3.1",
        "an older name of compare; it reads a report of two versions",
    ),
    "slip-to-roll gate --baseline A --solver exudyn --worse-than 10%": Left(
        "slip-to-roll compare A report --solver exudyn --worse-than 10%",
        "an older name of compare; A stands for a report of the reader's",
    ),
    "python -m reports.study stability --paper": Left(
        "slip-to-roll report study stability", "a study has no figures, so it has no option --paper any more"
    ),
    "python -m reports.history": Left(
        "python -m reports.history", "it installs 40 versions; tests/reports/test_history.py runs two"
    ),
    "python -m tests.scenes.point_set_figure point_sets.png": Left(
        "python -m tests.scenes.point_set_figure point_sets.png", "it draws a figure of the documentation, in a clone"
    ),
    "python -m reports.gate": Left("python -m reports.gate", "tests/reports/test_gate.py runs it"),
    "python -m reference --prove disc_in_circle": Left(
        "slip-to-roll prove disc_in_circle", "the page of proofs does it"
    ),
    "python -m reports.study paper": Left(
        "python -m tests.benchmarks paper", "it says what to type in a clone: tests/commands/test_invalid_input.py"
    ),
    "python -m reports.page.vendor": Left("python -m tests.browser.vendor", "it downloads packages into a clone"),
    "python -m reports.study effect_costs": Left("slip-to-roll report study", "it is gone"),
    "python -m reports.studies.meanings": Left(
        "python -m tests.benchmarks.meanings", "it writes a page of the repository, in a clone"
    ),
    "slip-to-roll deposit docs/results/0.2.0": Left(
        "slip-to-roll release deposit docs/results/0.2.0", "an older name, of a folder in a clone"
    ),
    "slip-to-roll completion bash": Left(
        "slip-to-roll completion bash", "it is gone, and says what to type: tests/commands/test_invalid_input.py"
    ),
}
# Commands of its scripts that fail today, with their exit status: a report writes no LaTeX, as CHANGELOG says.
CHANGED = {"paper": {"$ ls report/figures/*.pdf report/tables/verdict.tex": 2, "$ cat report/tables/verdict.tex": 1}}
# The last digits of a number in a scene: computed points differ between machines by some roundings.
ROUNDING = 1e-12


@pytest.fixture(scope="session")
def archive(tmp_path_factory) -> Path:
    """A folder with the files, which no test changes."""
    folder = tmp_path_factory.mktemp("archive")
    unpack(folder)
    return folder


@pytest.fixture
def own_files(tmp_path) -> Path:
    """A folder with the files, for one test."""
    unpack(tmp_path)
    return tmp_path


def pages_in(folder: Path) -> list[Path]:
    return [folder / "README.md", *sorted((folder / "docs").glob("*.md"))]


@pytest.mark.parametrize("name", sorted(page_names("python")))
def test_code_of_a_page_runs_from_top_to_bottom(name, archive, desk):  # noqa: F811
    (path,) = [path for path in pages_in(archive) if path.name == name]
    names: dict = {"__name__": "page"}
    for number, code in enumerate(codes(path, "python"), start=1):
        exec(compile(code, f"{path.name} of 0.2.0, block {number}", "exec"), names)


@pytest.mark.slow
def test_the_gallery_runs_and_shows_itself(archive, desk):  # noqa: F811
    assert len(cells_shown(archive / "docs" / "gallery.ipynb")) > 25


def test_every_case_has_its_name_and_parameters(archive):
    labels = (archive / "labels.txt").read_text(encoding="utf-8").splitlines()
    assert len(labels) == 179
    assert [cases.load(label).label for label in labels] == labels


@pytest.mark.parametrize("row", STEPS)
def test_a_command_reads_a_file(row, own_files):
    step, installed = STEPS[row], Environment.existing(Path(sys.prefix))
    if step.needs and not works(step.needs, installed, own_files):
        pytest.skip(f"there is no {step.needs} that starts")
    check_step(step, installed, own_files)


@pytest.mark.parametrize("label", EXPORTS)
def test_an_exported_motion_is_still_true(label, archive):
    """Its samples may leave the grade undecided; they never make it wrong."""
    (run,) = compare(cases.load(label), before=archive / "exported" / label / "motion.csv").runs
    assert run.outcome == "answered" and run.score.off < 1e-5, run.reason


# Contacts of plates with corners are read from poses now: CHANGELOG.
CHANGED_KEYS = {"scene.several_contacts was False and is True"}


@pytest.mark.parametrize("label", EXPORTS)
def test_a_scene_has_every_key_and_number_that_it_had(label, archive, tmp_path):
    """So an engine that reads the scene of 0.2.0 reads today's: keys may be added, none may go or change."""
    export.export(cases.load(label), tmp_path, points=POINTS)
    before, after = ((folder / "scene.json") for folder in (archive / "exported" / label, tmp_path))
    lost = set(differences(json.loads(before.read_text()), json.loads(after.read_text())))
    assert lost <= CHANGED_KEYS, "\n".join(lost)
    for name in ("track.csv", "outline.csv"):
        texts = ((folder / name).read_text().splitlines() for folder in (archive / "exported" / label, tmp_path))
        assert len({(rows[0], len(rows)) for rows in texts}) == 1


def differences(before, after, place: str = "scene"):
    """What a value of a JSON file has lost, in lines."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key, value in before.items():
            if key not in after:
                yield f"{place}.{key} is gone"
            else:
                yield from differences(value, after[key], f"{place}.{key}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for i, pair in enumerate(zip(before, after, strict=True)):
            yield from differences(*pair, f"{place}[{i}]")
    elif isinstance(before, float) and isinstance(after, int | float):
        if not isclose(before, after, rel_tol=ROUNDING, abs_tol=ROUNDING):
            yield f"{place} was {before!r} and is {after!r}"
    elif before != after:
        yield f"{place} was {before!r:.80} and is {after!r:.80}"


def step_of(command: str) -> Step | Left:
    """The step of a command of 0.2.0: what today's command prints and writes. KeyError for none."""
    known = {step.command: step for page in WALK.values() for step in page.steps} | ONLY_THERE
    if command in known:
        return known[command]
    for older, newer in TODAY.items():
        if (step := known.get(command.replace(older, newer))) is not None:
            # What a command suggests has the form in which it was called.
            more = (
                {"prints": tuple(text.replace(newer, older) for text in step.prints)} if isinstance(step, Step) else {}
            )
            return replace(step, command=command, **more)
    raise KeyError(command)


def test_every_command_of_its_pages_is_walked(archive):
    assert all(map(step_of, {command for path in pages_in(archive) for command in commands(path)}))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(WALK.keys() & page_names()))
def test_a_page_of_0_2_0_is_walked(name, environment, archive, tmp_path):  # noqa: F811
    """Its commands in their order, with its own blocks as files."""
    (path,) = [path for path in pages_in(archive) if path.name == name]
    page = Page(tuple(map(step_of, commands(path))), WALK[name].files)
    walk(page, environment, tmp_path, pages_in(archive))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ci", "engine", "lecture", "paper"])
def test_a_script_of_0_2_0_runs(name, environment, archive, tmp_path):  # noqa: F811
    """Each command with the exit status that its record has, or that of a change."""
    record, *_ = replay.run(name, environment, tmp_path, archive / "newcomers")
    before = (archive / "newcomers" / f"{name}.txt").read_text(encoding="utf-8")
    kept = [re.findall(r"^\$ .*|^\[exit status .*", text, flags=re.M) for text in (record, before)]
    status, expected = CHANGED.get(name, {}), list[str]()
    for line in kept[1]:
        expected += [line, f"[exit status {status[line]}]"] if line in status else [line]
    assert kept[0] == expected and "Traceback" not in record
