"""`python -m cases show NAME [mu=0.3 …] [--case-file FILE] [--out FILE]`: a picture of scene and motion, and the facts.

Lives among the reports because it needs solvers; `python -m cases` finds it as an entry point.
"""

from __future__ import annotations

import argparse
import inspect
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import adapters
import cases
import reference
from cases import BadValue, Case, CaseError, Gravity, Trajectory


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, by the suite's own error."""

    def error(self, message: str) -> NoReturn:
        raise BadValue(f"{message}; see {self.prog} --help")


def run(words: Sequence[str]) -> None:
    """Draw and print; raises CaseError if what was asked for makes no sense."""
    case, out = asked("show", words)
    motion = reference.simulate(case)
    picture = out or Path(f"{case.name}.png")
    draw(case, motion, picture)
    print(told(case, motion))
    print(f"picture: {picture}")


def asked(command: str, words: Sequence[str]) -> tuple[Case, Path | None]:
    """The case that a command line names, and where its output goes."""
    parser = _Parser(prog=f"python -m cases {command}", allow_abbrev=False)
    parser.add_argument("name", metavar="NAME", help='a case: name or "name[parameter=value,…]"')
    parser.add_argument("parameters", metavar="parameter=value", nargs="*")
    parser.add_argument("--case-file", metavar="FILE", action="append", default=[])
    parser.add_argument("--out", metavar="PATH", type=Path)
    options, stray = parser.parse_known_args(list(words))
    if stray:
        raise BadValue(f"{command} knows no option {stray[0]!r}; choose from --case-file, --out")
    for file in options.case_file:
        cases.load_file(file)
    inside = ",".join(options.parameters)
    return cases.load(f"{options.name}[{inside}]" if inside else options.name), options.out


def told(case: Case, motion: Trajectory) -> str:
    """Parameters, docstring with its facts, transitions, and which solvers can run it."""
    entry = cases.entry(case.name)
    lines = [case.label, "", inspect.getdoc(entry.function) or "", "", "parameters"]
    lines += [f"  {name} = {case.parameters.get(name, value)}" for name, value in entry.parameters.items()]
    lines += ["motion", f"  begins: {motion.first_mode}"]
    lines += [f"  {t.time:.9f} s: {t.after} ({t.cause})" for t in motion.transitions]
    lines += [f"  {motion.t[-1]:.9f} s: {motion.status}. {motion.reason}", "solvers", "  reference: runs it"]
    for name in adapters.engines():
        try:
            engine = adapters.engine(name)
        except ImportError as problem:
            lines.append(f"  {name}: not installed ({problem})")
            continue
        lines += [f"  {name}, {route}: {engine.refuses(case, route) or 'runs it'}" for route in engine.routes]
    return "\n".join(lines)


def draw(case: Case, motion: Trajectory, path: Path) -> None:
    """The plate at even times on its track, and slip velocity and normal force against time."""
    import matplotlib

    matplotlib.use("Agg")
    import numpy as np
    from matplotlib import pyplot as plt

    times = np.linspace(0.0, motion.t[-1], 400)
    state = motion(times)
    xs, ys, angles = (np.asarray(values) for values in (state.x, state.y, state.theta))
    figure, (scene, slip, force) = plt.subplots(3, 1, figsize=(7, 9), height_ratios=(2.5, 1, 1), layout="constrained")
    outline = case.plate.outline.point(np.linspace(*case.plate.outline.look, 200))
    size = 1.5 * float(np.ptp(outline))
    track = case.track.point(np.linspace(*case.track.look, 2000))
    scene.plot(*track, color="black", linewidth=1)
    for i in np.linspace(0, len(times) - 1, 8).astype(int):
        c, s = np.cos(angles[i]), np.sin(angles[i])
        x, y = c * outline[0] - s * outline[1] + xs[i], s * outline[0] + c * outline[1] + ys[i]
        scene.plot(x, y, color="#0072B2", alpha=0.25 + 0.75 * (1 - i / len(times)))
        scene.plot([xs[i], x[0]], [ys[i], y[0]], color="#0072B2", linewidth=0.6)
    # The page belongs to the motion, not to a track that may run on for metres.
    scene.set(
        xlim=(xs.min() - size, xs.max() + size),
        ylim=(ys.min() - size, ys.max() + size),
        title=case.label,
        aspect="equal",
    )
    gravity = case.effect(Gravity)
    if gravity is not None and np.sin(gravity.direction) > 0:
        scene.invert_yaxis()  # gravity pulls down the page
    scene.set(xlabel="X / m", ylabel="Y / m" + (" (points down)" if scene.yaxis_inverted() else ""))
    slip.plot(times, state.slip)
    force.plot(times, state.normal_force)
    for ax, label in ((slip, "slip velocity / (m/s)"), (force, "normal force / N")):
        ax.set(ylabel=label, xlabel="time / s")
        for t in motion.transitions:
            ax.axvline(t.time, color="#8a8a8a", linewidth=0.7)
    figure.savefig(path)
    plt.close(figure)


def main(command=run) -> int:
    """For a suite that is not installed: `python -m reports.show NAME`."""
    try:
        command(sys.argv[1:])
    except (CaseError, OSError) as problem:
        print(f"cases: {problem}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
