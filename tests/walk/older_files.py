"""What users of version 0.2.0 have, in `users_0_2_0.zip`: README and docs, `starter/`, `examples/`, scripts of four new
users, labels of all cases, a case file, exported scenes with their motions, and a submission.

`python -m tests.walk.older_files CLONE` writes it with the code of a clone at commit 43ab33a3.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

ARCHIVE = Path(__file__).with_name("users_0_2_0.zip")
# Files of the clone that users have, and where they are in the archive.
COPIES = {
    "README.md": "",
    "docs/*.md": "",
    "docs/gallery.ipynb": "",
    "starter/*": "",
    "examples/magnetic_wheel/*": "",
    "tests/walk/newcomers/*": "newcomers",
}
# Exported with 101 points of each curve: one scene with each kind of track, plate, effect and number of contacts.
EXPORTS = (
    "disc_in_circle[mu=0.2]", "disc_on_line[mu=0.1]", "disc_in_cosine", "disc_on_conveyor", "disc_rolling_to_rest",
    "stribeck_disc", "pebble_on_incline", "sliding_box", "dropped_box", "box_on_shaken_table", "disc_in_v_of_belts",
    "pile_of_discs",
)  # fmt: skip
POINTS = 101
# Run by starter/engine.py with this step, s: the motions of the submission.
SUBMITTED, STEP = ("disc_on_line[mu=0.1]", "disc_on_incline[slope=0.4]", "disc_in_circle[mu=0.2]"), 1e-3
SUBMISSION = "submissions/my_engine/2.1.0"
# All dates in the archive, so that it is the same each time.
DATE = (2026, 11, 27, 0, 0, 0)
_LABELS = "import cases; print('\\n'.join(case.label for name in cases.names() for case in cases.select(name)))"


def main(clone: str) -> None:
    """Write the archive."""
    source = Path(clone).resolve()
    with TemporaryDirectory() as folder:
        desk = Path(folder)
        for pattern, place in COPIES.items():
            for path in source.glob(pattern):
                copy = desk / place / (path.name if place else path.relative_to(source))
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(path.read_bytes())
        _strip(desk / "docs" / "gallery.ipynb")
        _by_commands(source, desk)
        with zipfile.ZipFile(ARCHIVE, "w", zipfile.ZIP_LZMA) as archive:
            for path in sorted(path for path in desk.rglob("*") if path.is_file()):
                entry = zipfile.ZipInfo(path.relative_to(desk).as_posix(), DATE)
                entry.compress_type = zipfile.ZIP_LZMA
                archive.writestr(entry, path.read_bytes())


def _strip(notebook: Path) -> None:
    """Remove the outputs of a notebook's cells: only its code is run again."""
    content = json.loads(notebook.read_text(encoding="utf-8"))
    content["cells"] = [cell | {"outputs": []} for cell in content["cells"] if cell["cell_type"] == "code"]
    notebook.write_text(json.dumps(content), encoding="utf-8")


def _by_commands(source: Path, desk: Path) -> None:
    """Files that commands of the clone write."""

    def run(*words: str, text: str | None = None) -> str:
        environment = {**os.environ, "PYTHONPATH": str(source), "PYTHONDONTWRITEBYTECODE": "1"}
        argv = [sys.executable, *words]
        return subprocess.run(
            argv, cwd=desk, env=environment, input=text, text=True, check=True, stdout=subprocess.PIPE
        ).stdout

    (desk / "labels.txt").write_text(run("-c", _LABELS), encoding="utf-8")
    run("-m", "cases", "new", "my_valley")
    for label in EXPORTS:
        run("-m", "cases", "export", label, "--points", str(POINTS), "--out", f"exported/{label}")
    (desk / SUBMISSION).mkdir(parents=True)
    toml = (desk / "docs" / "submit.md").read_text(encoding="utf-8").partition("```toml\n")[2].partition("```")[0]
    (desk / SUBMISSION / "submission.toml").write_text(toml, encoding="utf-8")
    for label in SUBMITTED:
        run("-m", "cases", "export", label, "--points", str(POINTS), "--out", "one")
        scene = json.loads((desk / "one" / "scene.json").read_text(encoding="utf-8")) | {"setting": {"h": STEP}}
        motion = run("starter/engine.py", text=json.dumps(scene))
        (desk / SUBMISSION / f"{label}.csv").write_text(motion, encoding="utf-8")
        for path in (desk / "one").iterdir():
            path.unlink()
    (desk / "one").rmdir()


def page_names() -> set[str]:
    """The names of the pages in the archive."""
    with zipfile.ZipFile(ARCHIVE) as archive:
        return {Path(name).name for name in archive.namelist() if name.endswith(".md")}


def unpack(desk: Path) -> None:
    """Put the files of the archive into a folder."""
    with zipfile.ZipFile(ARCHIVE) as archive:
        archive.extractall(desk)


if __name__ == "__main__":
    main(*sys.argv[1:])
