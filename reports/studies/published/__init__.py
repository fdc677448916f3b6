"""Published numbers of other programs: `PUBLICATIONS`, `rows(PUBLICATIONS)` for the table, `COLUMNS` with headings."""

from .bouncing import BOUNCING
from .publications import COLUMNS, Number, Publication, motion_of, rows
from .rolling import ROLLING

PUBLICATIONS: tuple[Publication, ...] = (*ROLLING, *BOUNCING)

__all__ = ["COLUMNS", "PUBLICATIONS", "Number", "Publication", "motion_of", "rows"]
