"""A figure of the page: SVG whose colours are the page's, in the light and the dark theme."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from math import isfinite

from markupsafe import Markup, escape

from .colours import LineStyles, identifier
from .traces import Diagram, Panel, PlotScale, Trace, apart

# Sizes in pixels of the drawing: of a row, of the margins of a panel, of a line of text.
_WIDTH, _LINE, _BOTTOM, _RIGHT, _LETTER = 540.0, 14.0, 36.0, 24.0, 7.0
# Shapes of 8 pixels by the names of Matplotlib's markers.
_SHAPES = {
    "o": "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z", "s": "M-3.6-3.6h7.2v7.2h-7.2z", "D": "M0-5L5 0L0 5L-5 0z",
    "^": "M0-4.6L4.4 3.4H-4.4z", "v": "M0 4.6L4.4-3.4H-4.4z",
    "P": "M-1.6-4.4h3.2v2.8h2.8v3.2h-2.8v2.8h-3.2v-2.8h-2.8v-3.2h2.8z",
    "X": "M-4-2.2L-2.2-4L0-1.8L2.2-4L4-2.2L1.8 0L4 2.2L2.2 4L0 1.8L-2.2 4L-4 2.2L-1.8 0z",
}  # fmt: skip
# An arrow to the left, for a point beyond the axis.
_ARROW = "M4 0H-5M-1.5-3L-5 0L-1.5 3"


def svg(diagram: Diagram, looks: LineStyles, height: float = 210.0) -> Markup:
    """The figure as an SVG element; `height` of a row in pixels of a width of 540."""
    total = height * len(diagram.rows)
    parts = [
        f'<svg class="figure" viewBox="0 0 {_WIDTH:g} {total:g}" role="{"group" if _has_links(diagram) else "img"}" '
        f'aria-label="{escape(f"{diagram.title}. {diagram.caption}")}">'
    ]
    for row, panels in enumerate(diagram.rows):
        width = _WIDTH / len(panels)
        for column, panel in enumerate(panels):
            parts += _panel(panel, looks, column * width, row * height, width, height)
    return Markup("".join([*parts, "</svg>"]))


def _has_links(diagram: Diagram) -> bool:
    return any(trace.links for row in diagram.rows for panel in row for trace in panel.traces)


def _panel(panel: Panel, looks: LineStyles, left: float, top: float, width: float, height: float) -> Iterator[str]:
    """The elements of one panel in its rectangle."""
    at_ends = [trace.label for trace in panel.traces if trace.label and trace.label_at == -1]
    lines = [line for line in (panel.title, panel.y.label) if line]
    y0, y1 = top + height - _BOTTOM, top + _LINE * (len(lines) + bool(panel.spans)) + 6.0
    y = PlotScale(panel.y, (v for trace in panel.traces for v in trace.y), y0, y1)
    gap = 14.0 if panel.y.names else 7.0
    x0 = left + gap + _LETTER * max(len(text) for _, text in y.ticks())
    x1 = left + width - max(_RIGHT, *(_LETTER * len(text) + 8.0 for text in at_ends), 0.0)
    x = PlotScale(panel.x, (v for trace in panel.traces for v in trace.x), x0, x1)
    for place, line in enumerate(lines, start=1):
        yield _text(left, top + _LINE * place - 3.0, line, "start", "strong" if line == panel.title else "soft")
    for span in panel.spans:
        low, high = x(span.low), x(span.high)
        if span.is_shaded:
            yield f'<path class="shade" d="M{low:g} {y0:g}V{y1:g}H{high:g}V{y0:g}z"/>'
        if x.side(span.low) == 0:
            yield f'<path class="grid" d="M{low:g} {y0:g}V{y1:g}"/>'
        if high - low > _LETTER * len(span.name):
            yield _text(0.5 * (low + high), y1 - 4.0, span.name, "middle", "soft")
    for level in panel.levels:
        yield f'<path class="grid" d="M{x0:g} {y(level):g}H{x1:g}"/>'
    for value, text in x.ticks():
        yield f'<path class="tick" d="M{x(value):g} {y0:g}v4"/>{_text(x(value), y0 + 15.0, text, "middle")}'
    for value, text in y.ticks():
        line = "" if panel.y.names else f'<path class="tick" d="M{x0 - 4.0:g} {y(value):g}h4"/>'
        yield line + _text(x0 - gap, y(value) + 4.0, text, "end")
    yield _text(0.5 * (x0 + x1), y0 + 29.0, panel.x.label, "middle", "soft")
    labels = [trace for trace in panel.traces if trace.label]
    places = apart([y(trace.label_point[1]) for trace in labels], _LINE - 1.0, y1 + 4.0, y0)
    heights = dict(zip((id(trace) for trace in labels), places, strict=True))
    for trace in panel.traces:
        yield _group(trace.solver, trace.route, "".join(_trace(trace, x, y, looks, heights.get(id(trace)))))
    for solver, route, value, row, text in panel.medians:
        at, is_far = x(value), x(value) > x1 - 70.0
        words = _text(
            at + (-5.0 if is_far else 5.0), y(row) - 11.0, text, "end" if is_far else "start", "strong outlined"
        )
        yield _group(solver, route, f'<path class="median" d="M{at:g} {y(row) - 17.0:g}v34"/>{words}')


def _group(solver: str, route: str, content: str) -> str:
    """Elements of a route, which the page's switches hide."""
    if not solver:
        return f'<g class="truth">{content}</g>'
    switch = f' data-route="{escape(route)}"' if route and solver != "reference" else ""
    return f'<g data-solver="{escape(solver)}"{switch} style="--of:var(--of-{identifier(solver)})">{content}</g>'


def _trace(trace: Trace, x: PlotScale, y: PlotScale, looks: LineStyles, label_y: float | None) -> Iterator[str]:
    points = [(x(a), y(b)) if isfinite(a) and isfinite(b) else None for a, b in zip(trace.x, trace.y, strict=True)]
    if not trace.is_marked:  # a line ends where it leaves the axes
        outside = [bool(x.side(a) or y.side(b)) for a, b in zip(trace.x, trace.y, strict=True)]
        points = [None if is_outside else point for point, is_outside in zip(points, outside, strict=True)]
    if trace.is_line:
        dashed = " dashed" if looks.is_dashed(trace.solver, trace.route) else ""
        yield f'<path class="curve{dashed}" d="{_path(points)}"/>'
    for i, (low, high) in enumerate(zip(trace.low, trace.high, strict=True)):
        point = points[i]
        if point and y(low) != y(high):
            yield f'<path class="curve" d="M{point[0]:g} {y(low):g}V{y(high):g}"/>'
    if trace.is_marked:
        shape = _SHAPES[looks.marker(trace.solver)]
        for i, point in enumerate(points):
            if point:
                yield _mark(trace, i, point, shape, x.side(trace.x[i]), y.side(trace.y[i]))
    if label_y is not None:
        place = x(trace.label_point[0]) + 6.0
        yield _text(place, label_y + 4.0, trace.label, "start", "name outlined")


def _mark(trace: Trace, i: int, point: tuple[float, float], shape: str, side_x: int, side_y: int) -> str:
    """One point: a marker, or an arrow for one beyond an axis; with its text, and its address."""
    turn = 0 if side_x < 0 else 180 if side_x > 0 else -90 if side_y < 0 else 90 if side_y > 0 else None
    look = " hollow" if i in trace.hollow else " pale" if i in trace.pale else ""
    where = f"translate({point[0]:g} {point[1]:g})" + ("" if turn is None else f" rotate({turn})")
    tip = f"<title>{escape(trace.tips[i])}</title>" if trace.tips else ""
    kind, path = ("mark", shape) if turn is None else ("arrow", _ARROW)
    mark = f'<path class="{kind}{look}" transform="{where}" d="{path}">{tip}</path>'
    return f'<a href="{escape(trace.links[i])}" tabindex="-1">{mark}</a>' if trace.links else mark


def _path(points: Sequence[tuple[float, float] | None]) -> str:
    """A line through points, interrupted where there is none; from point to point, which is shorter than by places."""
    parts = []
    for is_there, group in groupby(points, key=bool):
        line = [point for point in group if point]
        if is_there:
            steps = "".join(f"l{_short(b[0] - a[0])} {_short(b[1] - a[1])}" for a, b in pairwise(line))
            parts.append(f"M{line[0][0]:g} {line[0][1]:g}{steps}".replace(" -", "-"))
    return "".join(parts)


def _short(length: float) -> str:
    """A difference of two positions, which have one decimal."""
    text = f"{round(length, 1):g}"
    return text.replace("0.", ".") if abs(length) < 1.0 else text


def _text(x: float, y: float, text: str, anchor: str, style: str = "") -> str:
    style = f' class="{style}"' if style else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{style}>{escape(text)}</text>' if text else ""
