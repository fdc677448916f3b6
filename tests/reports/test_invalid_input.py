"""Invalid input of any command: status 2, one sentence that says what to give, and nothing is written or run.

The table has a command line and a part of its sentence. What only one command can be given (odd files of a report, of a
submission, of a motion) is tested with it.
"""

from __future__ import annotations

import os
import shlex
import sys

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from adapters import lookup
from cases import registry
from cases.commands import TEMPLATE
from reports import cli

LABEL = "disc_on_line[mu=0.1]"
RUNS = "case,solver,route,setting,outcome,off,off_doubt\n{},exudyn,native,h,answered,0.1,0\n"
FILES = {
    "broken.py": "from cases import case\n\n\n@case\ndef broken_case():\n    return 1 / 0\n",
    "bowls.py": TEMPLATE.format(name="bowl") + "\n\n@case\ndef other_bowl():\n    return bowl(mu=0.2)\n",
    "own": "#!/bin/sh\n",
    "taken": "precious",
    "mine/letter.txt": "dear friend",
    "old/manifest.json": '{"format": 2}',
    "old/tables/trajectories.csv": RUNS.format("a"),
    "new/tables/trajectories.csv": RUNS.format("b"),
}
CIRCLE = "sweep disc_in_circle --vary mu=0:1:3"
ROWS = [
    ("repot", "did you mean report?"),
    ("release", "did you mean release"),
    ("report --case disc_in_circel", "disc_in_circle"),
    ("report --case disc_in_circle[mu=nan]", "finite"),
    ("report --case disc_in_circle[m=-1]", "greater than zero"),
    ("report --case disc_in_circle[mass=1]", "parameter"),
    ("report --case disc_in_circle[mu]", "parameter=number"),
    ("report --case disc_in_circle[r=2]", "smaller plate"),
    ("report --case", "expected at least one"),
    ("report --case-file nowhere.py", "nowhere.py"),
    ("report --case-file broken.py", "ZeroDivisionError"),
    ("report --solver exudin", "exudyn"),
    ("report --solvr exudyn", "--solver"),
    ("report --jobs many", "whole number"),
    ("report --jobs 0", "from 1 to"),
    ("report --jobs=--", "has no value but --"),
    ("report --case-file=--", "has no value but --"),
    ("report --quick --full", "not allowed with"),
    ("report --out .", "inside it"),
    ("report --out taken", "which is a file"),
    ("report --out mine", "holds letter.txt and is no report; give another folder"),
    ("report --store a/b --out a", "not inside each other"),
    ("report --store taken", "which is a file"),
    pytest.param("report --out /proc/report", "cannot be written to", marks=pytest.mark.skipif(
        sys.platform != "linux", reason="no /proc")),  # there everybody may write, says the system, and nobody can
    ("report --engine ./own --dask local", "give one of the two"),
    ("report --points 3", "--points is for executables"),
    (f"report --case {LABEL} --trajectory mine", "give --trajectory NAME=FILE.csv"),
    (f"report --case {LABEL} --trajectory =mine.csv", "give --trajectory NAME=FILE.csv"),
    (f"report --case {LABEL} --trajectory reference=mine.csv", "takes the name of the solver reference"),
    (f"report --case {LABEL} --trajectory mine@disc_on_lien=mine.csv", "no case in this report 'disc_on_lien'"),
    (f"report --case {LABEL} --trajectory mine=nowhere.csv", "there is no file 'nowhere.csv'"),
    (f"report --case {LABEL} --trajectory mine=columns.csv", "has no column theta"),
    (f"report --case {LABEL} --trajectory mine=unsorted.csv", "does not increase"),
    (f"report --case {LABEL} --trajectory mine=millimetres.csv", "give metres"),
    ("report --case disc_on_line --trajectory mine=mine.csv", "names no case, and the report has"),
    ("report --trajectory mine@disc_on_line=mine.csv", "give one of disc_on_line["),
    ("report study stability a b c", "there is no option 'a'"),
    ("report study nothing", "nothing"),
    (f"compare {LABEL} mine.csv --colour", "there is no option '--colour'"),
    (f"compare {LABEL} nowhere.csv", "nowhere.csv"),
    (f"compare {LABEL} mine.csv --solver exudyn", "are for the folders of two reports"),
    (f"compare {LABEL} mine.csv --worse-than 10%", "are for the folders of two reports"),
    ("compare bowls none.csv", "give one: bowls.py:bowl"),
    ("compare bowls.py:no_such_case none.csv", "there is no case in bowls.py 'no_such_case'"),
    ("compare old mine", "contains no report"),
    ("compare old new --worse-than 10%", "no run in common"),
    ("compare old old --worse-than ten", "--worse-than is 'ten'; give a share such as 10% or 0.1"),
    ("compare old old --worse-than -5%", "expected one argument"),
    ("compare old old --worse-than=-5%", "--worse-than is '-5%'; give a share such as 10% or 0.1"),
    ("compare old old --worse-than 10% --format yaml", "--format is 'yaml'; give one of text, json, junit"),
    ("compare old old --worse-than 10% --solver nobody", "has no runs of the solver nobody"),
    ("compare old old --solver exudyn", "give --solver twice"),
    ("compare old old --solver exudyn --solver nobody", "has no rows of the solver nobody"),
    ("gate new", "give --baseline DIR"),
    ("gate --baseline old nowhere", "contains no report"),
    ("history", "name an engine, for example pymunk"),
    ("history pymunk@7.0.0", "give an engine without a version"),
    ("history reference", "reference has no history of releases"),
    ("history pymnk", "choose from box2d, exudyn"),
    ("sweep disc_in_circel --vary mu=0:1:3", "there is no case 'disc_in_circel'"),
    ("sweep disc_in_circle --vary nu=0:1:3", "there is no parameter of disc_in_circle 'nu'"),
    ("sweep disc_in_circle --vary mu=1:0:3", "which is empty"),
    ("sweep disc_in_circle --vary mu", "write --vary parameter=low:high:count"),
    ("sweep disc_in_circle", "nothing varies"),
    (f"{CIRCLE} --vary mu=0:1:3", "given twice"),
    ("sweep disc_in_circle --vary mu=0:1 --sample sobol", "needs the number of scenarios"),
    (f"{CIRCLE} --refine 0", "--refine is 0; give a number greater than zero"),
    ("sweep disc_in_circle --vary mu=0.1,0.2 --refine 1e-3", "needs a range to divide"),
    (f"{CIRCLE} --solver exudin", "there is no solver 'exudin'"),
    (f"{CIRCLE} --jobs 0", "from 1 to"),
    (f"{CIRCLE} --out=--", "has no value but --"),
    (f"{CIRCLE} --rtol much", "give a number"),
    ("sweep disc_in_circle --vary mu=0:1 --sample random --number 1.5", "--number is 1.5; give a whole"),
    ("sweep disc_in_circle --vary mu=0:1 --sample random --seed 0.5", "--seed is 0.5"),
    (f"{CIRCLE} --dask nonsense", "missing port number in address 'nonsense'"),
    (f"{CIRCLE} --out .", "contains the working folder"),
    (f"{CIRCLE} --out mine", "holds letter.txt and is no sweep; give another folder"),
    ("sweep bowls --vary mu=0.1,0.2", "give one: bowls.py:bowl"),
    ("cases film bowls", "give one: bowls.py:bowl"),
    ("cases show --case-file no.py x y", "no.py"),
    ("compare nowhere", "'nowhere' is no folder of motions; give a case and a FILE"),
    ("release publish mine", "mine holds no report"),
    ("release deposit mine", "contains no published report"),
]  # fmt: skip


@pytest.fixture(scope="module")
def tables() -> dict[str, pd.DataFrame]:
    """Files with a motion of the case, and with such as are none."""
    exact = reference.simulate(cases.load(LABEL), rtol=1e-12)
    t = np.linspace(0.0, exact.t[-1], 301)
    state = exact(t)
    table = pd.DataFrame({"t": t, "x": state.x, "y": state.y, "theta": state.theta})
    return {
        "mine.csv": table,
        "columns.csv": table.drop(columns="theta"),
        "unsorted.csv": table.iloc[::-1],
        "millimetres.csv": table.assign(x=1e3 * table.x, y=1e3 * table.y),
    }


@pytest.mark.parametrize(("line", "sentence"), ROWS)
def test_invalid_input_is_one_sentence_and_nothing_is_written(line, sentence, tables, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(registry, "_entries", dict(registry._entries))
    monkeypatch.setenv(lookup.EXECUTABLES, "")  # and again after the test
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    os.chmod("own", 0o755)
    for name, table in tables.items():
        table.to_csv(name, index=False)
    before = {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}
    assert cli.main(shlex.split(line)) == 2
    output = capsys.readouterr()
    assert output.out == "" and output.err.count("\n") == 1 and sentence in output.err, output.err
    assert {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")} == before
