"""A case gets the equations, events and cost of the effects it names, and of no other."""

import statistics
import time
from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Impact,
    PerfectlyRough,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases.formulas.expression_graph import in_order
from cases.library import circle, line
from cases.moving_frame import relative_case
from reference.minimal import contact_end, flight_end
from reference.minimal.integrators import dop853, taylor
from reference.minimal.modes import FLIGHT, candidates, phase, phase_at, start_state
from reference.solver import contact_chart
from tests.scenes import bits
from tests.scenes.moving import Adhesion, on_line

pytestmark = pytest.mark.taylor

G = 9.81
needs_heyoka = pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")


def scene(*effects, track=None):
    return Case(track or circle(1.0), disc(0.1, 1.0), effects, Start(xi1=-1.0), 2.0)


def frictionless():
    case = scene(Gravity(G))
    return phase(case, candidates(case)[0])


def by_hand():
    """A frictionless disc in a circle, as one would write it for heyoka: (R − r) ξ̈ = gravity along the tangent."""
    import heyoka as hy

    xi1, xi2, u1, u2 = hy.make_vars("xi1", "xi2", "u1", "u2")
    gx, gy, r, R = (hy.par[i] for i in range(4))
    along = (gx * hy.sin(xi1) - gy * hy.cos(xi1)) / (r - R)
    return hy.taylor_adaptive(
        [(xi1, u1), (xi2, u2), (u1, along), (u2, along)], [0.0] * 4, tol=taylor.FINEST, compact_mode=False
    )


@needs_heyoka
def test_frictionless_disc_compiles_to_no_more_operations_than_written_by_hand():
    hand = by_hand()
    compiled = taylor.integrators_of(frictionless().system, taylor.FINEST).call(lambda one: one.integrator)
    assert len(compiled.decomposition) <= len(hand.decomposition)
    assert not compiled.with_events


@pytest.mark.timed
@needs_heyoka
def test_frictionless_disc_runs_as_fast_as_by_hand():
    now = frictionless()
    workspace = taylor.integrators_of(now.system, taylor.FINEST).call(lambda one: one)
    contestants = [workspace.integrator, by_hand()]
    workspace.use(now)
    contestants[1].pars[:] = [0.0, -G, 0.1, 1.0]
    seconds = [[], []]
    for _ in range(200):
        for integrator, record in zip(contestants, seconds, strict=True):
            integrator.time, integrator.state[:] = 0.0, [-1.0, -1.0, 0.0, 0.0]
            began = time.process_time()
            integrator.propagate_until(2.0)
            record.append(time.process_time() - began)
    seconds_ours, seconds_hand = (statistics.median(record) for record in seconds)
    # The same operations; what is left is where their code lies in memory. A fifth is far above that.
    assert 0.8 <= seconds_ours / seconds_hand <= 1.25
    assert contestants[0].state == pytest.approx(contestants[1].state, rel=1e-14)


def test_acceleration_of_a_rolling_disc_on_a_line_is_computed_once():
    case = scene(Gravity(G), PerfectlyRough(), track=line())
    now = phase(case, candidates(case)[0])
    gx, r, k2 = (now.parameters[now.system.names.index(name)] for name in ("gx", "outline_c0", "G"))
    assert now.parameters[now.system.parameters.index(now.system.rates[-1])] == gx * r**2 / (k2 + r**2)


@pytest.mark.parametrize(
    "effects, events",
    [
        ((Gravity(G),), set()),
        ((Gravity(G), Unilateral()), {"normal_force"}),
        ((Gravity(G), PerfectlyRough()), set()),
        ((Gravity(G), PerfectlyRough(), Unilateral()), {"normal_force"}),
        ((Gravity(G), CoulombFriction(0.1), Unilateral()), {"slip", "normal_force", "cone_forward", "cone_backward"}),
        (
            (Gravity(G), PerfectlyRough(), RollingResistance(0.001), Unilateral()),
            {"turn", "couple_forward", "couple_backward", "normal_force"},
        ),
    ],
    ids=lambda value: "+".join(type(e).__name__ for e in value) if isinstance(value, tuple) else None,
)
def test_only_the_events_of_named_effects_are_watched(effects, events):
    case = scene(*effects)
    watched = {name for regime in candidates(case) for name in phase(case, regime).system.guards}
    # A disc at rest has no state that changes, and so nothing to watch but time.
    assert watched <= events and (watched == events or "turn" in events)
    assert {name for regime in candidates(case) for name in phase(case, regime).system.conditions} == events


# Numbers of operations of the equations of all regimes, flight last, before there were belts, driven tracks, friction
# by slip speed, effects of a user's own and plates that do not turn (commit bf32a94).
OPERATIONS = {
    "disc_in_circle[mu=0.2]": [51, 52, 52, 6],
    "ellipse_in_circle": [122, 122, 122, 6],
    "disc_on_line": [25, 33, 33, 6],
    "disc_rolling_to_rest": [24, 38, 38, 32, 45, 45, 32, 45, 45, 6],
}


def test_an_equal_copy_of_a_case_on_a_track_at_rest_is_not_seen_from_another_frame():
    # -0.0 of the first is 0.0 where a second one is turned by an angle of 0.
    first, second = scene(Gravity(G)), scene(Gravity(G))
    assert second == first and second is not first
    assert relative_case(first) is first and relative_case(second) is second
    assert bits.of_case(second) == bits.of_case(first)
    dense = reference.simulate(second).dense
    assert type(dense) is type(reference.simulate(first).dense)


def operations(case) -> list[int]:
    """Number of different operations, inputs and constants in the equations and conditions of each regime of a case."""
    case = relative_case(case)
    systems = [phase_at(case, regime, start_state(case)).system for regime in (*candidates(case), FLIGHT)]
    return [
        len(in_order([*s.rates, *s.outputs, *s.load_quantities, *(e for some in _named(s) for e in some.values())]))
        for s in systems
    ]


def _named(system):
    return system.conditions, system.condition_rates, system.guards


@pytest.mark.parametrize("label", OPERATIONS)
def test_scenes_without_them_have_the_operations_they_had_before_there_were_more_effects(label):
    assert operations(cases.select(label)[0]) == OPERATIONS[label]


@pytest.mark.parametrize("effect", [Belt("0.1*t"), Drive(x="0.1*t**2"), Adhesion(1.0, 0.1, 0.1)])
def test_each_effect_has_operations_of_its_own(effect):
    without = on_line(slip=1.0)
    case = replace(without, effects=(*without.effects, effect))
    assert all(more > less for more, less in zip(operations(case)[:-1], operations(without)[:-1], strict=True))


class Calls:
    """Counts calls of what it stands for."""

    def __init__(self, function):
        self.function, self.count = function, 0

    def __call__(self, *arguments, **options):
        self.count += 1
        return self.function(*arguments, **options)


@pytest.mark.parametrize("method", reference.METHODS)
def test_absent_effects_are_asked_nothing(monkeypatch, method):
    landings, impacts, guards = Calls(contact_chart.Landings), Calls(flight_end.collide), Calls(dop853.guards_at_nodes)
    monkeypatch.setattr(contact_chart, "Landings", landings)
    monkeypatch.setattr(flight_end, "collide", impacts)
    monkeypatch.setattr(dop853, "guards_at_nodes", guards)
    decisions = Calls(contact_chart.decide)
    for module in (contact_chart, contact_end):
        monkeypatch.setattr(module, "decide", decisions)
    reference.simulate(scene(Gravity(G)), method=method)
    assert (landings.count, impacts.count, guards.count, decisions.count) == (0, 0, 0, 1)  # the mode of the start
    reference.simulate(scene(Gravity(G), CoulombFriction(0.1), Unilateral()), method=method)
    assert landings.count == impacts.count == 0 and decisions.count > 2
    bouncing = Case(line(), disc(0.1, 1.0), (Gravity(G), Unilateral(), Flight(), Impact(0.5)), Start(0.0, gap=0.1), 0.2)
    reference.simulate(bouncing, method=method)
    assert landings.count > 0 and impacts.count > 0


def test_parameters_of_absent_effects_are_not_there():
    assert {*frictionless().system.names} == {"gx", "gy", "outline_c0", "track_c0"}


def test_frictionless_motion_keeps_its_energy():
    motion = reference.simulate(scene(Gravity(G)), rtol=1e-13)
    energies = 0.5 * (motion.vx**2 + motion.vy**2) + 0.25 * 0.01 * motion.omega**2 + G * motion.y
    assert np.ptp(energies) <= 1e-13 * G


def test_without_friction_the_matrix_is_symmetric_and_with_it_it_is_not():
    # Rows of the constraints combined so that q̈₂ drops out leave [M, −A; wᵀB, 0]: symmetric where wᵀB is parallel to A.
    from scipy.linalg import null_space

    from cases import Mode
    from reference.minimal.modes import start_state
    from reference.paper.augmented import fill

    def turn_between(case, mode):
        matrix = fill(case, mode, start_state(case)).matrix
        combination = null_space(matrix[3:, 3:5].T)[:, 0]
        row, column = combination @ matrix[3:, :3], -matrix[:3, 5]
        return 1 - abs(row @ column) / np.linalg.norm(row) / np.linalg.norm(column)

    assert turn_between(scene(Gravity(G)), Mode.SLIDE) <= 1e-15
    assert turn_between(scene(Gravity(G), CoulombFriction(0.3)), Mode.SLIP_FORWARD) > 1e-3
