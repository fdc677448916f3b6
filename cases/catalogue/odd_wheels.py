"""Wheels that are out of balance or out of round, and a rod on its end. Gravity pulls along −Y."""

from math import atan, cos, pi, sinh, sqrt

from cases import Curve, Plate, case
from cases import curves as c
from cases.catalogue.common_scenes import case_on_track
from cases.errors import positive
from cases.library import catenary_hill, hill, line, logarithmic_spiral, rounded_polygon, superellipse


def eccentric(radius: float, eccentricity: float) -> Curve:
    """A circle whose centre lies at −eccentricity on the plate's own x axis."""
    r, e = positive("radius of the wheel", radius), positive("eccentricity of the wheel", eccentricity)
    return Curve(lambda s: (r * c.cos(s) - e, r * c.sin(s)))


def unbalanced_wheel(r: float, e: float, m: float) -> Plate:
    """A wheel of radius r with its centre of mass at the distance e from its axle, and J = m r²/2 about that."""
    return Plate(eccentric(r, e), m, 0.5 * m * r**2)


def rod_on_tip(half: float, tip: float, m: float) -> Plate:
    """A slender rod of length 2·half that touches with a round tip of that radius."""
    return Plate(eccentric(tip, half), m, m * half**2 / 3)


@case
def eccentric_disc_on_line(mu=0.1, e=0.03, omega=-6.0, r=0.1, m=1.0, g=9.81, duration=1.2):
    """An unbalanced wheel started in rolling with its weight beside the axle: the normal force swings each turn.

    Why: rolling and slipping alternate for a reason that no disc shows. J = m r²/2 about the centre of mass.
    Source: Goldstein, Poole & Safko; Maritz & Theron, Am. J. Phys. 80 (2012) (both known to us, not looked up);
    derived: a rolling plate turns about its contact point, and friction does no work.
    Known exactly: while it rolls, (J + m d²) ω²/2 + m g y is constant, d being its distance from the contact point.
    """
    return case_on_track(line(), unbalanced_wheel(r, e, m), mu, g, duration, xi2=-pi / 2, omega=omega)


@case
def littlewood_hoop(mu=0.2, share=0.8, angle=0.4, r=0.5, m=1.0, g=9.81, duration=1.5):
    """Littlewood's hoop: a weight on the rim of a light hoop, let go at the top. Does it hop?

    Why: a century of arguments; friction decides, because the hoop slips before it leaves the ground. `share` is the
    weight's share of the mass. It starts at `angle` from the top with the spin of rolling from rest there.
    Source: Littlewood, A Mathematician's Miscellany (1953), and Tokieda, as Theron & Maritz, "The amazing variety of
    motions of a loaded hoop", Math. Comput. Modelling 47 (2008) 1077, give them (looked up); Pritchett, "The hopping
    hoop revisited", Am. Math. Monthly, August 1999 (abstract looked up): it slips before it can take off.
    Known exactly: while it rolls ω² = (g/r) share (1 − cos φ)/(1 + share cos φ), φ from the top.
    """
    spin = sqrt(g / r * share * (1 - cos(angle)) / (1 + share * cos(angle)))
    e = share * r
    plate = Plate(eccentric(r, e), m, m * (r**2 - e**2))
    return case_on_track(line(), plate, mu, g, duration, xi2=angle - pi, omega=-spin)


@case
def superellipse_on_hill(mu=0.6, tilt=0.15, R=1.0, a=0.2, b=0.15, m=1.0, g=9.81, duration=1.5):
    """A square with round corners, x⁴ and y⁴, rocking on a hill: nearly flat below, nearly a corner beside.

    Why: the outline's curvature is zero at rest and large a little further on.
    Source: Lamé's curve, Piet Hein's superellipse (known to us, not looked up); the scene is this suite's.
    Known exactly: its area is 4 a b Γ(5/4)²/Γ(3/2). The inertia is (a² + b²)/3 of the box around it.
    """
    plate = Plate(superellipse(a, b), m, m * (a * a + b * b) / 3)
    return case_on_track(hill(R), plate, mu, g, duration, xi2=-pi / 2 + tilt)


@case
def rounded_triangle_on_line(mu=0.3, sharpness=0.8, omega=-8.0, r=0.1, m=1.0, g=9.81, duration=1.2):
    """A triangle of constant width rolling on a line, from its support function h(φ).

    Why: a board laid over it stays level, the plate's centre does not.
    Source: Reuleaux, Kinematics of Machinery (1876); Barbier (1860): its perimeter is 2π r (both known to us, not
    looked up). Derived: the perimeter is the integral of h + h″ over all directions.
    Known exactly: while it rolls, (J + m (h² + h′²)) ω²/2 + m g h is constant.
    """
    plate = Plate(rounded_polygon(r, 3, sharpness), m, 0.5 * m * r**2)
    return case_on_track(line(), plate, mu, g, duration, xi2=-pi / 2 + 0.3, omega=omega)


@case
def straight_edge_on_catenary(omega=-2.0, xi1=-0.1, mu=2.0, h=0.2, m=1.0, g=9.81, duration=0.5):
    """A square wheel: one side of it rolling over a road of catenaries, its centre at one height.

    Why: outline and track both have no circle anywhere, and yet the plate's path is a level line.
    Source: Hall & Wagon, "Roads and wheels", Math. Mag. 65 (1992) 283–301 (reference looked up, not the text); derived:
    the catenary's tangent passes the point above the contact at a constant distance.
    Known exactly: the centre of mass stays level while the edge rolls, and (J + m d²) ω² is constant.
    """
    h = positive("h of straight_edge_on_catenary", h)
    # The edge has rolled from the top of the road, so both have been passed over by the same length.
    plate = Plate(Curve(lambda s: (s, -h), domain=(-h, h)), m, m * (2 * h) ** 2 / 6)
    return case_on_track(catenary_hill(h, reach=h), plate, mu, g, duration, xi1=xi1, xi2=h * sinh(xi1 / h), omega=omega)


@case
def spiral_on_incline(growth=0.2, omega=-5.0, mu=0.5, start=0.1, m=1.0, g=9.81, duration=0.5):
    """A logarithmic spiral with its mass at the pole, rolling down an incline of slope atan(growth) on the level.

    Why: it rolls downhill and does not fall: the pole's path is level, equilibrium is neutral everywhere.
    Source: Lockwood, A Book of Curves (known to us, not looked up); derived: the pole moves at right angles to its
    radius, and the radius meets the incline at one angle.
    Known exactly: y of the centre of mass is constant while it rolls, and (J + m d²) ω² is. J = m·start²/2.
    """
    plate = Plate(logarithmic_spiral(start, growth), m, 0.5 * m * start**2)
    return case_on_track(line(atan(growth)), plate, mu, g, duration, xi2=-1.2, omega=omega)


@case(variants=[dict(mu=0.5), dict(mu=1.2)])
def sliding_rod(mu=0.5, angle=1.2, v0=2.0, length=1.0, tip=0.001, m=1.0, g=9.81, duration=0.5):
    """Painlevé's rod: a slender rod pushed along a line on its round tip, the tip leading, at `angle` to the line.

    Why: above μ = 4/3 rigid Coulomb contact loses its unique force; below it friction only multiplies the normal force.
    Source: Painlevé (1895), Génot & Brogliato, Eur. J. Mech. A/Solids (1999) (known to us, not looked up); Champneys &
    Várkonyi, "The Painlevé paradox in contact mechanics", arXiv 1601.03545 (abstract looked up). Derived from N − m g =
    m ÿ and the moment about the centre of mass.
    Known exactly: N = m g/(1 + 3 cos²φ − 3 μ cos φ (sin φ + 2 tip/length)) at the start; a denominator of zero first
    appears at μ = 4/3, tan φ = 2 (tip → 0).
    """
    half, tip = positive("length of sliding_rod", length) / 2, positive("tip of sliding_rod", tip)
    return case_on_track(line(), rod_on_tip(half, tip, m), mu, g, duration, xi2=-pi / 2 - angle, slip=-v0)
