"""What heyoka compiles: large systems without optimising, and nothing is left in the user's home."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from reference.minimal.integrators import taylor

pytestmark = [
    pytest.mark.taylor,
    pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed"),
]


def test_nothing_is_left_in_the_home_folder(tmp_path):
    simulate = "import cases, reference; reference.simulate(cases.load('disc_in_circle'), method='taylor')"
    environment = {k: v for k, v in os.environ.items() if not k.startswith("XDG_")} | {"HOME": str(tmp_path)}
    subprocess.run(
        [sys.executable, "-c", simulate], cwd=Path(__file__).parent.parent.parent, env=environment, check=True
    )
    assert [file for file in tmp_path.rglob("*heyoka*") if file.is_file() or any(file.iterdir())] == []
