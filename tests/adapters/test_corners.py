"""Contacts on curves with corners, found from poses, and a block as one polygon of engines in JavaScript."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import adapters
import reference
from adapters.by_process.scene_file import as_json, scene
from cases.contact import find, follow, pose

from .test_motions import SCENES

ROLLS_OFF, ROCKS, WHEEL = (SCENES[name]() for name in ("disc over an edge", "block on a hill", "Reuleaux wheel"))


@pytest.mark.parametrize("case", [ROLLS_OFF, ROCKS, WHEEL])
def test_contact_of_a_pose_is_found_on_every_piece(case):
    motion = reference.simulate(case)
    s = motion(np.linspace(0, motion.t[-1], 300))
    xi1, xi2, gap = follow(case, s.x, s.y, s.theta)
    np.testing.assert_allclose(xi1, s.xi1, atol=1e-12)
    np.testing.assert_allclose(xi2, s.xi2, atol=1e-12)
    assert np.abs(gap).max() < 1e-14
    # Moved along the normal the pair is the same, and the gap is the way.
    for i in range(0, 300, 7):
        nx, ny = case.track.normal(xi1[i])
        contact = find(case, s.x[i] + 1e-3 * nx, s.y[i] + 1e-3 * ny, s.theta[i], (xi1[i], xi2[i]))
        assert contact.gap == pytest.approx(1e-3, rel=1e-9) and contact.xi1 == pytest.approx(xi1[i], abs=1e-9)


@pytest.mark.skipif(not shutil.which("node"), reason="needs node")
def test_a_block_is_one_polygon_of_engines_in_javascript():
    """It was twelve around its centre, with seams along its sides."""
    common = Path(adapters.__file__).parent / "executables" / "common.cjs"
    ask = f"const s = JSON.parse(require('fs').readFileSync(0)); const c = require({json.dumps(str(common))});"
    ask += "console.log(JSON.stringify(c.fan('it', s, 96, 8)))"
    answer = subprocess.run(
        ["node", "-e", ask], input=as_json(scene(ROCKS)), capture_output=True, text=True, check=True
    )
    (polygon,) = json.loads(answer.stdout)
    assert {(round(abs(p["x"]), 12), round(abs(p["y"]), 12)) for p in polygon} == {(0.15, 0.05)} and len(polygon) == 4


def test_contact_moves_on_to_the_next_pieces():
    """From a pair of the start, the contact on the table's edge is found two pieces further."""
    x, y, theta = pose(ROLLS_OFF, 1.5, 4.0)
    contact = find(ROLLS_OFF, float(x), float(y), float(theta), (0.9, 4.0))
    assert contact.xi1 == pytest.approx(1.5, abs=1e-12) and abs(contact.gap) < 1e-14
