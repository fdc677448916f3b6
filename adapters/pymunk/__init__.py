"""pymunk's adapter; `adapters.pymunk.adapter` describes it."""

from .adapter import (
    BELTS_AND_SUPPORTS,
    CORNERS,
    DRIVEN_CONTACTS,
    FREE_POLYGONS,
    NAME,
    SEVERAL_CONTACTS,
    SEVERAL_PLATES,
    SLIP_LAWS,
    SUPPORTS,
    bare_run,
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
    wide_grid,
)
from .meanings import MEANINGS

__all__ = [
    "BELTS_AND_SUPPORTS",
    "CORNERS", "DRIVEN_CONTACTS", "FREE_POLYGONS", "MEANINGS", "NAME", "SEVERAL_CONTACTS", "SEVERAL_PLATES",
    "SLIP_LAWS",
    "SUPPORTS", "build",
    "default_grid", "grid", "ladder", "read", "refuses", "refuses_several_contacts", "routes", "run", "bare_run",
    "version", "wide_grid",
]  # fmt: skip
