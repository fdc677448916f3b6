"""Cases and motions for readers: short words, tables, pictures and films of the right thing; nobody pays who does not
draw."""

import subprocess
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import cases
import reference
from adapters.common import motion_table
from adapters.common.motion_file import trajectory_of
from cases import BadValue, UnknownName
from cases.pictures import animation, plots
from cases.pictures.layout import CORNERS
from cases.pictures.style import FORCE
from reports import animate

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


def test_a_quantity_is_drawn_into_axes_that_are_given():
    left, right = Figure().subplots(1, 2)
    assert MOTION.plot(ax=left) is left and MOTION.plot("x", ax=right) is right
    assert [ax.get_ylabel() for ax in (left, right)] == [plots.LABELS[name] for name in ("slip", "x")]
    assert np.allclose(left.lines[0].get_xydata(), MOTION.to_frame()[["t", "slip"]])
    with pytest.raises(BadValue, match="give one"):
        MOTION.plot("x", "y", ax=left)


def test_modes_and_slip_of_several_contacts_are_those_of_the_first():
    """Of three discs in a pile, "slip v > 0" stood over a slip of -0.047 m/s: another contact's words."""
    motion = reference.simulate(cases.load("pile_of_discs", mu=0.08))
    name = motion.contact_names[0]
    above, below = motion.plot("slip", "y").axes[-2:]
    words = [text.get_text() for text in above.texts]
    first = motion.of(name)
    assert words == [plots.MODE_WORDS[mode] for mode in (first.first_mode, *(t.after for t in first.transitions))]
    assert above.get_ylabel() == f"slip velocity v / (m/s)\nat {name}" and below.get_ylabel() == "Y / m"


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


@pytest.mark.parametrize("name", ["dominoes", "disc_on_free_disc", "stack_of_boxes", "box_off_conveyor"])
def test_a_film_shows_every_plate_and_the_force_where_it_acts(name):
    motion = reference.simulate(cases.load(name))
    figure, show = motion.animate()._frames()
    left = figure.axes[0]
    for time in (0.0, 0.9 * motion.t[-1]):
        show(time)
        centres = [[body.get_xy()[:, i].min() + body.get_xy()[:, i].max() for i in range(2)] for body in left.patches]
        poses = [motion.plate(plate)(time) for plate in motion.plate_names]
        # The outlines are symmetric about their centres of mass.
        assert 0.5 * np.array(centres) == pytest.approx(np.array([[p.x, p.y] for p in poses]), abs=0.02)
        (low, high), (bottom, top) = left.get_xlim(), left.get_ylim()
        assert all(low < p.x < high and bottom < p.y < top for p in poses)
    now = motion(0.9 * motion.t[-1])
    touches = [line.get_xydata() for line in left.lines if line.get_marker() == "o" and line.get_color() == FORCE]
    boundary = {"track": motion.case.track, **motion.case.scene.supports}.get(
        motion.contact_names[0].split("/")[1].split()[0]
    )
    drawn = touches[0] if len(touches[0]) and np.isfinite(touches[0]).all() else None
    exact = boundary.point(now.xi1) if boundary is not None and np.isfinite(now.xi1) else None
    assert (drawn is None) == (exact is None) and (drawn is None or drawn[0] == pytest.approx(exact, abs=1e-12))


def test_what_cannot_be_filmed_is_told_in_a_sentence(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(animation.movies.FFMpegWriter, "isAvailable", lambda: False)
    assert animate.main(["disc_on_line", "mu=0.1", "--out", "film.mp4"]) == 2
    output = capsys.readouterr().err
    assert "ffmpeg is not installed" in output and output.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
