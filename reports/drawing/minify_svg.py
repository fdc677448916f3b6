"""Shorter SVG text for the same picture, as Matplotlib writes it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

# Matplotlib's typeface first; the fallbacks are equally wide.
_TYPEFACES = "DejaVu Sans, Verdana, sans-serif"


def minify(svg: str) -> str:
    """Shorten an SVG without visible change.

    Coordinates are rounded to a tenth of a point, points that a curve's shape does not need are left out, shared styles
    become classes, lines of a grid and marks of an axis become one path each, and elements in a row share a group with
    their clip path or class. Metadata and elements that draw nothing are removed.
    """
    svg = re.sub(r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    # Marks are small: a hundredth of a point shows in their shape.
    svg = re.sub(r'( id="[^"]*")? d="([^"]*)"', lambda m: f'{m[1] or ""} d="{_path(m[2], 2 if m[1] else 1)}"', svg)
    # Matplotlib before 3.9 lists the place of every letter of some texts.
    svg = re.sub(r' (x|y)="([^"]*)"', lambda m: f' {m[1]}="{" ".join(_short(float(n)) for n in m[2].split())}"', svg)
    svg = re.sub(r"\s*\n\s*", "\n", svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)  # groups are named and never referred to
    for place, name in enumerate(dict.fromkeys(re.findall(r' id="([^"]*)"', svg))):
        svg = svg.replace(f'"{name}"', f'"i{place}"')
        svg = re.sub(rf'#{re.escape(name)}(?=["\)])', f"#i{place}", svg)  # one name may be the prefix of another
    svg = re.sub(
        r"(rotate\([-\d.]+) ([-\d.]+) ([-\d.]+)\)",
        lambda m: f"{m[1]} {_short(float(m[2]))} {_short(float(m[3]))})",
        svg,
    )
    svg = re.sub(r'font-family: [^;"]*;? ?|(?<=style="); | transform="rotate\(-?0 [^"]*"', "", svg)
    svg = re.sub(r'style="([^"]*)"', lambda m: f'style="{_style(m[1])}"', svg)
    svg = _NOTHING.sub("", _bare_groups(_unique_ids(_styles_once(svg))))
    svg = _group_texts(_group_clipped(_join_segments(svg)))
    return svg.replace("<svg ", f'<svg font-family="{_TYPEFACES}" ', 1).strip() + "\n"


# Elements that draw nothing: a path that only moves, and an empty group.
_NOTHING = re.compile(r'<path d="(?:M[-\d. ]+)?"[^>]*/>|<g/>')


def _style(text: str) -> str:
    """A style without spaces, zeros before a decimal point, doubled digits of a colour, and a dash offset of zero."""
    text = re.sub(r"\s*([:;,])\s*", r"\1", text.replace("stroke-dashoffset: 0", "")).strip(";").replace(";;", ";")
    return re.sub(r"#(\w)\1(\w)\2(\w)\3\b", r"#\1\2\3", re.sub(r"(?<=[:,])0(?=\.)", "", text))


# A path with a clip path, and a group with one that contains no group.
_CLIPPED = re.compile(r'(<path\b[^>]*) (clip-path="[^"]*")([^>]*/>)')
_CLIP_GROUP = re.compile(r'(<g clip-path="[^"]*">)((?:(?!</?g\b).)*)</g>', re.DOTALL)
_DEFINITIONS = re.compile(r"(?:<defs>(?:(?!</defs>).)*</defs>)*", re.DOTALL)


def _group_clipped(svg: str) -> str:
    """One group around elements in a row with the same clip path, also if definitions are between them."""
    pieces = _CLIP_GROUP.split(_CLIPPED.sub(r"<g \2>\1\3</g>", svg))
    parts, group = pieces[:1], ""
    for start, content, after in zip(pieces[1::3], pieces[2::3], pieces[3::3], strict=True):
        if start != group:
            parts += ["</g>" if group else "", start]
        group = start if _DEFINITIONS.fullmatch(after) else ""
        parts += [content, "" if group else "</g>", after]
    return "".join(parts) + ("</g>" if group else "")


# At least three texts in a row with the same class, as the labels of an axis have; fewer are longer with a group.
_TEXTS = re.compile(r'<text (class="[^"]*")[^>]*>[^<]*</text>(?:<text \1[^>]*>[^<]*</text>){2,}')


def _group_texts(svg: str) -> str:
    """A group with the class of texts in a row."""
    return _TEXTS.sub(lambda m: f"<g {m[1]}>{m[0].replace(f' {m[1]}', '')}</g>", svg)


_Point = tuple[float, float]
# A path with at least this many points is a curve: its points are close to each other. Those this near (points, 1/72
# inch) to the line between their neighbours are left out: lines are three to five times as wide.
_CURVE, _NEAR = 30, 0.3


def _short(value: float, digits: int = 1) -> str:
    """The number without zeros that it does not need: .5, -.5, 3."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text


def _path(text: str, digits: int = 1) -> str:
    """A path rounded to so many digits, with relative coordinates, which take half the characters; of a curve only the
    points that its shape needs."""
    if re.search(r"[^-MLze\d\s.+]", text):  # Bézier curves
        words = re.findall(r"[A-Za-z]|-?[0-9.]+(?:e[-+]?[0-9]+)?", text)
        return re.sub(
            r" (?=[A-Za-z-])|(?<=[A-Za-z]) ",
            "",
            " ".join(w if w.isalpha() else _short(float(w), digits) for w in words),
        )
    parts = [
        (part, [float(word) for word in part.replace("L", " ").replace("z", " ").split()]) for part in text.split("M")
    ]
    is_curve = sum(len(numbers) // 2 for _, numbers in parts) >= _CURVE
    texts = []
    for part, numbers in parts[1:]:
        points = list(zip(numbers[::2], numbers[1::2], strict=True))
        texts.append(_relative(_simplify(points) if is_curve else points, digits) + "z" * ("z" in part))
    return "".join(texts)


def _relative(points: Sequence[_Point], digits: int) -> str:
    """The text of a part of a path."""
    texts, here = [], (0.0, 0.0)
    for place, (x, y) in enumerate(points):
        # Differences of rounded positions, so that rounding errors do not add up.
        there = round(x, digits), round(y, digits)
        pair = f"{_short(there[0] - here[0], digits)} {_short(there[1] - here[1], digits)}".replace(" -", "-")
        texts.append(("M" if place == 0 else "l" if place == 1 else "" if pair.startswith("-") else " ") + pair)
        here = there
    return "".join(texts)


def _simplify(points: Sequence[_Point]) -> Sequence[_Point]:
    """A part of a path without the points near the line between their neighbours (Ramer, Douglas and Peucker's
    method)."""
    places = np.array(points)
    corners, spans = {0, len(points) - 1}, [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        chord, others = places[last] - places[first], places[first + 1 : last] - places[first]
        # Most spans have few points, for which calls of np.clip and max take longer than their arithmetic.
        along = np.minimum(np.maximum(others @ chord / max(float(chord @ chord), 1e-12), 0.0), 1.0)
        distance = np.hypot(*(others - along[:, None] * chord).T)
        farthest = int(distance.argmax())
        if distance[farthest] > _NEAR:
            middle = first + 1 + farthest
            corners.add(middle)
            spans += [(first, middle), (middle, last)]
    return [points[place] for place in sorted(corners)]


# A segment: a path of two points, as a line of a grid; a path of several; and a mark that repeats a segment, as the
# ticks of an axis do.
_SEGMENT = re.compile(r'<path d="M(-?[\d.]+) ?(-?[\d.]+)l(-?[\d.]+) ?(-?[\d.]+)"([^>]*)/>')
_SEGMENTS = re.compile(r'<path d="((?:M-?[\d.]+ ?-?[\d.]+l-?[\d.]+ ?-?[\d.]+){2,})"([^>]*)/>')
_MARK = re.compile(r'<use xlink:href="#([^"]*)" x="([^"]*)" y="([^"]*)"/>')
_MARKER = re.compile(r'<path id="([^"]*)" d="M0 0(l[-\d. ]+)" (class="[^"]*")/>')
# What Matplotlib writes between the lines and marks of an axis, over which none of them is drawn.
_OF_AXIS = re.compile(r"<text\b[^>]*>[^<]*</text>|<defs>(?:<path[^>]*/>)*</defs>")
_ELEMENT = re.compile(rf"{_OF_AXIS.pattern}|<[^>]*>|[^<]+")


# A class whose lines have dashes.
_DASHED_CLASS = re.compile(r"\.(c\d+)\{[^}]*dasharray")


def _pair(x: float, y: float) -> str:
    """Two coordinates; marks have a hundredth of a point."""
    return f"{_short(x, 2)} {_short(y, 2)}".replace(" -", "-")


def _straight(start: _Point, end: _Point) -> str:
    """The part of a path that draws a line."""
    x, y = (_short(b - a, 2) for a, b in zip(start, end, strict=True))
    return f"v{y}" if x == "0" else f"h{x}" if y == "0" else f"l{x} {y}".replace(" -", "-")


def _next_segment(start: _Point, end: _Point, before: _Point, reversible: bool) -> tuple[str, _Point]:
    """The shortest text of a further segment of a path that ends at `before`, and where it then ends.

    `reversible`: it may be drawn from its end, as lines without dashes may."""
    texts = [(f"M{_pair(*start)}{_straight(start, end)}", end)]
    for a, b in ((start, end), (end, start))[: 1 + reversible]:
        texts.append((f"m{_pair(a[0] - before[0], a[1] - before[1])}{_straight(a, b)}", b))
    return min(texts, key=lambda text: len(text[0]))


def _join_segments(svg: str) -> str:
    """Join segments with the same attributes that only texts and other segments separate into one path."""
    markers = {name: (shift, look) for name, shift, look in _MARKER.findall(svg)}
    dashed = {f' class="{name}"' for name in _DASHED_CLASS.findall(svg)}

    def as_segment(use: re.Match) -> str:
        if use[1] not in markers:
            return use[0]
        shift, look = markers[use[1]]
        return f'<path d="M{use[2]} {use[3]}{shift}" {look}/>'

    parts: list[str] = []
    paths: dict[str, int] = {}  # attributes of the segments since the last other element, and their path's place
    ends: dict[str, _Point] = {}  # and where that path ends
    svg = _SEGMENTS.sub(lambda m: "".join(f'<path d="M{one}"{m[2]}/>' for one in m[1].split("M")[1:]), svg)
    for element in _ELEMENT.findall(_MARK.sub(as_segment, svg)):
        segment = _SEGMENT.fullmatch(element)
        if segment is None:
            paths = paths if _OF_AXIS.fullmatch(element) else {}
            parts.append(element)
            continue
        *numbers, look = segment.groups()
        x, y, right, down = map(float, numbers)
        start, end = (x, y), (x + right, y + down)
        if look not in paths:
            paths[look] = len(parts) + 1
            parts += ['<path d="', f"M{_pair(*start)}{_straight(start, end)}", f'"{look}/>']
            ends[look] = end
            continue
        has_dashes = "dasharray" in look or any(look.endswith(name) for name in dashed)
        line, ends[look] = _next_segment(start, end, ends[look], reversible=not has_dashes)
        parts[paths[look]] += line
    svg = "".join(parts)
    unused = [name for name in markers if f'"#{name}"' not in svg]
    for name in unused:
        svg = re.sub(rf'<path id="{name}"[^>]*/>', "", svg)
    return svg.replace("<defs></defs>", "")


def _unique_ids(svg: str) -> str:
    """Remove the class of a marker if the path that it repeats has the same class."""
    classes = dict(re.findall(r'<path id="([^"]*)" d="[^"]*" class="([^"]*)"', svg))
    return re.sub(
        r'(<use xlink:href="#([^"]*)"[^>]*?) class="([^"]*)"',
        lambda m: m[1] if classes.get(m[2]) == m[3] else m[0],
        svg,
    )


def _bare_groups(svg: str) -> str:
    """Remove groups without attributes."""
    parts, bare = [], []
    for part in re.split(r"(<g\b[^>]*>|</g>)", svg):
        if part.startswith("<g") and part.endswith("/>"):
            parts.append(part)  # an empty element
        elif part.startswith("<g"):
            bare.append(part == "<g>")
            parts.append("" if bare[-1] else part)
        else:
            parts.append("" if part == "</g>" and bare.pop() else part)
    return re.sub(r">\n+<", "><", "".join(parts))


def _styles_once(svg: str) -> str:
    """Replace styles that several elements share by classes of a style sheet."""
    counts = Counter(re.findall(r'style="([^"]*)"', svg))
    names = {style: f"c{i}" for i, style in enumerate(style for style, count in counts.items() if count > 1)}
    svg = re.sub(r'style="([^"]*)"', lambda m: f'class="{names[m[1]]}"' if m[1] in names else m[0], svg)
    sheet = "".join(f".{name}{{{style}}}\n" for style, name in names.items())
    return svg.replace("</style>", f"\n{sheet}</style>", 1)
