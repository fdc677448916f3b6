"""Cases and motions for readers: short words, tables, pictures and films of the right thing; nobody pays who does not
draw."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import cases
import reference
from adapters.common import motion_table
from adapters.common.motion_file import trajectory_of
from cases import BadValue, UnknownName
from cases.pictures import animation, plots
from cases.pictures.layout import CORNERS
from reports import animate

from ..full_disk import full_disk

pytestmark = pytest.mark.builds

CASE = cases.load("disc_in_circle", mu=0.2)
MOTION = reference.simulate(CASE)


def test_who_computes_loads_nothing_that_draws():
    code = "import sys, cases, reference; reference.simulate(cases.load('disc_on_line')); "
    code += "sys.exit(bool({'matplotlib', 'pandas', 'PIL'} & sys.modules.keys()))"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@pytest.mark.parametrize("name", cases.names()[::5])
def test_a_case_says_itself_in_a_few_words_without_addresses(name):
    for case in cases.select(name)[-1:]:
        for thing in (case, case.track, case.plate):
            assert len(repr(thing)) < 700 and " at 0x" not in repr(thing)
        assert case.label in repr(case)


def test_a_motion_says_itself_in_a_sentence():
    assert repr(MOTION).startswith("<Trajectory of disc_in_circle[mu=0.2]: slides forward for 0.63 s, then rolls")
    assert repr(MOTION).endswith("4 transitions>")
    assert repr(MOTION.transitions[0]) == "Transition(0.630053764 s: slip_forward -> roll, the slip velocity vanished)"
    assert len(repr(MOTION(MOTION.times()))) < 200


def test_a_table_is_dense_where_the_motion_is_known_and_goes_through_its_transitions(tmp_path):
    frame = MOTION.to_frame()
    assert len(MOTION.t) < 100 < 1000 < len(frame)
    assert {t.time for t in MOTION.transitions} <= set(frame["t"])
    assert np.array_equal(MOTION.to_frame(count=5)["t"], np.linspace(0.0, 2.5, 5))
    again = trajectory_of(CASE, motion_table.read(MOTION.to_csv(tmp_path / "motion.csv")))
    assert np.array_equal(again.x, frame["x"]) and np.array_equal(again.slip, frame["slip"])


def test_a_table_of_a_flight_is_read_again(tmp_path):
    """In flight there is no slip: an empty cell."""
    case = cases.load("bouncing_disc", e=0.5)
    motion = reference.simulate(case)
    path = motion.to_csv(tmp_path / "motion.csv")
    assert ",0.0,,0.0,0.0,," in path.read_text()  # omega, slip, both forces, both parameters
    again = trajectory_of(case, motion_table.read(path))
    assert np.isnan(again.slip[1]) and again.slip[-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
def test_a_picture_has_the_quantities_that_were_asked_for_and_a_line_at_each_transition(tmp_path):
    picture = MOTION.plot("slip", "x", "y")
    assert [ax.get_ylabel() for ax in picture.axes[1:]] == [plots.LABELS[name] for name in ("slip", "x", "y")]
    drawn = picture.axes[1].lines[0].get_xydata()
    assert np.allclose(drawn, MOTION.to_frame()[["t", "slip"]])
    at = {time for line in picture.axes[1].lines[1:] for time in line.get_xdata()}
    assert at == {t.time for t in MOTION.transitions}
    for ending in ("svg", "pdf", "png"):
        picture.savefig(tmp_path / f"motion.{ending}")
        assert (tmp_path / f"motion.{ending}").stat().st_size > 5000
    assert "<text" in (tmp_path / "motion.svg").read_text()  # text stays text
    picture.savefig(tmp_path / "motion", dpi=20)  # as Matplotlib has it: a PNG, and called so
    picture.savefig(tmp_path / "motion.picture", format="png", dpi=20)
    assert {file.name for file in tmp_path.iterdir()} == {
        f"motion.{ending}" for ending in ("svg", "pdf", "png", "picture")
    }
    with pytest.raises(UnknownName, match="normal_force"):
        MOTION.plot("normal_froce")


def test_a_picture_shows_the_supports_where_the_plate_passes():
    motion = reference.simulate(cases.load("ladder_at_wall"))
    floor, wall = (line.get_xydata() for line in motion.plot("y").axes[0].lines[:2])
    assert np.all(abs(floor[:, 1]) < 1e-12) and np.all(abs(wall[:, 0]) < 1e-12)
    assert wall[:, 1].min() < 0.0 and wall[:, 1].max() > 2.0 * motion(0.0).y  # its upper end touches


def test_the_roundings_of_a_constant_do_not_fill_its_axis():
    height, spin = plots.plot(reference.simulate(cases.load("box_on_shaken_table")), None, ["y", "omega"]).axes
    assert height.get_ylim() == pytest.approx((0.09, 0.11)) and np.ptp(spin.get_ylim()) > 0.1


def test_a_film_shows_the_plate_where_it_is(tmp_path, monkeypatch):
    film = MOTION.animate()
    figure, show = film._frames()
    body, cursor = figure.axes[0].patches[0], figure.axes[1].lines[-2]
    for time in (0.0, 0.7, 2.5):
        show(time)
        now = MOTION(time)
        assert np.mean(body.get_xy()[: CORNERS - 1], axis=0) == pytest.approx(
            [now.x, now.y], abs=0.01 * CASE.plate.reach
        )
        assert cursor.get_xdata()[0] == time
    monkeypatch.setattr(animation, "FRAMES_A_SECOND", 2)
    with Image.open(film.save(tmp_path / "film.gif")) as pictures:
        assert pictures.n_frames == int(film.seconds * 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "before"), [("film.gif", None), ("motion.csv", "old"), ("motion.png", "old"), ("motion.svg", None)]
)
def test_on_a_full_disk_there_is_the_old_file_or_none(name, before, tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "FRAMES_A_SECOND", 1)
    write = {
        "film.gif": lambda path: MOTION.animate().save(path),
        "motion.csv": lambda path: MOTION.to_csv(path),
        "motion.png": lambda path: MOTION.plot().savefig(path),
        "motion.svg": lambda path: MOTION.plot().savefig(path),
    }[name]
    file = tmp_path / name
    if before:
        file.write_text(before)
    with full_disk(free=5000), pytest.raises(OSError, match="File too large"):
        write(file)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == ([(name, before)] if before else [])
    write(file)
    assert file.stat().st_size > 5000


@pytest.mark.slow
def test_a_command_on_a_full_disk_says_so_and_leaves_no_film(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(animation, "FRAMES_A_SECOND", 1)
    monkeypatch.chdir(tmp_path)
    with full_disk(free=5000):
        assert animate.main(["disc_on_line", "mu=0.1"]) == 1
    assert "File too large" in capsys.readouterr().err and not list(tmp_path.iterdir())


@pytest.mark.parametrize(("lasts", "factor"), [(2.5, 1), (8, 1), (60, 10), (1e-3, 2e-4), (3600, 500)])
def test_a_film_lasts_some_seconds(lasts, factor):
    assert animation._round_factor(lasts) == pytest.approx(factor)
    assert 2 <= lasts / animation._round_factor(lasts) <= 10


def test_what_cannot_be_filmed_is_told_in_a_sentence(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadValue, match="end it in .gif or .mp4"):
        MOTION.animate().save("film.avi")
    monkeypatch.setattr(animation.movies.FFMpegWriter, "isAvailable", lambda: False)
    assert animate.main(["disc_on_line", "mu=0.1", "--out", "film.mp4"]) == 2
    output = capsys.readouterr().err
    assert "ffmpeg is not installed" in output and output.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
