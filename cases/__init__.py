"""The question and the form of the answer: scenes of a plate on a track, and trajectories."""

from . import keyboard_interrupt  # the first of all: what follows takes a second  # noqa: F401

# isort: split
from .case import Case
from .chain import Chain
from .curves import Curve
from .effects import (
    Belt,
    CoulombFriction,
    Drive,
    Effect,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    RollingResistance,
    Unilateral,
)
from .errors import BadCurve, BadValue, CaseError, DoesNotFit, NotSupported, UnknownName
from .outline import Outline, arc
from .own_effects import ContactEffect, ContactForce, EndCondition
from .plate import Plate, disc
from .registry import case, entry, load, load_file, names, select
from .start import Start
from .trajectory import Cost, Mode, Passage, State, Trajectory, Transition
from .version import __version__

__all__ = [
    "BadCurve",
    "BadValue",
    "Belt",
    "Case",
    "CaseError",
    "Chain",
    "ContactEffect",
    "ContactForce",
    "Cost",
    "CoulombFriction",
    "Curve",
    "DoesNotFit",
    "Drive",
    "Effect",
    "EndCondition",
    "Flight",
    "Gravity",
    "Impact",
    "Load",
    "Mode",
    "NotSupported",
    "Outline",
    "Passage",
    "PerfectlyRough",
    "Plate",
    "RollingResistance",
    "Start",
    "State",
    "Trajectory",
    "Transition",
    "Unilateral",
    "UnknownName",
    "__version__",
    "arc",
    "case",
    "disc",
    "entry",
    "load",
    "load_file",
    "names",
    "select",
]
