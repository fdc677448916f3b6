"""`python -m cases show NAME [mu=0.3 …] [--case-file FILE] [--out FILE]`: a picture of scene and motion, and the facts.

Lives among the reports because it needs solvers; `python -m cases` finds it as an entry point.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import cases
from cases import BadValue, Case, Gravity, Trajectory
from cases.files import place

from . import options

# Stands in every file that a command writes, so that the next one knows it for its own.
MADE_BY = "slip-to-roll"
KINDS = (".png", ".svg", ".pdf")


class Asked(NamedTuple):
    """What a command line asks for."""

    case: Case
    out: Path | None
    force: bool


def run(words: Sequence[str]) -> None:
    """Draw and print; raises CaseError if what was asked for makes no sense."""
    case, out, force = case_of("show", words)
    picture = out or Path(f"{case.name}.png")
    if picture.suffix not in KINDS:
        raise BadValue(f"--out is {str(picture)!r}; give a file that ends in {', '.join(KINDS)}")
    check_ours(picture, force)
    import reference

    motion = reference.simulate(case)
    picture.parent.mkdir(parents=True, exist_ok=True)
    draw(case, motion, picture)
    print(facts(case, motion))
    print(f"picture: {picture}")


def case_of(command: str, words: Sequence[str]) -> Asked:
    """The case that a command line names, where its output goes, and whether it may write over what is there."""
    positional = {"NAME": 'a case: name or "name[parameter=value,…]"', "parameter=value*": "what differs from its own"}
    parser = options.parser(
        f"cases {command}", f"{command.capitalize()} a case.", "case_file", "out", "force", words=positional
    )
    given = parser.parse_args(list(words))
    out = given.out and place("folder or file of --out", given.out)
    options.load_files(given.case_file)
    inside = ",".join(getattr(given, "parameter=value"))
    text = f"{given.NAME}[{inside}]" if inside else given.NAME
    return Asked(options.guarded(f"the case {text}", lambda: cases.load(text)), out, given.force)


def check_ours(path: Path, force: bool) -> None:
    """Raises BadValue for a file that no command of the suite wrote, unless it may be written over, and for what cannot
    be written."""
    if path.is_dir():
        raise BadValue(f"{path} is a folder; give another name with --out")
    if path.exists() and not force and MADE_BY.encode() not in path.read_bytes():
        raise BadValue(f"{path} is there and none of ours; give another name with --out, or --force to write over it")
    options.check_writable("--out", path, path.parent)


def facts(case: Case, motion: Trajectory) -> str:
    """Parameters, docstring with its facts, transitions, and which solvers can run it."""
    from .running.calls import Calls
    from .running.experiment import offers

    entry = cases.entry(case.name)
    lines = [case.label, "", inspect.getdoc(entry.function) or "", "", "parameters"]
    lines += [f"  {name} = {case.parameters.get(name, value)}" for name, value in entry.parameters.items()]
    lines += ["motion", f"  begins: {motion.first_mode}"]
    lines += [f"  {t.time:.9f} s: {t.after} ({t.cause})" for t in motion.transitions]
    lines += [f"  {motion.t[-1]:.9f} s: {motion.status}. {motion.reason}", "solvers", "  reference: runs it"]
    with Calls() as calls:
        for (_, name), of_routes in offers([case], options.solvers()[1:], calls).items():
            for offer in of_routes:
                lines.append(f"  {name}{offer.route and f', {offer.route}'}: {offer.reason or 'runs it'}")
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
    outline = case.plate.outline.point(np.linspace(*case.plate.outline.span, 200))
    size = 1.5 * float(np.ptp(outline))
    track = case.track.point(np.linspace(*case.track.span, 2000))
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
    figure.savefig(path, metadata={"Software" if path.suffix == ".png" else "Creator": MADE_BY})
    plt.close(figure)


def main(command: Callable[[list[str]], None] = run) -> int:
    """For a suite that is not installed: `python -m reports.show NAME`."""
    return options.status("cases", command, None)


if __name__ == "__main__":
    sys.exit(main())
