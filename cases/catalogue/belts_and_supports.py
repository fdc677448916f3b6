"""Belts together with further contacts: a plate on a conveyor next to a wall, on two belts, or carried to a stop.

Gravity pulls along −Y."""

from math import cos, pi

from cases import Belt, Case, CoulombFriction, Curve, Gravity, Load, Plate, StartPose, Support, Unilateral, case, disc
from cases.catalogue.common_scenes import case_with_impacts, contact_with_impacts
from cases.errors import not_negative, positive
from cases.library import line


def _wall(x: float) -> Support:
    """A vertical wall at x without friction; the plate is on its left."""
    return Support(Curve(lambda s: (x + 0.0 * s, 1.0 * s)), "wall", ())


@case(variants=[dict(), dict(speed=-2.0, press=10.0)])
def disc_between_belt_and_wall(speed=2.0, mu=0.3, mu_wall=0.4, press=3.0, r=0.5, m=1.0, g=9.81, duration=2.0):
    """A load presses a disc against a wall on its left, and a conveyor below it spins it up.

    A speed above 0 runs towards the wall. Away from it, and with 10 N, the wall's friction holds the disc at rest.

    Why: two slipping contacts of which one begins to stick; three rows of contact then determine the motion.
    Source: derived: with the friction F₁ of the belt, F₁ (1 − μ μ_wall) = μ (m g + μ_wall press) while both slip.
    Known exactly: it sticks to the belt after m speed/(2 (F₁ (1 − μ_wall) − μ_wall press)).
    """
    supports = (Support(line(pi / 2), "wall", (CoulombFriction(mu_wall),)),)
    plate = disc(positive("r of disc_between_belt_and_wall", r), m)
    start = StartPose(r, r)
    return case_with_impacts(line(), plate, mu, g, start, duration, Belt(-speed), Load(fx=-press), supports=supports)


@case
def disc_in_v_of_belts(speed=1.5, mu=0.3, incline=pi / 6, r=0.5, m=1.0, g=9.81, duration=1.5):
    """A disc at rest in a V of two planes whose surfaces run: it spins until it rolls on both.

    Why: both contacts begin to stick at once; four rows determine the motion, and the forces are not unique.
    Source: derived as for `disc_spinning_in_v`.
    Known exactly: it rolls after speed (1 + μ²) cos α/(2 μ g), as long as μ < tan α.
    """
    supports = (Support(line(-incline), "right", (CoulombFriction(mu), Belt(speed))),)
    start = StartPose(0.0, r / cos(incline))
    return case_with_impacts(line(incline), disc(r, m), mu, g, start, duration, Belt(speed), supports=supports)


@case(variants=[dict(), dict(speed=0.8, mu_static=0.0, stiffness=0.0)])
def block_on_conveyor(speed=0.3, mu=0.2, mu_static=0.4, stiffness=20.0, m=1.0, g=9.81, duration=3.0):
    """A block lies on a conveyor with both lower corners, held by a spring: it sticks and slips by turns.

    Without the spring (stiffness=0) it is carried to a wall, where the belt slips below it.

    Why: stick and slip with two contacts that share the load in a way that Coulomb's law leaves open.
    Source: the oscillator on a belt of textbooks (known to us, not looked up); derived.
    Known exactly: with ω² = stiffness/m and d = (μ_static − μ) g/ω² it sticks for 2 d/speed and slips for
    (2 π − 2 atan(ω d/speed))/ω; without the spring it rides after speed/(μ g), and stops (e = 0).
    Certified to 2.9e-11 s with the spring: one witness notices the limit by accelerations of 1e-12 of their terms.
    """
    friction = CoulombFriction(mu, mu_static or None)
    spring = (Load(fx=f"-{float(stiffness)!r}*x"),) if stiffness else ()
    effects = tuple(e for e in contact_with_impacts(mu, g) if not isinstance(e, CoulombFriction))
    return Case(
        track=line(),
        plate=Plate.rectangle(0.6, 0.4, m),
        effects=(*effects, friction, Belt(speed), *spring),
        start=StartPose(0.0, 0.2),
        duration=duration,
        supports=(_wall(1.0),),
    )


@case
def block_on_stribeck_belt(speed=0.5, low=0.2, drop=0.2, width=0.2, stiffness=400.0, m=1.0, g=9.81, duration=1.0):
    """A block rides on a belt with both lower corners against a spring, with friction that falls with the slip speed.

    The coefficient is low + drop·exp(−v/width): 0.4 at rest, and less in each slip.

    Why: two contacts with friction by a formula; its fall drives stick and slip without a static coefficient.
    Source: the oscillator on a belt of textbooks (known to us, not looked up); derived.
    Known exactly: it first slips after (low + drop) m g/(stiffness speed); all times are those of a particle.
    """
    friction = CoulombFriction(
        f"{not_negative('low', low)!r} + {not_negative('drop', drop)!r}*exp(-v/{positive('width', width)!r})"
    )
    return Case(
        track=line(),
        plate=Plate.rectangle(0.6, 0.4, m),
        effects=(Gravity(g), friction, Unilateral(), Belt(speed), Load(fx=f"-{float(stiffness)!r}*x")),
        start=StartPose(0.0, 0.2, vx=speed),
        duration=duration,
    )
