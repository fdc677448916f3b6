"""The figure of all 48 point sets with the curves through them: python -m tests.scenes.point_set_figure FILE.png"""

import sys
from pathlib import Path

import numpy as np

from cases import Curve
from cases.pictures.style import FORCE, TRACK, Picture, apply_style
from tests.scenes.point_sets import PointSet, point_sets

# Samples of a curve, and of the shape that was measured: far more than a part of the figure has pixels across.
SAMPLES = 2001


def off_shape(curve: Curve, points: PointSet) -> float:
    """The largest distance (m) of the curve from the shape that was measured, to the spacing of the samples."""
    from scipy.spatial import cKDTree

    true = points.shape(np.linspace(0.0, 1.0, 20 * SAMPLES)).T
    return float(cKDTree(true).query(curve.point(np.linspace(*curve.span, SAMPLES)).T)[0].max())


def figure():
    """Twelve shapes in rows, four ways of measuring them in columns; distances in parts of the shape's extent."""
    sets = list(point_sets())
    with apply_style():
        picture = Picture(figsize=(9.0, 19.0), layout="constrained")
        axes = picture.subplots(len(sets) // 4, 4)
        for ax, points in zip(axes.flat, sets, strict=True):
            curve = Curve.spline(points.points, smoothing=points.tolerance, closed=points.closed)
            ax.plot(*points.points.T, linestyle="none", marker=".", markersize=2, color=FORCE)
            ax.plot(*curve.point(np.linspace(*curve.span, SAMPLES)), color=TRACK, linewidth=0.8)
            ax.set_aspect("equal", adjustable="datalim")
            ax.set_xticks([])
            ax.set_yticks([])
            off = curve.residual / points.extent, off_shape(curve, points) / points.extent
            ax.set_title(f"{points.name}\npoints {off[0]:.1e}, shape {off[1]:.1e}", fontsize=7)
    return picture


def main() -> None:
    if len(sys.argv) != 2 or not sys.argv[1].endswith(".png"):
        sys.exit("usage: python -m tests.scenes.point_set_figure FILE.png")
    target = Path(sys.argv[1])
    if target.exists():
        sys.exit(f"{target} exists; give the name of a new file")
    figure().savefig(target, dpi=80)
    print(target)


if __name__ == "__main__":
    main()
