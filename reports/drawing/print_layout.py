"""Layout of a figure for print: as wide as one column or two of a journal, with text of at least 6 pt."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

# Widths in inches: 21 and 43 picas, one column and two of a journal with two columns on a page of letter size or A4.
COLUMN, TWO_COLUMNS = 3.5, 43 / 6
# The height of such a page in inches without its margins and a caption; a margin around content outside a figure.
_HIGHEST, _MARGIN = 8.5, 0.03
# Figures with one panel fit into a column if they are at most this wide on a screen, in inches; wider ones have more in
# their panel.
_ONE_PANEL = 7.6
# Most text of figures has 9 pt on a screen; in print it has 7 pt, and no text has less than 6 pt.
_TEXT_SCALE, _SMALLEST_TEXT = 7 / 9, 6.0
# The least part of a column's width for a panel next to its labels; with less, the figure takes two columns.
_LEAST_SHARE = 0.5


def fit_to_print(figure: Figure) -> Bbox:
    """Change the size of a figure to a column of a journal, or to two columns if it has several panels or wide labels.

    A legend to the right of the only panel is moved below it. Returns the bounding box of the page in inches: exactly
    as wide as the columns, and as high as the content.
    """
    from matplotlib.text import Text

    wide, high = figure.get_size_inches()
    for text in {text for text in figure.findobj(Text) if isinstance(text, Text)}:
        text.set_fontsize(max(_TEXT_SCALE * float(text.get_fontsize()), _SMALLEST_TEXT))
    panels = [ax for ax in figure.axes if not hasattr(ax, "_colorbar")]
    if len(panels) == 1 and wide <= _ONE_PANEL:
        legend_height = _move_legend(panels[0])
        _resize(figure, COLUMN, high * COLUMN / wide + legend_height)
        if panels[0].get_position().width >= _LEAST_SHARE:
            return _page(figure)
    _resize(figure, TWO_COLUMNS, min(high * TWO_COLUMNS / wide, _HIGHEST))
    return _page(figure)


def _page(figure: Figure) -> Bbox:
    """The bounding box of the page: content outside the figure makes it higher."""
    from matplotlib.transforms import Bbox

    wide, high = figure.get_size_inches()
    content = figure.get_tightbbox()
    return Bbox([[0.0, min(0.0, content.y0 - _MARGIN)], [wide, max(high, content.y1 + _MARGIN)]])


def _move_legend(panel: Axes) -> float:
    """Move a legend that is to the right of a panel below it, as a part of the figure for which the constrained layout
    reserves room; returns the height that it adds, in inches."""
    legend, figure = panel.get_legend(), panel.get_figure()
    if legend is None or figure is None or legend.get_bbox_to_anchor().x0 < panel.bbox.x1:
        return 0.0
    texts = [text.get_text() for text in legend.get_texts()]
    columns = 2 if max(map(len, texts), default=0) <= 24 else 1
    legend.remove()
    size = _TEXT_SCALE * 8.5
    handles = [handle for handle in legend.legend_handles if handle is not None]
    figure.legend(
        handles=handles, labels=texts, loc="outside lower center", ncols=columns, fontsize=size, frameon=False
    )
    return -(-len(texts) // columns) * 1.35 * size / 72


def _resize(figure: Figure, wide: float, high: float) -> None:
    """Set the size in inches, compute the figure's constrained layout again, if it has one, and wrap labels of vertical
    axes that are longer than their panel."""
    figure.set_size_inches(wide, high)
    _lay_out(figure)
    if _wrap_labels(figure):
        _lay_out(figure)


def _wrap_labels(figure: Figure) -> bool:
    """Wrap labels of vertical axes that are longer than their panel; returns whether there were any."""
    is_any = False
    for panel in figure.axes:
        label = panel.yaxis.label
        length, height = label.get_window_extent().height, panel.bbox.height
        if length > height and "$" not in label.get_text():
            label.set_text(fill(label.get_text(), max(int(len(label.get_text()) * height / length), 10)))
            is_any = True
    return is_any


def _lay_out(figure: Figure) -> None:
    if figure.get_layout_engine() is not None:
        figure.set_layout_engine("constrained")
        if engine := figure.get_layout_engine():
            engine.execute(figure)
        figure.set_layout_engine("none")
