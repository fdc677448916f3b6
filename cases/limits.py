"""What the reference does not compute, or computes without a certificate: one table, each row with its reason.

`limit` decides by the table; the checks of a case, `reference.simulate`, sweeps, certificates and `cases check` read
it. `python -m cases.limits > docs/limits.md` writes the page of limits, and a test compares them.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from typing import Any, NamedTuple

from .chain import Chain
from .corner import Corner
from .effects import Drive, Flight, Impact, Unilateral
from .errors import BadValue, DoesNotFit
from .free_plates import MOST, why_not_closed_forms
from .outline_features import arc_ranges, features, is_arc, sides
from .own_effects import own_effects
from .supports import has_belt, has_rolling_resistance, has_slip_law, is_hill, is_hollow, is_straight


class Scope(StrEnum):
    """The motions that a limit is for."""

    ANY = "any motion"
    SEVERAL_CONTACTS = "a plate with several contacts"
    SEVERAL_PLATES = "several plates"
    SWEEP = "a sweep"
    CERTIFICATE = "a certificate of several contacts"


class Reason(StrEnum):
    """Why there is a limit."""

    MECHANICS = "mechanics"
    NOT_BUILT = "not built yet"


class Limit(NamedTuple):
    """One limit: what a case must not have in a scope.

    `applies`: what of a case has the limit, as text for `sentence`, or True; falsy if it has none. `sentence` says what
    to give instead, without a capital and a period. `why`: the reason in words.
    """

    scope: Scope
    feature: str
    applies: Callable[[Any], object]
    sentence: str
    reason: Reason
    why: str


def _curves(case: Any) -> tuple[Any, ...]:
    return (case.track, *(support.curve for support in case.supports))


def _own(case: Any) -> str:
    return next((type(effect).__name__ for effect in own_effects(case.effects)), "")


def _missing(case: Any) -> str:
    """The first effect that plates need in order to part and meet."""
    needs = {Unilateral: "Unilateral()", Flight: "Flight()"}
    return next((text for kind, text in needs.items() if case.effect(kind) is None), "")


def _has_corners(case: Any) -> bool:
    return isinstance(case.plate.outline, Chain)


def _is_by_curves(case: Any) -> bool:
    """Whether its contacts are certified by the shapes of its curves: one plate with corners or pieces, or supports."""
    return not case.others and bool(case.supports or _has_corners(case) or isinstance(case.track, Chain))


def _is_by_features(case: Any) -> bool:
    """The same with contacts of corners and arcs."""
    return not case.others and _has_corners(case)


def _bends_away(case: Any) -> bool:
    return _is_by_features(case) and not all(
        is_straight(curve) or is_hollow(curve) or (is_hill(curve) and sides(case.plate.outline))
        for curve in _curves(case)
        if not isinstance(curve, Chain)
    )


def _has_no_features(case: Any) -> bool:
    outline = case.plate.outline
    return _is_by_features(case) and not (outline.is_closed and features(outline))


def _has_other_pieces(case: Any) -> bool:
    return _is_by_features(case) and not all(
        isinstance(piece, Corner) or is_arc(piece) for piece in features(case.plate.outline)
    )


def _has_arcs_on_curves(case: Any) -> bool:
    is_curved = not all(is_straight(curve) for curve in _curves(case) if not isinstance(curve, Chain))
    return _is_by_features(case) and is_curved and any(one is not None for one in arc_ranges(case.plate.outline))


_PARTS = "only the solver in poses follows contacts from part to part of a curve"
_SWEEP = "a sweep does not support {}; simulate such cases one by one"
_ARRAYS = "the rules of decisions on arrays are for one contact with constant coefficients"

# The first row of a scope that applies is the one that is reported.
LIMITS = (
    Limit(
        Scope.ANY,
        "a plate of infinite inertia with RollingResistance",
        lambda case: not case.plate.turns and has_rolling_resistance(case),
        "a plate of infinite inertia does not turn; leave RollingResistance out",
        Reason.MECHANICS,
        "a plate that does not turn does not roll",
    ),
    Limit(
        Scope.ANY,
        "a plate of infinite inertia on a track that turns (angle of Drive)",
        lambda case: not case.plate.turns and (drive := case.effect(Drive)) is not None and drive.is_turning,
        "a plate of infinite inertia on a track that turns is not supported; leave angle of Drive out",
        Reason.NOT_BUILT,
        "equations are in the track's frame, in which such a plate turns",
    ),
    Limit(
        Scope.SEVERAL_CONTACTS,
        "an effect of a package",
        _own,
        "{} with several contacts is not supported; leave it out",
        Reason.NOT_BUILT,
        "such an effect is a force at one contact",
    ),
    Limit(
        Scope.SEVERAL_CONTACTS,
        "no Unilateral (a guide that pulls, too)",
        lambda case: case.effect(Unilateral) is None,
        "a bilateral guide with several contacts is not supported; add Unilateral to the effects",
        Reason.NOT_BUILT,
        "the modes of several contacts are those of contacts that only push",
    ),
    Limit(
        Scope.SEVERAL_PLATES,
        f"more than {MOST} plates",
        lambda case: len(case.others) >= MOST,
        f"a case has at most {MOST} plates; leave some of the others out",
        Reason.NOT_BUILT,
        "modes are enumerated, four for each contact of plates that touch each other",
    ),
    Limit(
        Scope.SEVERAL_PLATES,
        "an effect of a package",
        _own,
        "{0} with several plates is not supported; leave {0} out",
        Reason.NOT_BUILT,
        "such an effect is a force at one contact",
    ),
    Limit(
        Scope.SEVERAL_PLATES,
        "no Unilateral or Flight",
        _missing,
        "several plates may part and meet; add {} to the effects",
        Reason.MECHANICS,
        "plates that are not guided part and meet",
    ),
    Limit(Scope.SWEEP, "supports", lambda case: case.supports, _SWEEP.format("supports"), Reason.NOT_BUILT, _ARRAYS),
    Limit(
        Scope.SWEEP,
        "several plates",
        lambda case: case.others,
        _SWEEP.format("several plates (others)"),
        Reason.NOT_BUILT,
        _ARRAYS,
    ),
    Limit(Scope.SWEEP, "an effect of a package", _own, _SWEEP, Reason.NOT_BUILT, _ARRAYS),
    Limit(
        Scope.SWEEP,
        "a mu that depends on the slip speed",
        has_slip_law,
        _SWEEP.format("a mu that depends on the slip velocity"),
        Reason.NOT_BUILT,
        _ARRAYS,
    ),
    Limit(
        Scope.SWEEP,
        "Drive",
        lambda case: case.effect(Drive) is not None,
        _SWEEP.format("a driven track"),
        Reason.NOT_BUILT,
        _ARRAYS,
    ),
    Limit(
        Scope.CERTIFICATE,
        "several plates with a Drive, or a Load of a further plate",
        lambda case: case.others and (case.effect(Drive) is not None or any(other.load for other in case.others)),
        "several plates have a Drive or a Load of their own; leave both out",
        Reason.NOT_BUILT,
        "the second formulation has the loads of the first plate only",
    ),
    Limit(
        Scope.CERTIFICATE,
        "several plates that are no discs and one convex polygon on straight lines",
        lambda case: case.others and why_not_closed_forms(case),
        "several plates are certified as discs and at most one convex polygon on straight lines, and {}",
        Reason.NOT_BUILT,
        "the second formulation has contacts with closed forms only",
    ),
    Limit(
        Scope.CERTIFICATE,
        "a track or support with edges",
        lambda case: _is_by_curves(case) and any(_has_edge(curve) for curve in _curves(case)),
        "a plate on a track with an edge has one contact; give a line as track if it stays on one part",
        Reason.NOT_BUILT,
        _PARTS,
    ),
    Limit(
        Scope.CERTIFICATE,
        "a track or support with corners",
        lambda case: _is_by_curves(case) and any(isinstance(curve, Chain) for curve in _curves(case)),
        "a plate on a track with corners has one contact; give a line as track and its other parts as supports",
        Reason.NOT_BUILT,
        _PARTS,
    ),
    Limit(
        Scope.CERTIFICATE,
        "supports, and a curve through points or in pieces",
        lambda case: bool(case.supports) and not case.others and _in_parts(case),
        "a curve in parts has one contact; give curves by formulas",
        Reason.NOT_BUILT,
        _PARTS,
    ),
    Limit(
        Scope.CERTIFICATE,
        "supports, and a plate with corners that does not turn",
        lambda case: bool(case.supports) and _is_by_features(case) and not case.plate.turns,
        "a plate of infinite inertia with corners has one contact; give a smooth outline",
        Reason.NOT_BUILT,
        "a side of such a plate lies flat in every pose",
    ),
    Limit(
        Scope.CERTIFICATE,
        'supports, a Belt, and Impact(law="newton")',
        lambda case: bool(case.supports) and not case.others and _is_newton(case) and has_belt(case),
        "Newton's law of impact at belts has one contact; give law='poisson'",
        Reason.NOT_BUILT,
        "the second formulation compares energies without what a belt gives",
    ),
    Limit(
        Scope.CERTIFICATE,
        "a plate with corners on a curve that bends away from it, but for a convex polygon on a closed hill",
        _bends_away,
        "a plate with corners has several contacts on a straight track without ends or one that bends to its plate's "
        "side everywhere, a convex polygon also on a closed one that bends away from it; give such a track",
        Reason.NOT_BUILT,
        "elsewhere the nearest points of a pair are not unique, and the second formulation watches one pair each",
    ),
    Limit(
        Scope.CERTIFICATE,
        "an open outline, or one without a corner or arc that bulges",
        _has_no_features,
        "the outline is not closed, or has no corner or arc that bulges; give one that is and has",
        Reason.NOT_BUILT,
        "the second formulation watches corners and arcs that bulge",
    ),
    Limit(
        Scope.CERTIFICATE,
        "an outline with a round piece that is no arc of a circle",
        _has_other_pieces,
        "a round piece of the outline is no arc of a circle; give one whose pieces are edges and arcs",
        Reason.NOT_BUILT,
        "the second formulation watches corners and arcs that bulge",
    ),
    Limit(
        Scope.CERTIFICATE,
        "an outline with an arc that ends at a corner, on a curved track",
        _has_arcs_on_curves,
        "an arc of the outline ends at a corner, or bends beyond its hull; on a curved track give corners only",
        Reason.NOT_BUILT,
        "an arc's range of angles is compared with straight lines only",
    ),
)


def _has_edge(curve: Any) -> bool:
    return isinstance(curve, Chain) and any(
        isinstance(one.piece, Corner) and one.piece.turn < 0.0 for one in curve.elements
    )


def _in_parts(case: Any) -> bool:
    curves = (*_curves(case), case.plate.outline)
    return any(curve.parts is not None for curve in curves if not isinstance(curve, Chain))


def _is_newton(case: Any) -> bool:
    law = case.effect(Impact)
    return law is not None and law.law == "newton"


def limit(case: Any, scope: Scope) -> str:
    """The first limit of a scope that a case has, in a sentence without its capital and period that says what to give
    instead; "" if it has none."""
    for row in LIMITS:
        if row.scope is scope and (what := row.applies(case)):
            return row.sentence.format(what)
    return ""


def as_sentence(reason: str) -> str:
    """A limit as a sentence with capital and period; "" for none."""
    return f"{reason[0].upper()}{reason[1:]}." if reason else ""


def check_limits(case: Any) -> None:
    """Raise BadValue or DoesNotFit, with a sentence, for a case that no solver of the reference computes."""
    scopes = [Scope.SEVERAL_CONTACTS] * bool(case.supports) + [Scope.SEVERAL_PLATES] * bool(case.others) + [Scope.ANY]
    for scope in scopes:
        if reason := limit(case, scope):
            raise (DoesNotFit if scope is Scope.ANY else BadValue)(reason)
