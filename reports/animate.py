"""`slip-to-roll cases film CASE [mu=0.3 …] [--out FILE.gif]`: write an animation of the true motion, GIF or MP4.

It plays in real time if that takes a few seconds, otherwise slowed down or sped up by a round factor, which it shows.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cases.files.command_line import status

from .drawing.figure_files import readable_name
from .show import case_of, check_free

if TYPE_CHECKING:
    from cases import Case

COMMAND = "reports.animate"


def run(words: Sequence[str]) -> None:
    """Write the animation; raises CaseError for invalid arguments, or if ffmpeg is missing for an MP4."""
    case, out, force, _ = case_of(
        COMMAND, words, "Write an animation of a case: GIF, or MP4 if ffmpeg is installed.", "out file"
    )
    path = out or Path(f"{readable_name(case.label)}.gif")
    check_free(path, force)
    _film(case, path, force)


def _film(case: Case, path: Path, force: bool) -> None:
    import reference

    film = reference.simulate(case).animate()
    path.parent.mkdir(parents=True, exist_ok=True)
    film.save(path, replace=force)
    print(f"{film.seconds:.3g} s of animation, {film.factor:g} × real time, {path.stat().st_size / 1e3:.0f} kB: {path}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    return status(COMMAND, run, argv)


if __name__ == "__main__":
    sys.exit(main())
