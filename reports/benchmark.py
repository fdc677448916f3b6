"""`slip-to-roll release benchmark`: the canonical friction benchmark, one archive for engines in any language.

It has the scenes as data (scenes/NAME.json, the form that `docs/process_protocol.md` describes), the certified truth
with error bars (transitions.csv, states.csv, derivatives.csv, truth.json), a page that states each scene by its
formulas (index.html), and readers in C++, Rust, JavaScript and Python that print the errors of a list of values, paired
with the truth. To use it, nothing of the suite is needed. The same version gives the same bytes.

Exit status: 0; 2, with one sentence, for an unsuitable file; 1 if it cannot be written.
"""

from __future__ import annotations

import inspect
import json
import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from html import escape
from itertools import groupby
from math import inf, nan, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

import cases
from cases import BadValue
from cases.files import user_files
from cases.files.owned_folder import atomic_path, check_new

from . import options
from .deposit import entry

if TYPE_CHECKING:
    from cases import Case
    from reference.certification import Certificate
    from reference.certification.bars import Bar

COMMAND = "reports.benchmark"
ARCHIVE = "canonical-friction-benchmark"
READERS = Path(__file__).with_name("readers")
# One scene or a few of each family that engines can build from plates, curves, friction and restitution alone.
SCENES = (
    "disc_in_circle[mu=0.01]", "disc_in_circle[mu=0.1]", "disc_in_circle[mu=0.2]", "disc_on_line[mu=0.1]",
    "disc_on_line[mu=0.3]", "disc_on_incline[slope=0.29]", "disc_on_incline[slope=0.3]", "disc_on_incline[slope=0.4]",
    "disc_in_parabola", "disc_in_cosine", "disc_in_catenary", "disc_in_ellipse", "disc_on_trochoid",
    "disc_across_circle", "cycloidal_pendulum[s0=-0.5]", "rolling_pendulum", "rolling_loop[ratio=3.5]",
    "sliding_loop[ratio=4.9]", "disc_off_ramp", "disc_rolling_off_hill", "disc_sliding_off_hill",
    "disc_onto_incline[mu=0.1]", "disc_onto_incline[mu=0.5]", "ellipse_on_line[mu=0.05]", "ellipse_on_incline",
    "ellipse_in_circle", "block_on_incline[slope=0.3,mu=0.2]", "block_on_incline[slope=0.6,mu=0.52]",
    "block_on_conveyor", "disc_on_conveyor", "slider_on_spring", "bouncing_disc[e=0.5]", "bouncing_disc[e=0.8]",
    "rebound_with_spin", "thrown_with_spin[backspin=2]", "disc_over_seams", "box_over_seams", "disc_rolling_to_rest",
    "sliding_box", "dropped_box", "rocking_block", "ladder_at_wall", "disc_rocking_in_groove", "pile_of_discs",
    "row_of_discs", "stack_of_boxes", "dominoes", "disc_on_shaken_table",
)  # fmt: skip
TRANSITIONS = "case,contact,before,after,time,bar"
STATES = "case,quantity,t,value,bar"
DERIVATIVES = "case,parameter,contact,before,after,derivative,bar"
# The parameters of derivatives.
PARAMETERS = ("mu", "e")
_WORDS = """# Canonical friction benchmark, version {version}

{count} scenes of rigid plates on planar curves with Coulomb friction, and their true motions.

1. Build a scene from scenes/NAME.json (index.html states it by formulas) and simulate it with your engine.
2. Write a file of your values, with the columns of transitions.csv, states.csv or derivatives.csv, which has
   d(time)/d(parameter) for differentiable engines, without the last one, bar.
3. Print their errors, each paired with the truth, by a reader of your language in readers/:
   `python3 readers/errors.py transitions.csv mine.csv`

The last column of the truth is the error bar of its value; SI units, radians. The contact has a name where a scene has
several. The truth of a scene is what independent solutions agree on: see "witnesses" in truth.json. Licence of the
data: CC BY 4.0.
"""


def name_of(label: str) -> str:
    """The name of a scene in the archive: its label without the comma that separates columns."""
    return label.replace(",", ";")


def pack(archive: Path, labels: Sequence[str] = SCENES, replace: bool = False) -> Path:
    """Write the archive of the scenes with these labels; returns its path. Raises CaseError for an unknown one, and
    FileExistsError if the archive exists and may not be replaced."""
    from adapters.by_process.scene_file import as_json, scene

    truths = [_certified(label) for label in labels]
    files = {
        "README.md": _WORDS.format(version=cases.__version__, count=len(truths)),
        "index.html": _page(truths),
        "transitions.csv": _csv(TRANSITIONS, _transitions(truths)),
        "states.csv": _csv(STATES, _states(truths)),
        "derivatives.csv": _csv(DERIVATIVES, _derivatives(truths)),
        "truth.json": json.dumps([_summary(one) for one in truths], indent=1) + "\n",
        **{f"scenes/{name_of(one.case.label)}.json": as_json(scene(one.case)) + "\n" for one in truths},
        **{f"readers/{path.name}": path.read_text(encoding="utf-8") for path in sorted(READERS.iterdir())},
    }
    root = f"{ARCHIVE}-{cases.__version__}"
    with atomic_path(archive, replace) as partial, ZipFile(partial, "w", ZIP_DEFLATED) as zipped:
        for name, text in files.items():
            zipped.writestr(entry(f"{root}/{name}"), text)
    return archive


class _Certified(NamedTuple):
    """A scene, its certificate, and the contacts of its transitions, in their order."""

    case: Case
    truth: Certificate
    contacts: list[str]

    def transitions(self) -> Iterator[tuple[str, Any, Any, Bar]]:
        """Contact, mode before, mode after, and time (s) of each transition."""
        for contact, (before, after, time, _) in zip(self.contacts, self.truth.transitions, strict=True):
            yield contact, before, after, time


def _certified(label: str) -> _Certified:
    """Raises CaseError if there is no such scene, or its certificate is out of date."""
    import reference
    from reference.certification import stored_or_new

    case = cases.lookup.case_name(label).one()
    truth, found = stored_or_new(case), reference.simulate(case, rtol=1e-13).transitions
    if [(t.before, t.after) for t in found] != [(before, after) for before, after, *_ in truth.transitions]:
        raise BadValue(f"{label} has other transitions here than in its certificate; run `python -m reference`")
    return _Certified(case, truth, [t.contact for t in found])


def _transitions(some: Sequence[_Certified]) -> Iterator[tuple]:
    return (
        (name_of(one.case.label), contact, before, after, *time)
        for one in some
        for contact, before, after, time in one.transitions()
    )


def _states(some: Sequence[_Certified]) -> Iterator[tuple]:
    for case, truth, _ in some:
        for quantity, values in truth.samples.items():
            for t, value in zip(truth.times, values, strict=True):
                yield name_of(case.label), quantity, t, *value


def _derivatives(some: Sequence[_Certified]) -> Iterator[tuple]:
    """The derivatives of transition times by friction and restitution; NaN where there are none."""
    from reference import NoDerivative, derivatives

    for case, *_ in some:
        for parameter in (p for p in PARAMETERS if p in cases.registry.entry(case.name).parameters):
            try:
                changes = derivatives(case, parameter).transitions
            except NoDerivative:
                yield name_of(case.label), parameter, "", "", "", nan, inf
                continue
            for t in changes:
                yield name_of(case.label), parameter, t.contact, t.before, t.after, *t.derivative


def _csv(head: str, rows: Iterator[tuple]) -> str:
    return "\n".join([head, *(",".join(map(str, row)) for row in rows)]) + "\n"


def _summary(one: _Certified) -> dict[str, Any]:
    case, truth, _ = one
    return {
        "case": name_of(case.label),
        "status": truth.status,
        "end": truth.end._asdict(),
        "witnesses": truth.witnesses,
        "kinds": truth.kinds,
    }


def _page(some: Sequence[_Certified]) -> str:
    """The page: each scene by its formulas, and its transitions with error bars."""
    title = f"Canonical friction benchmark {cases.__version__}"
    head = f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>{_STYLE}</style>'
    parts = list[str]()
    for name, group in groupby(some, lambda one: one.case.name):
        words = (inspect.getdoc(cases.registry.entry(name).function) or "").split("\n\n")
        parts += [f"<h2>{escape(name)}</h2>", *(f"<p>{escape(paragraph)}</p>" for paragraph in words)]
        parts += map(_section, group)
    return f"{head}</head><body><h1>{title}</h1>\n<p>{escape(_FRAME)}</p>\n" + "\n".join(parts) + "\n</body></html>\n"


_STYLE = (
    "body{font:16px/1.5 sans-serif;max-width:50em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse;margin:.7em 0}td,th{padding:.1em .8em .1em 0;text-align:left;vertical-align:top}"
)
_FRAME = (
    "SI units, radians. The plate lies on the left of the track. A pose is that of the centre of mass; outlines and "
    "corners are given from there. Slip is the velocity of the plate's contact point along the track's tangent. "
    "Numbers have 12 digits here and all digits in scenes/."
)


def _section(one: _Certified) -> str:
    from tabulate import tabulate

    rows = [
        (contact, before, after, repr(time.value), f"{time.bar:.1e}", kind)
        for (contact, before, after, time), kind in zip(one.transitions(), one.truth.kinds, strict=True)
    ]
    head = ("contact", "before", "after", "time (s)", "±", "by")
    end = f"<p>{escape(one.truth.status)} at {one.truth.end.value!r} s ± {one.truth.end.bar:.1e} s</p>"
    stated = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in _stated(one.case))
    table = tabulate(rows, head, tablefmt="html", disable_numparse=True) if rows else "<p>No transition.</p>"
    return f"<h3>{escape(one.case.label)}</h3>\n<table>{stated}</table>\n{table}{end}"


def _stated(case: Case) -> Iterator[tuple[str, str]]:
    """What defines a scene, in words and formulas."""
    from cases.scene.free_plates import POSE, names_of, plates_of, start_poses

    yield "track", _curve(case.track)
    for support in case.supports:
        yield f"support {support.name}", f"{_curve(support.curve)}; {_effects(support.acting(case.effects))}"
    starts = start_poses(case).tolist()
    for name, plate, pose in zip(names_of(case), plates_of(case), starts, strict=True):
        at = ", ".join(f"{quantity} = {_number(value)}" for quantity, value in zip(POSE, pose, strict=True))
        yield name, f"mass {plate.mass:g}, inertia {plate.inertia:.12g}; {_curve(plate.outline)}; starts at {at}"
    yield "effects", _effects(case.effects)
    yield "duration", f"{case.duration:g} s"


def _curve(curve: Any) -> str:
    """A curve by its formulas, or through its corners and joints."""
    from adapters.by_process.scene_file import formula

    expression = formula(curve)
    if expression is not None:
        return f"x = {expression[0]}, y = {expression[1]}"
    places = curve.point(curve.vertices(2.0 * pi)).T
    return "through " + ", ".join(f"({_number(x)}, {_number(y)})" for x, y in places)


def _effects(effects: Sequence[Any]) -> str:
    return ", ".join(map(str, effects)) or "none"


def _number(value: float) -> str:
    """A number without the roundings of a pose that was computed."""
    return f"{round(value, 12) + 0.0:.12g}"


@options.runs(
    COMMAND, "Write the canonical friction benchmark: scenes, truth and readers for engines in any language.",
    "out file", "force", example="slip-to-roll release benchmark --out benchmark.zip",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> None:
    """Write the archive and print its path."""
    archive = user_files.place("file of --out", arguments.out or f"{ARCHIVE}-{cases.__version__}.zip")
    if archive.suffix != ".zip":
        raise BadValue(f"--out is {str(archive)!r}; give a file that ends in .zip")
    check_new(archive, arguments.force)
    options.check_writable("--out", archive, archive.parent)
    archive.parent.mkdir(parents=True, exist_ok=True)
    print(f"{len(SCENES)} scenes, their truth and its derivatives: half a minute", file=sys.stderr)
    pack(archive, replace=arguments.force)
    print(f"{archive}, {archive.stat().st_size / 1e6:.1f} MB: {len(SCENES)} scenes")


if __name__ == "__main__":
    sys.exit(main())
