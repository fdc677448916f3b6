"""The symbols of authors' formulas by name; those of SymPy are made when they are first used.

Modules that document one of them have it as an attribute by the same `__getattr__`.
"""

from typing import Any

from . import late_sympy as sp

NAMES: dict[str, str | tuple[str, ...]] = {
    # Of every curve.
    "PARAMETER": "s",
    # What a load may depend on: time (s), pose (m, rad) and velocities (m/s, rad/s) of the centre of mass.
    "MOTION": ("t", "x", "y", "theta", "vx", "vy", "omega"),
    # What a force at the contact may depend on: time (s), slip velocity (m/s) and spin (rad/s), both relative to the
    # track, which a Drive may turn.
    "CONTACT": ("t", "slip", "omega"),
    # Of belts and drives.
    "TIME": "t",
    # The slip speed of a friction law, m/s.
    "SLIP_SPEED": "v",
}


def __getattr__(name: str) -> Any:
    if name not in NAMES:
        raise AttributeError(f"there is no symbol {name!r}")
    value = globals()[name] = sp.symbols(NAMES[name], real=True)
    return value
