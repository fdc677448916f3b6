"""Other people's numbers: `PUBLICATIONS`, `rows(PUBLICATIONS)` for the table, `COLUMNS` for its words."""

from .bouncing import BOUNCING
from .records import COLUMNS, Number, Publication, motion_of, rows
from .rolling import ROLLING

PUBLICATIONS: tuple[Publication, ...] = (*ROLLING, *BOUNCING)

__all__ = ["COLUMNS", "PUBLICATIONS", "Number", "Publication", "motion_of", "rows"]
