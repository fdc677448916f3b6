"""What contradicts a motion: the second formulation, a law of mechanics, or the same motion begun in its middle."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf, isfinite, remainder

import numpy as np

import reference
from cases import Belt, Case, Chain, Curve, Drive, Load, Trajectory, Transition
from cases.effects import MOTION
from cases.motion.trajectory import CONTACT
from cases.moving_surface import TIME as INSTANT
from cases.scene.free_plates import names_of, plates_of
from reference.endings import CAUSES
from reference.witness import predict
from tests.composition.confirm import resumed

# Two integrations at 1e-13 over seconds: rounding grows with the motion; a grazing slip loses the square root of it.
TIME, STATE = 1e-8, 1e-6
# Transitions within this time (s) are at one instant, in an order that is no fact.
INSTANTLY = 1e-9
# Impacts within this time (s) before bouncing comes to rest close with about a thousandth of the largest speed: which
# of them are small, and so not listed, depends on where a formulation begins to count.
SMALL_IMPACTS = 2e-3
# Where the second formulation goes no further: motions agree up to there.
ENDS_EARLY = "second_contact", "breakdown"


def agree(case: Case, within: float = TIME, method: str | None = None) -> Trajectory:
    """The motion of a case; raises AssertionError where the second formulation has other transitions, another end or
    another pose there, by more than `within` (s) and STATE, where it breaks a law, or where its rest from its middle
    differs."""
    motion = reference.simulate(case, rtol=1e-13, method=method)
    problem = unlike_second(case, motion, within) or "; ".join(map(str, reference.check(case, motion)))
    assert not problem, f"{problem}: {case}"
    problem = "" if _is_in_time(case) else resumed(case, motion)
    assert not problem, f"resumed: {problem}: {case}"
    return motion


def unlike_second(case: Case, motion: Trajectory, within: float = TIME) -> str:
    """How the second formulation's motion differs, in words; "" if it agrees as far as it goes."""
    second = predict(case, 1e-13)
    is_early = second.status in ENDS_EARLY and second.status != motion.status
    problem = unlike(case, motion.transitions, second.transitions, within, second.end if is_early else inf)
    if problem or is_early:
        return problem
    if second.status != motion.status:
        return f"its status is {second.status} instead of {motion.status}"
    if abs(second.end - motion.t[-1]) > within:
        return f"it ends at {second.end:.12g} s instead of {motion.t[-1]:.12g} s"
    now = [motion.plate(name)(motion.t[-1]) for name in names_of(case)]
    poses = np.array([(one.x, one.y, one.theta) for one in now]).ravel()
    far = float(np.abs(poses - second.body[: len(poses)]).max())
    return f"its last pose is {far:.3g} away" if far > STATE else ""


def unlike(case: Case, ours: Iterable[Transition], theirs: Iterable[Transition], within: float, end: float) -> str:
    """How one list of transitions differs from another before `end` (s), in words. They are compared by curve, time,
    modes and place: formulations may number the contacts of one curve otherwise."""
    rests = [t.time for t in ours if t.cause == CAUSES["rest"]]
    one, other = (in_order([t for t in some if t.time < end - within], rests) for some in (ours, theirs))
    if [(curve_of(t), t.before, t.after) for t in one] != [(curve_of(t), t.before, t.after) for t in other]:
        return "\n".join(
            str([(curve_of(t), t.time, str(t.before), str(t.after)) for t in some]) for some in (one, other)
        )
    late = max((abs(a.time - b.time) for a, b in zip(one, other, strict=True)), default=0.0)
    if late > within:
        return f"a transition is {late:.3g} s away"
    rounds = {name: _round(plate.outline) for name, plate in zip(names_of(case), plates_of(case), strict=True)}
    rounds |= {support.name: _round(support.curve) for support in case.supports}
    for a, b in zip(one, other, strict=True):
        whole = rounds.get(curve_of(a).partition("/")[2], _round(case.track))
        off = remainder(a.xi1 - b.xi1, whole) if isfinite(whole) else a.xi1 - b.xi1
        if abs(off) > STATE:
            return f"the place of the transition at {a.time:.9g} s is {off:.3g} away"
    return ""


def _round(curve: Curve) -> float:
    """How far the parameter goes in one round of a closed curve; infinite for others."""
    is_closed = curve.is_closed if isinstance(curve, Chain) else curve.period
    return curve.span[1] - curve.span[0] if is_closed else inf


def curve_of(transition: Transition) -> str:
    """The couple of a contact; one that is the only one may have no name."""
    return (transition.contact or CONTACT).partition(" ")[0]


def in_order(transitions: Sequence[Transition], rests: Sequence[float]) -> list[Transition]:
    """Transitions by time, those of one instant by contact's curve and place, without small impacts before `rests`."""
    some = [t for t in transitions if not any(-SMALL_IMPACTS < t.time - rest < -INSTANTLY for rest in rests)]
    result, begin = list[Transition](), 0
    for k, one in enumerate(some):
        if k + 1 == len(some) or some[k + 1].time - one.time > INSTANTLY:
            result += sorted(some[begin : k + 1], key=lambda t: (curve_of(t), round(t.xi1, 6)))
            begin = k + 1
    return result


def _is_in_time(case: Case) -> bool:
    """Whether a load, a belt or a drive has a formula with the time in it."""
    effects = [*case.effects, *(e for support in case.supports for e in support.effects or ())]
    effects += [other.load for other in case.others if other.load] + [e for pair in case.pairs for e in pair.effects]
    formulas = []
    for effect in effects:
        if isinstance(effect, Load | Belt | Drive):
            own = effect.expression
            formulas += [*own] if isinstance(own, tuple | list) else [own]
    return any({MOTION[0], INSTANT} & getattr(formula, "free_symbols", set()) for formula in formulas)
