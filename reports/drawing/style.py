"""Style of figures written to files: the common style, the line styles, and colours that belong to no solver."""

from __future__ import annotations

import matplotlib

from cases.pictures.style import FAINT, STYLE

from .colours import LineStyles

__all__ = ["AREAS", "FAINT", "STYLE", "LineStyles"]

matplotlib.use("Agg")  # pictures are written to files without opening windows

# Areas of a map, which are no solver's colours: paler than any line. Paul Tol's "light" scheme, for labelled areas.
AREAS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#aaaa00")
