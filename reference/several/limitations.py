"""Which cases the formulation with several contacts does not support."""

from __future__ import annotations

from cases import Belt, Case, CoulombFriction, Drive, RollingResistance, Unilateral
from cases.own_effects import own_effects
from cases.piece_case import has_pieces
from cases.supports import touches_by_features


def supports(case: Case) -> str:
    """Why a motion of this case with several contacts cannot be computed, in a sentence; "" if it can."""
    if case.effect(Unilateral) is None:
        return "A second contact needs Unilateral: a bilateral guide has no free side."
    if case.effect(RollingResistance) is not None:
        return "RollingResistance is not supported with several contacts."
    if case.effect(Belt) is not None:
        return "A belt is not supported with several contacts."
    if own := own_effects(case.effects):
        return f"{type(own[0]).__name__} is not supported with several contacts."
    if case.effect(Drive) is not None:
        return "A driven track is not supported with several contacts."
    if not case.plate.turns:
        return "A plate of infinite inertia is not supported with several contacts."
    friction = case.effect(CoulombFriction)
    if friction is not None and friction.by_speed:
        return "Friction that depends on the slip speed is not supported with several contacts."
    if touches_by_features(case):
        return ""
    if has_pieces(case) or case.track.parts is not None or case.plate.outline.parts is not None:
        return "Curves in pieces are not supported with several contacts."
    return ""
