"""pymunk's adapter; `adapters.pymunk.adapter` describes it."""

from .adapter import (
    CORNERS,
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
    "CORNERS", "MEANINGS", "NAME", "SEVERAL_CONTACTS", "SEVERAL_PLATES", "SLIP_LAWS", "SUPPORTS", "build",
    "default_grid", "grid", "ladder", "read", "refuses", "refuses_several_contacts", "routes", "run", "bare_run",
    "version", "wide_grid",
]  # fmt: skip
