"""Figures as files: what is left out of them leaves a whole picture."""

import xml.etree.ElementTree as ET

import matplotlib
from matplotlib import pyplot as plt
from PIL import Image

from reports.drawing import figure_files, minify_svg, style


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


def test_an_empty_group_stays_closed():
    ET.fromstring(minify_svg.minify('<svg ><g id="one"><g id="two"/><path d="M 0 0 L 1.234567 2"/></g></svg>'))


def test_a_name_that_begins_another_is_not_taken_for_it():
    svg = '<svg ><path id="Sans-5"/><path id="Sans-5c"/><use xlink:href="#Sans-5c"/><use xlink:href="#Sans-5"/></svg>'
    assert minify_svg.minify(svg).count('href="#i1"') == minify_svg.minify(svg).count('href="#i0"') == 1


def test_a_path_of_two_pieces_keeps_both():
    assert minify_svg._path("M 1 1 L 2 1 L 2 2 z M 5 5 L 6 5 z") == "M1 1l1 0 0 1zM5 5l1 0z"


def test_places_of_single_letters_are_rounded():
    """As Matplotlib 3.8 writes them."""
    svg = '<svg ><text><tspan x="0 5.726074" y="-1.004">ab</tspan></text></svg>'
    assert '<tspan x="0 5.7" y="-1">' in minify_svg.minify(svg)


def test_text_stays_text_after_the_style_of_a_figure_ended(tmp_path):
    """The outlines of letters were most of the paper's figures."""
    with matplotlib.rc_context(style.STYLE):
        figure, ax = plt.subplots()
        ax.set_title("a title")
    with matplotlib.rc_context({"svg.fonttype": "path"}):
        figure_files.save(figure, tmp_path, "figure", "", "Title", "Words")
    assert ">a title<" in (tmp_path / "figure.svg").read_text()


def test_a_png_has_a_palette_and_the_colours_of_its_figure(tmp_path):
    with matplotlib.rc_context(style.STYLE):
        figure, ax = plt.subplots(figsize=(2, 2))
        ax.axhspan(0.2, 0.8, color="#0072b2")
        figure_files.save(figure, tmp_path, "figure", "", "Title", "Words", png=True)
    with Image.open(tmp_path / "figure.png") as image:
        assert image.mode == "P"
        colours = {colour for _, colour in image.convert("RGB").getcolors()}
    assert {(255, 255, 255), (0x00, 0x72, 0xB2)} <= colours


def test_numbers_have_no_zeros_that_they_do_not_need():
    numbers = {0.5: ".5", -0.5: "-.5", 10.04: "10", -0.04: "0", 0.0: "0", 100.0: "100", 20.5: "20.5"}
    assert {value: minify_svg._short(value) for value in numbers} == numbers
    assert minify_svg._path("M 0.5 0.5 L 1 0.2 L 1.5 0.4") == "M.5 .5l.5-.3 .5 .2"
