"""Published numbers of other programs: `PUBLICATIONS`, `rows(PUBLICATIONS)` for the table, `COLUMNS` with headings."""

from .bouncing import BOUNCING
from .oscillating import OSCILLATING
from .publications import COLUMNS, Number, Publication, motion_of, rows
from .rolling import ROLLING

PUBLICATIONS: tuple[Publication, ...] = (*ROLLING, *BOUNCING, *OSCILLATING)

__all__ = ["COLUMNS", "PUBLICATIONS", "Number", "Publication", "motion_of", "rows"]
