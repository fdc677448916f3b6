"""The canonical friction benchmark: its archive, and its readers in four languages on the same values."""

import csv
import json
import shutil
import subprocess
import sys
from zipfile import ZipFile

import pytest

import cases
from reports import benchmark

LABELS = "disc_in_circle[mu=0.2]", "block_on_incline[slope=0.6,mu=0.52]"
ROOT = f"{benchmark.ARCHIVE}-{cases.__version__}"
# How each reader becomes a command in a folder, and the program that this needs.
MAKE = {
    "errors.py": (sys.executable, None),
    "errors.js": ("node", None),
    "errors.cpp": ("g++", ["g++", "-std=c++17", "-o", "errors"]),
    "errors.rs": ("rustc", ["rustc", "-o", "errors"]),
}


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("benchmark")
    archive, again = (benchmark.pack(folder / name, LABELS) for name in ("one.zip", "two.zip"))
    assert archive.read_bytes() == again.read_bytes()
    with ZipFile(archive) as zipped:
        zipped.extractall(folder)
    return folder / ROOT


def test_the_archive_states_scenes_and_their_truth(unpacked):
    with (unpacked / "transitions.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    first = rows[0]
    assert (first["case"], first["before"], first["after"]) == (LABELS[0], "slip_forward", "roll")
    assert float(first["time"]) == pytest.approx(0.6300537639273031, abs=float(first["bar"]))
    scene = json.loads((unpacked / "scenes" / f"{LABELS[0]}.json").read_text())
    assert scene["effects"]["CoulombFriction"]["mu"] == 0.2 and not {"transitions", "status"} & set(scene)
    page = (unpacked / "index.html").read_text()
    assert "0.6300537639273031" in page and "x = 1.0*cos(s), y = 1.0*sin(s)" in page
    rows = [row.split(",") for row in (unpacked / "derivatives.csv").read_text().splitlines()[1:]]
    slope = next(row for row in rows if row[:5] == [LABELS[0], "mu", "", "slip_forward", "roll"])
    assert float(slope[5]) == pytest.approx(-1.32111851, rel=1e-6) and float(slope[6]) < 1e-9
    assert {path.name for path in (unpacked / "readers").iterdir()} == set(MAKE)


@pytest.mark.parametrize("name", MAKE)
def test_a_reader_prints_paired_errors(unpacked, name, tmp_path):
    program, make = MAKE[name]
    if shutil.which(program) is None or subprocess.run([program, "--version"], capture_output=True).returncode:
        pytest.skip(f"{program} is not here, or does not start")
    mine = tmp_path / "mine.csv"
    case = LABELS[0]
    # The first transition is late by a millisecond, the last one is missed, and another one is not in the truth.
    times = [("slip_forward,roll", 0.6310537639273031), ("roll,slip_backward", 0.8968668720782423)]
    times += [("slip_backward,roll", 1.9148272709420633), ("slip_backward,roll", 2.0)]
    mine.write_text("\n".join(["case,contact,before,after,time", *(f"{case},,{key},{time!r}" for key, time in times)]))
    source = unpacked / "readers" / name
    command = [program, source]
    if make is not None:
        subprocess.run([*make, source], cwd=tmp_path, check=True)
        command = [tmp_path / "errors"]
    output = subprocess.run([*command, unpacked / "transitions.csv", mine], capture_output=True, text=True, check=False)
    assert output.returncode == 1, output.stderr  # two have no partner
    lines = {tuple(line.split(",")[:4]): line.split(",")[4:] for line in output.stdout.splitlines()[1:]}
    assert len(output.stdout.splitlines()) == 6 and all(key[0] == case for key in lines)
    late = lines[case, "", "slip_forward", "roll"]
    assert float(late[2]) == pytest.approx(1e-3, rel=1e-3) and float(late[3]) < 1e-13
    assert lines[case, "", "roll", "slip_forward"][0] == "missed"
    assert lines[case, "", "slip_backward", "roll"][1] == "spurious"
