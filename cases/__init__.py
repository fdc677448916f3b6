"""The question and the form of the answer: scenes of a plate on a track, and trajectories.

Its classes are imported when they are first used: SymPy takes most of a command's start, and help and lists need none.
"""

from .files import keyboard_interrupt, search_path  # the first of all: what follows takes a second  # noqa: F401

# isort: split
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from .errors import BadCurve, BadValue, CaseError, DoesNotFit, NotSupported, UnknownName
from .lookup import load
from .registry import case, entry, load_file, names, select
from .version import __version__

if TYPE_CHECKING:
    from .curves import Curve
    from .curves.chain import Chain
    from .curves.outline import Outline, arc
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
    from .fits import fit_friction, fit_waves
    from .motion.trajectory import ContactImpulse, Cost, Mode, Passage, State, Trajectory, Transition
    from .own_effects import ContactEffect, ContactForce, EndCondition
    from .scene.case_class import Case
    from .scene.free_plates import FreePlate
    from .scene.pair_effects import Pair
    from .scene.plate import Plate, block, disc
    from .scene.start import Start
    from .scene.start_pose import StartPose
    from .scene.supports import Support

__all__ = [
    "BadCurve",
    "BadValue",
    "Belt",
    "Case",
    "CaseError",
    "Chain",
    "ContactEffect",
    "ContactForce",
    "ContactImpulse",
    "Cost",
    "CoulombFriction",
    "Curve",
    "DoesNotFit",
    "Drive",
    "Effect",
    "EndCondition",
    "Flight",
    "FreePlate",
    "Gravity",
    "Impact",
    "Load",
    "Mode",
    "NotSupported",
    "Outline",
    "Pair",
    "Passage",
    "PerfectlyRough",
    "Plate",
    "RollingResistance",
    "Start",
    "StartPose",
    "State",
    "Support",
    "Trajectory",
    "Transition",
    "Unilateral",
    "UnknownName",
    "__version__",
    "arc",
    "block",
    "case",
    "disc",
    "entry",
    "fit_friction",
    "fit_waves",
    "load",
    "load_file",
    "names",
    "select",
]

# The modules of the names that are imported at their first use.
_MODULES = {
    "scene.case_class": ("Case",), "curves.chain": ("Chain",), "curves": ("Curve",),
    "effects": ("Belt", "CoulombFriction", "Drive", "Effect", "Flight", "Gravity", "Impact", "Load", "PerfectlyRough",
                "RollingResistance", "Unilateral"),
    "fits": ("fit_friction", "fit_waves"), "scene.free_plates": ("FreePlate",), "curves.outline": ("Outline", "arc"),
    "own_effects": ("ContactEffect", "ContactForce", "EndCondition"), "scene.pair_effects": ("Pair",),
    "scene.plate": ("Plate", "block", "disc"), "scene.start": ("Start",), "scene.start_pose": ("StartPose",),
    "scene.supports": ("Support",),
    "motion.trajectory": ("ContactImpulse", "Cost", "Mode", "Passage", "State", "Trajectory", "Transition"),
}  # fmt: skip
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name in _MODULE_OF:  # from now on an attribute: to look it up here takes as long as making an effect
        value = globals()[name] = getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)
        return value
    if not name.startswith("_") and find_spec(f"{__name__}.{name}"):
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
