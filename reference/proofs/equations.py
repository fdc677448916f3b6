"""The equations of contact that proofs use, on power series; derived here, not taken from the two formulations.

Frame of the contact: t along the track, n = U t towards the plate. On the track P = |R_p| and the curvature κ, on the
outline p = |r_p| and the curvature k. The arm from the centre of mass to the contact is h = h_t t + h_n n. The state is
the slip velocity v and the spin ω, with the contact parameters. By (6) and (12) the contact point runs along track and
outline with the speeds

    S1 = P ξ̇₁ = (k v − ω)/(k − κ),   S2 = p ξ̇₂ = S1 − v.

The centre of mass moves with v + ω h_n along t and −ω h_t along n, by (11). Differentiated in the turning frame, with
G = J/m and f, M, N, T per mass, (15) is

    v̇ = f_t + T − ω̇ h_n − ω² h_t
    N = −f_n − ω̇ h_t + ω² h_n − ω S2 + κ S1 v
    G ω̇ = M + h_t N − h_n T − c N

with c N the couple of rolling resistance. These need no third derivative of the curves. A contact that slips has
T = ρ N with ρ = −μ sign(v) sign(N). Then G ω̇ = M + (h_t − h_n ρ − c) N, and N = free/den with
free = ω² h_n − ω S2 + κ S1 v − f_n − h_t M/G and den = 1 + h_t (h_t − h_n ρ − c)/G. A contact that does not slip has
v = v̇ = 0, which gives ω̇, and T and N from it.

A disc has h_t = 0, h_n = −r and k = 1/r. With the velocity V = v − r ω of its centre as the state instead of ω,

    S1 = V/(1 − κ r),   N = κ S1 V − f_n,   V̇ = f_t + T,   G ω̇ = M + r T − c N,   v̇ = V̇ + r ω̇,

and V does not depend on v while the disc slips: this is the linear equation for V² along the track, in time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import sympy as sp
from flint import arb, arb_series, fmpq

from cases import Mode
from cases.effects import MOTION
from cases.formulas.expressions import PARAMETER

from .formulas import Formula, as_series, constant
from .scene import Pair, Scene
from .steps import NotCovered

SLIP_SIGN = {Mode.SLIP_FORWARD: 1, Mode.SLIP_BACKWARD: -1}
# Sums of squares of shorter formulas are simplified: those of a circle are constant.
SHORT = 30


class ContactRegime(NamedTuple):
    """A mode of contact; `side` is the sign of the normal force, `turn` that of the spin (0 without resistance)."""

    mode: Mode
    side: int = 1
    turn: int = 0

    @property
    def slips(self) -> bool:
        return self.mode is not Mode.ROLL

    @property
    def sign(self) -> int:
        """The sign of the slip velocity; 0 for a contact without friction or without slip."""
        return SLIP_SIGN.get(self.mode, 0)


@dataclass(frozen=True)
class Point:
    """The contact's values at a state: rates of the state, spin, forces per mass, and what must not vanish."""

    rates: Mapping[str, arb_series]
    omega: arb_series
    omega_dot: arb_series
    normal: arb_series
    friction: arb_series
    den: arb_series
    fit: arb_series  # k − κ, the curvature of the outline minus the track's


class CurveSeries:
    """A curve on series of its parameter: place, inverse speed, unit tangent and curvature."""

    def __init__(self, curve: Pair):
        xp, yp = (sp.diff(part, PARAMETER) for part in curve)
        xs, ys = (sp.diff(part, PARAMETER) for part in (xp, yp))
        square, cross = (_shorten(part) for part in (xp**2 + yp**2, xp * ys - yp * xs))
        self._formula = Formula([PARAMETER], [*curve, xp, yp, square, cross])

    def __call__(self, s: arb_series):
        x, y, xp, yp, square, cross = self._formula(s)
        inverse = square.rsqrt()
        return (x, y), inverse, (xp * inverse, yp * inverse), cross * inverse / square


def _shorten(expression: sp.Expr) -> sp.Expr:
    return sp.trigsimp(expression) if sp.count_ops(expression) <= SHORT else expression


class Dynamics:
    """The equations of a scene. A state has the entries of `names`, each a series in the time since `begin`."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self._mu, self._gyration = number(scene.mu), number(scene.gyration)
        self._gravity = [constant(part) for part in scene.gravity]
        self._track = CurveSeries(scene.track)
        self._load = Formula(MOTION, scene.load) if scene.load else None

    def names(self, regime: ContactRegime) -> tuple[str, ...]:
        """The entries of the state: contact parameters, and the velocities that the regime leaves free."""
        raise NotImplementedError

    def at(self, regime: ContactRegime, state: Mapping[str, arb_series], begin: arb) -> Point:
        """The values at a state that is a series in the time since `begin`."""
        raise NotImplementedError

    def start(self) -> dict[str, arb]:
        """All entries of the state at the start, where `v` is the slip velocity and `omega` the spin."""
        names = {"v": self.scene.slip, "omega": self.scene.omega, "xi1": self.scene.xi1, "xi2": self.scene.xi2}
        return {name: number(value) for name, value in names.items()}

    def without_slip(self, state: dict[str, arb]) -> dict[str, arb]:
        """The state at an instant without slip."""
        return state | {"v": arb(0)}

    def without_spin(self, state: dict[str, arb]) -> dict[str, arb]:
        """The state at an instant without spin."""
        return state | {"omega": arb(0)}

    def spin(self, state: Mapping[str, arb]) -> arb:
        """The spin at a full state."""
        return state["omega"]

    def rest(self, state: Mapping[str, arb]) -> list[arb]:
        """What is positive if the plate can stay at rest: the margins of friction and of rolling resistance."""
        raise NotCovered("rest of a plate that is not a disc is not covered")

    def _ratio(self, regime: ContactRegime) -> arb:
        """Friction over the normal force of a contact that slips."""
        return -regime.sign * regime.side * self._mu

    def _couple(self, regime: ContactRegime) -> arb:
        """The couple of rolling resistance over the normal force."""
        return number(self.scene.arm) * (regime.turn * regime.side) if self.scene.arm else arb(0)

    def _forces(self, begin: arb, track, arm: Sequence, velocity: Sequence, omega):
        """Applied forces along t and n, and their moment, per mass; `velocity` is that of the centre of mass."""
        (X, Y), (tx, ty) = track
        fx, fy = (as_series(part) for part in self._gravity)
        M: arb_series = as_series(arb(0))
        if self._load is not None:
            (ht, hn), (along, across) = arm, velocity
            time = arb_series([begin, 1])
            x, y = X - (ht * tx - hn * ty), Y - (ht * ty + hn * tx)
            vx, vy = along * tx - across * ty, along * ty + across * tx
            px, py, M = self._load(time, x, y, as_series(arb(0)), vx, vy, omega)
            fx, fy = fx + px, fy + py
        return fx * tx + fy * ty, fy * tx - fx * ty, M


class PlateEquations(Dynamics):
    """The equations of any plate, in slip velocity and spin."""

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self._outline = CurveSeries(scene.outline)

    def names(self, regime: ContactRegime) -> tuple[str, ...]:
        return ("xi1", "xi2", "v", "omega") if regime.slips else ("xi1", "xi2", "omega")

    def at(self, regime: ContactRegime, state: Mapping[str, arb_series], begin: arb) -> Point:
        omega = state["omega"]
        place, inverse, tangent, kappa = self._track(state["xi1"])
        (x, y), inverse2, (bx, by), k = self._outline(state["xi2"])
        ht, hn = x * bx + y * by, y * bx - x * by
        fit = k - kappa
        v = state["v"] if regime.slips else as_series(arb(0))
        S1 = (k * v - omega) / fit
        S2 = S1 - v
        ft, fn, M = self._forces(begin, (place, tangent), (ht, hn), (v + omega * hn, -omega * ht), omega)
        acting = omega * omega * hn - omega * S2 + kappa * S1 * v - fn
        if regime.slips:
            omega_dot, v_dot, N, T, den = self._slipping(regime, (ht, hn), (ft, M), acting, omega)
        else:
            omega_dot, N, T, den = self._rolling(regime, (ht, hn), (ft, M), acting, omega)
            v_dot = v
        rates = {"xi1": S1 * inverse, "xi2": S2 * inverse2, "v": v_dot, "omega": omega_dot}
        own = {name: rates[name] for name in self.names(regime)}
        return Point(own, omega, omega_dot, N, T, den, fit)

    def _slipping(self, regime: ContactRegime, arm, forces, acting, omega):
        (ht, hn), (ft, M), G = arm, forces, self._gyration
        rho = self._ratio(regime)
        lever = ht - hn * rho - self._couple(regime)
        den = 1 + ht * lever / G
        N = (acting - ht * M / G) / den
        T = rho * N
        omega_dot = (M + lever * N) / G
        return omega_dot, ft + T - omega_dot * hn - omega * omega * ht, N, T, den

    def _rolling(self, regime: ContactRegime, arm, forces, acting, omega):
        (ht, hn), (ft, M), G = arm, forces, self._gyration
        lever = ht - self._couple(regime)
        den = (G + lever * ht + hn * hn) / G
        omega_dot = (M + lever * acting - hn * (omega * omega * ht - ft)) / (G * den)
        return omega_dot, acting - omega_dot * ht, omega_dot * hn + omega * omega * ht - ft, den


class DiscEquations(Dynamics):
    """The equations of a disc, in slip velocity and the velocity of its centre; ξ₂ does not occur."""

    def __init__(self, scene: Scene, radius: Fraction):
        super().__init__(scene)
        self._radius = number(radius)

    def names(self, regime: ContactRegime) -> tuple[str, ...]:
        return ("xi1", "v", "V") if regime.slips else ("xi1", "V")

    def at(self, regime: ContactRegime, state: Mapping[str, arb_series], begin: arb) -> Point:
        V, r, G = state["V"], self._radius, self._gyration
        v = state["v"] if regime.slips else as_series(arb(0))
        omega = (v - V) / r
        place, inverse, tangent, kappa = self._track(state["xi1"])
        room = 1 - kappa * r
        S1 = V / room
        ft, fn, M = self._forces(begin, (place, tangent), (arb(0), -r), (V, as_series(arb(0))), omega)
        N = kappa * S1 * V - fn
        c = self._couple(regime)
        if regime.slips:
            T = self._ratio(regime) * N
            V_dot = ft + T
        else:
            V_dot = r * (r * ft - M + c * N) / (G + r * r)
            T = V_dot - ft
        omega_dot = (M + r * T - c * N) / G
        rates = {"xi1": S1 * inverse, "V": V_dot, "v": V_dot + r * omega_dot}
        own = {name: rates[name] for name in self.names(regime)}
        return Point(own, omega, omega_dot, N, T, as_series(arb(1)), room / r)

    def start(self) -> dict[str, arb]:
        result = super().start()
        v = result["v"]
        return {"xi1": result["xi1"], "v": v, "V": v - self._radius * result["omega"] if self.scene.omega else v}

    def rest(self, state: Mapping[str, arb]) -> list[arb]:
        still = as_series(arb(0))
        place, _, tangent, _ = self._track(as_series(state["xi1"]))
        ft, fn, M = self._forces(arb(0), (place, tangent), (arb(0), -self._radius), (still, still), still)
        N, T = -fn[0], -ft[0]
        couple, largest = M[0] + self._radius * T, number(self.scene.arm) * N
        sticks = number(self.scene.mu_static) * N
        return [sticks - T, sticks + T, largest - couple, largest + couple]

    def without_spin(self, state: dict[str, arb]) -> dict[str, arb]:
        return state | {"V": state["v"]}

    def spin(self, state: Mapping[str, arb]) -> arb:
        return arb(0) if state["v"] is state["V"] else (state["v"] - state["V"]) / self._radius


def equations(scene: Scene) -> Dynamics:
    """The equations of a scene, those of a disc where the plate is one."""
    return PlateEquations(scene) if scene.disc is None else DiscEquations(scene, scene.disc)


def number(value: Fraction | int | None) -> arb:
    """An exact rational number as a ball; 0 for None."""
    return arb(fmpq(*(value or 0).as_integer_ratio()))
