"""The paper, line by line: its equations in the code, its figures next to the continued motions, its claims.

The paper's figures end where v vanishes. Its sizes and its start are not in its text; ours are those of
`disc_in_circle`. What it claims depends on neither R, r, m nor g (`reference.paper.application`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import cases
import reference
from cases import Mode, Trajectory
from reference.errata import errata
from reference.paper.application import rolls_beyond, slip_end
from reference.paper.equation_list import LINES
from reports.analysis.columns import Table
from reports.drawing.figure_files import FigureEntry, save
from reports.running.calls import Calls, StorePolicy
from reports.running.records import Row
from reports.studies import Request

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TABLES = {
    "paper_equations": Table(
        "The paper's numbered equations and their places in the code",
        {"equation": "its number", "says": "its content", "places": "its places in the code"},
    ),
    "paper_claims": Table(
        "The paper's claim that rolling follows, for each of its coefficients, with the cone's margin",
        {
            "mu": "the coefficient μ₀",
            "time_unitless": "when v vanishes, in units of √((R − r)/g)",
            "time": "the same in s, with R = 1 m, r = 0.1 m",
            "xi1": "ξ₁ there, rad",
            "demand": "the friction that rolling would need, over the largest friction of the cone",
            "margin": "1 − demand",
            "after": "the mode that follows",
            "claim_holds": "whether it rolls",
            "rolls_beyond": "the disc rolls if it is released from rest beyond this ξ₁, rad",
        },
    ),
    "paper_remark": Table(
        "Where and when the slip first vanishes over the friction coefficient",
        {
            "mu": "the coefficient μ₀",
            "time": "when v vanishes, in units of √((R − r)/g)",
            "xi1": "ξ₁ there, rad",
            "demand": "the friction that rolling would need, over the largest friction of the cone",
        },
    ),
    "errata": Table(
        "The paper's misprints, each formula evaluated (residuals relative to what it must equal)",
        {
            "where": "place in the paper",
            "printed": "as printed",
            "corrected": "as it must be",
            "printed_residual": "residual of the formula as printed, relative",
            "corrected_residual": "residual of the corrected formula, relative",
            "verdict": "the misprint",
            "claim": "the paper's claim",
        },
    ),
}

# The paper's coefficients, and those of its figures.
COEFFICIENTS, FIGURE_COEFFICIENTS = (0.01, 0.1, 0.2), (0.01, 0.1)
# The quantities of its figures, in its order.
QUANTITIES = {
    "v": "slip velocity v / (m/s)",
    "xi1": "track angle ξ₁ / rad",
    "xi2": "plate angle ξ₂ / rad",
    "theta": "rotation θ / rad",
    "lambda": "multiplier λ / (N/m)",
}
# Four decades of friction, evenly spaced on a logarithmic axis: enough points for a smooth line.
MUS = np.geomspace(1e-3, 10.0, 200)


class Paper(NamedTuple):
    """The rows of the three tables, and for each coefficient of `FIGURED` the curves up to v = 0, the complete curves,
    the time of v = 0 (s) and the mode that follows."""

    equations: list[Row]
    claims: list[Row]
    remark: list[Row]
    curves: dict[float, tuple[dict[str, np.ndarray], dict[str, np.ndarray], float, str]]


def measure() -> Paper:
    """All findings of the study."""
    by_coefficient = {}
    for mu in FIGURE_COEFFICIENTS:
        stop = _motion(mu).transitions[0]
        by_coefficient[mu] = curves(mu, stop.time), curves(mu), stop.time, str(stop.after).replace("_", " ")
    return Paper(equation_rows(), claim_rows(), remark_rows(), by_coefficient)


def equation_rows() -> list[Row]:
    """One row for each numbered equation: its content and its places in the code."""
    return [{"equation": f"({n})", "says": says, "places": ", ".join(places)} for n, says, places in LINES]


def claim_rows() -> list[Row]:
    """One row for each of the paper's coefficients: where v vanishes, what follows, and the cone's margin there.

    `demand`: the friction that rolling would need over the largest friction of the cone; `rolls_beyond` (rad): the disc
    rolls if it is released from rest beyond this ξ₁.
    """
    rows: list[Row] = []
    for mu in COEFFICIENTS:
        end, first = slip_end(mu), _motion(mu).transitions[0]
        rows.append(
            {
                "mu": mu,
                "time_unitless": end.time,
                "time": first.time,
                "xi1": first.xi1,
                "demand": end.demand,
                "margin": 1.0 - end.demand,
                "after": str(first.after),
                "claim_holds": first.after is Mode.ROLL,
                "rolls_beyond": rolls_beyond(mu),
            }
        )
    return rows


def remark_rows() -> list[Row]:
    """The closing remark: where and when v vanishes (in units of √((R − r)/g)), one row for each of `MUS`."""
    return [{"mu": float(mu), **slip_end(float(mu))._asdict()} for mu in MUS]


def _motion(mu: float) -> Trajectory:
    return reference.simulate(cases.load("disc_in_circle", mu=mu), rtol=1e-12)


def curves(mu: float, until: float | None = None, points: int = 300) -> dict[str, np.ndarray]:
    """The paper's five quantities and `t` (s) for one coefficient, to the end of the motion or `until`.

    λ = N/‖R_p‖ of (31), in N per unit of the track's parameter.
    """
    motion = _motion(mu)
    end = motion.t[-1] if until is None else until
    # The transitions are also samples, so that both sides of a jump of the force are included.
    t = np.unique([*np.linspace(0.0, end, points), *(x.time for x in motion.transitions if x.time < end)])
    state = motion(t)
    speed = cases.load("disc_in_circle", mu=mu).track.speed(np.asarray(state.xi1))
    quantities = (state.slip, state.xi1, state.xi2, state.theta, state.normal_force / speed)
    return {"t": t, **{name: np.asarray(values) for name, values in zip(QUANTITIES, quantities, strict=True)}}


def run(request: Request, calls: Calls) -> Paper:
    """All findings, computed in one call."""
    (answer,) = calls.all("the paper", measure, [()], keep=StorePolicy())
    if answer.outcome != "done":
        raise RuntimeError(answer.reason)
    return answer.value


def rows(findings: Paper) -> dict[str, list[dict[str, Any]]]:
    """The four tables."""
    return {
        "paper_equations": findings.equations,
        "paper_claims": findings.claims,
        "paper_remark": findings.remark,
        "errata": [erratum._asdict() for erratum in errata()],
    }


# --- figures ----------------------------------------------------------------------------------------------------------

# Figures 3 and 4 show the slip velocity for the two coefficients; the other quantities follow in pairs up to 11 and 12.
_FIRST_FIGURE = 3


def _ordinal(count: int) -> list[str]:
    """`count` colours for ordered things that are not solvers, such as coefficients of friction."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    # The yellow end is pale on white.
    return [to_hex(colormaps["cividis"](0.85 * i / max(count - 1, 1))) for i in range(count)]


def diagrams(findings: Paper) -> Figure:
    """Figures 3 to 12, each up to v = 0 as in the paper, and next to it the continued motion."""
    from matplotlib import pyplot as plt
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    from reports.drawing.style import FAINT, STYLE

    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(QUANTITIES),
            2 * len(FIGURE_COEFFICIENTS),
            figsize=(10.8, 9.6),
            sharex="col",
            layout=ConstrainedLayoutEngine(w_pad=0.1, wspace=0.03),
        )
        shades = _ordinal(len(FIGURE_COEFFICIENTS))
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
                ax.set_xlabel("time / s")
        figure.align_ylabels()
    return figure


def remark(findings: Paper) -> Figure:
    """The closing remark as curves over μ₀, with the range in which rolling follows."""
    from matplotlib import pyplot as plt

    from reports.drawing.style import FAINT, STYLE

    rows = findings.remark
    mus = np.array([row["mu"] for row in rows])
    rolls = np.array([row["demand"] for row in rows], dtype=float) <= 1.0
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.4, 3.3), layout="constrained")
        panels = (
            ("time", "time of the first v = 0 / √((R − r)/g)"),
            ("xi1", "track angle ξ₁ of the first v = 0 / rad"),
            ("demand", "friction to roll / largest friction"),
        )
        reverses, follows = reversed(_ordinal(2))
        for ax, (name, label) in zip(axes, panels, strict=True):
            values = np.array([row[name] for row in rows])
            for mask, colour, what in (
                (~rolls, reverses, "then it reverses"),
                (rolls, follows, "then it rolls"),
            ):
                ax.plot(mus[mask], values[mask], color=colour, label=what)
            values_of_paper = [getattr(slip_end(mu), name) for mu in COEFFICIENTS]
            ax.plot(COEFFICIENTS, values_of_paper, "o", color="black", markersize=4, label="the paper's coefficients")
            ax.set(xscale="log", yscale="log" if name == "demand" else "linear")
            ax.set_xlabel("friction coefficient μ₀")
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
