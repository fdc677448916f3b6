"""Where rigid Coulomb contact has no motion, one or several: a rod that slides on a floor, and on a floor and a wall.

The rod is that of `ladder_at_wall`: thin, homogeneous, of length 2 h, at the angle θ to the floor, turning towards it
with ω; Ω = ω² h/g. With s = sin θ, c = cos θ and forces per weight, its accelerations with both ends in contact are
linear in N_A (floor) and N_B (wall); eliminating them gives the boundaries of `BOUNDARIES`.

The floor alone is Painlevé's problem; its bounds are those of `painleve_rod`. (That with a floor alone either no motion
or several follow beyond it is known from Hogan & Kristiansen, Proc. R. Soc. A 473, 2017, doi 10.1098/rspa.2016.0773,
abstract looked up. The boundaries are derived here.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import cos, pi, sin, sqrt
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

import cases
from reference.solver.decide import motions_in
from reports.analysis.columns import Table
from reports.drawing.figure_files import FigureEntry, save
from reports.running.calls import Calls, StorePolicy
from reports.studies import Request

TITLE = "Where rigid contact has no, one or several motions"

TABLES = {
    "uniqueness": Table(
        "Motions of a sliding rod that rigid Coulomb contact allows, counted over friction and angle",
        {
            "scene": "what the rod touches",
            "spin": "Ω = ω² h/g: ω the angular velocity, 2 h the length of the rod",
            "motions": "number of consistent motions",
            "modes": "the ends of the rod that stay in contact, for each of them",
            "states": "number of states on the grid",
            "share": "its fraction of the scene's states",
            "least_mu": "the smallest coefficient of friction among them",
            "greatest_mu": "the largest one",
        },
    )
}

FLOOR, BOTH = "floor", "floor and wall"
# Ω of the panels: the floor alone lifts a rod of Ω > 1 at some angles.
SPINS = (0.5, 1.5, 3.0)
# Middles of cells, so that no state lies on a boundary to rounding. Coefficients at both ends are the same.
MUS = (np.arange(24) + 0.5) * 0.125
ANGLES = (np.arange(30) + 0.5) * (0.5 * pi / 30)
# With the floor alone the rod is this far from the wall, in m.
AWAY = 1.0


class Boundary(NamedTuple):
    """A boundary in the map: its name, the scenes that have it, and μ over (θ, Ω); NaN where there is none."""

    name: str
    scenes: tuple[str, ...]
    mu: Callable[[np.ndarray, float], np.ndarray]


def painleve_mu(theta: np.ndarray, spin: float = 0.0) -> np.ndarray:
    """μ above which the floor's normal force pulls the sliding end in: 1 + 3 c² = 3 μ s c, least 4/3 at tan θ = 2."""
    s, c = np.sin(theta), np.cos(theta)
    return np.asarray((1.0 + 3.0 * c * c) / (3.0 * s * c))


def locking_mu(theta: np.ndarray, spin: float = 0.0) -> np.ndarray:
    """μ = √2 at every angle: the inertia (1 + μ²)/3 + 1 − μ² of a rod that slides at both ends is 0."""
    return np.full_like(theta, sqrt(2.0))


def wall_mu(theta: np.ndarray, spin: float) -> np.ndarray:
    """μ at which the wall's normal force is 0 while both ends slide: c (4 Ω − 3 s) = μ (1 − 3 s² + 2 Ω s)."""
    s, c = np.sin(theta), np.cos(theta)
    mu = c * (4.0 * spin - 3.0 * s) / (1.0 - 3.0 * s * s + 2.0 * spin * s)
    return np.where(mu > 0.0, mu, np.nan)


BOUNDARIES = (
    Boundary("Painlevé's bound", (FLOOR, BOTH), painleve_mu),
    Boundary("μ = √2", (BOTH,), locking_mu),
    Boundary("no force at the wall", (BOTH,), wall_mu),
)


class StateRow(NamedTuple):
    """One state of the map: its scene, Ω, coefficient of friction, angle (rad), and the ends in contact per motion."""

    scene: str
    spin: float
    mu: float
    theta: float
    motions: tuple[str, ...]


def sliding_rod(scene: str, spin: float, theta: float) -> list[float]:
    """x, y, θ, vx, vy, ω of the rod of `ladder_at_wall` that slides with its lower end away from the wall."""
    half, g = 1.0, 9.81
    omega, s, c = sqrt(spin * g / half), sin(theta), cos(theta)
    x = half * c + (AWAY if scene == FLOOR else 0.0)
    return [x, half * s, pi - theta, half * omega * s, -half * omega * c, omega]


def count(scene: str, spin: float, mus: Sequence[float], angles: Sequence[float]) -> list[StateRow]:
    """The consistent motions of all those states."""
    results = []
    for mu in mus:
        case = cases.load("ladder_at_wall", mu=mu, mu_wall=mu)
        for theta in angles:
            motions = motions_in(case, sliding_rod(scene, spin, theta))
            results.append(StateRow(scene, spin, mu, theta, tuple(sorted(map(_ends, motions)))))
    return results


def _ends(modes: dict[str, cases.Mode]) -> str:
    """Which ends stay in contact."""
    names = {"plate/track": "floor", "plate/wall": "wall"}
    closed = [names[contact] for contact, mode in modes.items() if mode is not cases.Mode.FLIGHT]
    return " and ".join(closed) or "none"


def run(request: Request, calls: Calls) -> list[StateRow]:
    """The states of all panels, computed in one call for each."""
    panels = [(scene, spin, MUS.tolist(), ANGLES.tolist()) for scene in (FLOOR, BOTH) for spin in SPINS]
    answers = calls.all("map of uniqueness", count, panels, keep=StorePolicy())
    for answer in answers:
        if answer.outcome != "done":
            raise RuntimeError(answer.reason)
    return [row for answer in answers for row in answer.value]


def rows(findings: list[StateRow]) -> dict[str, list[dict[str, Any]]]:
    """For each panel and set of motions: number of states, and the range of friction."""
    panels: dict[tuple[str, float], list[StateRow]] = {}
    for row in findings:
        panels.setdefault((row.scene, row.spin), []).append(row)
    table = []
    for (scene, spin), states in panels.items():
        for motions in sorted({row.motions for row in states}, key=lambda motions: (len(motions), motions)):
            mus = [row.mu for row in states if row.motions == motions]
            table.append(
                {
                    "scene": scene, "spin": spin, "motions": len(motions), "modes": "; ".join(motions),
                    "states": len(mus), "share": len(mus) / len(states),
                    "least_mu": min(mus), "greatest_mu": max(mus),
                }
            )  # fmt: skip
    return {"uniqueness": table}


def draw(findings: list[StateRow], folder: Path) -> Iterator[FigureEntry]:
    """Write the figure: a panel for each scene and Ω; yields its entry."""
    from matplotlib import pyplot as plt
    from matplotlib.artist import Artist
    from matplotlib.colors import ListedColormap
    from matplotlib.lines import Line2D
    from matplotlib.patches import Rectangle

    from reports.drawing.style import AREAS, STYLE

    colours = AREAS[1], "white", AREAS[0]
    styles: tuple[Literal["-", "--", ":", "-."], ...] = ("-", "--", ":", "-.")
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, len(SPINS), figsize=(9.6, 5.8), sharex=True, sharey=True, layout="constrained")
        for ax, (scene, spin) in zip(axes.flat, [(a, b) for a in (FLOOR, BOTH) for b in SPINS], strict=True):
            counts = {(r.mu, r.theta): len(r.motions) for r in findings if (r.scene, r.spin) == (scene, spin)}
            grid = np.array([[counts.get((mu, theta), np.nan) for theta in ANGLES.tolist()] for mu in MUS.tolist()])
            ax.pcolormesh(
                np.degrees(ANGLES), MUS, grid, cmap=ListedColormap(colours), vmin=-0.5, vmax=2.5, rasterized=True
            )
            theta = np.linspace(0.01, 0.5 * pi - 0.01, 400)
            for boundary, style in zip(BOUNDARIES, styles, strict=False):
                if scene in boundary.scenes:
                    mu = boundary.mu(theta, spin)
                    ax.plot(np.degrees(theta), np.where(mu < 4.0, mu, np.nan), "k", linestyle=style, linewidth=1.0)
            if spin > 1.0:  # Ω sin θ = 1: the rod would leave the floor
                ax.axvline(np.degrees(np.arcsin(1.0 / spin)), color="black", linestyle="-.", linewidth=1.0)
            ax.set_title(f"{scene}, Ω = {spin:g}")
            ax.set_ylim(0.0, 3.0)
        handles: list[Artist] = [Rectangle((0, 0), 1, 1, facecolor=colour, edgecolor="black") for colour in colours]
        handles += [Line2D([], [], color="black", linestyle=style) for style in styles]
        labels = ["no motion", "one", "two", *(boundary.name for boundary in BOUNDARIES), "Ω sin θ = 1"]
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
        figure.supxlabel("angle θ between rod and floor / °")
        figure.supylabel("friction coefficient μ at both ends")
        yield save(figure, folder, "uniqueness", "", TITLE, _CAPTION)


_CAPTION = (
    "A homogeneous rod slides with its lower end away from the wall, at 720 states per panel; Ω = ω² h/g with the "
    "angular velocity ω and half the length h. Colours: number of motions by enumeration of all modes. Lines: exact "
    "boundaries; at Ω sin θ = 1 a rod without forces would leave the floor. The motion is unique for every μ ≤ 4/3, "
    "with a wall and without (Painlevé's rod). With a wall and μ > √2, every angle flatter than Painlevé's steeper "
    "bound has none or two."
)
