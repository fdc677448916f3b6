"""Exact solutions in mpmath, independent of any integrator. SI units; `digits` is the working precision."""

from __future__ import annotations

from typing import NamedTuple

import mpmath as mp

from cases import Mode


class FirstZero(NamedTuple):
    """First instant without slip: its time, place, and the mode that follows by Coulomb's inequality."""

    time: mp.mpf
    xi1: mp.mpf
    after: Mode


def sliding_disc_in_circle(R, r, mu, g, digits: int = 20) -> FirstZero:
    """First zero of the slip velocity of a homogeneous disc released at rest at ξ₁ = 0 (Y down), from (35).

    While v > 0, u = ξ̇₁² obeys du/dξ₁ + 2μu = (2g/L)(cos ξ₁ − μ sin ξ₁), L = R − r, so u = A sin ξ₁ + B cos ξ₁ +
    C e^(−2μξ₁); time and spin follow by quadrature in s = √ξ₁, which removes the root at the start.
    """
    with mp.workdps(digits + 10):
        R, r, mu, g = (mp.mpf(value) for value in (R, r, mu, g))
        L = R - r
        A = 2 * g / L * (1 - 2 * mu**2) / (1 + 4 * mu**2)
        B = 2 * g / L * 3 * mu / (1 + 4 * mu**2)

        def u(xi):
            return A * mp.sin(xi) + B * (mp.cos(xi) - mp.exp(-2 * mu * xi))

        def per_root(function):
            """∫ function(ξ)/√u dξ from 0, as a function of the upper end."""

            def slope(s):
                # At the start u = (A − … )ξ: the quotient 2s/√u(s²) has the limit 2/√u'(0).
                return 2 / mp.sqrt(A + 2 * mu * B) if s == 0 else 2 * s / mp.sqrt(u(s * s))

            return lambda xi: mp.quad(lambda s: function(s * s) * slope(s), mp.linspace(0, mp.sqrt(xi), 5))

        spin = per_root(lambda xi: -2 * mu / r * (g * mp.sin(xi) + L * u(xi)))

        def slip(xi):
            return L * mp.sqrt(u(xi)) + r * spin(xi)

        # v rises from zero at the start and is negative where the disc turns back (u = 0, spinning): one zero between.
        # Without friction u = A sin ξ vanishes at π, with friction before that.
        turn = next(xi for k in range(10, 315) if u((xi := mp.mpf(k) / 100) + mp.mpf("0.01")) <= 0)
        turn = mp.findroot(u, (turn, turn + mp.mpf("0.01")), solver="anderson") * (1 - mp.mpf(10) ** -digits)
        xi = mp.findroot(slip, (mp.mpf("0.1"), turn), solver="anderson", tol=mp.mpf(10) ** (-2 * digits))
        time = per_root(lambda _: mp.mpf(1))(xi)
        # The disc rolls if the friction that rolling needs, (g/3)|cos ξ₁| per mass, lies within the cone.
        if g / 3 * abs(mp.cos(xi)) <= mu * (g * mp.sin(xi) + L * u(xi)):
            return FirstZero(time, xi, Mode.ROLL)
        return FirstZero(time, xi, Mode.SLIP_BACKWARD if mp.cos(xi) < 0 else Mode.SLIP_FORWARD)
