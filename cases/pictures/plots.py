"""Plots of a motion: the scene, and quantities against time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.colors import is_color_like
from matplotlib.lines import Line2D

from ..curves import Curve
from ..curves.chain import Chain
from ..errors import BadValue, choice
from . import drawn_scene
from .layout import DrawnScene, shown_poses
from .style import FAINT, PLATE, Picture, apply_style

# Axis labels of the quantities that can be plotted against time.
LABELS = {
    "x": "X / m",
    "y": "Y / m",
    "theta": "rotation θ / rad",
    "vx": "X velocity / (m/s)",
    "vy": "Y velocity / (m/s)",
    "omega": "angular velocity / (rad/s)",
    "slip": "slip velocity v / (m/s)",
    "normal_force": "normal force / N",
    "friction_force": "friction force / N",
    "xi1": "track parameter ξ₁",
    "xi2": "outline parameter ξ₂",
}
# Those of a contact; of several contacts the first one's are drawn, with its modes.
_OF_CONTACT = ("slip", "normal_force", "friction_force", "xi1", "xi2")
# Values of a curve's parameter at which its unit is determined, and the relative rounding of the comparison.
_SAMPLES, _ROUNDING = 33, 1e-9
# Roundings of a motion are those of quantities at least this large, in SI units: its positions, speeds and forces.
_LARGE = 1e-3
MODE_WORDS = {
    "slide": "slides",
    "slip_forward": "slip v > 0",
    "slip_backward": "slip v < 0",
    "roll": "rolls",
    "rest": "rests",
    "flight": "flies",
}
# Mean width of a letter of size 8, in points.
_LETTER = 5.0
# Width of a time panel, in points.
_PANEL = 270.0


def parameter_unit(curve: Curve) -> str:
    """The unit of a curve's parameter: "rad" if it is the turning angle, "m" if it is an arc length or a coordinate, ""
    for any other parameter, as of a chain, whose pieces have units of their own."""
    if isinstance(curve, Chain):
        return ""
    s = np.linspace(*curve.span, _SAMPLES)
    with np.errstate(invalid="ignore"):  # at a corner the speed is zero and the curvature infinite
        speed, turning = np.asarray(curve.speed(s)), np.abs(np.asarray(curve.speed(s) * curve.curvature(s)))
    lengths = [speed, *(np.gradient(part, s) for part in curve.point(s))]
    if np.allclose(turning, 1.0, rtol=_ROUNDING):
        return "rad"
    return "m" if any(np.allclose(np.abs(length), 1.0, rtol=_ROUNDING) for length in lengths) else ""


def with_unit(name: str, unit: str) -> str:
    """An axis label: the name of a quantity and its unit, if it has one."""
    compound = "/" in unit
    return name if not unit else f"{name} / ({unit})" if compound else f"{name} / {unit}"


def parameter_labels(scene: DrawnScene) -> dict[str, str]:
    """Axis labels of the two contact parameters of a scene, with their units."""
    curves = {"xi1": scene.track, "xi2": scene.outline}
    return {name: with_unit(LABELS[name], parameter_unit(curve)) for name, curve in curves.items()}


def first_contact(motion: Any) -> Any:
    """The motion of the first contact where there are several: other contacts change their modes at other times."""
    return motion.of(motion.contact_names[0]) if len(motion.contact_names) > 1 else motion


def plot(
    motion: Any, scene: DrawnScene | None, quantities: Iterable[str], colour: str = PLATE, axes: Any = None
) -> Any:
    """Plot the scene (unless None) next to the quantities against time, with lines at the transitions; returns a
    Picture, or `axes`, an Axes of Matplotlib that is given for one quantity.

    Raises UnknownName for a quantity that a motion does not have.
    """
    names = tuple(quantities)
    for name in names:
        choice("quantity of a motion", name, LABELS)
    if not is_color_like(colour):
        raise BadValue(f"the colour is {colour!r}; give a name or a code, such as 'C0' or '#1f77b4'")
    times = motion.times()
    state, first = motion(times), first_contact(motion)
    of_contact, at = (state, "") if first is motion else (first(times), f"\nat {first.contact_names[0]}")
    labels = LABELS | (parameter_labels(scene) if scene else {})

    def panel(ax: Any, name: str, width: float) -> None:
        is_of_contact = name in _OF_CONTACT
        values = np.asarray(getattr(of_contact if is_of_contact else state, name))
        ax.plot(times, values, color=colour)
        _keep_level(ax, values)
        ax.set_ylabel(f"{labels[name]}{at if is_of_contact else ''}")
        ax.margins(x=0)
        mark_transitions(ax, first.transitions, first.first_mode, times[[0, -1]], width)

    if axes is not None:
        if len(names) != 1:
            raise BadValue(f"plot was given one ax and {len(names)} quantities; give one, or no ax")
        panel(axes, names[0], _PANEL)
        axes.set_xlabel("time / s")
        return axes
    with apply_style():
        figure = Picture(figsize=(9.2 if scene else 5.0, max(1.5 * len(names), 3.4)), layout="constrained")
        right: Any = figure
        if scene is not None:
            left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.15), squeeze=False)[0]
            _scene(left.subplots(), scene, motion, times, state)
        panels = right.subplots(max(len(names), 1), 1, sharex=True, squeeze=False)[:, 0]
        for i, (ax, name) in enumerate(zip(panels, names, strict=False)):
            panel(ax, name, _PANEL if i == 0 else 0.0)
        panels[-1].set_xlabel("time / s")
        right.align_ylabels()
    return figure


def _keep_level(ax: Any, values: np.ndarray) -> None:
    """Give a constant an axis of its own size: its roundings would fill a narrower one."""
    shown = values[np.isfinite(values)]
    largest = float(np.abs(shown).max(initial=0.0))
    if shown.size and float(np.ptp(shown)) <= _ROUNDING * max(largest, _LARGE):
        middle, room = float(np.median(shown)), 0.1 * (largest if largest > _ROUNDING * _LARGE else 1.0)
        ax.set_ylim(middle - room, middle + room)


def _scene(ax: Any, scene: DrawnScene, motion: Any, times: np.ndarray, state: Any) -> None:
    poses, others = shown_poses(motion, times, state, most=6)
    drawn_scene.draw(ax, scene, np.array([state.x, state.y]), state.xi1, poses, others)
    ax.set_title(scene.label, loc="left", fontweight="bold")


def mark_transitions(ax: Any, transitions: Sequence, first_mode: str | None, span, width: float = 0.0) -> None:
    """Draw lines at the transitions and, if `width` (of the axis, in points) is positive, the modes in words."""
    times = [t.time for t in transitions]
    # One path for all: for each line of its own, Matplotlib would compute the limits of the axes.
    places, heights = np.repeat(times, 3), np.tile([0.0, 1.0, np.nan], len(times))
    ax.add_artist(Line2D(places, heights, transform=ax.get_xaxis_transform(), color=FAINT, linewidth=0.7, zorder=0.5))
    if not width:
        return
    edges = [float(span[0]), *times, float(span[1])]
    modes = [first_mode, *(t.after for t in transitions)]
    for mode, left, right in zip(modes, edges[:-1], edges[1:], strict=False):
        word = MODE_WORDS[mode] if mode is not None else ""
        # Omit a word that is wider than its interval.
        if word and (right - left) * width > _LETTER * len(word) * (edges[-1] - edges[0]):
            ax.annotate(
                word, (0.5 * (left + right), 1.0), (0, 3), xycoords=("data", "axes fraction"),
                textcoords="offset points", ha="center", color="#555555", fontsize=8,
            )  # fmt: skip
