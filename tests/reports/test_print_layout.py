"""Figures for print: PDF pages as wide as one column or two of a journal, with legible text that is not cut off."""

import re

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.text import Text

from cases.pictures.style import STYLE
from reports.drawing.figure_files import for_print, picture
from reports.drawing.print_layout import COLUMN, TWO_COLUMNS, fit_to_print

pytestmark = pytest.mark.builds


def one_panel(label: str = "error / s"):
    with plt.rc_context(STYLE):
        figure, ax = plt.subplots(figsize=(7.2, 4.3), layout="constrained")
        for solver in ("reference, taylor", "pymunk, native", "exudyn, native"):
            ax.plot([1, 2, 3], label=solver)
        ax.set_ylabel(label)
        ax.annotate("small", (1, 1), fontsize=6)
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def several_panels():
    with plt.rc_context(STYLE):
        return plt.subplots(7, 2, figsize=(9.2, 13.6), layout="constrained")[0]


def wide_labels():
    with plt.rc_context(STYLE):
        figure, ax = plt.subplots(figsize=(7.4, 3.0), layout="constrained")
        ax.set_yticks([0, 1], ["disc_in_circle[mu=0.2]: pymunk, native, default settings"] * 2)
    return figure


@pytest.mark.parametrize(
    ("figure", "width"), [(one_panel, COLUMN), (several_panels, TWO_COLUMNS), (wide_labels, TWO_COLUMNS)]
)
def test_a_page_has_the_width_of_its_columns_and_cuts_nothing_off(figure, width):
    drawing = figure()
    page = fit_to_print(drawing)
    assert page.width == pytest.approx(width) and page.height < 9.0
    content = drawing.get_tightbbox()
    assert page.x0 - 0.01 <= content.x0 and content.x1 <= page.x1 + 0.01
    assert page.y0 <= content.y0 and content.y1 <= page.y1
    plt.close(drawing)


def test_a_label_longer_than_its_panel_has_several_lines():
    figure = one_panel("error of the first transition's time, of the finest setting / s")
    fit_to_print(figure)
    (panel,) = figure.axes
    label = panel.yaxis.label
    assert label.get_text().count("\n") == 1
    assert label.get_window_extent().height <= panel.bbox.height
    plt.close(figure)


def test_text_is_legible_and_the_legend_is_below_the_panel():
    figure = one_panel()
    page = fit_to_print(figure)
    sizes = [text.get_fontsize() for text in figure.findobj(Text) if text.get_text()]
    assert min(sizes) == 6.0 and max(sizes) <= 8.0
    (legend,), (panel,) = figure.legends, figure.axes
    assert legend.get_window_extent().y1 < panel.get_window_extent().y0
    assert panel.get_position().width > 0.7 and page.width == pytest.approx(COLUMN)
    assert [text.get_text() for text in legend.get_texts()] == ["reference, taylor", "pymunk, native", "exudyn, native"]
    plt.close(figure)


def test_only_the_pdf_of_a_figure_has_the_size_for_print():
    plain = picture(one_panel(), "a", "", "", "", png=True)
    with for_print():
        printed = picture(one_panel(), "a", "", "", "", png=True)
    assert (printed.svg, printed.png.tobytes()) == (plain.svg, plain.png.tobytes()) and not len(plain.pdf)
    box = re.search(rb"/MediaBox \[ ([^]]*) \]", printed.pdf.tobytes())
    left, _, right, _ = np.array(box[1].split(), dtype=float) / 72
    assert right - left == pytest.approx(COLUMN, abs=0.01)
