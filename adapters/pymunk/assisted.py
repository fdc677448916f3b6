"""Any plate on any track: the adapter computes the contact point, the engine the mechanics.

Two circles that overlap everywhere give one arbiter in every step. Before the engine solves it,
`ContactGuide.pre_solve` writes the exact contact point and normal into it, and the normal velocity with which the
plate's next position is on the track again; inertia, friction cone, stick and normal force are the engine's. That
`surface_velocity` may have a part along the normal is not in pymunk's manual; it follows from Chipmunk's
`cpArbiterApplyImpulse`.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, isnan
from typing import Any

import pymunk
from pymunk import Arbiter, ContactPoint, ContactPointSet, Vec2d

from cases import Belt, Case, CoulombFriction, Unilateral
from cases.contact import Contact, MotionPoint, start_motion
from cases.motion.mechanics import gravity

from ..common.flights import BEYOND, Follower
from ..interface import Setting
from . import older_versions
from .load import LoadInSteps, Torsor, loads_in_steps
from .native import friction_coefficient, to_start

# Radius in metres of the overlapping circles: much larger than any track, small enough to lose no digits.
EVERYWHERE = 1e6

# A normal velocity in m/s at which a contact may open or close without a push.
FREELY = 1e9

_TRACK, _PLATE = 1, 2


class ContactGuide:
    """Sets the engine's contact geometry in each step, and records the contacts.

    `off_track` is true once no point of the track is near the plate; `problem` is the first exception raised inside the
    callback, which the engine would print and drop.
    """

    def __init__(self, case: Case, body: pymunk.Body, h: float, drive: LoadInSteps | None):
        self.contacts: list[Contact] = []
        self.off_track = False
        self.problem: Exception | None = None
        self._case, self._body, self._h = case, body, h
        self._belt = case.effect(Belt)
        self._bilateral = case.effect(Unilateral) is None
        self._here, self._ahead, self._track = Follower(case), Follower(case), case.track.jet
        self._before = _velocities(start_motion(case))
        gx, gy = gravity(case)
        self._gravity, self._drive = (float(gx), float(gy)), drive
        friction = case.effect(CoulombFriction)
        self._coefficient = friction.at if friction and friction.by_speed else None

    def pre_solve(self, arbiter: Arbiter, space: pymunk.Space, data: object) -> None:
        """Write contact point, normal and target normal velocity into the arbiter; release a plate off its track."""
        try:
            if not self.off_track:
                self._set_contact(arbiter)
        except BEYOND:
            self.off_track = True
        except Exception as problem:
            self.problem = self.problem or problem
        if self.off_track or self.problem:
            arbiter.process_collision = False

    def _set_contact(self, arbiter: Arbiter) -> None:
        body, h = self._body, self._h
        (x, y), theta, (now_vx, now_vy), now_omega = body.position, body.angle, body.velocity, body.angular_velocity
        contact = self._here(x, y, theta)
        self.contacts.append(contact)
        more_vx, more_vy, more_omega = self._predict(now_vx, now_vy, now_omega)
        vx, vy, omega = now_vx + more_vx, now_vy + more_vy, now_omega + more_omega
        ahead = self._ahead(x + h * vx, y + h * vy, theta + h * omega)
        if isnan(contact.xi1) or isnan(ahead.xi1):
            # A collision that is skipped once is skipped for good; with this normal velocity it never pushes instead.
            here = Vec2d(x, y)
            arbiter.contact_point_set = ContactPointSet(Vec2d(0.0, 1.0), (ContactPoint(here, here, 0.0),))
            arbiter.surface_velocity = Vec2d(0.0, FREELY)
            return
        # Floats: the engine's vectors check types in every product and take twice the time.
        X, Y, tx, ty = self._frame(contact.xi1)
        lever_x, lever_y = X - x, Y - y
        # With the predicted velocities the plate would be off the track by the gap: the target corrects for it.
        ux, uy = vx - omega * lever_y, vy + omega * lever_x
        target = ux * -ty + uy * tx - ahead.gap / h
        # Slip and belt are those of the middle of the step; the engine uses its beginning, so it gets the change.
        middle_x, middle_y, along_x, along_y = self._frame(0.5 * (contact.xi1 + ahead.xi1))
        # The plate is there off the middle of its chord, towards the inside of its path, by an eighth of the
        # displacement by the step's change.
        part, half = 0.125 * h if len(self.contacts) > 1 else 0.25 * h, 0.5 * h
        far_x, far_y = middle_x - x - half * vx + part * more_vx, middle_y - y - half * vy + part * more_vy
        change = (vx - omega * far_y) * along_x + (vy + omega * far_x) * along_y - (ux * tx + uy * ty)
        belt = self._belt.at(h * (len(self.contacts) - 0.5))[0] if self._belt else 0.0
        change -= belt
        velocity = Vec2d(change * tx - target * -ty, change * ty - target * tx)
        point, normal = Vec2d(X, Y), Vec2d(-ty, tx)
        # A bilateral guide pushes from the side that is needed; without a normal force there is no friction either, so
        # the free motion decides.
        if self._bilateral:
            kick = h if len(self.contacts) > 1 else half
            ax, ay, turn = self._accelerations()
            spin = now_omega + kick * turn
            free_x, free_y = now_vx + kick * ax - spin * lever_y, now_vy + kick * ay + spin * lever_x
            if free_x * -ty + free_y * tx > target:
                normal = Vec2d(ty, -tx)
        arbiter.contact_point_set = ContactPointSet(normal, (ContactPoint(point, point, 0.0),))
        arbiter.surface_velocity = velocity
        if self._coefficient:
            # By the slip in the middle of this step's change of velocity, as predicted.
            spin = now_omega + 0.5 * more_omega
            slip_x, slip_y = now_vx + 0.5 * more_vx - spin * lever_y, now_vy + 0.5 * more_vy + spin * lever_x
            arbiter.friction = self._coefficient(abs(slip_x * tx + slip_y * ty - belt))

    def _accelerations(self) -> Torsor:
        """The accelerations by gravity and load, without the contact."""
        if self._drive is None:
            return (*self._gravity, 0.0)
        (fx, fy, moment), plate = self._drive.torsor(), self._case.plate
        return self._gravity[0] + fx / plate.mass, self._gravity[1] + fy / plate.mass, moment / plate.inertia

    def _predict(self, vx: float, vy: float, omega: float) -> Torsor:
        """The change of these velocities in this step: that in the previous one."""
        number, before, self._before = len(self.contacts), self._before, (vx, vy, omega)
        if number == 1:
            ax, ay, turn = self._accelerations()
            return 0.5 * self._h * ax, 0.5 * self._h * ay, 0.5 * self._h * turn
        # The first step is a half one.
        ratio = 2.0 if number == 2 else 1.0
        return ratio * (vx - before[0]), ratio * (vy - before[1]), ratio * (omega - before[2])

    def _frame(self, xi1: float) -> tuple[float, float, float, float]:
        """The track's point and unit tangent."""
        X, Y, tx, ty, _, _, _, _ = self._track(xi1)
        length = hypot(tx, ty)
        return X, Y, tx / length, ty / length


def _velocities(start: MotionPoint) -> tuple[float, float, float]:
    return start.vx, start.vy, start.omega


def iterations(case: Case) -> int:
    """Iterations of the engine's solver: its default for a disc, with decoupled normal and friction impulse; else more.

    The two impulses of one contact are solved separately, and the iterations reduce the error of their coupling.
    """
    return 10 if case.plate.radius else 40


def build(case: Case, setting: Setting, h: float) -> tuple[pymunk.Space, pymunk.Body, LoadInSteps | None, ContactGuide]:
    """Build a space with the plate as a body, the drive of its load, and the guide along its track."""
    space, body = overlapping(case, setting)
    to_start(case, [body], h)
    (drive,) = loads_in_steps(case, [body], h)
    guide = ContactGuide(case, body, h, drive)
    listen(space, guide.pre_solve)
    return space, body, drive, guide


def overlapping(case: Case, setting: Setting) -> tuple[pymunk.Space, pymunk.Body]:
    """Build a space with two circles that overlap everywhere; the second one's body is the plate."""
    space = pymunk.Space()
    gx, gy = gravity(case)
    space.gravity = float(gx), float(gy)
    # Slop and bias correct overlap, and the contact set by the guide has none; only iterations have an effect.
    if "iterations" in setting:
        space.iterations = setting["iterations"]
    body = pymunk.Body(case.plate.mass, case.plate.inertia)
    track, plate = pymunk.Circle(space.static_body, EVERYWHERE), pymunk.Circle(body, EVERYWHERE)
    track.collision_type, plate.collision_type = _TRACK, _PLATE
    track.friction, plate.friction = 1.0, friction_coefficient(case.effects)
    space.add(body, track, plate)
    return space, body


def listen(space: pymunk.Space, pre_solve: Callable[[Arbiter, pymunk.Space, Any], None]) -> None:
    """Register a function that is called in every step before the contact is solved."""
    older_versions.on_collision(space, _TRACK, _PLATE, pre_solve)
