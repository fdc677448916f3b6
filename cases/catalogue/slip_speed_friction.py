"""Friction that depends on the slip velocity: Stribeck, falling and viscous laws. Gravity pulls along −Y."""

from math import inf

from cases import Belt, Load, case, disc, effects
from cases.catalogue.common_scenes import case_on_track
from cases.library import line


@case
def stribeck_disc(v0=1.0, low=0.1, more=0.1, width=0.05, viscous=0.02, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A disc bowled onto a level line under Stribeck friction: it slows down faster, the slower it slips.

    Why: the usual law of lubricated contacts; friction is largest where the slip ends.
    Source: Pennestrì et al. 2016, Nonlinear Dyn. 83, 1785 (abstract looked up), compare such laws; posed here.
    Known exactly: it rolls after the integral of dv/(3 mu(v) g) from 0 to v0.
    """
    law = f"{low!r} + {more!r}*exp(-v/{width!r}) + {viscous!r}*v"
    return case_on_track(line(), disc(r, m), law, g, duration, slip=v0)


@case
def slider_on_belt_falling_law(
    speed=0.2, k=40.0, low=0.2, more=0.2, width=0.1, r=0.1, m=1.0, g=9.81, duration=4.0
):  # fmt: skip
    """A block on a running belt at a spring, with mu = low + more/(1 + v/width): it sticks and slips without end.

    Why: stick and slip without a static coefficient; each slip begins without acceleration, at the cone.
    Source: posed here after the oscillator of Dieci & Lopez (2009, known to us, not looked up).
    Known exactly: the first slip begins where the spring holds (low + more) m g, at stretch (low + more) m g/k.
    """
    law = f"{low!r} + {more!r}/(1 + v/{width!r})"
    return case_on_track(line(), disc(r, m, inf), law, g, duration, Load(fx=-k * effects.MOTION[1]), Belt(speed))


@case
def block_on_viscous_ramp(v0=1.0, slope=0.5, mu=0.2, viscous=0.2, r=0.1, m=1.0, g=9.81, duration=3.0):
    """A block pushed up a ramp under viscous friction: it stops, slides back, and tends to a steady speed.

    Why: Galileo's ramp with mu(v); the two directions have different decays.
    Source: Galileo's incline; derived: v̇ = −g (sin slope ± (mu + viscous |v|) cos slope).
    Known exactly: exponentials in t; down the ramp the speed tends to (tan slope − mu)/viscous.
    """
    return case_on_track(line(-slope), disc(r, m, inf), f"{mu!r} + {viscous!r}*v", g, duration, slip=v0)
