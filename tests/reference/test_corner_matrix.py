"""The paper's matrix at corners agrees with the eliminated equations and the second formulation at every instant."""

import numpy as np
import pytest

import reference
from cases import (
    Belt,
    Case,
    Chain,
    CoulombFriction,
    Gravity,
    Load,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
    library,
    load,
)
from cases.contact import belt_speed, velocity
from cases.curves.corner import Corner
from cases.scene.piece_case import PieceCase
from reference.minimal.modes import full_state
from reference.paper.corners import solve_at_corner
from reference.solve import INTEGRATORS, solve_motion
from reference.witness.contacts import PlateDynamics
from reference.witness.phase import SeveralContactPhase, WatchedContact
from tests.sampling import quick_every

# All three are a few dozen operations on numbers of one size.
ROUNDING = 1e-11
TABLE = Chain.polyline([(-1, 0), (0, 0), (0, -1)])


def on(track, plate, *effects, **start):
    return Case(track, plate, (Gravity(9.81), *effects, Unilateral()), Start(**start), 1.0)


@quick_every(3)
@pytest.mark.parametrize(
    "case",
    [
        load("disc_over_edge"),
        load("block_on_hill"),
        load("reuleaux_on_slope"),
        on(TABLE, disc(0.1, 1.0), CoulombFriction(0.5), Belt("0.5 + 0.3*sin(9*t)"), xi1=0.9, omega=-1.0),
        on(library.hill(1.0), Plate.rectangle(0.3, 0.1, 1.0), CoulombFriction(0.3, 0.5), Belt(-0.3), xi1=0.1),
        on(library.hill(1.5), Plate.reuleaux(0.2, 1.0), CoulombFriction(0.4), RollingResistance(0.005),
           Load(moment="0.3*sin(5*t) - 0.1*theta"), xi1=0.05, omega=-1.0),
        on(library.line(0.2), Plate.reuleaux(0.2, 1.0), PerfectlyRough(), xi1=0.0, omega=-4.0),
    ],
)  # fmt: skip
def test_three_forms_agree_at_every_instant_on_a_corner(case):
    segments, *_ = solve_motion(case, 1e-12, INTEGRATORS["dop853"][1])
    checked = 0
    for segment in segments:
        pieces, now = segment.phase.case, segment.phase
        if not isinstance(pieces, PieceCase) or not any(isinstance(piece, Corner) for piece in pieces.pieces):
            continue
        dynamics = PlateDynamics(case)
        for t in np.linspace(segment.times[0], segment.times[-1], 5)[1:-1].tolist():
            own = segment.states(np.array([t]))[:, 0].tolist()
            state = full_state(pieces, now, t, own)
            m = now.system.record(*now.system.outputs_of_numbers(t, own, now.parameters))
            mode, turn = now.regime.mode, now.regime.turn
            answer = solve_at_corner(pieces, mode, state, now.regime.side, turn, t)
            mass, size = case.plate.mass, 9.81 + abs(m.omega) ** 2
            assert answer.normal_force == pytest.approx(mass * m.normal, abs=ROUNDING * size)
            assert answer.friction_force == pytest.approx(mass * m.friction, abs=ROUNDING * size)
            assert answer.q1_ddot[2] == pytest.approx(m.omega_dot, abs=ROUNDING * size / case.plate.gyration)
            free = m.u2_dot if isinstance(pieces.pieces[0], Corner) else m.u1_dot
            assert answer.q2_ddot == pytest.approx(free, abs=ROUNDING * size / case.plate.gyration)
            start = velocity(pieces, *state[:2], m.slip + float(belt_speed(case, t)), m.omega)
            y = np.array([start.x, start.y, start.theta + pieces.turn, start.vx, start.vy, m.omega, *state[:2]])
            contact = WatchedContact("", pieces, (state[0], state[1]), mode, side=now.regime.side)
            turns = {(0, None): turn} if case.effect(RollingResistance) else {}
            forces = SeveralContactPhase(dynamics, [contact], turns=turns).forces(t, y)
            assert answer.normal_force == pytest.approx(forces.normal[0], abs=ROUNDING * size)
            assert answer.friction_force == pytest.approx(forces.friction[0], abs=ROUNDING * size)
            checked += 1
    assert checked >= 3
    assert reference.simulate(case).passages
