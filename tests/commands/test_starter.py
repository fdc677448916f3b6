"""The engines in `starter/`: short, complete, and right on three scenes, in each language that this machine has."""

import shutil
import subprocess
import sys
from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path

import numpy as np
import pytest

import cases
from adapters import Setting, lookup
from cases import CoulombFriction, Gravity, NotSupported, Unilateral
from reports.judging.grades import LIMITS, Grade, is_within
from reports.running.tasks import find_truth, measure

FOLDER = Path(__file__).parents[2] / "starter"
SCENES = ("disc_on_line[mu=0.1]", "disc_on_incline[slope=0.4]", "disc_in_circle[mu=0.2]")
# How to make an executable from the source, by its ending; None: the file itself is one.
COMPILERS = {
    "c": ["cc", "-O2", "-Wall", "-Wextra", "-Werror", "-o", "{out}", "{source}", "-lm"],
    "rs": ["rustc", "-O", "-D", "warnings", "-o", "{out}", "{source}"],
    "js": None,
    "py": None,
}
INTERPRETERS = {"js": "node", "py": sys.executable}
LANGUAGES = tuple(COMPILERS)


@cache
def works(tool: str) -> bool:
    """Whether a tool runs here: rustup leaves a `rustc` on PATH that has no compiler in another home folder."""
    return shutil.which(tool) is not None and subprocess.run([tool, "--version"], capture_output=True).returncode == 0


@pytest.fixture(scope="module")
def build_engine(tmp_path_factory):
    """Makes the engine of a language; skips the test where its toolchain is missing."""
    folder = tmp_path_factory.mktemp("starter")

    def build(language: str) -> Path:
        source, out, command = FOLDER / f"engine.{language}", folder / f"starter_{language}", COMPILERS[language]
        tool = command[0] if command else INTERPRETERS[language]
        if not works(tool):
            pytest.skip(f"{tool} is not installed, or does not run here")
        if out.exists():
            return out
        if command:
            words = [word.format(out=out, source=source) for word in command]
            done = subprocess.run(words, capture_output=True, text=True, timeout=300)
            assert done.returncode == 0, done.stderr
        else:
            shutil.copy(source, out)
            out.chmod(0o755)
        return out

    return build


@cache
def truth(label: str):
    return find_truth(cases.load(label))


@pytest.fixture
def run(build_engine, monkeypatch):
    """Runs a scene by the engine of a language, at the finest step of the ladder or at another one (s)."""
    monkeypatch.setenv(lookup.EXECUTABLES, "")

    def perform_finest(language: str, label: str, h: float | None = None):
        name = lookup.register(build_engine(language))
        case = cases.load(label)
        setting = Setting.of(h=h) if h else lookup.engine(name).ladder(case, "process")[-1]
        return measure(case, name, "process", setting, 7, truth(label))

    return perform_finest


def test_there_is_an_engine_in_each_language_of_fewer_than_100_lines():
    files = {file.suffix[1:]: file.read_text().count("\n") for file in FOLDER.iterdir() if file.stem == "engine"}
    assert files.keys() == {*LANGUAGES} and max(files.values()) < 100


@pytest.mark.parametrize(
    ("language", "scene"),
    [  # quick: each language has one scene, and each scene a language
        pytest.param(language, scene, marks=() if (i - k) % len(SCENES) == 0 else pytest.mark.slow)
        for i, language in enumerate(LANGUAGES) for k, scene in enumerate(SCENES)
    ],
)  # fmt: skip
def test_it_is_excellent_on_three_scenes(language, scene, run):
    result = run(language, scene)
    assert (result.outcome, result.grade, result.sequence) == ("answered", "excellent", "same sequence"), result.reason


OTHER_SCENES = {
    "another curve": lambda: cases.load("disc_in_cosine"),
    "no disc": lambda: cases.load("ellipse_on_line"),
    "a start in flight": lambda: cases.load("disc_onto_incline"),
    "another effect": lambda: cases.load("disc_rolling_to_rest"),
    "free plates": lambda: cases.load("disc_on_free_disc"),
    "static friction": lambda: _with_friction(CoulombFriction(0.1, 0.2)),
    "a friction law": lambda: _with_friction(CoulombFriction(FORMULA)),
}
FORMULA = "0.1 + 0.1*exp(-v/0.05)"


def _with_friction(friction: CoulombFriction):
    return replace(cases.load("disc_on_line"), effects=(Gravity(9.81), friction, Unilateral()))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("scene", OTHER_SCENES.values(), ids=OTHER_SCENES)
def test_it_reports_any_other_scene_as_unsupported(language, scene, build_engine, monkeypatch):
    monkeypatch.setenv(lookup.EXECUTABLES, "")
    engine, case = lookup.engine(lookup.register(build_engine(language))), scene()
    model = engine.build(case, "process", engine.ladder(case, "process")[-1])
    with pytest.raises(NotSupported, match="line or a circle"):
        engine.run(model)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_disc_that_does_not_turn_slides_until_it_stops(language, build_engine, monkeypatch):
    """Its inertia is null in the scene; the motion is x = v0 t - mu g t²/2 up to its highest value."""
    monkeypatch.setenv(lookup.EXECUTABLES, "")
    engine, case = lookup.engine(lookup.register(build_engine(language))), cases.load("disc_on_line", mu=0.2)
    case = replace(case, plate=replace(case.plate, inertia=inf), duration=0.8)
    model = engine.build(case, "process", engine.ladder(case, "process")[-1])
    engine.run(model)
    motion = engine.read(model)
    t = np.minimum(motion.t, 1.0 / (0.2 * 9.81))
    # The step in which the disc stops is inexact by mu g h²/2 = 4e-8 m.
    assert np.abs(motion.x - (t - 0.5 * 0.2 * 9.81 * t**2)).max() < 1e-7
    assert np.ptp(motion.theta) == 0.0 and motion.t[-1] > 1.0 / (0.2 * 9.81)


@pytest.mark.parametrize("language", LANGUAGES)
def test_it_ends_where_the_disc_leaves_the_track(language, run):
    # At the ladder's finest step the samples leave 0.11 % in doubt, more than very good allows.
    result = run(language, "disc_rolling_off_hill[mu=0.3]", h=1e-4)
    assert result.outcome == "answered" and is_within(result.score, LIMITS[Grade.VERY_GOOD]), result.reason
    assert result.sequence == "same sequence"
