"""Engines on curves with corners: corners as corners, convergence to the true motion, and routes that reject them."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import adapters
import reference
from adapters.by_process.scene_file import as_json, scene
from adapters.interface import refusal
from cases import Case, Chain, CoulombFriction, Gravity, Plate, Start, Unilateral, disc, library
from cases.contact import find, follow, pose

EFFECTS = (Gravity(9.81), CoulombFriction(0.4), Unilateral())
TABLE = Chain.polyline([(-1, 0), (0, 0), (0, -1)])
ROLLS_OFF = Case(TABLE, disc(0.1, 1.0), EFFECTS, Start(0.9, omega=-3.0), 1.0)
ROCKS = Case(library.hill(1.0), Plate.rectangle(0.3, 0.1, 1.0), EFFECTS, Start(0.1), 0.8)
WHEEL = Case(library.line(0.2), Plate.reuleaux(0.3, 1.0), EFFECTS, Start(0.1), 1.0)


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


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", ["pymunk", "box2d"])
@pytest.mark.parametrize(("case", "order"), [(ROLLS_OFF, None), (ROCKS, 0.7), (WHEEL, 0.7)])
def test_engine_has_the_corners_and_converges(name, case, order):
    """The disc's motion on the table is exact to rounding, as on any line; that of a rocking plate converges."""
    engine = pytest.importorskip({"box2d": "pyb2d3"}.get(name, name)) and adapters.engine(name)
    truth, errors = reference.simulate(case), []
    for setting in engine.ladder(case, "native")[2:6]:
        model = engine.build(case, "native", setting)
        engine.run(model)
        motion = engine.read(model)
        early = motion.t <= 0.9 * min(truth.t[-1], motion.t[-1])
        true = truth(motion.t[early])
        errors.append(np.hypot(motion.x[early] - true.x, motion.y[early] - true.y).max())
    if order is None:
        assert errors[-1] < 2e-3
    else:
        steps = [setting["h"] for setting in engine.ladder(case, "native")[2:6]]
        assert errors[0] / errors[-1] > (steps[0] / steps[-1]) ** order / 2, errors


@pytest.mark.parametrize("name", ["pymunk", "box2d"])
def test_outline_with_corners_that_point_inwards_is_rejected(name):
    """A gear as one convex polygon would be its hull."""
    engine = pytest.importorskip({"box2d": "pyb2d3"}.get(name, name)) and adapters.engine(name)
    case = Case(library.line(0.2), Plate.gear(0.1, 6, 0.02, 1.0), EFFECTS, Start(0.0, xi2=0.3), 1.0)
    assert "point inwards" in (refusal(engine, case, "native") or "")
    assert refusal(engine, ROCKS, "native") is None


def test_routes_without_corners_reject_them_in_one_sentence():
    """Each engine here or its executable, on each route: a sentence, or shapes with corners."""
    for name in adapters.engines():
        try:
            engine = adapters.engine(name)
        except ImportError:
            continue
        for route in engine.routes:
            if route not in getattr(engine, "CORNERS", ()):
                assert "corners" in (refusal(engine, ROCKS, route) or ""), (name, route)
