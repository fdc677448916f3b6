"""Tracks that move themselves: shaken tables, accelerated plates, swinging bowls. Gravity pulls along −Y."""

from math import pi

from cases import Drive, Flight, Impact, case, disc, moving_surface
from cases.catalogue.common_scenes import case_on_track
from cases.curves import sin
from cases.library import circle, line


@case
def disc_on_accelerated_plate(jerk=4.0, mu=0.2, r=0.1, m=1.0, g=9.81, duration=2.5):
    """A disc on a plate whose acceleration grows: it rolls, then the plate slips away below it.

    Why: the ball on a moving plate; the plate drives a disc that stands still at first.
    Source: derived: rolling on a plate of acceleration a takes m a/3 of friction and gives the disc a/3 (J = m r²/2).
    Known exactly: it rolls until jerk t = 3 mu g, with a third of the plate's acceleration.
    """
    return case_on_track(line(), disc(r, m), mu, g, duration, Drive(x=jerk * moving_surface.TIME**3 / 6))


@case
def disc_on_shaken_table(amplitude=0.05, rate=12.0, mu=0.2, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc on a table shaken to and fro, x = amplitude sin(rate t): it rolls where friction holds, else it slips.

    Why: stick and slip alternate for ever, driven by the track.
    Source: posed here.
    Known exactly: where it rolls its acceleration is a third of the table's; it slips where that exceeds 3 mu g.
    """
    return case_on_track(line(), disc(r, m), mu, g, duration, Drive(x=amplitude * sin(rate * moving_surface.TIME)))


@case
def disc_in_swinging_bowl(swing=0.4, rate=3.0, mu=0.1, R=1.0, r=0.1, m=1.0, g=9.81, duration=3.0):
    """A disc in a circular bowl that swings about its centre by the angle swing sin(rate t).

    Why: the track's surface moves along itself, and Coriolis's and Euler's forces act in its frame.
    Source: posed here.
    Known exactly: the bowl's shape never changes, so it is a belt of speed R swing rate cos(rate t).
    """
    drive = Drive(angle=swing * sin(rate * moving_surface.TIME))
    return case_on_track(circle(R), disc(r, m), mu, g, duration, drive, xi1=-pi / 2 + 0.5)


@case
def disc_on_bouncing_table(amplitude=0.02, rate=30.0, e=0.4, mu=0.2, v0=0.5, r=0.1, m=1.0, g=9.81, duration=0.5):
    """A sliding disc on a table shaken up and down by more than g: it lifts off, flies, and lands on the moving table.

    Why: lift-off, flight, impact and slip relative to a track that moves.
    Source: posed here; the bouncing ball on a vibrating table is known to us, not looked up.
    Known exactly: it first lifts off where amplitude rate² sin(rate t) = g.
    """
    drive = Drive(y=amplitude * sin(rate * moving_surface.TIME))
    return case_on_track(line(), disc(r, m), mu, g, duration, Flight(), Impact(e), drive, slip=v0)
