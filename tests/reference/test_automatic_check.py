"""Every motion is checked by the laws before it is returned: solvers with planted faults end as `broken_law`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

import cases
import reference
from cases import Case, Chain, CoulombFriction, Curve, Flight, Gravity, Impact, Start, StartPose, Unilateral, disc
from reference import solve
from reference.certification import NotCertified
from reference.endings import BROKEN_LAW
from reference.laws_check.broken_laws import OVERLAP
from reference.sweeping import batches, motions

CIRCLE, BOX, FREE = "disc_in_circle[mu=0.2]", "sliding_box[mu=0.4,slope=0.2]", "disc_on_free_disc[mu=0.5]"
HILL, BOUNCE = "disc_sliding_off_hill", "bouncing_disc[e=0.5]"
# A disc that rolls off a table to the floor.
TABLE = Case(
    Chain.polyline([(-1, 0), (0, 0), (0, -1), (3, -1)]), disc(0.1, 1.0),
    (Gravity(9.81), CoulombFriction(0.5), Impact(0.5), Unilateral(), Flight()), Start(xi1=0.5, omega=-15.0), 1.2,
)  # fmt: skip


def other_scene(change: Callable[[Case], Case]) -> Callable:
    """A solver of another scene."""
    return lambda right: lambda case, *more: right(change(case), *more)


def with_effect(effect) -> Callable[[Case], Case]:
    """The scene with an effect in the place of that of its kind."""
    return lambda case: replace(case, effects=(*(e for e in case.effects if type(e) is not type(effect)), effect))


def without(*kinds: type) -> Callable[[Case], Case]:
    """The scene without some effects."""
    return lambda case: replace(case, effects=tuple(e for e in case.effects if not isinstance(e, kinds)))


def other_mode(right):
    """A solver that calls its first phase, a slip, by the mode of the second, a roll."""

    def solution(*arguments):
        segments, transitions, ending = right(*arguments)
        first, second = segments[0].phase, segments[1].phase
        segments[0] = replace(segments[0], phase=first._replace(regime=second.regime))
        return segments, transitions, ending

    return solution


# One for each kind of motion; `test_planted_faults` has the kinds of faults.
FAULTS = {
    "friction a millionth larger": (CIRCLE, other_scene(with_effect(CoulombFriction(0.2 * (1 + 1e-6)))), "Coulomb"),
    "a track that pulls": (HILL, other_scene(without(Unilateral, Flight)), "normal force presses"),
    "a weight that grows": (CIRCLE, other_scene(with_effect(Gravity(9.82))), "energy is not created"),
    "a slip that is called a roll": (CIRCLE, other_mode, "no slip"),
    "restitution at a floor with corners": (TABLE, other_scene(with_effect(Impact(0.6))), "law of impact"),
    "a lower floor": (BOUNCE, other_scene(lambda case: replace(case, track=Curve(("s", "-0.01")))), OVERLAP),
    "friction at two contacts": (BOX, other_scene(with_effect(CoulombFriction(0.4 * (1 + 1e-6)))), "Coulomb"),
    "friction of free plates": (FREE, other_scene(with_effect(CoulombFriction(0.51))), "Coulomb"),
}


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_solver_ends_as_a_broken_law(fault, method, monkeypatch):
    """The status, and which law, where, when and by how much in the reason; without the fault neither."""
    if method not in reference.METHODS:
        pytest.skip("heyoka is not installed")
    label, solver, law = FAULTS[fault]
    case = cases.load(label) if isinstance(label, str) else label
    assert reference.simulate(case, method=method).status != BROKEN_LAW
    monkeypatch.setattr(solve, "solve_motion", solver(solve.solve_motion))
    motion = reference.simulate(case, method=method)
    assert motion.status == BROKEN_LAW
    assert law in motion.reason and "broken by" in motion.reason and "It ended as" in motion.reason
    assert BROKEN_LAW in motion.in_words()


REST = StartPose(0.0, 0.1, 0.0, 0.0, 0.0, 1e-16)


@pytest.mark.parametrize("effects", [(Gravity(9.81),), ()], ids=["weight", "weightless"])
@pytest.mark.parametrize("method", reference.METHODS)
def test_a_rest_with_roundings_breaks_no_law(effects, method):
    """Speeds and forces of roundings are compared with scales that do not vanish with them."""
    case = Case(cases.library.line(), disc(0.1, 1.0), (*effects, CoulombFriction(0.3), Unilateral()), REST, 1.0)
    assert reference.simulate(case, method=method).status == "completed"


@pytest.mark.parametrize("together", [True, False])
def test_a_sweep_checks_what_goes_alone_and_some_of_the_rest(together, monkeypatch):
    """Of scenarios that go together the first of a thousand, and those that end early."""
    if together and "taylor" not in reference.METHODS:
        pytest.skip("heyoka is not installed")
    monkeypatch.setattr(solve, "solve_motion", other_scene(with_effect(CoulombFriction(1e-12)))(solve.solve_motion))
    if not together:
        monkeypatch.setattr(batches, "_plain", lambda scenes: False)
    rows = reference.sweep("disc_in_circle", mu=[0.2, 0.3, 0.4])
    others = ["completed"] * 2 if together else [BROKEN_LAW] * 2
    assert rows.outcome.to_list() == [BROKEN_LAW, *others]
    assert "Coulomb's law in slip" in rows.reason[0]
    monkeypatch.setattr(motions, "USUAL", ())
    assert set(reference.sweep("disc_in_circle", mu=[0.2, 0.3, 0.4]).outcome) == {BROKEN_LAW}


def test_certify_names_the_law_and_the_witness(monkeypatch):
    monkeypatch.setattr(solve, "solve_motion", other_scene(with_effect(CoulombFriction(0.21)))(solve.solve_motion))
    with pytest.raises(
        NotCertified, match=r"dop853 1e-13 breaks a law, Coulomb's law in slip at plate/track: broken by"
    ):
        reference.certify(cases.load(CIRCLE))
