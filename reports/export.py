"""`slip-to-roll cases export NAME [mu=0.3 …] [--out DIR] [--points N]`: write a case as data for other tools.

Writes scene.json (`adapters.by_process.scene_file`, the input of executables, with the true transitions and their error
bars), track.csv and outline.csv (parameter, point, left normal, curvature), and the true motion: its samples in
motion.csv, the polynomials of its steps in motion_steps.csv, the impulses of its impacts in impacts.csv.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cases import ContactImpulse
from cases.files.owned_folder import atomic_path, write

from . import options
from .show import MADE_BY, case_of, check_free, main

if TYPE_CHECKING:
    from cases import Case, Trajectory

# Samples of the true motion, at equal times: so many that the phases too short for them leave a doubt of about 1 %
# where a disc bounces, or rocks, to rest.
SAMPLES = 4001
FILES = ("scene.json", "track.csv", "outline.csv", "motion.csv", "motion_steps.csv", "impacts.csv")
# Columns of plates, and of closed contacts, in motion_steps.csv.
OF_PLATES = ("x", "y", "theta", "vx", "vy", "omega")
OF_CONTACTS = ("xi1", "xi2", "slip", "normal_force", "friction_force")


def run(words: Sequence[str]) -> None:
    """Write the files; raises CaseError for invalid arguments."""
    case, out, force, more = case_of("cases export", words, "Write a case as data for other tools.", "out", "points")
    points = options.points_of(more.points)
    folder = out or Path(case.name)
    for name in FILES:
        check_free(folder / name, force)
    paths = export(case, folder, force, points)
    print("\n".join(f"written: {path}" for path in paths))


def export(case: Case, folder: Path, replace: bool = True, points: int | None = None) -> list[Path]:
    """Write a case into a folder, its curves with that many points (default 1001); returns the files. Without
    `replace`, raises FileExistsError if one exists."""
    from adapters.by_process.scene_file import SAMPLES as DEFAULT
    from adapters.by_process.scene_file import as_json, curve_samples, scene

    samples = DEFAULT if points is None else points
    data = {**scene(case, samples), **truth(case)}
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / name for name in FILES]
    write(paths[0], as_json(data, indent=1) + "\n", replace)
    for path, rows in zip(paths[1:3], curve_samples(case, samples).values(), strict=True):
        _write_csv(path, rows, "s,x,y,normal_x,normal_y,curvature", replace)
    true = true_motion(case)
    names, rows = motion(true)
    _write_csv(paths[3], rows, ",".join(names), replace, fmt="%.16g")
    write(paths[4], steps_text(true), replace)
    write(paths[5], impacts_text(true), replace)
    return paths


def _write_csv(path: Path, rows: np.ndarray, head: str, replace: bool, fmt: str = "%.18e") -> None:
    with atomic_path(path, replace) as partial:
        np.savetxt(partial, rows, delimiter=",", comments="", header=head, fmt=fmt)


def truth(case: Case) -> dict:
    """The end of the true motion and its transitions with their error bars, from the certificate that reports use."""
    from reference.certification import stored_or_new

    from .running.tasks import in_catalogue

    certificate = stored_or_new(case, use_file=in_catalogue(case))
    return {
        "made_by": f"{MADE_BY} export",
        "status": certificate.status,
        "end": certificate.end._asdict(),
        "transitions": [
            {"before": before, "after": after, "time": time._asdict(), "xi1": xi1._asdict()}
            for before, after, time, xi1 in certificate.transitions
        ],
    }


def true_motion(case: Case) -> Trajectory:
    """The true motion, with its dense output."""
    import reference

    return reference.simulate(case, rtol=1e-13)


def motion(true: Trajectory, samples: int = SAMPLES) -> tuple[tuple[str, ...], np.ndarray]:
    """Columns and rows of the true motion at even times, in the format of `reports.compare`."""
    from .running.true_motions import columns_at

    times = np.unique(np.linspace(0.0, true.t[-1], samples))  # a motion that ends at once has one sample
    columns = columns_at(true, times)
    return tuple(columns), np.column_stack([*columns.values()])


def steps_text(true: Trajectory) -> str:
    """The motion as polynomials, a line for each step, plate or closed contact, and quantity: start and end (s), and
    the coefficients c₀ … c₂₄ of Chebyshev polynomials, Σ cₖ Tₖ(2 (t − start)/(end − start) − 1) in SI units. With them
    anybody can check the laws, without code of the suite."""
    from reference.laws_check import chebyshev
    from reference.laws_check.samples import nodes_of, steps_of

    head = ["of", "quantity", "start", "end", *(f"c{k}" for k in range(chebyshev.COUNT))]
    start, end = steps_of(true) if len(true.t) > 1 else (np.zeros(0), np.zeros(0))
    times = nodes_of(start, end)
    lines = [",".join(head)]
    for name, quantity, values in _quantities(true, times.ravel()):
        table = chebyshev.coefficients(values.reshape(times.shape))
        is_known = np.isfinite(table).all(axis=1)
        lines += [
            ",".join([name, quantity, f"{a:.17g}", f"{b:.17g}", *(f"{c:.17g}" for c in row)])
            for a, b, row in zip(start[is_known], end[is_known], table[is_known], strict=True)
        ]
    return "\n".join(lines) + "\n"


def impacts_text(true: Trajectory) -> str:
    """A line for each contact in each impact: time (s), impulses along normal and tangent (N s), work (J); empty where
    velocities do not determine them."""
    lines = [",".join(ContactImpulse._fields)]
    for time, contact, *values in true.impacts:
        lines.append(",".join([f"{time:.17g}", contact, *("" if isnan(v) else f"{v:.17g}" for v in values)]))
    return "\n".join(lines) + "\n"


def _quantities(true: Trajectory, times: np.ndarray) -> Iterator[tuple[str, str, np.ndarray]]:
    """Name of the plate or contact, quantity, and its values at times; NaN where a contact is open."""
    from reference.laws_check.samples import state_of

    if not len(times):
        return
    for name in true.plate_names:
        state = state_of(true, name, times)
        yield from ((name, quantity, np.asarray(getattr(state, quantity))) for quantity in OF_PLATES)
    for name in true.contact_names:
        now = true.contact_columns(name, times) if true.contact_columns is not None else true(times)
        is_open = np.isnan(now.slip)
        yield from ((name, each, np.where(is_open, np.nan, getattr(now, each))) for each in OF_CONTACTS)


if __name__ == "__main__":
    sys.exit(main(run))
