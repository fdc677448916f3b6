"""Seams, holds, stacks, rebounds and a conveyor's end: exact values, and the laws at every step."""

from math import asin, atan, cos, sin, tan

import pytest

import cases
import reference
from cases import Case, Chain, CoulombFriction, Flight, Gravity, Impact, Plate, Start, Unilateral
from cases.library import line
from reference.solver import mode_program

G = 9.81
EXACT = 1e-12  # relative: roundings of the integration


def run(name, **parameters):
    case = cases.load(name, **parameters)
    motion = reference.simulate(case)
    assert motion.status == "completed" and not reference.check(case, motion), motion.reason
    return motion


def test_a_disc_passes_seams_as_a_line():
    motion = run("disc_over_seams")
    assert motion.transitions[0].time == pytest.approx(2.0 / (3 * 0.3 * G), rel=EXACT)
    assert motion(1.0).vx == pytest.approx(4 / 3, rel=EXACT) and motion(1.0).y == 0.1


def test_a_seam_exactly_at_the_end_of_the_motion():
    motion = run("disc_over_seams", v=0.5, mu=0.0)  # x = 0.5 m, a seam, after 1 s
    assert motion(1.0).x == pytest.approx(0.5, rel=EXACT) and motion(1.0).vx == 0.5


def test_a_box_passes_seams_as_a_line():
    end = run("box_over_seams")(0.5)
    assert end.x == pytest.approx(2.0 * 0.5 - 0.3 * G / 8, rel=EXACT) and abs(end.omega) < EXACT


@pytest.mark.parametrize(
    "start", [Start(0.3, 0.1, slip=2.0), Start(0.3, slip=2.0), Start(0.3, 0.1, 1.0, 0.5, 0.02, 0.3)]
)
def test_a_box_begins_on_a_tile_as_on_a_line(start):
    tiles, box = Chain.polyline([(0.5 * k, 0.0) for k in range(5)]), Plate.rectangle(0.2, 0.2, 1.0)
    effects = Gravity(G), CoulombFriction(0.2), Unilateral(), Flight(), Impact(0.0, "moreau")
    on_tiles, on_line = (reference.simulate(Case(track, box, effects, start, 0.3)) for track in (tiles, line()))
    for name in ("x", "y", "theta", "vx", "vy", "omega"):
        assert getattr(on_tiles, name)[[0, -1]] == pytest.approx(getattr(on_line, name)[[0, -1]], abs=1e-12)


@pytest.mark.parametrize("part", [-0.01, 0.0, 0.01])
def test_a_box_holds_up_to_its_angle(part):
    motion = run("box_held_by_friction", part=part)
    slope = 0.3
    along = G * (sin(slope) - tan(slope) / (1 + part) * cos(slope)) * 25 / 2 if part > 0 else 0.0
    moved = (motion(5.0).x - motion(0.0).x) / cos(slope)
    assert moved == pytest.approx(along, rel=1e-11, abs=1e-15)  # differences of nearly equal forces


@pytest.mark.parametrize("part", [-0.05, 0.05])
def test_a_disc_holds_up_to_its_rolling_resistance(part):
    motion = run("disc_held_by_resistance", part=part)
    slope = atan(0.1 * (1 + part))
    rate = 2 / 3 * G * (sin(slope) - 0.1 * cos(slope)) * 2.0 if part > 0 else 0.0
    assert motion(2.0).vx / cos(slope) == pytest.approx(rate, rel=1e-11, abs=1e-15)  # as above


def test_a_stack_stands_still():
    motion = run("stack_of_boxes", count=3)
    for i, name in enumerate(motion.plate_names):
        now = motion.plate(name)(2.0)
        assert now.y == pytest.approx(0.1 + 0.2 * i, rel=EXACT) and abs(now.x) + abs(now.theta) < 1e-15


def test_the_upper_box_slips_where_its_own_friction_ends():
    motion = run("boxes_on_shaken_table")
    slips = next(t for t in motion.transitions if t.contact.startswith("plate/upper") and t.time > 0)
    assert slips.time == pytest.approx(asin(0.2 * G / (0.05 * 81)) / 9, rel=1e-10)  # the method's own tolerance


@pytest.mark.parametrize(("e", "mu"), [(1.0, 0.0), (0.8, 0.3)])
def test_a_rebound_has_the_impulses_of_its_law(e, mu):
    case = cases.load("rebound_with_spin", e=e, mu=mu)
    first = reference.impacts(case, run("rebound_with_spin", e=e, mu=mu))[0]
    speed, slip = (2 * G) ** 0.5, 2.0 + 2.0  # of the rim: v and the backspin
    assert first.normal == pytest.approx((1 + e) * speed, rel=1e-11)
    assert first.friction == pytest.approx(
        -min(mu * (1 + e) * speed, slip / 3), rel=1e-11, abs=1e-13
    )  # roundings of momenta


def test_a_conveyor_hands_a_box_over():
    motion = run("box_off_conveyor")
    first, _, tips, *_ = motion.transitions
    rides = 1.0 / (0.4 * G)
    assert first.time == pytest.approx(rides, rel=EXACT)  # it has the belt's speed
    assert tips.contact == "plate/track 2"
    # At 0.5 m/s on average until it sticks, then at 1 m/s until its centre is above the end, 0.3 m.
    assert tips.time == pytest.approx(rides + 0.3 - 0.5 * rides, rel=EXACT)


def test_the_first_domino_turns_by_its_energy():
    case = cases.load("dominoes")
    motion = run("dominoes")
    hit = motion.transitions[0].time if "impact" in motion.transitions[0].cause else None
    w, h = 0.1, 0.6
    inertia = (w * w + h * h) / 3  # about the corner, per mass
    # The push gives the spin about the corner at once: a rotation about it has these velocities.
    for t in (0.05, 0.1):
        assert hit is None or t < hit
        now = motion(t)
        rise = (h / 2) * (cos(now.theta) - 1) + (w / 2) * sin(-now.theta)
        assert now.omega**2 * inertia / 2 == pytest.approx(inertia / 2 - G * rise, rel=1e-9)  # ten times the tolerance
    assert len(case.others) == 1


def test_five_dominoes_hit_each_other_in_turn():
    """The last impact has ten contacts: 4**10 combinations of modes."""
    motion = run("dominoes", count=5, duration=2.45)
    hits = [event for event in motion.transitions if event.cause == "impact" and "track" not in event.contact]
    assert [event.contact for event in hits] == ["plate/block2", "block2/block3", "block3/block4", "block4/block5"]
    assert hits[0].time == pytest.approx(run("dominoes").transitions[0].time, rel=EXACT * 10)


@pytest.mark.parametrize("name", ["boxes_on_shaken_table", "dominoes", "disc_pushes_block"])
def test_modes_that_a_program_leaves_give_the_motion_of_all_modes(name, monkeypatch):
    every = reference.simulate(cases.load(name))
    monkeypatch.setattr(mode_program, "FEW", 1)
    allows, asked = mode_program._Program.allows, list[int]()

    def looked_at(self, rates, k, kind):
        asked.append(k)
        return allows(self, rates, k, kind)

    monkeypatch.setattr(mode_program._Program, "allows", looked_at)
    motion = reference.simulate(cases.load(name))
    assert asked and motion.transitions == every.transitions and (motion.x == every.x).all()


def test_too_many_modes_end_the_motion_in_a_sentence(monkeypatch):
    monkeypatch.setattr(mode_program, "MOST", 1)
    motion = reference.simulate(cases.load("dominoes"))
    assert motion.status == "unfinished" and "have more combinations of modes than are tried" in motion.reason
