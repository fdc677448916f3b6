"""New users: the wheel in an empty environment, a script in an empty folder, and every line that is printed.

A lecturer, a PhD student with measured ground, the author of an engine in C and its continuous integration, a
maintainer with a case and an adapter of her own, and a paper. The records in `newcomers/` were read sentence by
sentence; what is printed must be the same.
"""

import shutil

import pytest

from . import replay
from .test_walk import environment  # noqa: F401 - a fixture

# CPU seconds until the first result: a minute of a user's time on one core, whatever else the machine does.
FIRST_SECONDS = 60.0
# CPU seconds of all commands: more than twice the longest, 73 s, for CPU time varies by half where cores are shared.
WHOLE_SECONDS = 180.0


def test_each_script_has_a_record_and_one_first_result():
    assert replay.SCRIPTS == ["ci", "engine", "lecture", "maintainer", "paper", "student"]
    for name in replay.SCRIPTS:
        lines = replay.lines_of(name)
        assert sum("# first result" in line for line in lines) == 1
        record = (replay.FOLDER / f"{name}.txt").read_text(encoding="utf-8")
        commands = [line.partition("  # first result")[0] for line in lines]
        assert [line[2:] for line in record.splitlines() if line.startswith("$ ")] == commands
        assert "Traceback" not in record


def test_the_engine_in_c_has_35_lines():
    text = (replay.FOLDER / "my_engine.c").read_text(encoding="utf-8")
    assert len([line for line in text.splitlines() if line.strip()]) <= 35


@pytest.mark.slow
@pytest.mark.parametrize("name", replay.SCRIPTS)
def test_a_new_user_succeeds_and_reads_what_was_checked(name, environment, tmp_path):  # noqa: F811
    if name in ("ci", "engine") and shutil.which("cc") is None:
        pytest.skip("cc is not installed")
    record, first, whole = replay.run(name, environment, tmp_path)
    assert record == (replay.FOLDER / f"{name}.txt").read_text(encoding="utf-8")
    assert 0.0 < first.cpu < FIRST_SECONDS and whole.cpu < WHOLE_SECONDS
