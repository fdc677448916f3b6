"""The paper, line by line: its equations in the code, its figures 3 to 12 beside ours that go on, and its claims.

    python -m reports.paper_figures [--out DIR]

The paper's figures end where v vanishes. Its sizes and its start are not in its text; ours are those of
`disc_in_circle`. What it claims depends on neither R, r, m nor g (`reference.paper.application`).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import cases
import reference
from cases import Mode, Trajectory
from reference.errata import errata
from reference.paper.application import rolls_beyond, slip_end
from reference.paper.lines import LINES

from .drawing import Drawn

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

# The paper's coefficients, and those it draws.
COEFFICIENTS, FIGURED = (0.01, 0.1, 0.2), (0.01, 0.1)
# What it draws, in its order: figures 3 and 4 are the slip velocity for the two coefficients, and so on to 11 and 12.
_FIRST_FIGURE = 3
QUANTITIES = {
    "v": "v / (m/s)",
    "xi1": "ξ₁ / rad",
    "xi2": "ξ₂ / rad",
    "theta": "θ / rad",
    "lambda": "λ / (N/m)",
}
# Four decades of friction, evenly on a logarithmic axis: as many points as a line needs to look smooth.
MUS = np.geomspace(1e-3, 10.0, 200)


# --- rows -------------------------------------------------------------------------------------------------------------


def equation_rows() -> list[dict[str, Any]]:
    """One row for each numbered equation: what it says and where it stands in the code."""
    return [{"equation": f"({n})", "says": says, "places": ", ".join(places)} for n, says, places in LINES]


def claim_rows() -> list[dict[str, Any]]:
    """One row for each of the paper's coefficients: where v vanishes, what follows, and the cone's margin there.

    `needed` is the friction that rolling would take over what the cone holds; `rolls_beyond` (rad) the release from
    rest from which on the disc rolls.
    """
    rows = []
    for mu in COEFFICIENTS:
        end, first = slip_end(mu), _motion(mu).transitions[0]
        rows.append(
            {
                "mu": mu,
                "time_unitless": end.time,
                "time": first.time,
                "xi1": first.xi1,
                "needed": end.needed,
                "margin": 1.0 - end.needed,
                "after": str(first.after),
                "claim_holds": first.after is Mode.ROLL,
                "rolls_beyond": rolls_beyond(mu),
            }
        )
    return rows


def remark_rows() -> list[dict[str, Any]]:
    """The closing remark: where and when v vanishes (in units of √((R − r)/g)), one row for each of `MUS`."""
    return [{"mu": float(mu), **slip_end(float(mu))._asdict()} for mu in MUS]


def frames() -> dict[str, pd.DataFrame]:
    """The tables `paper_equations`, `paper_claims` and `paper_remark`."""
    import pandas as pd

    rows = {"paper_equations": equation_rows(), "paper_claims": claim_rows(), "paper_remark": remark_rows()}
    return {name: pd.DataFrame(of_one) for name, of_one in rows.items()}


def _motion(mu: float) -> Trajectory:
    return reference.simulate(cases.load("disc_in_circle", mu=mu), rtol=1e-12)


def curves(mu: float, until: float | None = None, points: int = 300) -> dict[str, np.ndarray]:
    """The paper's five quantities and `t` (s) for one coefficient, to the end of the motion or `until`.

    λ = N/‖R_p‖ of (31), in N per unit of the track's parameter.
    """
    motion = _motion(mu)
    end = motion.t[-1] if until is None else until
    # Both sides of a jump of the force: the instants of the transitions are samples, too.
    t = np.unique([*np.linspace(0.0, end, points), *(x.time for x in motion.transitions if x.time < end)])
    state = motion(t)
    speed = cases.load("disc_in_circle", mu=mu).track.speed(np.asarray(state.xi1))
    drawn = (state.slip, state.xi1, state.xi2, state.theta, state.normal_force / speed)
    return {"t": t, **{name: np.asarray(values) for name, values in zip(QUANTITIES, drawn, strict=True)}}


# --- pictures ---------------------------------------------------------------------------------------------------------


def diagrams() -> Figure:
    """Figures 3 to 12, each up to v = 0 as the paper has it, and beside it the motion that goes on."""
    from matplotlib import pyplot as plt

    from .drawing import FAINT, PALETTE, STYLE

    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(QUANTITIES), 2 * len(FIGURED), figsize=(10.4, 9.6), layout="constrained", sharex="col"
        )
        for i, mu in enumerate(FIGURED):
            stop = _motion(mu).transitions[0]
            paper, ours = curves(mu, stop.time), curves(mu)
            for row, (name, label) in enumerate(QUANTITIES.items()):
                left, right = axes[row, 2 * i], axes[row, 2 * i + 1]
                left.plot(paper["t"], paper[name], color=PALETTE[i])
                left.set_title(f"figure {_FIRST_FIGURE + 2 * row + i}, μ₀ = {mu:g}")
                left.set_ylabel(label)
                right.plot(ours["t"], ours[name], color=FAINT)
                right.plot(paper["t"], paper[name], color=PALETTE[i])
                right.axvline(stop.time, color=FAINT, linewidth=0.8, linestyle=":")
                right.set_title(f"the same, going on: {str(stop.after).replace('_', ' ')}" if row == 0 else "going on")
            for ax in axes[-1, 2 * i : 2 * i + 2]:
                ax.set_xlabel("t / s")
        figure.align_ylabels()
    return figure


def remark() -> Figure:
    """The closing remark as curves over μ₀, and with it where rolling follows."""
    from matplotlib import pyplot as plt

    from .drawing import FAINT, PALETTE, STYLE, logarithmic

    rows = remark_rows()
    mus = np.array([row["mu"] for row in rows])
    rolls = np.array([row["needed"] <= 1.0 for row in rows])
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.4, 3.3), layout="constrained")
        panels = (
            ("time", "time of v = 0 / √((R − r)/g)"),
            ("xi1", "ξ₁ there / rad"),
            ("needed", "|T| / (μ₀ N) to roll"),
        )
        for ax, (name, label) in zip(axes, panels, strict=True):
            values = np.array([row[name] for row in rows])
            for chosen, colour, what in (
                (~rolls, PALETTE[1], "then it reverses"),
                (rolls, PALETTE[0], "then it rolls"),
            ):
                ax.plot(mus[chosen], values[chosen], color=colour, label=what)
            for mu in COEFFICIENTS:
                ax.plot(mu, getattr(slip_end(mu), name), "o", color="black", markersize=4)
            logarithmic(ax, "xy" if name == "needed" else "x")
            ax.set_xlabel("μ₀")
            ax.set_ylabel(label)
        axes[1].axhline(np.pi / 2, color=FAINT, linewidth=0.8, linestyle=":")
        axes[1].annotate("the bottom", (mus[0], np.pi / 2), xytext=(0, 3), textcoords="offset points", fontsize=8)
        axes[2].axhline(1.0, color=FAINT, linewidth=0.8, linestyle=":")
        axes[0].legend()
    return figure


_PICTURES: tuple[tuple[str, Callable[[], Any], str, str], ...] = (
    (
        "paper_diagrams",
        diagrams,
        "The paper's figures 3 to 12, and how the motion goes on",
        "Each pair: up to v = 0, where the paper's diagrams end, and the whole motion. For both coefficients the slip "
        "reverses there. The figures are not copied: they are drawn from the paper's equations with R = 1 m, "
        "r = 0.1 m, m = 1 kg and a release at rest at ξ₁ = 0, which its text does not give.",
    ),
    (
        "paper_remark",
        remark,
        "The paper's closing remark",
        "More friction ends the slip earlier and at a smaller ξ₁: true for all 200 coefficients drawn. Right: the "
        "friction that rolling would take then, over what the cone holds; zero where the slip ends at the bottom. "
        "Dots: the paper's 0.01, 0.1 and 0.2.",
    ),
)


def draw(folder: Path) -> Iterator[Drawn]:
    """Write the pictures into the folder; yields what was written."""
    from .drawing import save

    folder.mkdir(parents=True, exist_ok=True)
    for name, make, title, caption in _PICTURES:
        yield save(make(), folder, name, "", title, caption)


# --- the command ------------------------------------------------------------------------------------------------------


def summary() -> str:
    """What the paper claims and what is so, in sentences."""
    unit = sqrt(0.9 / 9.81)
    told = []
    for row in claim_rows():
        so = "holds" if row["claim_holds"] else "fails: the slip reverses"
        told.append(
            f"μ₀ = {row['mu']:g}: v vanishes at {row['time_unitless']:.6f} units of √((R − r)/g) "
            f"({row['time_unitless'] * unit:.6f} s here), ξ₁ = {row['xi1']:.6f} rad; rolling would take "
            f"{row['needed']:.4g} times what the cone holds: the claim that it rolls {so}."
        )
    return " ".join(told)


def main(argv: list[str] | None = None) -> int:
    """The command: writes tables and pictures."""
    from . import tables

    parser = argparse.ArgumentParser(prog="python -m reports.paper_figures", description=str(__doc__).split("\n")[0])
    parser.add_argument("--out", default="paper", metavar="DIR", help="folder to write (default: paper)")
    folder = Path(parser.parse_args(argv).out)
    try:
        tables.write(frames(), folder)
        written = [folder / f"{drawn.name}.svg" for drawn in draw(folder)]
    except OSError as problem:
        print(f"reports.paper_figures: cannot write: {problem}", file=sys.stderr)
        return 1
    print(summary())
    for erratum in errata():
        print(f"{erratum.where}: {erratum.printed} -> {erratum.corrected}. {erratum.verdict}.")
    print(f"written: {', '.join(map(str, written))} and tables beside them")
    return 0


if __name__ == "__main__":
    sys.exit(main())
