"""Combinations of modes that numbers exclude together: one system of all unknowns excludes them one by one."""

import numpy as np
import pytest

import reference
from cases import Mode
from reference.effect_laws.friction import SLIP_SIGN, STICKING
from reference.solver import impact
from reference.solver.accelerations import GroupRows
from reference.solver.exclusion import impact_exclusions
from reference.solver.places import sharing
from reference.solver.plate_numbers import bodies
from tests.scenes.walled_plates import random_walled_plates

# Blocks and discs in piles between walls, with two to seven contacts in a group.
PILES = (2474928891, 2474928864 + 131, 2474928864 + 163)


def solve_alone(now, contacts, modes):
    """Accelerations and the largest violation, in parts of the largest of its kind, of one combination of modes: from
    Newton's equations and the rows of contacts, in one system. None if it is singular."""
    inverse, size = bodies(now.case).inverse, len(now.load)
    rows, columns, biases = [], [], []
    closed = [k for k, mode in enumerate(modes) if mode is not Mode.FLIGHT]
    sticking = [k for k in closed if modes[k] in STICKING]
    same = sharing([contacts[k] for k in sticking])
    holders = [k for i, k in enumerate(sticking) if i not in same]
    for k in closed:
        at = contacts[k]
        friction = SLIP_SIGN.get(modes[k], 0.0) * at.mu_of(now.velocity, now.time)
        rows, columns = [*rows, at.lift_row], [*columns, at.lift_row - friction * at.slip_row]
        biases.append(at.lift_bias)
    for k in holders:
        rows, columns = [*rows, contacts[k].slip_row], [*columns, contacts[k].slip_row]
        biases.append(contacts[k].slip_bias)
    matrix = np.eye(size + len(rows))
    if rows:
        matrix[:size, size:], matrix[size:, :size] = -inverse[:, None] * np.transpose(columns), rows
        matrix[size:, size:] = 0.0
    if np.linalg.cond(matrix) > 1e8:
        return None
    solution = np.linalg.solve(matrix, np.append(now.load, -np.array(biases)))
    acceleration, forces = solution[:size], solution[size:]
    normal = dict(zip(closed, forces, strict=False))
    bounds = {k: 0.0 for k in holders}
    for i, k in enumerate(sticking):
        bounds[sticking[same.get(i, i)]] += contacts[k].stick * max(normal[k], 0.0)
    force = max(np.abs(forces).max(initial=0.0), now.scale * bodies(now.case).masses.max())
    rate = max(np.abs(acceleration * bodies(now.case).lengths).max(), now.scale)
    tangential = dict(zip(holders, forces[len(closed) :], strict=True))
    violations = [-value / force for value in normal.values()]
    violations += [(abs(value) - bounds[k]) / force for k, value in tangential.items()]
    for k, at in enumerate(contacts):
        if modes[k] is Mode.FLIGHT:
            violations.append(-(at.lift_row @ acceleration + at.lift_bias) / rate)
        elif modes[k] in SLIP_SIGN and abs(at.slip(now.velocity, now.time)) <= now.still:
            violations.append(-SLIP_SIGN[modes[k]] * at.slip_rate(acceleration, now.time) / rate)
    return acceleration, max(violations)


@pytest.mark.parametrize("seed", PILES)
def test_combinations_that_numbers_exclude_together_violate_a_condition_alone(seed, monkeypatch):
    counts, answers = [0, 0], GroupRows.answers

    def compare(self, combinations):
        result = list(answers(self, combinations))
        possible = {modes: answer for modes, _, answer in result}
        for modes, turns in combinations:
            alone, answer = solve_alone(self.now, self.contacts, modes), possible.get(modes)
            assert not turns
            if modes not in possible:
                assert alone is not None and alone[1] > 0.0
            elif answer is not None and not answer.guides and alone is not None:
                largest = max(np.abs(alone[0]).max(), self.now.scale)
                assert np.abs(answer.acceleration - alone[0]).max() <= 1e-7 * largest
                assert not answer.is_possible or alone[1] <= 1e-4
        counts[0], counts[1] = counts[0] + len(combinations), counts[1] + len(result)
        return result

    monkeypatch.setattr(GroupRows, "answers", compare)
    motion = reference.simulate(random_walled_plates(seed, duration=0.4), method="dop853")
    assert motion.status == "completed"
    assert counts[1] < 0.6 * counts[0]


@pytest.mark.parametrize("seed", PILES)
def test_impacts_that_are_left_out_break_the_law_of_impact(seed, monkeypatch):
    """The velocities after each impact are those of all combinations, tried one by one."""
    alone, counts = impact._collide, [0, 0]

    def count(*arguments):
        without = impact_exclusions(*arguments)
        counts[0], counts[1] = counts[0] + len(without), counts[1] + int((~without).sum())
        return without

    def compare(*arguments):
        outcome, impulses = alone(*arguments)
        with monkeypatch.context() as inside:
            inside.setattr(impact, "impact_exclusions", lambda modes, *_: np.zeros(len(modes.closed), dtype=bool))
            other, _ = alone(*arguments)
        assert (outcome.velocity == other.velocity).all() and (outcome.lift == other.lift).all()
        return outcome, impulses

    monkeypatch.setattr(impact, "impact_exclusions", count)
    monkeypatch.setattr(impact, "_collide", compare)
    motion = reference.simulate(random_walled_plates(seed, duration=0.4), method="dop853")
    assert motion.status == "completed"
    assert 0 < counts[1] < 0.6 * counts[0]
