"""The canvas of figures that become SVG files: layout and drawing measure texts alike, each text once per process."""

from __future__ import annotations

import codecs
from functools import lru_cache
from io import StringIO, TextIOBase
from typing import Any

from matplotlib.backends.backend_svg import FigureCanvasSVG, RendererSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

# Sizes in SVG files of Matplotlib are in points.
DPI = 72


class _Renderer(RendererSVG):
    def get_text_width_height_descent(self, s: str, prop: FontProperties, ismath: Any) -> tuple[float, float, float]:
        return _text_size(s, prop, ismath)


@lru_cache(maxsize=8192)
def _text_size(text: str, font: FontProperties, is_mathematical: Any) -> tuple[float, float, float]:
    return text_to_path.get_text_width_height_descent(text, font, is_mathematical)


class SvgCanvas(FigureCanvasSVG):
    """Writes a figure as SVG, as Matplotlib's canvas does."""

    def __init__(self, figure: Figure):
        super().__init__(figure)
        figure.set_dpi(DPI)

    def get_renderer(self) -> RendererSVG:
        """A renderer that layouts measure with."""
        return self._renderer_to(StringIO())

    def print_svg(
        self, filename: Any, *, bbox_inches_restore: Any = None, metadata: dict[str, Any] | None = None, **_: Any
    ) -> None:
        """Write the figure to an open file, of text or of bytes."""
        if any(child.get_rasterized() for ax in self.figure.axes for child in ax.get_children()):
            super().print_svg(filename, bbox_inches_restore=bbox_inches_restore, metadata=metadata)
            return
        # Without parts that become pixels, nothing needs to be drawn by two renderers.
        self.figure.dpi = DPI
        is_text = isinstance(filename, TextIOBase)
        renderer = self._renderer_to(filename if is_text else codecs.getwriter("utf-8")(filename), metadata)
        self.figure.draw(renderer)
        renderer.finalize()

    def _renderer_to(self, file: Any, metadata: dict[str, Any] | None = None) -> RendererSVG:
        width, height = DPI * self.figure.get_size_inches()
        return _Renderer(width, height, file, metadata={"Date": None} if metadata is None else metadata)
