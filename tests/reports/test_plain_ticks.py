"""Ticks that are drawn as few artists are those of Matplotlib's axes: the same places, lines and texts in the file."""

import re

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from reports.drawing.figure_files import for_print, picture
from reports.drawing.plain_ticks import plain_ticks
from reports.drawing.style import STYLE, logarithmic

TEXT = re.compile(r'<text[^>]* x="([^"]*)" y="([^"]*)"[^>]*>([^<]*)</text>')


def drawn(x, y, logs: str, is_plain: bool) -> str:
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(4.0, 3.0))
        ax = figure.subplots(gridspec_kw={"left": 0.25, "bottom": 0.25})
        ax.plot(x, y)
        logarithmic(ax, logs)
        ax.set(xlabel="time / s", ylabel="slip velocity / (m/s)")
        if is_plain:
            plain_ticks(ax)
        return picture(figure, "one", "", "", "", has_margins=True).svg


@pytest.mark.parametrize(
    ("x", "y", "logs"),
    [
        ([0.0, 1.0], [-0.3, 0.7], ""),
        ([0.0, 2e-6], [1e6 + 0.1, 1e6 + 0.2], ""),  # a common factor, and a common summand
        ([1.0, 3e4], [1e-12, 0.2], "xy"),
        ([0.02, 0.9], [0.0, 1.0], "x"),
    ],
)
def test_texts_lines_and_marks_are_those_of_matplotlibs_axes(x, y, logs):
    ours, theirs = drawn(x, y, logs, True), drawn(x, y, logs, False)
    texts = {text: np.array([float(a), float(b)]) for a, b, text in TEXT.findall(ours)}
    expected = {text: np.array([float(a), float(b)]) for a, b, text in TEXT.findall(theirs)}
    assert texts.keys() == expected.keys() and len(texts) > 8
    # Matplotlib leaves room for the tallest of its texts below an axis, which differs by versions: 2 points.
    assert max(np.abs(texts[text] - expected[text]).max() for text in texts) <= 2.0
    ticks = [text for text in texts if re.fullmatch("[−0-9.·⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", text)]
    assert len(ticks) > 5 and max(np.abs(texts[text] - expected[text]).max() for text in ticks) <= 0.1
    for look in ("#e6e6e6", "stroke-width:.8"):  # the grid, the marks
        assert ends(ours, look) == ends(theirs, look)


def ends(svg: str, look: str) -> set[tuple[float, float]]:
    """The ends of all lines whose class has that look."""
    names = re.findall(r"\.(c\d+)\{[^}]*" + re.escape(look), svg)
    result, here = set(), (0.0, 0.0)
    for path in re.findall(rf'<path d="([^"]*)"[^>]* ?class="(?:{"|".join(names)})"/>', svg):
        for command, text in re.findall("([Mmlhv])([^Mmlhvz]*)", path):
            numbers = [float(number) for number in re.findall(r"-?[\d.]+", text)]
            x, y = numbers[:2] if len(numbers) >= 2 else (numbers[0], 0.0) if command == "h" else (0.0, numbers[0])
            here = (x, y) if command == "M" else (here[0] + x, here[1] + y)
            result.add((round(here[0], 1), round(here[1], 1)))
    assert result
    return result


def test_a_figure_for_print_keeps_matplotlibs_ticks_which_change_with_its_size():
    with for_print(True), matplotlib.rc_context(STYLE):
        ax = Figure().subplots()
        plain_ticks(ax)
    assert ax.yaxis.get_visible() and not ax.texts
