"""Figures as files: what is left out of them leaves a whole picture."""

import xml.etree.ElementTree as ET

import matplotlib
from matplotlib import pyplot as plt

from reports.drawing import figure_files, style


def test_a_figure_is_well_formed_and_says_how_it_is_made(tmp_path):
    with matplotlib.rc_context(style.STYLE):
        figure, ax = plt.subplots()
        ax.bar([0, 1], [1.0, float("nan")])
        ax.plot([], [], "o")  # nothing to draw: a group without content
        ax.text(0.5, 0.5, "")
        drawn = figure_files.save(figure, tmp_path, "figure", "case", "Title", "Words")
    figure_files.embed_command(tmp_path, drawn, "python -m reports.build --case a<b")
    output = ET.parse(tmp_path / "figure.svg").getroot()
    assert "--case a<b" in next(child.text or "" for child in output if child.tag.endswith("desc"))


def test_text_stays_text_after_the_style_of_a_figure_ended(tmp_path):
    """The outlines of letters were most of the paper's figures."""
    with matplotlib.rc_context(style.STYLE):
        figure, ax = plt.subplots()
        ax.set_title("a title")
    with matplotlib.rc_context({"svg.fonttype": "path"}):
        figure_files.save(figure, tmp_path, "figure", "", "Title", "Words")
    assert ">a title<" in (tmp_path / "figure.svg").read_text()
