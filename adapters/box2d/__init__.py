"""Box2D's adapter; `adapters.box2d.adapter` describes it."""

from .adapter import (
    BELTS_AND_SUPPORTS,
    CORNERS,
    DRIVEN_CONTACTS,
    FREE_POLYGONS,
    NAME,
    ROUNDING,
    SEVERAL_CONTACTS,
    SEVERAL_PLATES,
    SUPPORTS,
    build,
    default_grid,
    grid,
    ladder,
    read,
    refuses,
    refuses_several_contacts,
    routes,
    run,
    version,
)
from .meanings import MEANINGS

__all__ = [
    "BELTS_AND_SUPPORTS", "CORNERS", "DRIVEN_CONTACTS", "FREE_POLYGONS", "MEANINGS", "NAME", "ROUNDING",
    "SEVERAL_CONTACTS",
    "SEVERAL_PLATES", "SUPPORTS", "build", "default_grid", "grid", "ladder", "read", "refuses",
    "refuses_several_contacts", "routes", "run", "version",
]  # fmt: skip
