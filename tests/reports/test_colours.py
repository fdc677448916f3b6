"""One colour a solver: fixed, apart for every reader, and seen on both grounds."""

from itertools import combinations

import numpy as np
import pytest

from reports.drawing.colours import FIXED_COLOURS, GRADES, GROUND, MARKERS, OTHERS, Colour, LineStyles
from reports.running.names import REFERENCE

# Dichromats as Machado, Oliveira and Fernandes simulate them (2009; their matrices for severity 1, looked up in
# copies): linear RGB in, linear RGB out.
EYES = {
    "all cones": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}
# CIE 1976 colour differences: 2.3 is just seen side by side; lines are thin and apart.
OWN_APART, APART = 15.0, 8.0
# W3C's least contrast of graphical objects with their ground.
CONTRAST = 3.0


def linear(colour: str) -> np.ndarray:
    """sRGB as #rrggbb to linear light (IEC 61966-2-1)."""
    c = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(light: np.ndarray) -> np.ndarray:
    """Linear sRGB to CIE L*a*b*, white D65."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ np.clip(light, 0.0, 1.0) / to_xyz.sum(axis=1)
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("ground", Colour._fields)
@pytest.mark.parametrize("eyes", EYES)
def test_any_two_solvers_look_different(ground, eyes):
    for least, known in ((OWN_APART, list(FIXED_COLOURS.values())), (APART, [*FIXED_COLOURS.values(), *OTHERS])):
        for one, other in combinations(known, 2):
            seen = [lab(EYES[eyes] @ linear(getattr(colour, ground))) for colour in (one, other)]
            assert np.linalg.norm(seen[0] - seen[1]) > least, (one, other)


@pytest.mark.parametrize("ground", Colour._fields)
def test_every_solver_is_seen_on_its_ground(ground):
    def luminance(colour: str) -> float:
        return float(linear(colour) @ [0.2126, 0.7152, 0.0722]) + 0.05

    for colour in [*FIXED_COLOURS.values(), *OTHERS]:
        pair = sorted((luminance(getattr(colour, ground)), luminance(getattr(GROUND, ground))))
        assert pair[1] / pair[0] > CONTRAST, colour


def test_grades_are_greys_apart_and_no_solvers_colours():
    grades = [lab(linear(colour)) for name, colour in GRADES.items() if name != "not decided"]
    engines_ = [lab(linear(pair.light)) for name, pair in FIXED_COLOURS.items() if name != REFERENCE]
    chroma = [float(np.hypot(*colour[1:])) for colour in (*grades, *engines_)]
    assert max(chroma[: len(grades)]) < 12.0 < 25.0 < min(chroma[len(grades) :])
    # Darker from grade to grade, by more than twice what is just seen; dark text is read on the darkest.
    assert min(a[0] - b[0] for a, b in zip(grades[:-1], grades[1:], strict=True)) > 4.6
    light, dark = (float(linear(c) @ [0.2126, 0.7152, 0.0722]) + 0.05 for c in (GRADES["unusable"], "#101418"))
    assert light / dark > 4.5


def test_a_solver_has_one_marker_and_other_dashes_for_its_other_routes():
    looks = LineStyles([("pymunk", "native"), ("pymunk", "assisted"), ("mine", "file")])
    assert len(set(MARKERS.values())) == len(MARKERS) and looks.marker("mine") not in MARKERS.values()
    assert (looks.is_dashed("pymunk", "native"), looks.is_dashed("pymunk", "assisted")) == (False, True)
