"""Figures of the study: the paper's figures 3 to 12 next to the continued motions, and its closing remark as curves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from reference.paper.application import slip_end

from ...drawing.figure_files import FigureEntry, save
from ...drawing.style import FAINT, STYLE, logarithmic, ordinal
from .measure import COEFFICIENTS, FIGURE_COEFFICIENTS, QUANTITIES, Paper

# Figures 3 and 4 show the slip velocity for the two coefficients; the other quantities follow in pairs up to 11 and 12.
_FIRST_FIGURE = 3


def diagrams(findings: Paper) -> Figure:
    """Figures 3 to 12, each up to v = 0 as in the paper, and next to it the continued motion."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(QUANTITIES), 2 * len(FIGURE_COEFFICIENTS), figsize=(10.4, 9.6), layout="constrained", sharex="col"
        )
        shades = ordinal(len(FIGURE_COEFFICIENTS))
        for i, mu in enumerate(FIGURE_COEFFICIENTS):
            paper, ours, stop, after = findings.curves[mu]
            for row, (name, label) in enumerate(QUANTITIES.items()):
                left, right = axes[row, 2 * i], axes[row, 2 * i + 1]
                left.plot(paper["t"], paper[name], color=shades[i])
                left.set_title(f"figure {_FIRST_FIGURE + 2 * row + i}, μ₀ = {mu:g}")
                left.set_ylabel(label)
                right.plot(ours["t"], ours[name], color=FAINT)
                right.plot(paper["t"], paper[name], color=shades[i])
                right.axvline(stop, color=FAINT, linewidth=0.8, linestyle=":")
                right.set_title(f"continued: {after}" if row == 0 else "continued")
            for ax in axes[-1, 2 * i : 2 * i + 2]:
                ax.set_xlabel("t / s")
        figure.align_ylabels()
    return figure


def remark(findings: Paper) -> Figure:
    """The closing remark as curves over μ₀, with the range in which rolling follows."""
    rows = findings.remark
    mus = np.array([row["mu"] for row in rows])
    rolls = np.array([row["demand"] for row in rows], dtype=float) <= 1.0
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.4, 3.3), layout="constrained")
        panels = (
            ("time", "time of v = 0 / √((R − r)/g)"),
            ("xi1", "ξ₁ there / rad"),
            ("demand", "|T| / (μ₀ N) to roll"),
        )
        reverses, follows = reversed(ordinal(2))
        for ax, (name, label) in zip(axes, panels, strict=True):
            values = np.array([row[name] for row in rows])
            for mask, colour, what in (
                (~rolls, reverses, "then it reverses"),
                (rolls, follows, "then it rolls"),
            ):
                ax.plot(mus[mask], values[mask], color=colour, label=what)
            for mu in COEFFICIENTS:
                ax.plot(mu, getattr(slip_end(mu), name), "o", color="black", markersize=4)
            logarithmic(ax, "xy" if name == "demand" else "x")
            ax.set_xlabel("μ₀")
            ax.set_ylabel(label)
        axes[1].axhline(np.pi / 2, color=FAINT, linewidth=0.8, linestyle=":")
        axes[1].annotate("the bottom", (mus[0], np.pi / 2), xytext=(0, 3), textcoords="offset points", fontsize=8)
        axes[2].axhline(1.0, color=FAINT, linewidth=0.8, linestyle=":")
        axes[0].legend()
    return figure


_PICTURES: tuple[tuple[str, Callable[[Paper], Figure], str, str], ...] = (
    (
        "paper_diagrams",
        diagrams,
        "The paper's figures 3 to 12, and the continued motion",
        "Each pair: the motion up to v = 0, where the paper's diagrams end, and the whole motion. For both "
        "coefficients the slip reverses there. The figures are not copies: they are drawn from the paper's equations "
        "with R = 1 m, r = 0.1 m, m = 1 kg and a release at rest at ξ₁ = 0, which its text does not give.",
    ),
    (
        "paper_remark",
        remark,
        "The paper's closing remark",
        "More friction ends the slip earlier and at a smaller ξ₁: true for all 200 coefficients shown. Right: the "
        "friction that rolling would need at that time over the largest friction of the cone; zero where the slip ends "
        "at the bottom. Dots: the paper's 0.01, 0.1 and 0.2.",
    ),
)


def draw(findings: Paper, folder: Path) -> Iterator[FigureEntry]:
    """Write the figures to the folder; yields their entries."""
    for name, make, title, caption in _PICTURES:
        yield save(make(findings), folder, name, "", title, caption)
