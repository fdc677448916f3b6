"""`python -m cases export NAME [mu=0.3 …] [--out DIR]`: a case as data, for a tool of your own.

Writes scene.json (parameters, effects, start, true transitions with error bars), track.csv and outline.csv (parameter,
point, left normal, curvature).
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from cases import Case, Curve
from cases.contact import start_motion

from .show import MADE_BY, case_of, check_ours, main

# Chords of a closed curve of a thousand sides miss it by 5e-6 of its radius.
SAMPLES = 1001
FILES = ("scene.json", "track.csv", "outline.csv")


def run(words: Sequence[str]) -> None:
    """Write the files; raises CaseError if what was asked for makes no sense."""
    case, out, force = case_of("export", words)
    folder = out or Path(case.name)
    check_ours(folder / FILES[0], force)
    for name in FILES[1:]:  # what stands beside a scene of ours is ours
        check_ours(folder / name, force or (folder / FILES[0]).exists())
    written = export(case, folder)
    print("\n".join(f"written: {path}" for path in written))


def export(case: Case, folder: Path) -> list[Path]:
    """Write a case into a folder; returns the files."""
    said = scene(case)
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / name for name in FILES]
    paths[0].write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    for path, curve in zip(paths[1:], (case.track, case.plate.outline), strict=True):
        np.savetxt(path, sampled(curve), delimiter=",", comments="", header="s,x,y,normal_x,normal_y,curvature")
    return paths


def sampled(curve: Curve) -> np.ndarray:
    """Rows of parameter, point (m), left unit normal, curvature (1/m); shape (SAMPLES, 6)."""
    s = np.linspace(*curve.span, SAMPLES)
    return np.column_stack([s, *curve.point(s), *curve.normal(s), curve.curvature(s)])


def scene(case: Case) -> dict:
    """Everything but the sampled curves, in SI units."""
    import reference

    certificate = reference.certify(case)
    return {
        "made_by": f"{MADE_BY} export",
        "case": case.label,
        "units": "SI, radians; the plate lies on the left of the track; components along its tangent and left normal",
        "plate": {"mass": case.plate.mass, "inertia": case.plate.inertia, "radius": case.plate.radius},
        "track": [str(part) for part in case.track.expression],
        "outline": [str(part) for part in case.plate.outline.expression],
        "effects": {type(e).__name__: asdict(e) for e in case.effects},
        "start": start_motion(case)._asdict(),
        "duration": case.duration,
        "status": certificate.status,
        "end": certificate.end._asdict(),
        "transitions": [
            {"before": before, "after": after, "time": time._asdict(), "xi1": xi1._asdict()}
            for before, after, time, xi1 in certificate.transitions
        ],
    }


if __name__ == "__main__":
    sys.exit(main(run))
