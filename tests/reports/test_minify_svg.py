"""What is left out of an SVG file leaves the same picture."""

import re

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from reports.drawing import minify_svg


def points_of(path: str) -> list[tuple[float, float]]:
    """The corners of a path of M, L, l and z, by the rules of SVG."""
    output, command, here = [], "", (0.0, 0.0)
    numbers: list[float] = []
    for word in re.findall(r"[MLlz]|-?[0-9.]+(?:e-?[0-9]+)?", path):
        if word.isalpha():
            command = word
            continue
        numbers.append(float(word))
        if len(numbers) == 2:
            x, y = numbers
            here = (here[0] + x, here[1] + y) if command == "l" else (x, y)
            output.append(here)
            numbers.clear()
    return output


@settings(deadline=None)  # a busy machine is no failure
@given(st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=2, max_size=100))
def test_small_paths_go_through_the_same_points(points):
    text = "M " + " \nL ".join(f"{x:.6f} {y:.6f}" for x, y in points) + " \nz\n"
    output = minify_svg._path(text)
    drawn, given_points = np.array(points_of(output)), np.array(points)
    assert output.endswith("z") and np.abs(drawn[[0, -1]] - given_points[[0, -1]]).max() <= 0.06
    if len(points) < 30:
        assert np.abs(drawn - given_points).max() <= 0.06
        return
    # A curve loses only points that are near the lines of the others: 0.3, and 0.07 by rounding.
    assert max(np.abs(given_points - point).max(axis=1).min() for point in drawn) <= 0.06
    begin, way = drawn[:-1, None], np.diff(drawn, axis=0)[:, None]
    along = np.sum((given_points - begin) * way, axis=2) / np.maximum(np.sum(way**2, axis=2), 1e-12)
    off = given_points - begin - np.clip(along, 0.0, 1.0)[:, :, None] * way
    assert np.hypot(off[..., 0], off[..., 1]).min(axis=0).max() <= 0.38


def test_a_smooth_curve_is_drawn_with_the_points_that_show():
    x = np.linspace(0.0, 270.0, 400)
    text = "M " + " \nL ".join(f"{a:.6f} {b:.6f}" for a, b in zip(x, 50.0 * np.sin(x / 40.0), strict=True))
    assert 10 < len(points_of(minify_svg._path(text))) < 60


def test_lines_of_a_grid_are_one_path_and_nothing_else_is():
    grid, tick = '<path d="M{0} 9l0-8" clip-path="url(#c)" class="c1"/>', '<use xlink:href="#t" x="{0}" y="9"/>'
    mark = '<defs><path id="t" d="M0 0l0 3.5" class="c2"/></defs>'
    curve = '<path d="M0 0l1 1 2 3" class="c1"/>'
    svg = mark + "".join(grid.format(x) + tick.format(x) + f"<text>{x}</text>" for x in (1, 2)) + curve + grid.format(5)
    assert minify_svg._join_segments(svg) == (
        '<path d="M1 9v-8m1 0v8" clip-path="url(#c)" class="c1"/><path d="M1 9v3.5M2 9v3.5" class="c2"/>'
        "<text>1</text><text>2</text>" + curve + '<path d="M5 9v-8" clip-path="url(#c)" class="c1"/>'
    )


def test_a_path_of_several_segments_is_joined_as_they_are():
    one = '<path d="M1 9l0-8M2 9l0-8" class="c1"/>'
    assert minify_svg._join_segments(one) == '<path d="M1 9v-8m1 0v8" class="c1"/>'
    curves = '<path d="M1 9l0-8 1 1M2 9l0-8" class="c1"/>'
    assert minify_svg._join_segments(curves) == curves


_TENTHS = st.integers(-9999, 9999).map(lambda value: value / 10)


@given(st.lists(st.tuples(_TENTHS, _TENTHS, _TENTHS, _TENTHS), min_size=1, max_size=8))
@settings(max_examples=50, deadline=None)
def test_joined_segments_are_the_same_segments(segments):
    write = lambda *numbers: minify_svg._path("M {} {} L {} {}".format(*numbers))  # noqa: E731
    (path,) = re.findall(
        ' d="([^"]*)"', minify_svg._join_segments("".join(f'<path d="{write(*s)}"/>' for s in segments))
    )
    here, drawn = (0.0, 0.0), []
    for command, text in re.findall("([Mmlhv])([^Mmlhv]*)", path):
        numbers = [float(number) for number in re.findall(r"-?[\d.]+", text)]
        x, y = numbers if len(numbers) == 2 else (numbers[0], 0.0) if command == "h" else (0.0, numbers[0])
        there = (x, y) if command == "M" else (here[0] + x, here[1] + y)
        drawn += [sorted((here, there))] if command in "lhv" else []
        here = there
    # A line may be drawn from either end; the numbers have one decimal place, and their sums are rounded.
    ends = [[tuple(np.round(point, 1)) for point in segment] for segment in drawn]
    assert [sorted(pair) for pair in ends] == [sorted(((x, y), (right, down))) for x, y, right, down in segments]


def test_lines_with_dashes_are_drawn_in_their_direction():
    """Dashes begin at the start of a line."""
    lines = '<path d="M1 9l0-8" class="c1"/><path d="M2 9l0-8" class="c1"/>'
    sheet = "<style>.c1{stroke:#000;stroke-dasharray:4,1.5}</style>"
    assert "M1 9v-8M2 9v-8" in minify_svg._join_segments(sheet + lines)


def test_elements_in_a_row_share_a_group_with_their_clip_path():
    path, mark = '<path d="M0 0l1 1 2 3" clip-path="url(#{0})"/>', '<g clip-path="url(#{0})"><use x="1"/></g>'
    define = '<defs><path id="m" d="M0 0"/></defs>'
    svg = path.format("a") + define + mark.format("a") + path.format("b") + "<text/>" + mark.format("b")
    assert minify_svg._group_clipped(svg) == (
        f'<g clip-path="url(#a)"><path d="M0 0l1 1 2 3"/>{define}<use x="1"/></g>'
        '<g clip-path="url(#b)"><path d="M0 0l1 1 2 3"/></g><text/><g clip-path="url(#b)"><use x="1"/></g>'
    )


def test_a_path_that_only_moves_and_an_empty_group_are_left_out():
    svg = '<svg ><path d="M 1 2" style="fill: none"/><g id="line2d_3"/><path d="M 1 2 L 3 4"/></svg>'
    assert minify_svg.minify(svg).count("<path") == 1 and "<g" not in minify_svg.minify(svg)


def test_small_files_keep_their_picture():
    svg = (
        '<?xml version="1.0"?>\n<svg viewBox="0 0 10 10">\n <style type="text/css">*{a: b}</style>\n'
        ' <g id="line2d_1">\n  <path id="m7f" d="M 1.23456 -0.00001 \nL 2.5 1e-05 \nL 3 -1" style="fill: none"/>\n'
        '  <path d="M 0.125 3 \nC 1 2 3 4.56789 5 6" style="fill: none"/>\n  <use xlink:href="#m7f" x="1.239"/>\n'
        "  <text style=\"font: 9px 'DejaVu Sans', sans-serif; text-anchor: end\">0.123456</text>\n </g>\n</svg>\n"
    )
    output = minify_svg.minify(svg)
    assert 'd="M1.23 0l1.27 0 .5-1"' in output and 'd="M.1 3C1 2 3 4.6 5 6"' in output
    assert '<use xlink:href="#i0" x="1.2"/>' in output and 'id="i0"' in output
    assert ">0.123456<" in output and "line2d_1" not in output and "<?xml" not in output
    assert output.count("fill:none") == 1 and output.count('class="c0"') == 2
