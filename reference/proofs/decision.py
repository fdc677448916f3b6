"""The mode after an event, by strict inequalities: exactly one mode of Coulomb's law is consistent with the state.

- Without slip: the friction that rolling needs lies strictly inside the cone, and in both directions a slip that began
  would be turned back (sign(v) v̇ < 0 under its own friction).
- With slip in one direction: sign(v) v̇ > 0 there, the other direction is turned back, and rolling needs friction
  strictly outside the cone.
- At the cone's boundary, reached from inside with a strictly decreasing margin: friction of a slip against it equals
  that of rolling, so v̇ = 0 exactly, and the first step of the new phase proves v̈ > 0 in its direction.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

from flint import arb, arb_series, ctx

from cases import Mode

from .equations import SLIP_SIGN, ContactRegime, Dynamics, Point, number
from .steps import NotProved

State = dict[str, arb]
# The slip that begins where friction reaches the cone.
BEGINS = {"cone_forward": Mode.SLIP_FORWARD, "cone_backward": Mode.SLIP_BACKWARD}


class Following(NamedTuple):
    """What follows an event: a regime with its state and the guards' leading zeros, or a status."""

    regime: ContactRegime | None
    state: State
    known: Mapping[str, int]
    reason: str
    status: str = ""
    share: arb | None = None  # of the cone, the part that rolling needs where the slip vanishes


def cone_margins(equations: Dynamics, regime: ContactRegime, point: Point) -> tuple[arb_series, arb_series]:
    """How far friction is from the bounds beyond which a slip forward or backward begins."""
    largest = number(equations.scene.mu_static) * (regime.side * point.normal)
    return largest + point.friction, largest - point.friction


def first_regime(equations: Dynamics) -> tuple[ContactRegime, State, Mapping[str, int]]:
    """The regime at the start, which is exact."""
    full = equations.start()
    regime, _ = decide(equations, full, arb(0))
    return regime, _own(equations, regime, full), {}


def following(equations: Dynamics, regime: ContactRegime, guard: str, state: State, t: arb) -> Following:
    """The regime after a guard's zero. Raises NotProved if no strict inequalities decide it."""
    scene = equations.scene
    full = {"v": arb(0)} | state
    if guard == "normal_force":
        if scene.unilateral:
            return _leave(equations, regime)
        across = regime._replace(side=-regime.side)
        return Following(across, _own(equations, across, full), {"normal_force": 1}, "the guide's other side presses")
    if guard == "slip":
        full = equations.without_slip(full)
    if guard == "turn":
        full = equations.without_spin(full)
    if guard in BEGINS:
        mode = BEGINS[guard]
        other = Mode.SLIP_FORWARD if mode is Mode.SLIP_BACKWARD else Mode.SLIP_BACKWARD
        full = equations.without_slip(full)
        if consistent(equations, ContactRegime(other, regime.side, regime.turn), full, t) is not False:
            raise NotProved(f"at the cone {other} is not excluded")
        begins = ContactRegime(mode, regime.side, regime.turn)
        known = {"slip": 2} if scene.mu == scene.mu_static else {}
        return Following(begins, _own(equations, begins, full), known, "friction reaches its cone from inside")
    share = rolling_share(equations, full, t) if guard == "slip" else None
    next_regime, reason = decide(equations, full, t)
    return Following(next_regime, _own(equations, next_regime, full), {}, reason, share=share)


def _own(equations: Dynamics, regime: ContactRegime, full: State) -> State:
    return full if regime.mode is Mode.REST else {name: full[name] for name in equations.names(regime)}


def _leave(equations: Dynamics, regime: ContactRegime) -> Following:
    if not regime.slips:
        raise NotProved("the normal force of a contact without slip vanishes")
    reason = "the normal force vanished and would pull: no mode of contact follows"
    return Following(None, {}, {}, reason, "lift_off")


def rolling_share(equations: Dynamics, full: State, t: arb) -> arb | None:
    """The friction that rolling would need over the largest one, |T|/(μ N), at a state without slip."""
    if equations.scene.arm is not None:
        return None
    point = _values(equations, ContactRegime(Mode.ROLL), full, t)
    return abs(point.friction[0]) / (number(equations.scene.mu_static) * abs(point.normal[0]))


def _values(equations: Dynamics, regime: ContactRegime, full: State, t: arb) -> Point:
    """The contact's values at one instant: series of length one."""
    cap, ctx.cap = ctx.cap, 1
    try:
        return equations.at(regime, {name: arb_series([full[name]]) for name in equations.names(regime)}, t)
    finally:
        ctx.cap = cap


def decide(equations: Dynamics, full: State, t: arb) -> tuple[ContactRegime, str]:
    """The one regime that is consistent with a state, and why; raises NotProved if strict inequalities leave more or
    none."""
    results = {regime: consistent(equations, regime, full, t) for regime in _candidates(equations, full)}
    able = [regime for regime, verdict in results.items() if verdict]
    open_ones = [regime for regime, verdict in results.items() if verdict is None]
    if len(able) == 1 and not open_ones:
        others = ", ".join(sorted({str(r.mode) for r in results if r.mode is not able[0].mode}))
        return able[0], f"{others} excluded by strict inequalities" if others else "the only mode"
    names = ", ".join(str(regime.mode) for regime in able + open_ones) or "none"
    raise NotProved(f"strict inequalities do not decide the mode (possible: {names})")


def _candidates(equations: Dynamics, full: State) -> list[ContactRegime]:
    scene, v = equations.scene, full["v"]
    if scene.rough:
        modes = [Mode.ROLL]
    elif scene.mu is None:
        modes = [Mode.SLIDE]
    elif v.is_zero():
        modes = [Mode.ROLL, *SLIP_SIGN]
    else:
        modes = [Mode.SLIP_FORWARD if v > 0 else Mode.SLIP_BACKWARD]
    sides = (1,) if scene.unilateral or scene.mu is None or scene.rough else (1, -1)
    if scene.arm is None:
        turns: tuple[int, ...] = (0,)
    elif equations.spin(full).is_zero():
        turns = (1, -1)
    else:
        turns = (1,) if equations.spin(full) > 0 else (-1,)
    rest = [ContactRegime(Mode.REST)] if len(turns) == 2 and Mode.ROLL in modes else []
    return [ContactRegime(*values) for values in product(modes, sides, turns)] + rest


def consistent(equations: Dynamics, regime: ContactRegime, full: State, t: arb) -> bool | None:
    """Whether the regime's conditions hold just after the state; None if balls that contain 0 leave it open.

    A normal force that is exactly zero is left to the first step of the phase, which proves its sign.
    """
    if regime.mode is Mode.REST:
        values = equations.rest(full)
    else:
        values = _conditions(equations, regime, full, t)
    if any(value < 0 for value in values):
        return False
    return True if all(value > 0 for value in values) else None


def _conditions(equations: Dynamics, regime: ContactRegime, full: State, t: arb) -> list[arb]:
    point = _values(equations, regime, full, t)
    force = regime.side * point.normal[0]
    values = [point.den[0], point.fit[0]]
    if regime.sign or equations.scene.unilateral:
        values += [] if force.is_zero() else [force]
    if regime.sign and full["v"].is_zero():
        values.append(regime.sign * point.rates["v"][0])
    if not regime.slips and not equations.scene.rough:
        values += [margin[0] for margin in cone_margins(equations, regime, point)]
    if regime.turn and equations.spin(full).is_zero():
        values.append(regime.turn * point.omega_dot[0])
    return values
