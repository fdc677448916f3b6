"""The equations of one mode of contact as a graph, with the conditions under which the mode lasts.

State: the contact parameters, the velocity V of the plate's centre along the track, and the spin ω. The plate's centre
has the velocity V t − ω h_t n, with the arm h from the centre to the contact. On the track P = |R_p| and the curvature
is κ, on the outline p = |r_p| and k. The contact runs along the track with S1 = (k v − ω)/(k − κ) and along the outline
with S2 = S1 − v, where v = V − ω h_n is the slip velocity. In the frame of the contact, which turns with κ S1, the arm
obeys ḣ_t = (1 + k h_n) S2 and ḣ_n = −k h_t S2, and (15) gives, with forces and couples per mass and G = J/m,

    V̇ = f_t + T − κ S1 ω h_t
    N = −f_n + κ S1 V − ω (1 + k h_n) S2 − ω̇ h_t
    G ω̇ = M + h_t N − h_n T − c N,

with c N the couple of rolling resistance. T = −μ |N| sign(v) while the contact slips. While it does not, v = 0, which
leaves ω as the only velocity, and v̇ = 0 gives T. A disc has h_t = 0, h_n = −r, k = 1/r, and S1 = V/(1 − κ r).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from .balls import Ball, FixedPoint
from .formulas import Formula
from .graph import Graph

SLIPS = {"slip_forward": 1, "slip_backward": -1}
State = dict[str, Ball]


class Regime(NamedTuple):
    """A mode, the side on which the track presses, and the sense of rotation (0 without rolling resistance)."""

    mode: str
    side: int = 1
    turn: int = 0


class _Curve(NamedTuple):
    """A curve's nodes: place, speed, unit tangent and curvature."""

    x: int
    y: int
    speed: int
    tx: int
    ty: int
    curvature: int


def _curve(g: Graph, texts: list[str], s: int) -> _Curve:
    (X, Xp, Xs), (Y, Yp, Ys) = (Formula(g, {"s": s}).jet(text) for text in texts)
    square = g.sum_of_products(Xp, Xp, Yp, Yp)
    speed = g.sqrt(square)
    cross = g.sum_of_products(Xp, Ys, g.sub(g.constant(0), Yp), Xs)
    return _Curve(X, Y, speed, g.div(Xp, speed), g.div(Yp, speed), g.div(cross, g.mul(square, speed)))


class System:
    """A regime's states, their rates, and conditions that are positive while it lasts.

    `outputs` are further quantities: slip velocity, its rate, the spin's rate, V without slip, forces and arm.
    """

    def __init__(self, scene: Mapping[str, Any], regime: Regime, arithmetic: FixedPoint):
        self.graph = g = Graph(arithmetic)
        self.arithmetic, self.regime, self.scene = arithmetic, regime, scene
        disc, rolls = scene["plate"] == "disc", regime.mode == "roll"
        self.names = ("xi1", *(() if disc else ("xi2",)), *(() if rolls else ("V",)), "omega")
        state = {name: g.variable(name) for name in self.names}
        self.variables = tuple(state.values())
        self.time = g.variable("t")
        G = g.constant(Fraction(scene["inertia_per_mass"]))
        track, omega = _curve(g, scene["track"], state["xi1"]), state["omega"]
        kappa = track.curvature
        if disc:
            r = Fraction(scene["radius"])
            k, ht, hn = (g.constant(value) for value in (1 / r, Fraction(0), -r))
        else:
            outline = _curve(g, scene["outline"], state["xi2"])
            k = outline.curvature
            ht = g.sum_of_products(outline.x, outline.tx, outline.y, outline.ty)
            hn = g.sub(g.mul(outline.y, outline.tx), g.mul(outline.x, outline.ty))
        stick = g.mul(omega, hn)
        V = stick if rolls else state["V"]
        v = g.constant(0) if rolls else g.sub(V, stick)
        if disc:
            fit = g.sub(g.constant(1), g.mul(kappa, g.constant(Fraction(scene["radius"]))))
            S1 = g.div(V, fit)
        else:
            fit = g.sub(k, kappa)
            S1 = g.div(g.sub(g.mul(k, v), omega), fit)
        S2, turning = g.sub(S1, v), g.mul(kappa, S1)
        ft, fn, M = self._forces(track, (ht, hn), (V, g.mul(omega, ht)), omega)
        widens = g.mul(g.mul(omega, g.add(g.constant(1), g.mul(k, hn))), S2)  # ω ḣ_t
        acting = g.sub(g.sub(g.mul(turning, V), widens), fn)
        drift = g.mul(turning, g.mul(omega, ht))
        slides = g.mul(g.mul(omega, k), g.mul(ht, S2))  # −ω ḣ_n
        c = g.constant(Fraction(scene["resistance_arm"] or 0) * regime.turn * regime.side)
        sign = SLIPS.get(regime.mode, 0)
        if rolls:
            # v̇ = V̇ − ω̇ h_n − ω ḣ_n = 0 gives T = ω̇ h_n − ω k h_t S2 − f_t + κ S1 ω h_t.
            rest = g.sub(g.sub(drift, slides), ft)
            lever = g.sub(ht, c)
            den = g.add(G, g.add(g.mul(lever, ht), g.mul(hn, hn)))
            omega_dot = g.div(g.sub(g.add(M, g.mul(lever, acting)), g.mul(hn, rest)), den)
            N, T = g.sub(acting, g.mul(omega_dot, ht)), g.add(g.mul(omega_dot, hn), rest)
        else:
            rho = g.constant(-sign * regime.side * Fraction(scene["mu"] or 0))
            lever = g.sub(g.sub(ht, g.mul(hn, rho)), c)
            den = g.add(g.constant(1), g.div(g.mul(ht, lever), G))
            N = g.div(g.sub(acting, g.div(g.mul(ht, M), G)), den)
            T, omega_dot = g.mul(rho, N), g.div(g.add(M, g.mul(lever, N)), G)
        V_dot = g.sub(g.add(ft, T), drift)
        v_dot = g.add(g.sub(V_dot, g.mul(omega_dot, hn)), slides)
        rates = {"xi1": g.div(S1, track.speed), "V": V_dot, "omega": omega_dot}
        if not disc:
            rates["xi2"] = g.div(S2, outline.speed)
        self.rates = tuple(rates[name] for name in self.names)
        self.outputs = {"slip": v, "slip_rate": v_dot, "spin_rate": omega_dot, "without_slip": stick,
                        "along": ft, "across": fn, "couple": M, "arm_t": ht, "arm_n": hn}  # fmt: skip
        self.conditions = self._conditions({"fit": fit, "painleve": den}, N, T, v, state)

    def _conditions(self, always: dict[str, int], N: int, T: int, v: int, state: Mapping[str, int]) -> dict[str, int]:
        g, scene, (mode, side, turn) = self.graph, self.scene, self.regime
        sign, one_sided = SLIPS.get(mode, 0), scene["unilateral"]
        force, result = g.mul(g.constant(side), N), dict(always)
        if sign:
            result |= {"slip": g.mul(g.constant(sign), v), "normal_force": force}
        elif mode == "roll" and not scene["perfectly_rough"]:
            largest = g.mul(g.constant(Fraction(scene["mu_static"])), force)
            result |= {"cone_forward": g.add(largest, T), "cone_backward": g.sub(largest, T)}
        elif one_sided:
            result["normal_force"] = N
        if turn:
            result["turn"] = g.mul(g.constant(turn), state["omega"])
        for curve, name in (("track", "xi1"), ("outline", "xi2")):
            if scene[f"{curve}_domain"] is not None:
                low, high = (g.constant(Fraction(text)) for text in scene[f"{curve}_domain"])
                result |= {f"{curve}_start": g.sub(state[name], low), f"{curve}_end": g.sub(high, state[name])}
        return result

    def _forces(self, track: _Curve, arm: tuple[int, int], velocity: tuple[int, int], omega: int):
        """Applied forces along the track and across it, and their moment, per mass; `velocity` of the centre is V along
        and −ω h_t across."""
        g, scene, (V, falls) = self.graph, self.scene, velocity
        tx, ty = track.tx, track.ty
        fx, fy = (Formula(g, {}).node(text) for text in scene["gravity"])
        M = g.constant(0)
        if scene["load_per_mass"]:
            (ht, hn) = arm
            names = {
                "t": self.time,
                "x": g.sub(track.x, g.sub(g.mul(ht, tx), g.mul(hn, ty))),
                "y": g.sub(track.y, g.add(g.mul(ht, ty), g.mul(hn, tx))),
                "vx": g.add(g.mul(V, tx), g.mul(falls, ty)),
                "vy": g.sub(g.mul(V, ty), g.mul(falls, tx)),
                "omega": omega,
            }
            lx, ly, M = (Formula(g, names).node(text) for text in scene["load_per_mass"])
            fx, fy = g.add(fx, lx), g.add(fy, ly)
        return g.add(g.mul(fx, tx), g.mul(fy, ty)), g.sub(g.mul(fy, tx), g.mul(fx, ty)), M

    # --- values -----------------------------------------------------------------------------------------------------

    def values(self, state: State, time: Ball) -> dict[str, Ball]:
        """The outputs and conditions at one instant."""
        self._begin([state[name] for name in self.names], time)
        self.graph.compute(0)
        return {name: self.graph.c[node][0] for name, node in (self.outputs | self.conditions).items()}

    def expand(self, state: list[Ball], time: Ball, order: int, exponent: int):
        """Taylor coefficients 0 … order of states and conditions, of powers of (time since the start)/2^exponent."""
        graph, f = self.graph, self.arithmetic
        self._begin(state, time)
        for k in range(order + 1):
            graph.compute(k)
            for node, rate in zip(self.variables, self.rates, strict=True):
                graph.c[node].append(f.over(f.times_power(graph.c[rate][k], exponent), k + 1))
            graph.c[self.time].append(f.times_power((f.one, 0), exponent) if k == 0 else (0, 0))
        states = [graph.c[node].balls(order + 1) for node in self.variables]
        return states, {name: graph.c[node].balls(order + 1) for name, node in self.conditions.items()}

    def _begin(self, state: list[Ball], time: Ball) -> None:
        self.graph.clear()
        for node, value in zip((*self.variables, self.time), (*state, time), strict=True):
            self.graph.c[node].append(value)
