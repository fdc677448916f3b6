"""What games and robots ask of an engine: seams between tiles, stacks, dominoes, and what holds for ever. Gravity pulls
along −Y."""

from math import atan, cos, sin, tan

from cases import (
    Belt,
    Chain,
    CoulombFriction,
    Curve,
    Drive,
    FreePlate,
    Pair,
    Plate,
    RollingResistance,
    StartPose,
    Support,
    case,
    disc,
    moving_surface,
)
from cases.catalogue.common_scenes import case_on_track, case_with_impacts
from cases.curves import sin as sin_of
from cases.errors import positive, whole
from cases.library import line


def _tiles(length: float, low: float, high: float) -> Chain:
    """Tiles in one line, each of a length, from x = low on to high or beyond."""
    count = whole("number of tiles", int((high - low) / positive("tile", length)) + 1, 1, 1000)
    return Chain.polyline([(low + i * length, 0.0) for i in range(count + 1)])


@case(variants=[dict(), dict(v=0.5, mu=0.0)])
def disc_over_seams(v=2.0, mu=0.3, tile=0.25, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A disc slides, then rolls over tiles that lie in line.

    Why: a seam between two tiles is no obstacle; engines that meet the next tile's corner lose speed or hop there.
    Source: public reports on ghost collisions (issue trackers of engines); derived: the tiles are one line.
    Known exactly: every seam takes no speed. It rolls after v/(3 μ g) at 2 v/3, as on the line.
    """
    return case_with_impacts(_tiles(tile, -1.0, 3.0), disc(r, m), mu, g, StartPose(0.0, r, vx=v), duration)


@case
def box_over_seams(v=2.0, mu=0.3, tile=0.25, width=0.4, height=0.2, m=1.0, g=9.81, duration=0.5):
    """A box slides flat over tiles that lie in line.

    Why: both corners and the side between them pass seams under friction; nothing may catch.
    Source: public reports on ghost collisions (issue trackers of engines); derived: the tiles are one line.
    Known exactly: x = v t − μ g t²/2, and no spin.
    """
    plate = Plate.rectangle(width, positive("height of box_over_seams", height), m)
    return case_with_impacts(_tiles(tile, -1.0, 3.0), plate, mu, g, StartPose(0.0, height / 2, vx=v), duration)


@case(variants=[dict(), dict(part=0.01)])
def box_held_by_friction(part=-0.01, slope=0.3, width=0.4, height=0.2, m=1.0, g=9.81, duration=5.0):
    """A box at rest on an incline a little flatter than its angle of friction stays; a little steeper, it slides.

    Why: does it hold? Engines with a regularised law creep, at a speed that depends on their setting.
    Source: a textbook problem of statics (known to us, not looked up); derived. μ = tan(slope)/(1 + part).
    Known exactly: with part ≤ 0 it rests; else x slides by g (sin α − μ cos α) t²/2 along the incline.
    """
    high = 0.5 * positive("height of box_held_by_friction", height)
    mu = tan(slope) / (1.0 + part)
    start = StartPose(high * sin(slope), high * cos(slope), -slope)
    return case_with_impacts(line(slope), Plate.rectangle(width, 2 * high, m), mu, g, start, duration)


@case(variants=[dict(), dict(part=0.05)])
def disc_held_by_resistance(part=-0.05, arm=0.01, mu=0.5, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc at rest on an incline is held by its rolling resistance, or just not.

    Why: the meaning of an engine's rolling resistance: the slope at which a wheel begins to roll.
    Source: a textbook problem of statics (known to us, not looked up); derived.
    tan(slope) = (arm/r)(1 + part).
    Known exactly: with part ≤ 0 it rests; else it rolls down by (2/3) g (sin α − (arm/r) cos α).
    """
    slope = atan(positive("arm", arm) * (1.0 + part) / positive("r", r))
    return case_on_track(line(slope), disc(r, m), mu, g, duration, RollingResistance(arm))


@case(variants=[dict(), dict(count=3)])
def stack_of_boxes(count=2, mu=0.3, width=0.4, height=0.2, m=1.0, g=9.81, duration=2.0):
    """Boxes stand on each other on the floor, and stay.

    Why: the first scene of every engine: does a stack stand still, and does it creep?
    Source: posed here; derived: all loads are vertical.
    Known exactly: nothing moves.
    """
    count = whole("count of stack_of_boxes", count, 2, 6)
    box = Plate.rectangle(width, positive("height of stack_of_boxes", height), m)
    others = tuple(FreePlate(box, StartPose(0.0, (i + 0.5) * height), f"box{i + 1}") for i in range(1, count))
    return case_with_impacts(line(), box, mu, g, StartPose(0.0, 0.5 * height), duration, others=others)


@case
def boxes_on_shaken_table(
    amplitude=0.05, rate=9.0, mu=0.6, mu_upper=0.2, width=0.4, height=0.1, m=1.0, g=9.81, duration=1.0
):
    """Two boxes on each other stand on a table that is shaken to and fro; the upper one slides on the lower one.

    Why: friction per pair: the lower box sticks to the table, the upper one slips on it.
    Source: a textbook problem of dynamics (known to us, not looked up); derived.
    Known exactly: with a = amplitude rate² the upper box begins to slip where a sin(rate t) = μ_upper g.
    """
    box = Plate.rectangle(width, positive("height of boxes_on_shaken_table", height), m)
    start = StartPose(0.0, 0.5 * height, 0.0, amplitude * rate)
    upper = FreePlate(box, StartPose(0.0, 1.5 * height, 0.0, amplitude * rate), "upper")
    drive = Drive(x=amplitude * sin_of(rate * moving_surface.TIME))
    pairs = (Pair("upper/plate", (CoulombFriction(mu_upper),)),)
    return case_with_impacts(line(), box, mu, g, start, duration, drive, others=(upper,), pairs=pairs)


@case(variants=[dict(), dict(count=5, duration=1.5)])
def dominoes(count=2, push=1.0, apart=0.3, mu=2.0, width=0.1, height=0.6, m=1.0, g=9.81, duration=1.0):
    """Thin blocks stand in a row; the first one is pushed and knocks the next one over.

    Why: corners that meet sides, one after the other; the speed of the wave is what viewers see.
    Source: posed here.
    Known exactly: until the first block hits the second one, its energy about the corner on which it turns.
    """
    count = whole("count of dominoes", count, 2, 8)
    box = Plate.rectangle(positive("width of dominoes", width), positive("height of dominoes", height), m)
    # It turns about its right lower corner: the centre moves across the line to it.
    start = StartPose(0.0, 0.5 * height, 0.0, 0.5 * height * push, 0.5 * width * push, -push)
    others = tuple(FreePlate(box, StartPose(i * apart, 0.5 * height), f"block{i + 1}") for i in range(1, count))
    return case_with_impacts(line(), box, mu, g, start, duration, others=others)


@case(variants=[dict(), dict(e=1.0, mu=0.0)])
def rebound_with_spin(e=0.8, mu=0.3, v=2.0, backspin=2.0, height=1.0, r=0.1, m=1.0, g=9.81, duration=1.5):
    """A disc with backspin is thrown flat and bounces on the floor, with or without loss.

    Why: rebounds and their energy; friction in an impact trades speed for spin.
    Source: derived by the momenta: P = (1 + e) m √(2 g h), friction μ P against the slip or what ends it.
    Known exactly: with e = 1 and no friction it comes back to its height for ever; else each rebound in closed form.
    """
    start = StartPose(0.0, r + positive("height of rebound_with_spin", height), 0.0, v, 0.0, backspin / r)
    return case_with_impacts(line(), disc(r, m), mu, g, start, duration, restitution=e)


@case
def box_off_conveyor(speed=1.0, mu=0.4, slope=0.3, width=0.2, height=0.1, m=1.0, g=9.81, duration=1.2):
    """A box rides a conveyor to its end and slides down the chute behind it.

    Why: a conveyor's hand-over: a surface that runs next to one that does not, and a side that tips over an edge.
    Source: posed here.
    Known exactly: it reaches the belt's speed after speed/(μ g), and tips when its centre has passed the end.
    """
    high = 0.5 * positive("height of box_off_conveyor", height)
    belt = Chain.polyline([(-2.0, 0.0), (0.3, 0.0), (0.3, -0.5)])  # it turns down behind its end
    # The chute begins below the belt's end: in an engine its own end would hold a box that lies on both.
    chute = Support(
        Curve(lambda s: (0.3 + s * cos(slope), -s * sin(slope)), (0.02, 3.0)), "chute", (CoulombFriction(mu),)
    )
    plate = Plate.rectangle(width, 2 * high, m)
    return case_with_impacts(belt, plate, mu, g, StartPose(0.0, high), duration, Belt(speed), supports=(chute,))
