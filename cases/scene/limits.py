"""What the reference does not compute, or computes without a certificate: one table, each row with its reason.

`limit` decides by the table; the checks of a case, `reference.simulate`, sweeps, certificates and `cases check` read
it. `limits_page` writes docs/limits.md from it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from enum import StrEnum
from typing import Any, NamedTuple

from ..contact.outline_features import arc_ranges, features, is_arc, sides
from ..curves.chain import Chain
from ..curves.corner import Corner
from ..effects import Belt, CoulombFriction, Drive, Flight, Impact, PerfectlyRough, RollingResistance, Unilateral
from ..errors import BadValue, DoesNotFit
from .free_plates import why_not_convex
from .pair_effects import of_pair
from .supports import has_rolling_resistance, is_hill, is_hollow, is_straight


class Scope(StrEnum):
    """The motions that a limit is for."""

    ANY = "any motion"
    SEVERAL_CONTACTS = "a plate with several contacts"
    SEVERAL_PLATES = "several plates"
    SHAPES = "a certificate of several contacts: shapes"


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

    def matches(self, sentence: str) -> bool:
        """Whether a sentence is that of this limit, of any case."""
        parts = re.split(r"\{0?\}", self.sentence)
        return re.fullmatch("[^;]+".join(map(re.escape, parts)), sentence) is not None


def _curves(case: Any) -> tuple[Any, ...]:
    return (case.track, *(support.curve for support in case.supports))


def _missing(case: Any) -> str:
    """The first effect that plates need in order to part and meet."""
    needs = {Unilateral: "Unilateral()", Flight: "Flight()"}
    return next((text for kind, text in needs.items() if case.effect(kind) is None), "")


def _has_corners(case: Any) -> bool:
    return isinstance(case.plate.outline, Chain)


def has_spinning_plate(case: Any) -> bool:
    """Whether a plate of infinite inertia is on a track that turns."""
    turns = (drive := case.effect(Drive)) is not None and drive.is_turning
    return turns and not all(plate.turns for plate in (case.plate, *(other.plate for other in case.others)))


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


def _kinds_at_contacts(case: Any) -> Iterator[set[type]]:
    """The kinds of effects at the contacts with the track, with each support, and of each pair."""
    yield {type(effect) for effect in case.effects}
    for support in case.supports:
        yield {type(effect) for effect in support.acting(case.effects)}
    for pair in case.pairs:
        yield {type(effect) for effect in of_pair(case, pair.name, case.effects)}


def _needs(kind: type, partners: tuple[type, ...], why: str) -> Limit:
    """The limit of an effect that needs another one."""
    names = " or ".join(partner.__name__ for partner in partners)
    return Limit(
        Scope.ANY,
        f"{kind.__name__} without {names}",
        lambda case: any(kind in kinds and kinds.isdisjoint(partners) for kinds in _kinds_at_contacts(case)),
        f"{kind.__name__} needs {names} as well ({why}); add it or remove {kind.__name__}",
        Reason.MECHANICS,
        why,
    )


def _excludes(one: type, other: type, why: str) -> Limit:
    """The limit of two effects that contradict each other."""
    return Limit(
        Scope.ANY,
        f"{one.__name__} with {other.__name__}",
        lambda case: any(kinds.issuperset((one, other)) for kinds in _kinds_at_contacts(case)),
        f"{one.__name__} and {other.__name__} contradict each other ({why}); leave one out",
        Reason.MECHANICS,
        why,
    )


# The first row of a scope that applies is the one that is reported.
LIMITS = (
    _needs(RollingResistance, (CoulombFriction, PerfectlyRough), "nothing makes a plate without friction roll"),
    _needs(Belt, (CoulombFriction, PerfectlyRough), "a belt acts on the plate by friction only"),
    _needs(Flight, (Unilateral,), "the plate cannot leave a bilateral guide"),
    _needs(Impact, (Flight,), "a plate that does not fly does not land"),
    _excludes(CoulombFriction, PerfectlyRough, "friction is either bounded or not"),
    _excludes(
        Belt,
        RollingResistance,
        "resistance to rolling on a surface that runs along a curve has no established law",
    ),
    Limit(
        Scope.ANY,
        "a plate of infinite inertia with RollingResistance",
        lambda case: not case.plate.turns and has_rolling_resistance(case),
        "a plate of infinite inertia does not turn; leave RollingResistance out",
        Reason.MECHANICS,
        "a plate that does not turn does not roll",
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
        "no Unilateral or Flight",
        _missing,
        "several plates may part and meet; add {} to the effects",
        Reason.MECHANICS,
        "plates that are not guided part and meet",
    ),
    Limit(
        Scope.SHAPES,
        "several plates that are no smooth convex outlines, or discs and one convex polygon, on straight lines",
        lambda case: case.others and why_not_convex(case),
        "{}; give smooth convex outlines, or discs and at most one convex polygon, on straight lines",
        Reason.NOT_BUILT,
        "elsewhere the nearest points of two plates are not unique, and the second formulation watches one pair each",
    ),
    Limit(
        Scope.SHAPES,
        "a plate of infinite inertia on a track that turns (angle of Drive)",
        has_spinning_plate,
        "a plate of infinite inertia is on a track that turns; leave angle of Drive out",
        Reason.NOT_BUILT,
        "such a plate turns in the track's frame, in which the second formulation is",
    ),
    Limit(
        Scope.SHAPES,
        "a track or support with edges",
        lambda case: _is_by_curves(case) and any(_has_edge(curve) for curve in _curves(case)),
        "a curve has an edge; give a line as track if the plate stays on one part",
        Reason.NOT_BUILT,
        _PARTS,
    ),
    Limit(
        Scope.SHAPES,
        "a track or support with corners",
        lambda case: _is_by_curves(case) and any(isinstance(curve, Chain) for curve in _curves(case)),
        "a curve has corners; give a line as track and its other parts as supports",
        Reason.NOT_BUILT,
        _PARTS,
    ),
    Limit(
        Scope.SHAPES,
        "supports, and a plate with corners that does not turn",
        lambda case: bool(case.supports) and _is_by_features(case) and not case.plate.turns,
        "a plate with corners does not turn; give a smooth outline",
        Reason.NOT_BUILT,
        "a side of such a plate lies flat in every pose",
    ),
    Limit(
        Scope.SHAPES,
        "corners on a curve that bends away, but for convex polygons on closed hills",
        _bends_away,
        "a plate with corners is on a curve that bends away from it; give a straight one without ends, one that bends "
        "to its side everywhere, or a convex polygon on a closed hill",
        Reason.NOT_BUILT,
        "elsewhere the nearest points of a pair are not unique, and the second formulation watches one pair each",
    ),
    Limit(
        Scope.SHAPES,
        "an open outline, or one without a corner or arc that bulges",
        _has_no_features,
        "the outline is not closed, or has no corner or arc that bulges; give one that is and has",
        Reason.NOT_BUILT,
        "the second formulation watches corners and arcs that bulge",
    ),
    Limit(
        Scope.SHAPES,
        "an outline with a round piece that is no arc of a circle",
        _has_other_pieces,
        "a round piece of the outline is no arc of a circle; give one whose pieces are edges and arcs",
        Reason.NOT_BUILT,
        "the second formulation watches corners and arcs that bulge",
    ),
    Limit(
        Scope.SHAPES,
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


def limit(case: Any, scope: Scope) -> str:
    """The first limit of a scope that a case has, in a sentence without its capital and period that says what to give
    instead; "" if it has none."""
    for row in LIMITS:
        if row.scope is scope and (what := row.applies(case)):
            return row.sentence.format(what)
    return ""


def without_certificate(case: Any) -> str:
    """Why the second formulation does not compute a case with several contacts, as of `limit`; "" if it does."""
    return limit(case, Scope.SHAPES)


def as_sentence(reason: str) -> str:
    """A limit as a sentence with capital and period; "" for none."""
    return f"{reason[0].upper()}{reason[1:]}." if reason else ""


def check_limits(case: Any) -> None:
    """Raise BadValue or DoesNotFit, with a sentence, for a case that no solver of the reference computes."""
    is_in_pieces = _has_corners(case) or isinstance(case.track, Chain)
    in_poses = case.supports or has_spinning_plate(case) or (is_in_pieces and not case.plate.turns)
    several = {Scope.SEVERAL_CONTACTS: in_poses, Scope.SEVERAL_PLATES: case.others}
    for scope in (Scope.ANY, *(scope for scope, parts in several.items() if parts)):
        if reason := limit(case, scope):
            raise (DoesNotFit if scope is Scope.ANY else BadValue)(reason)
