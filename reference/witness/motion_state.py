"""The state of a simulation by the second formulation: the plate's state, the transitions so far, and the time."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

from cases import Case, Drive, Transition
from cases.contact import pose
from cases.scene.piece_case import PieceCase

from .bouncing import Bounce
from .coulomb_law import decide
from .drive import case_at_rest, loads_of_drive
from .equations import ContactPhase, ContactScene
from .steps import WorkBudget
from .surroundings import Surroundings

# The status of a motion that reached the limit on work.
IN_PROGRESS = "unfinished"


class ContactState(NamedTuple):
    """The plate on its track: (ξ₁, ξ₂, ω, v), the whole turns of θ in addition to (6), and the phase."""

    z: list[float]
    turns: int
    phase: ContactPhase


class LiftOff(NamedTuple):
    """The start of a flight from the track: (ξ₁, ξ₂, ω, v), turns, normal velocity; the estimated duration of a short
    flight (s), and whether it is short."""

    z: list[float]
    turns: int
    lift: float
    lasts: float
    short: bool


class FlightState(NamedTuple):
    """The plate off its track: (x, y, θ, vx, vy, ω), the contact's parameters if it comes from its track, and the
    lift-off, if the flight began with a normal velocity."""

    body: list[float]
    place: tuple[float, float] | None = None
    leap: LiftOff | None = None


class LandingState(NamedTuple):
    """The plate at a landing: (ξ₁, ξ₂, ω, v), turns, and normal velocity."""

    z: list[float]
    turns: int
    lift: float


class EndState(NamedTuple):
    """The end of a motion."""

    status: str


class MotionState:
    """One motion during its simulation: the transitions and bounces so far, and the time."""

    def __init__(self, case: Case, rtol: float, steps_per_turn: int, until: float, overlaps: bool):
        drive = case.effect(Drive)
        self.drive_load = next(iter(loads_of_drive(case)), None)
        if drive:
            case = case_at_rest(case, drive)
        self.case, self.scene = case, ContactScene(case, self.drive_load)
        # An open outline has no inside and is only the contact arc.
        self.overlaps = overlaps and bool(case.plate.outline.period)
        self.rtol, self.steps_per_turn, self.end = max(rtol, 1e-13), steps_per_turn, min(case.duration, until)
        self.last: ContactState | FlightState | None = None  # the state at the end of a motion
        self.t, self.work = 0.0, WorkBudget()
        self.transitions: list[Transition] = []
        self.bounces: list[Bounce] = []
        self.fastest = 0.0  # closing speed since the plate last lay on its track
        self.around: Surroundings | None = None  # sampled when the first flight begins
        self.last_xi1 = case.start.xi1

    def contact_state(self, z, turns: int, **options) -> ContactState | None:
        """The contact at the present instant, if one of its phases is consistent, else None; `options` as in
        `decide`."""
        phase = decide(self.scene, self.t, z, turns, **options)
        return ContactState(z, turns, phase) if phase else None

    def on_curves(self, z) -> tuple[float, float]:
        """The contact parameters of a state on the whole curves."""
        case = self.scene.case
        return case.to_whole(z[0], z[1]) if isinstance(case, PieceCase) else (z[0], z[1])

    @property
    def pieces(self) -> PieceCase | None:
        """The pieces of the contact, if the curves have any."""
        return self.scene.case if isinstance(self.scene.case, PieceCase) else None

    def unwind(self, theta: float, xi1: float, xi2: float) -> tuple[float, float, int]:
        """Contact parameters of a landing at the plate's angle `theta` (rad), on closed curves: the track's period
        nearest to the last contact, the outline's such that (6) gives that angle; and the remaining whole turns if the
        outline is open."""
        track, outline = self.case.track, self.case.plate.outline
        if track.period:
            xi1 += track.period * round((self.last_xi1 - xi1) / track.period)
        turns = round((theta - float(pose(self.case, xi1, xi2)[2])) / (2 * pi))
        return (xi1, xi2 - turns * outline.period, 0) if outline.period else (xi1, xi2, turns)

    def surroundings(self) -> Surroundings:
        """The track in stretches, sampled on first use."""
        if self.around is None:
            self.around = Surroundings(self.scene.case, self.last_xi1)
        return self.around
