"""What a type checker knows of the public names in a user's file, strictly."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# Names that a user calls, with what the checker says of them; then calls that it has to reject.
KNOWN = {
    "mine": "def (mu: float =) -> cases.scene.case_class.Case",
    "library.circle": "def (radius: float) -> cases.curves.Curve",
    "reference.sweep(mine, mu=[0.1, 0.2])": "reference.sweeping.sweep_table.SweepTable",
    "reference.simulate(mine(mu=0.1))": "cases.motion.trajectory.Trajectory",
    "cases.load": "def (",
    "compare(mine())": "reports.comparison.Comparison",
    "reference.certify": "def (case: cases.scene.case_class.Case)",
}
WRONG = ('library.circle("a")', "mine(nu=3)", "reference.sweep(3, mu=[0.1, 0.2])", 'reference.simulate("disc_on_line")')
HEAD = """
import cases, reference
from cases import Case, CoulombFriction, Gravity, Start, case, disc, library
from reports.comparison import compare

@case
def mine(mu: float = 0.2) -> Case:
    return Case(library.circle(1.0), disc(0.1, 1.0), (Gravity(9.81), CoulombFriction(mu)), Start(0.1), 1.0)

"""


def strictly(text: str, folder: Path) -> str:
    """What mypy says of a file with that text, of itself alone."""
    pytest.importorskip("mypy")
    (folder / "users.py").write_text(text)
    words = ["--strict", "--follow-imports=silent", "--config-file=", "--cache-dir", ROOT / ".mypy_cache" / "users"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *words, folder / "users.py"], capture_output=True, text=True, cwd=folder,
        env={"MYPYPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def test_a_checker_knows_what_users_call(tmp_path):
    text = HEAD + "\n".join([*(f"reveal_type({name})" for name in KNOWN), *WRONG])
    lines = strictly(text, tmp_path).splitlines()
    revealed = [match[1] for line in lines if (match := re.search('Revealed type is "(.*)"', line))]
    for name, said in zip(KNOWN, revealed, strict=True):
        assert said.startswith(KNOWN[name]), (name, said)
    first = text.count("\n") + 2 - len(WRONG)
    errors = {int(match[1]) for line in lines if (match := re.search(r"users\.py:(\d+): error", line))}
    assert errors == {first + i for i in range(len(WRONG))}, lines


def test_the_tutorial_is_strictly_typed(tmp_path):
    blocks = re.findall("^```python\n(.*?)^```", (ROOT / "docs" / "tutorial.md").read_text(), re.M | re.S)
    assert len(blocks) == 6
    assert strictly("\n".join(blocks), tmp_path).startswith("Success")
