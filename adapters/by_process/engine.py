"""An executable as an adapter: one process per run; its output is bounded, read as numbers and never executed.

The cost that it reports is marked as its own measurement and is not ranked.
"""

from __future__ import annotations

import hashlib
import os
import re
import resource
import signal
import subprocess
import tempfile
from dataclasses import dataclass, replace
from math import isfinite, nan
from pathlib import Path

from cases import BadValue, Case, CaseError, Chain, Cost, Drive, NotSupported, Trajectory
from cases.scene.supports import is_straight

from ..common import motion_file, motion_table, several_contacts, supervision
from ..common.facets import is_convex
from ..interface import EngineFailure, Setting
from .scene_file import FACETS, SAMPLES, as_json, scene

# With fewer, transitions lie between samples that are too far apart to extrapolate from.
FEWEST_STEPS = 60
# Steps (s) for a case of a few seconds, the first a game's; a longer case has as many steps.
STEPS, USUAL_DURATION = (1 / 60, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4), 2.5
# A motion of 100,000 samples with ten columns has about twenty megabytes.
MOST_BYTES = 30 * 2**20
# Time limit of a run, wall seconds, unless a shorter one is set.
MOST_SECONDS = 600.0
# Exit status of an executable for an unsupported scene; the reason is on standard error.
UNSUPPORTED_STATUS = 3
# How the second line on standard error begins, if the engine's documentation says that it cannot.
LIMIT = "limit:"
# Characters of a line that is quoted.
_QUOTE_CHARACTERS = 200
_COST = re.compile(r"^#\s*cost\b(.*)$", re.MULTILINE)


@dataclass
class ProcessModel:
    """One run: its input and output."""

    case: Case
    scene_text: str
    output: str = ""
    cpu_s: float = nan


class Engine:
    """The adapter of an executable; raises BadValue if the file cannot be run."""

    routes = ("process",)
    TELLS_COST = True
    # An executable decides when it sees the scene.
    CAPABILITIES: dict[str, tuple[str, ...]] = {
        "process": (
            "slip laws", "corners", "several contacts", "supports", "belts and supports", "driven contacts",
            "several plates", "free polygons",
        )
    }  # fmt: skip

    def __init__(self, path: Path):
        if not self.runs(path):
            raise BadValue(f"the engine {path} is no executable file; give one (chmod +x {path})")
        self.path = path.resolve()
        self.NAME = path.stem

    @staticmethod
    def runs(path: Path) -> bool:
        """Whether the file can be run."""
        return path.is_file() and os.access(path, os.X_OK)

    @staticmethod
    def command(path: Path) -> list[str]:
        """What runs it."""
        return [str(path)]

    def version(self) -> str:
        """A digest of the file; of what it loads nothing is known."""
        return f"executable, sha256 {hashlib.sha256(self.path.read_bytes()).hexdigest()[:12]}"

    def refuses(self, case: Case, route: str) -> str | None:
        """What a scene cannot describe: a track with corners, whose samples do not have them, and supports that are
        curved or driven. An executable refuses a scene when it sees it."""
        if isinstance(case.track, Chain):
            return "A scene has no track with corners."
        if isinstance(case.plate.outline, Chain) and not is_convex(case.plate.outline):
            return "A scene has no outline with corners that point inwards."
        if case.supports and case.effect(Drive) is not None:
            return "A scene has no supports that move with a driven track."
        if curve := next((support.name for support in case.supports if not is_straight(support.curve)), ""):
            return f"A scene has supports that are straight lines without ends, and {curve!r} is none."
        return None

    def refuses_several_contacts(self, case: Case, route: str) -> str | None:
        """Why the contacts do not follow from the poses that an executable writes, in one sentence, or None."""
        return several_contacts.refuses(case)

    def ladder(self, case: Case, route: str) -> tuple[Setting, ...]:
        """Steps from coarse to fine, none so long that too few samples come of it."""
        stretch, longest = max(1.0, case.duration / USUAL_DURATION), case.duration / FEWEST_STEPS
        steps = dict.fromkeys(min(h * stretch, longest) for h in STEPS[1:])
        return Setting.of(rung="defaults", h=min(self.own_step(), longest)), *(Setting.of(h=h) for h in steps)

    def own_step(self) -> float:
        """The engine's default step (s): unknown, so that of games is used."""
        return STEPS[0]

    def build(self, case: Case, route: str, setting: Setting) -> ProcessModel:
        """The scene and the setting as text; a setting may have the number of points of each curve and of facets."""
        samples, facets = int(setting.get("points", SAMPLES)), int(setting.get("facets", FACETS))
        return ProcessModel(case, as_json({**scene(case, samples, facets), "setting": dict(setting)}) + "\n")

    def run(self, model: ProcessModel) -> None:
        """One process; raises NotSupported if it refuses, EngineFailure if it fails, or writes or takes too much."""
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            scene_file = Path(folder) / "scene.json"
            scene_file.write_text(model.scene_text, encoding="utf-8")
            with scene_file.open("rb") as scene_text:
                try:
                    status = subprocess.run(
                        self.command(self.path), stdin=scene_text, stdout=out, stderr=err, cwd=folder,
                        timeout=MOST_SECONDS, preexec_fn=_bound,
                    ).returncode  # fmt: skip
                except subprocess.TimeoutExpired:
                    raise EngineFailure(f"it was still running after {MOST_SECONDS:g} s") from None
            _check_size(out.fileno(), err.fileno())
            message = _read(err, 2000)
            if status == UNSUPPORTED_STATUS:
                reason, _, rest = message.partition("\n")
                limit = rest.partition("\n")[0]
                limit = limit.removeprefix(LIMIT).strip() if limit.startswith(LIMIT) else ""
                raise NotSupported(reason or "it gave no reason", limit)
            if status < 0:
                raise EngineFailure(f"its process was ended by signal {_signal(-status)}{_quote(message)}")
            if status:
                raise EngineFailure(f"its process ended with exit status {status}{_quote(message)}")
            model.output = _read(out, MOST_BYTES)

    def read(self, model: ProcessModel) -> Trajectory:
        """The motion; raises EngineFailure for output that is no motion of the case."""
        try:
            table = motion_table.parse(model.output, self.NAME)
            motion = motion_file.trajectory_of(model.case, table)
        except CaseError as problem:
            raise EngineFailure(f"its output is no motion: {problem}") from problem
        return replace(motion, cost=_cost(model.output))


def _check_size(*files: int) -> None:
    if max(os.fstat(file).st_size for file in files) >= MOST_BYTES:
        raise EngineFailure(f"it wrote more than {MOST_BYTES // 2**20} MB")


def _read(file, most: int) -> str:
    file.seek(0)
    return file.read(most).decode("utf-8", errors="replace").strip()


def _quote(message: str) -> str:
    """The text on standard error, to append to a sentence: the first line that contains a letter, and the last."""
    lines = [line.strip() for line in message.splitlines() if any(map(str.isalnum, line))]
    ends = [lines[0], *lines[-1:]] if len(lines) > 1 else lines
    return f": {' … '.join(line[:_QUOTE_CHARACTERS] for line in ends)}" if ends else ""


def _cost(output: str) -> Cost:
    """What the line `# cost cpu_s=0.01 steps=1000` says; raises EngineFailure for a cost that is none."""
    line = _COST.search(output)
    values = dict(part.split("=", 1) for part in (line[1].split() if line else ()) if "=" in part)
    try:
        cpu, steps = float(values.get("cpu_s", "nan")), float(values.get("steps", "0"))
    except ValueError as problem:
        raise EngineFailure(f"its cost is no number: {line and line[0][:80]!r}") from problem
    if cpu < 0.0 or not 0.0 <= steps < 1e15 or not (isfinite(cpu) or "cpu_s" not in values):
        raise EngineFailure(f"its cost makes no sense: {line and line[0][:80]!r}")
    return Cost(cpu_s=cpu, steps=int(steps))


def _signal(number: int) -> str:
    return signal.Signals(number).name if number in set(signal.Signals) else str(number)


def _bound() -> None:
    """In the new process: limit the size of its files, and end it when its parent ends (Linux), so that a process that
    hangs does not remain."""
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    most = MOST_BYTES if hard == resource.RLIM_INFINITY else min(MOST_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    supervision.end_with_parent(os.getppid())
