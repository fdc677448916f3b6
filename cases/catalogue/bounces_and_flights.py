"""Plates that leave their track and come back: flight, landing, impact, bouncing to rest. Gravity pulls along −Y."""

from dataclasses import replace
from math import pi, sqrt

from cases import Curve, Flight, Impact, Plate, case, disc
from cases import curves as c
from cases.catalogue.common_scenes import case_on_track, ellipse_plate
from cases.catalogue.odd_wheels import eccentric, rod_on_tip
from cases.errors import positive
from cases.library import circle, line


@case(variants=[dict(e=0.5), dict(e=0.8)])
def bouncing_disc(e=0.5, mu=0.2, height=0.5, slip=1.0, omega=0.0, r=0.1, m=1.0, g=9.81, duration=4.0):
    """A disc thrown flat over a level floor: it bounces until it does not, slipping at first, then rolling.

    Why: infinitely many impacts in a finite time; friction acts in instants.
    Source: the usual bouncing ball, here with friction; derived: each flight lasts e times the one before.
    Known exactly: it comes to rest at sqrt(2 h/g) (1 + e)/(1 − e); the flights are a geometric series.
    """
    return case_on_track(line(), disc(r, m), mu, g, duration, Flight(), Impact(e), gap=height, slip=slip, omega=omega)


@case
def disc_off_ramp(e=0.3, mu=0.4, speed=1.3, r=0.05, m=1.0, g=9.81, duration=1.5):
    """A disc rolls over the crest of y = exp(−4 x²), leaves it, lands on the flank, bounces and rolls on.

    Why: lift-off, a search for the landing, oblique impacts and an accumulation, one after the other.
    Source: the smooth cousin of the ski jump; posed here.
    Known exactly: each flight's centre runs on a parabola.
    """
    track = Curve(lambda s: (s, c.exp(-4.0 * s**2)), domain=(-8, 8))
    return case_on_track(track, disc(r, m), mu, g, duration, Flight(), Impact(e), omega=-speed / r)


@case
def disc_across_circle(e=0.6, mu=0.3, xi1=0.5, r=0.1, m=1.0, g=9.81, duration=3.0):
    """A disc let go against the upper wall of a circle falls off at once, crosses it and bounces on the other side.

    Why: contact is lost at time zero and found again in another place.
    Source: posed here.
    Known exactly: the fall until the first impact is a parabola inside a circle of radius R − r.
    """
    return case_on_track(circle(1.0), disc(r, m), mu, g, duration, Flight(), Impact(e), xi1=xi1)


@case
def tumbling_ellipse(e=0.4, mu=0.3, height=0.4, omega=4.0, a=0.2, b=0.1, m=1.0, g=9.81, duration=1.0):
    """A spinning ellipse dropped on a line: impacts off the centre, where friction and spin trade places.

    Why: slip reverses within an impact; what follows depends on the angle at which it lands.
    Source: this suite's, after Wang & Mason, "Two-dimensional rigid-body collisions with friction", J. Appl. Mech. 59
    (1992) 635–642 (reference looked up, not the text).
    Known exactly: it lands when its centre is sqrt(a² sin² θ + b² cos² θ) high; no impact adds energy.
    """
    plate = ellipse_plate(a, b, m)
    return case_on_track(line(), plate, mu, g, duration, Flight(), Impact(e), xi2=-pi / 2, gap=height, omega=omega)


@case
def tumbling_ellipse_moreau(e=0.4, mu=0.3, height=0.4, omega=4.0, a=0.2, b=0.1, m=1.0, g=9.81, duration=1.0):
    """The ellipse of `tumbling_ellipse`, with the law of impact of engines that solve for a step's end.

    Why: beside `tumbling_ellipse` it tells an engine's other law from its errors.
    Source: this suite's; Moreau's law as `Impact` has it.
    Known exactly: it lands when and where `tumbling_ellipse` does; each impact turns the normal velocity to −e times
    itself.
    """
    one = tumbling_ellipse(e, mu, height, omega, a, b, m, g, duration)
    effects = tuple(Impact(e, "moreau") if isinstance(effect, Impact) else effect for effect in one.effects)
    return replace(one, effects=effects)


@case
def hopping_hoop(mu=0.6, share=0.7, angle=0.4, push=1.0, e=0.0, r=0.5, m=1.0, g=9.81, duration=1.2):
    """Littlewood's hoop, pushed: it rolls, slips both ways, hops when the weight comes down, lands and slips on.

    Why: the hop that was argued about for decades, and the landing nobody computed. `share` is the weight's share of
    the mass, `angle` its place from the top, `push` the spin at the start in units of sqrt(g/r). Let go at the top it
    does not hop (`littlewood_hoop`).
    Source: Theron & Maritz, "The amazing variety of motions of a loaded hoop", Math. Comput. Modelling 47 (2008) 1077
    (looked up), who also tell of Littlewood's and Tokieda's hoops; the push is this suite's.
    Known exactly: while it rolls, (1 + share cos φ) ω² + share (g/r) cos φ is constant, φ from the top.
    """
    offset = share * r
    plate = Plate(eccentric(r, offset), m, m * (r**2 - offset**2))
    return case_on_track(line(), plate, mu, g, duration, Flight(), Impact(e), xi2=angle - pi, omega=-push * sqrt(g / r))


@case(variants=[dict(mu=0.1), dict(mu=0.5)])
def disc_onto_incline(mu=0.5, slope=0.5, height=0.1, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A disc let go above an incline: it falls, does not bounce, and slides or rolls down.

    Why: friction in the impact and friction after it decide alike, at tan(slope) = 3 μ. `height` is the gap along the
    incline's normal.
    Source: the test "sphere inclined plane friction" of scopi (github.com/hpc-maths/scopi, test/test_friction.cpp and
    test/analytical_solution.cpp, looked up), there with r = g = 1 and height 1.
    Known exactly: it lands at T = sqrt(2 height/(g cos slope)). From then on it rolls with 2/3 of the speed
    g t sin(slope) of the frictionless disc, if tan(slope) ≤ 3 μ; else its speed is g t (sin(slope) − μ cos(slope)).
    Derived: the impulse m g T cos(slope) of the impact, then the force m g cos(slope), bound friction to μ times them,
    and what brings the rim to rest is a third of the slip's momentum.
    """
    return case_on_track(line(slope), disc(r, m), mu, g, duration, Flight(), Impact(0.0), gap=height)


@case
def hopping_rod(mu=1.2, angle=1.0, v0=2.0, omega=4.0, length=1.0, tip=0.001, m=1.0, g=9.81, duration=1.0):
    """Painlevé's rod, turning up as it is pushed along on its end: it takes off, lands on the same tip and slides on.

    Why: `sliding_rod` shows how friction multiplies the normal force; here it shows nothing of where the rod departs.
    Source: derived here; Painlevé's rod as other authors (Glocker among them) treat it was not found to be looked up.
    Known exactly: with half = length/2 the normal force at the start is
    m (g − half·sin φ·ω²)/(1 + 3 cos²φ − 3 μ cos φ (sin φ + tip/half)), φ = `angle`; the rod departs where
    half·sin φ·ω² = g, whatever μ is; it lands without rebound. Derived: N − m g = m ÿ with y = half·sin φ + tip, and
    m half² φ̈/3 = −half·N cos φ + μ N (half·sin φ + tip) for a tip that slides towards −X, the rod leaning to +X.
    """
    half, tip = positive("length of hopping_rod", length) / 2, positive("tip of hopping_rod", tip)
    effects, start = (Flight(), Impact(0.0)), dict(xi2=-pi / 2 - angle, slip=-v0, omega=omega)
    return case_on_track(line(), rod_on_tip(half, tip, m), mu, g, duration, *effects, **start)
