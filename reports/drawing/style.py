"""How figures that become files look: the style of all pictures, who looks how, and colours of what is no solver."""

from __future__ import annotations

import matplotlib
from matplotlib import colormaps
from matplotlib.colors import to_hex

from cases.pictures.style import FAINT, STYLE

from .colours import TRUTH as _TRUTH
from .looks import Looks, logarithmic, looks_of

__all__ = ["AREAS", "FAINT", "POINTS", "STYLE", "TRUTH", "Looks", "logarithmic", "looks_of", "ordinal"]

matplotlib.use("Agg")  # pictures are files: no window is opened

TRUTH = _TRUTH.light
# Areas of a map, which stand for no solver: paler than any line. Paul Tol's "light" scheme, made for labelled areas.
AREAS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#aaaa00")
# Points along a line: more than a panel of some 270 points' width needs, so that the page stays light.
POINTS = 150


def ordinal(count: int) -> list[str]:
    """Colours for so many things that are no solvers and have an order, such as coefficients of friction."""
    # The yellow end is pale on white.
    return [to_hex(colormaps["cividis"](0.85 * i / max(count - 1, 1))) for i in range(count)]
