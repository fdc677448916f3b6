"""Animations of motions: GIF with Pillow, MP4 with ffmpeg, both drawn by Matplotlib."""

from __future__ import annotations

import subprocess
import tempfile
from base64 import b64encode
from collections.abc import Callable, Sequence
from math import floor, log10
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import animation as movies
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from ..curves import Curve
from ..errors import BadValue, choice, positive
from ..files.owned_folder import atomic_path
from . import MADE_BY, drawn_scene, layout
from .layout import DrawnScene
from .plots import LABELS, MODE_WORDS, first_contact, mark_transitions
from .style import FAINT, FORCE, PLATE, Picture, apply_style

# Frames per second: smooth, and a whole number of hundredths of a second per frame, which is the time unit of a GIF.
FRAMES_A_SECOND = 20
# Default duration of a film in seconds: long enough to follow the motion, short enough for a small file.
_SHORTEST, _LONGEST = 4.0, 8.0
# Dots per inch: a figure of 7 × 3.6 inches is then 560 × 288 pixels.
_DPI = 80
# Length of the force arrow for the plate's weight, as a fraction of the plate's size.
_ARROW = 0.8
KINDS = (".gif", ".mp4")


class Animation:
    """An animation of a motion: `save` writes it, and a notebook displays it.

    `factor`: seconds of the motion per second of film; None: 1 if that makes a film of a few seconds, otherwise a
    round number that does. `quantity`: the quantity plotted against time next to the scene.
    """

    def __init__(self, motion: Any, scene: DrawnScene, weight: float, factor: float | None, quantity: str):
        choice("quantity of a motion", quantity, LABELS)
        self._motion, self._scene, self._weight, self._quantity = motion, scene, weight, quantity
        lasts = float(motion.t[-1] - motion.t[0])
        if not lasts > 0.0:
            raise BadValue(f"the motion of {scene.label} has no duration; there is nothing to animate")
        self.factor = _round_factor(lasts) if factor is None else positive("factor", factor)
        self.seconds = lasts / self.factor

    def __repr__(self) -> str:
        return (
            f"<Animation of {self._scene.label}: {self.seconds:.3g} s{self._speed()}; save(path) writes .gif or .mp4>"
        )

    def _repr_html_(self) -> str:
        with tempfile.TemporaryDirectory() as folder:
            data = b64encode(self.save(Path(folder) / "film.gif").read_bytes()).decode()
        return f'<img alt="{self._scene.label} moving" src="data:image/gif;base64,{data}">'

    def save(self, path: str | Path, replace: bool = True) -> Path:
        """Write the film; returns its path.

        Raises BadValue for an ending other than .gif and .mp4, and for .mp4 if ffmpeg is missing; FileExistsError if
        the file exists and `replace` is false; OSError if it cannot be written, in which case no file is left.
        """
        path = Path(path)
        gif = _check_kind(path)
        with apply_style(), atomic_path(path, replace) as partial:
            figure, show = self._frames()
            times = np.linspace(self._motion.t[0], self._motion.t[-1], max(int(self.seconds * FRAMES_A_SECOND), 2))
            (_save_gif if gif else _save_mp4)(partial, figure, show, [float(time) for time in times])
        return path

    def _speed(self) -> str:
        return "" if self.factor == 1 else f", {self.factor:g} × real time"

    def _frames(self) -> tuple[Picture, Callable[[float], None]]:
        """The first frame, and a function that changes it to the frame of a given time."""
        motion, scene = self._motion, self._scene
        times = motion.times()
        state = motion(times)
        figure = Picture(figsize=(7.0, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1.2, 1.0))
        others = [(motion.plate(one.name), scene.of(one.plate)) for one in motion.case.others]
        paths = [np.array([at.x, at.y]) for at in (state, *(plate(times) for plate, _ in others))]
        _room(left, [scene, *(other for _, other in others)], paths, state.xi1)
        values = getattr(state, self._quantity)
        right.plot(times, values, color=FAINT, linewidth=1.0)
        right.set(xlabel="time / s" + self._speed(), ylabel=LABELS[self._quantity])
        right.margins(x=0)
        first = first_contact(motion)
        mark_transitions(right, first.transitions, first.first_mode, times[[0, -1]], 190.0)
        left.set_title(scene.label, loc="left", fontweight="bold")
        moving = _Moving(left, right, scene, _curve_of_first_contact(motion, scene))
        bodies = [(plate, _Body(left, other)) for plate, other in others]
        size = float(np.ptp(scene.corners(), axis=1).max())
        scale = _ARROW * size / self._weight if self._weight else 0.0

        def show(time: float) -> None:
            now = motion(time)
            for plate, body in bodies:
                body.show(plate(time))
            moving.show(now, time, getattr(now, self._quantity), scale, _mode_at(first, time))

        show(float(times[0]))
        figure.draw_without_rendering()  # compute the layout once instead of in every frame
        figure.set_layout_engine("none")
        return figure, show


class _Body:
    """A plate with a spoke, in the picture of the scene."""

    def __init__(self, left: Any, scene: DrawnScene):
        self._scene = scene
        (self._body,) = left.fill([0], [0], facecolor=(PLATE, 0.25), edgecolor=PLATE, linewidth=1.2)
        (self._spoke,) = left.plot([], [], color=PLATE, linewidth=1.2)
        (self._rim,) = left.plot([], [], "o", color=PLATE, markersize=4)

    def show(self, at: Any) -> None:
        corners, spoke = layout.place_outline(self._scene, at)
        self._body.set_xy(corners.T)
        self._spoke.set_data(*spoke)
        self._rim.set_data(*spoke[:, 1:])


class _Moving:
    """The parts of the picture that change from frame to frame, but for free plates; `curve` has the contact whose
    forces are drawn, None where it is a plate's outline."""

    def __init__(self, left: Any, right: Any, scene: DrawnScene, curve: Curve | None):
        self._body, self._curve = _Body(left, scene), curve
        (self._touch,) = left.plot([], [], "o", color=FORCE, markersize=4)
        (self._normal,) = left.plot([], [], color=FORCE, linewidth=1.8)
        (self._friction,) = left.plot([], [], color=FORCE, linewidth=1.8)
        self._word = left.text(0.99, 1.02, "", transform=left.transAxes, ha="right", color="#555555")
        self._cursor = right.axvline(0.0, color=FORCE, linewidth=1.0)
        (self._here,) = right.plot([], [], "o", color=PLATE, markersize=5)

    def show(self, now: Any, time: float, value: float, scale: float, mode: str | None) -> None:
        self._body.show(now)
        if self._curve is not None:
            self._show_forces(self._curve, now, scale)
        self._word.set_text(MODE_WORDS[mode] if mode else "")
        self._cursor.set_xdata([time, time])
        self._here.set_data([time], [value])

    def _show_forces(self, curve: Curve, now: Any, scale: float) -> None:
        touching = np.isfinite(now.xi1)
        place = curve.point(now.xi1) if touching else np.array([np.nan, np.nan])
        self._touch.set_data(*place[:, None])
        for arrow, force, along in (
            (self._normal, now.normal_force, curve.normal),
            (self._friction, now.friction_force, curve.tangent),
        ):
            tip = place + scale * force * along(now.xi1) if touching else place
            arrow.set_data(*np.column_stack([place, tip]))


def _curve_of_first_contact(motion: Any, scene: DrawnScene) -> Curve | None:
    """The track or support of the contact that a motion's own columns are of; None if it is a plate's outline."""
    if not motion.contact_names:
        return scene.track
    boundary = motion.contact_names[0].partition("/")[2].partition(" ")[0]
    return None if boundary in motion.plate_names else scene.supports.get(boundary, scene.track)


def _mode_at(motion: Any, time: float) -> str | None:
    mode = motion.first_mode
    for transition in motion.transitions:
        if transition.time <= time:
            mode = transition.after
    return mode


def _room(ax: Any, scenes: Sequence[DrawnScene], paths: Sequence[np.ndarray], xi1: np.ndarray) -> None:
    """Draw track and supports, and set the axes so that they contain all plates at all times: their scenes and paths,
    the first plate's first."""
    curves = layout.drawn_curves(scenes[0], paths[0], xi1)
    for points in curves:
        ax.plot(*points, color="black", linewidth=1.6)
    X, Y = np.hstack(curves)
    reach, path = max(float(np.hypot(*one.corners()).max()) for one in scenes), np.hstack(paths)
    room = 0.3 * reach
    ax.set_xlim(min(X.min(), path[0].min() - reach) - room, max(X.max(), path[0].max() + reach) + room)
    ax.set_ylim(min(Y.min(), path[1].min() - reach) - room, max(Y.max(), path[1].max() + reach) + room)
    drawn_scene.finish(ax, scenes[0])


def _round_factor(lasts: float) -> float:
    """1 for a motion of a few seconds, otherwise the factor 1, 2 or 5 × 10ⁿ that makes a film of a few seconds."""
    if _SHORTEST / 2 <= lasts <= _LONGEST:
        return 1.0
    quotient = lasts / _SHORTEST
    power = 10.0 ** floor(log10(quotient))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= quotient * (1 + 1e-9))


def _check_kind(path: Path) -> bool:
    """Whether the file is a GIF; raises BadValue for a kind that cannot be written."""
    if path.suffix.lower() not in KINDS:
        raise BadValue(f"{path.name} ends in {path.suffix or 'nothing'!r}; end it in .gif or .mp4")
    if path.suffix.lower() == ".mp4" and not movies.FFMpegWriter.isAvailable():
        raise BadValue("ffmpeg is not installed, and an MP4 needs it; install it, or write a .gif")
    return path.suffix.lower() == ".gif"


def _save_gif(path: Path, figure: Picture, show: Callable[[float], None], times: list[float]) -> None:
    figure.set_dpi(_DPI)
    canvas, frames = FigureCanvasAgg(figure), []
    for time in times:
        show(time)
        canvas.draw()
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    lasts = 1000 // FRAMES_A_SECOND  # ms
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=lasts, loop=0, comment=MADE_BY.encode())


def _save_mp4(path: Path, figure: Picture, show: Callable[[float], None], times: list[float]) -> None:
    writer = movies.FFMpegWriter(fps=FRAMES_A_SECOND, metadata={"comment": MADE_BY})
    try:
        with writer.saving(figure, str(path), _DPI):
            for time in times:
                show(time)
                writer.grab_frame()
    except subprocess.CalledProcessError as problem:
        raise OSError(f"ffmpeg could not write the film: {problem}") from None
