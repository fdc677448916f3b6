"""A curve run through backwards: the outline of a plate as the track of another one, which then lies on its left."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from ..formulas import formula_symbols
from . import Curve
from .chain import Chain
from .corner import Corner
from .pieces import CurvePieces


@lru_cache(maxsize=512)
def backwards(curve: Curve) -> Curve:
    """The same curve in the other direction; `forwards` gives the parameters of the curve itself."""
    if isinstance(curve, Chain):
        return Chain([backwards(piece) for piece in reversed(curve.pieces)], curve.is_closed)
    if curve.parts is not None:
        return Curve.in_pieces(_pieces(curve.parts), curve.residual, curve.may_cross)
    domain = None if curve.domain is None else (-curve.domain[1], -curve.domain[0])
    return Curve(lambda s: curve.at(-s), domain, curve.residual, curve.may_cross)


def forwards(curve: Curve, s):
    """The parameter of a curve at the parameter `s` of `backwards` of it, a number or an array."""
    if not isinstance(curve, Chain):
        return -s
    last = [element for element in curve.elements if not isinstance(element.piece, Corner)][-1]
    return last.start + (last.piece.span[1] - last.piece.span[0]) - (s - backwards(curve).span[0])


def _pieces(parts: CurvePieces) -> CurvePieces:
    forms = []
    for (x, y), symbols in parts.forms:
        s = formula_symbols.PARAMETER
        turned = {s: -s, symbols[0]: -symbols[0]}
        forms.append(((x.xreplace(turned), y.xreplace(turned)), symbols))
    return replace(
        parts,
        breaks=tuple(-s for s in reversed(parts.breaks)),
        forms=tuple(forms),
        form_numbers=tuple(reversed(parts.form_numbers)),
        origins=tuple(-s for s in reversed(parts.origins)),
        sizes=tuple(reversed(parts.sizes)),
        inner_edges=tuple(tuple(-s for s in reversed(edges)) for edges in reversed(parts.inner_edges)),
    )
