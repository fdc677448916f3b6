"""Hard: very small, very large, very long. Gravity pulls along −Y."""

from math import pi, sin, sqrt

from cases import Case, CoulombFriction, Gravity, Start, Unilateral, case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.catalogue.odd_wheels import unbalanced_wheel
from cases.errors import positive
from cases.library import circle, line


@case(
    variants=[dict(length=1e-6, mass=1e-9), dict(length=1e-3), dict(length=1e3, mass=1e9)],
    hard="micrometres or kilometres, micrograms or a million tonnes: whoever has an absolute tolerance meets it here",
    outcome="the paper's motion: times scale as √length, forces as mass",
)
def at_any_size(length=1.0, mass=1.0, mu=0.2, g=9.81):
    """The paper's disc in a circle, in another size: R = `length`, r = length/10.

    Why: nothing in the equations has a size, nothing in a solver should.
    Source: dimensional analysis; the scene is Ogaru & Pandrea's 4.2.
    Known exactly: all times are those of `disc_in_circle` times √(length/1 m); ξ₁ and ξ₂ are the same.
    """
    R = positive("length of at_any_size", length)
    return case_on_track(circle(R), disc(0.1 * R, mass), mu, g, 2.5 * sqrt(R), xi1=-pi)


@case(
    variants=[dict(mu=0.0), dict(mu=1.0)],
    long=[dict(mu=0.0, periods=1000.0), dict(mu=1.0, periods=1000.0)],
    hard="nothing happens, again and again: what is lost or gained in each swing adds up",
    outcome="the same swing from the first to the last, its end where it began",
)
def many_swings(periods=10.0, mu=0.0, amplitude=1.0, R=1.0, r=0.1, m=1.0, g=9.81):
    """A disc sliding without friction (mu = 0) or rolling to and fro in a circle.

    Why: a thousand periods show any drift in energy or phase.
    Source: Landau & Lifshitz, Mechanics (known to us, not looked up); derived from energy.
    Known exactly: period 4 √(L/g) K(sin²(amplitude/2)), L = R − r or, rolling, 3(R − r)/2. It lasts
    whole periods.
    """
    from scipy.special import ellipk

    friction = (CoulombFriction(mu),) if mu else ()
    pendulum = (R - r) * (1.5 if mu else 1.0)
    period = 4 * sqrt(pendulum / positive("g of many_swings", g)) * float(ellipk(sin(amplitude / 2) ** 2))
    return Case(
        track=circle(R),
        plate=disc(r, m),
        effects=(Gravity(g), *friction, Unilateral()),
        start=Start(xi1=-pi / 2 - amplitude),
        duration=positive("periods of many_swings", periods) * period,
    )


@case(
    variants=[dict(duration=4.0)],
    long=[dict(duration=1120.0)],
    hard="four transitions in each turn, ten thousand in 1120 s",
    outcome="limps for ever: what it gains by the slope each turn takes by friction",
)
def limping_wheel(slope=0.03, mu=0.3, e=0.07, omega=-13.0, r=0.1, m=1.0, g=9.81, duration=4.0):
    """An unbalanced wheel going down a gentle slope: rolling and slipping alternate, and settle into a rhythm.

    Why: a stable cycle, so that ten thousand transitions are as sure as ten; energy must be closed over all of them.
    Source: this suite's, after the loaded hoop of Maritz & Theron, Am. J. Phys. 80 (2012, known to us, not looked up).
    Known exactly: energy lost = work of friction; while it rolls, (J + m d²) ω²/2 + m g y is constant.
    """
    return case_on_track(line(slope), unbalanced_wheel(r, e, m), mu, g, duration, xi2=-pi / 2, omega=omega)


@case(
    variants=[dict(duration=20.0)],
    long=[dict(duration=5800.0)],
    hard="the slip at the end of each swing gets ever shallower: 1e-6 m/s after ten minutes, 1e-8 after an hour",
    outcome="rocks, slips a little less with each swing, and never ceases to",
)
def rocking_to_rest(slope=0.02, mu=0.05, e=0.03, omega=-6.0, r=0.1, m=1.0, g=9.81, duration=20.0):
    """The same wheel with less weight on less slope: it comes to rock about its lowest place.

    Why: friction takes energy only where the cone is reached, so the swing decays towards the one that just touches it,
    as 1/t and not exponentially.
    Source: this suite's.
    Known exactly: energy lost = work of friction.
    """
    return case_on_track(line(slope), unbalanced_wheel(r, e, m), mu, g, duration, xi2=-pi / 2, omega=omega)
