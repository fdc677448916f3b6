"""Ranges of forces that are not unique: by the vertices of their polytope, and by linear programs."""

from types import SimpleNamespace

import numpy as np
import pytest

from reference.solver import forces
from tests.sampling import quick_every

UNITS = np.array([1.0, 1.0, 2.0])


def contact(angle, x, y):
    """A contact at (x, y) from the centre of mass whose normal has that angle."""
    normal, tangent = np.array([np.cos(angle), np.sin(angle)]), np.array([np.sin(angle), -np.cos(angle)])
    rows = ([*way, x * way[1] - y * way[0]] for way in (normal, tangent))
    return SimpleNamespace(**dict(zip(("lift_row", "slip_row"), map(np.array, rows), strict=True)))


def by_programs(contacts, load, sticks):
    columns, parts = forces._generators(contacts, sticks)
    size = np.abs(load * UNITS).max()
    return forces._limits_by_programs(columns * UNITS[:, None], -load * UNITS / size, parts, size)


@quick_every(3)
@pytest.mark.parametrize("seed", range(12))
def test_vertices_give_the_ranges_of_linear_programs(seed):
    """Contacts around a plate: forces have bounds, none, or cannot balance the load."""
    draw = np.random.default_rng(seed)
    contacts = [contact(*draw.uniform((0.0, -1.0, -1.0), (np.pi, 1.0, 0.0))) for _ in range(2 + seed % 3)]
    sticks = [*draw.uniform(0.2, 1.5, len(contacts) - 1).tolist(), 0.0 if seed % 4 else np.inf]
    weights = draw.uniform(-0.2 if seed % 3 == 2 else 0.5, 1.0, forces._generators(contacts, sticks)[0].shape[1])
    load = -forces._generators(contacts, sticks)[0] @ weights
    own, programs = forces.ranges(contacts, load, UNITS, sticks), by_programs(contacts, load, sticks)
    # HiGHS is feasible to 1e-9 of the load, and its active equations are solved to rounding.
    assert np.array([own.normal, own.friction]) == pytest.approx(
        programs.swapaxes(0, 1), abs=1e-8 * np.abs(load).max(), nan_ok=True
    )


def test_two_walls_press_without_bound_and_a_plane_does_not():
    load = np.array([0.0, -1.0, 0.0])
    walls = [contact(0.0, -1.0, 0.0), contact(np.pi, 1.0, 0.0)]
    assert np.isinf(forces.ranges(walls, load, UNITS, [0.5, 0.5]).normal[:, 1]).all()
    floor = [contact(np.pi / 2, -1.0, -1.0), contact(np.pi / 2, 1.0, -1.0)]
    limits = forces.ranges(floor, load, UNITS, [0.5, 0.5])
    # Each carries half of the weight; the two frictions are opposite and at most μ N.
    assert limits.normal == pytest.approx(np.full((2, 2), 0.5), abs=1e-15)
    assert limits.friction == pytest.approx(np.array([[-0.25, 0.25]] * 2), abs=1e-15)
