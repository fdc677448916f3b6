"""Numbers of other people's programs. Their records are in `published_numbers`; as a program, this file writes them as
the table of a report, `reports/studies/published/numbers.csv`.

Here is what decides between a publisher and us where the two differ: the closed form of a ball that bounces on a level
floor. From the height h, thrown up with v, it meets the floor at t₁ = (v + w)/g with w = sqrt(v² + 2 g h) and leaves it
with e w; the flight after impact k lasts 2 e^k w/g. (Derived: free fall, and Newton's restitution.)
"""

import csv
from math import sqrt
from pathlib import Path

from .published_numbers import COLUMNS, PUBLICATIONS, Number, Publication, motion_of, rows

__all__ = ["COLUMNS", "FILE", "PUBLICATIONS", "Number", "Publication", "impacts", "motion_of", "rows"]


def impacts(count: int, h: float, v: float, e: float, g: float) -> list[float]:
    """The instants of the first impacts, s."""
    w = sqrt(v * v + 2 * g * h)
    times = [(v + w) / g]
    for k in range(1, count):
        times.append(times[-1] + 2 * e**k * w / g)
    return times


FILE = Path(__file__).parents[2] / "reports" / "studies" / "published" / "numbers.csv"

if __name__ == "__main__":
    with open(FILE, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows(PUBLICATIONS))
