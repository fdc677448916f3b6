"""The independent checker confirms true records and rejects those of provers with planted faults."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cases
from tests.style.test_architecture import imported

pytest.importorskip("flint")

from reference import proof_checker  # noqa: E402
from reference.proof_checker import NotConfirmed, check  # noqa: E402
from reference.proof_checker.__main__ import main  # noqa: E402
from reference.proof_checker.balls import FixedPoint  # noqa: E402
from reference.proofs import equations, motion, prove  # noqa: E402
from reference.proofs.catalogue import CATALOGUE  # noqa: E402
from tests.sampling import quick_every


def record_of(label: str, digits: int = 10, transitions: int | None = None) -> dict:
    return json.loads(prove(cases.load(label), digits, transitions).as_json())


@quick_every(10, first=5)
@pytest.mark.parametrize(
    "label",
    [
        "almost_rolling[slip=1e-12]",
        "disc_in_sticky_valley",  # rolling resistance, and rest at the end
        "disc_in_weightless_ring",
        "disc_on_incline[slope=0.2]",
        "disc_on_line[mu=0.1]",
        "disc_on_spring",
        "disc_rolling_to_rest",
        "driven_disc",
        "guided_loop",  # a guide that presses from either side
        "thrown_with_spin[backspin=-2.5]",
    ],
)
def test_whole_record_is_confirmed(label):
    assert "status completed" in check(record_of(label))


RECORDS = {record["case"]: record for record in map(json.loads, CATALOGUE.read_text(encoding="utf-8").splitlines())}
# Stored records whose check takes less than a second: discs on curves, and a plate that is no disc.
STORED = [
    "balanced_on_its_tip[duration=1]",
    "disc_across_circle",
    "disc_in_circle[mu=0.01]",
    "disc_in_circle[mu=0.1]",
    "disc_in_circle[mu=0.2]",
    "nearly_conforming[gap=1e-08]",
    "rolling_loop[ratio=3.5]",
    "touching_slip[above=-1e-09]",
]


# Plates that are no disc, whose sets grow too wide or whose check takes over 30 s of CPU time (docs/proofs.md).
NOT_CONFIRMED = {
    *(name for name in RECORDS if name.startswith(("degenerate_release", "sliding_rod"))),
    "hopping_rod",
}
OTHERS = [name for name in RECORDS if name not in {*STORED, *NOT_CONFIRMED}]


@quick_every(3)
@pytest.mark.parametrize("label", [*STORED, *(pytest.param(name, marks=pytest.mark.slow) for name in OTHERS)])
def test_stored_record_is_confirmed(label):
    record = RECORDS[label]
    answer = check(record)
    assert answer.startswith("confirmed" if record["first_mode"] != "none" else "nothing to confirm")


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.01, 0.1, 0.2])
def test_papers_fifty_digits_are_confirmed(mu):
    check(record_of(f"disc_in_circle[mu={mu:g}]", 50, 1))


def test_checker_shares_no_code_with_the_prover():
    for file in Path(proof_checker.__path__[0]).glob("*.py"):
        rooms = {name.split(".")[0] for name in imported(file)} - {"reference"}
        assert not rooms & {"flint", "sympy", "numpy", "scipy", "cases", "adapters", "reports"}, file
        inside = {name for name in imported(file) if name.startswith("reference.")}
        assert all(name.startswith("reference.proof_checker") for name in inside), file


# --- planted faults ---------------------------------------------------------------------------------------------------


def test_wrong_sign_of_friction_is_rejected(monkeypatch):
    """The sign of the paper's printed (32) in the prover: friction drives the slip, which never ends."""
    right = equations.Dynamics._ratio
    monkeypatch.setattr(equations.Dynamics, "_ratio", lambda self, regime: -right(self, regime))
    with pytest.raises(NotConfirmed, match="slip"):
        check(record_of("disc_on_line[mu=0.1]"))


def test_skipped_earlier_zero_is_rejected(monkeypatch):
    """A prover that passes over the first zero of the slip states that there is none."""
    first_zero = motion.first_zero
    monkeypatch.setattr(motion, "first_zero", lambda g, h, name: None if name == "slip" else first_zero(g, h, name))
    claim = record_of("disc_on_line[mu=0.1]")
    assert claim["status"] == "completed" and not claim["transitions"]
    with pytest.raises(NotConfirmed, match="slip"):
        check(claim)


@pytest.mark.parametrize("key, value", [("before", "roll"), ("after", "slip_backward")])
def test_wrong_mode_is_rejected(key, value):
    claim = record_of("disc_on_line[mu=0.1]")
    claim["transitions"][0][key] = value
    with pytest.raises(NotConfirmed):
        check(claim)


def test_another_scene_is_rejected():
    claim = record_of("disc_on_line[mu=0.1]")
    claim["scene"]["mu"] = claim["scene"]["mu_static"] = "1000001/10000000"
    with pytest.raises(NotConfirmed, match="time of transition 1"):
        check(claim)


# --- balls ------------------------------------------------------------------------------------------------------------

FIXED = FixedPoint(40)
numbers = st.fractions(min_value=-30, max_value=30, max_denominator=10**6)
radii = st.integers(min_value=0, max_value=2**30)


@given(x=numbers, y=numbers, r=radii, q=radii, where=st.integers(-8, 8), there=st.integers(-8, 8))
def test_results_of_balls_contain_the_exact_results(x, y, r, q, where, there):
    """For numbers anywhere in two balls, their exact sum, product, quotient and root lie in the results."""
    balls = [(m, e + more) for (m, e), more in ((FIXED.of(x), r), (FIXED.of(y), q))]
    a, b = (Fraction(8 * m + part * e, 8 * FIXED.one) for (m, e), part in zip(balls, (where, there), strict=True))
    results = [(FIXED.mul(*balls), a * b), (FIXED.over(balls[0], 7), a / 7)]
    results += [(FIXED.times_power(balls[0], n), a * Fraction(2) ** n) for n in (-5, 3)]
    results += [(FIXED.polynomial([balls[0], balls[1], balls[0]], balls[1]), a + b * b + a * b * b)]
    if abs(balls[1][0]) > balls[1][1]:
        results.append((FIXED.div(*balls), a / b))
    for ball, exact in results:
        assert FIXED.low(ball) <= exact <= FIXED.high(ball)
    if balls[0][0] > balls[0][1]:
        root = FIXED.sqrt(balls[0])
        assert FIXED.low(root) ** 2 <= a <= FIXED.high(root) ** 2


# --- the record as data -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["__import__('os').getcwd()", "s.real", "(lambda: s)()", "open(s)", "s if s else 1"])
def test_nothing_of_a_record_is_executed(text):
    claim = record_of("disc_on_line[mu=0.1]")
    claim["scene"]["track"][0] = text
    with pytest.raises(ValueError, match="a record has"):
        check(claim)


def test_command_reports_each_file(tmp_path, capsys):
    good, bad, other = (tmp_path / name for name in ("good.json", "bad.json", "other.json"))
    claim = record_of("disc_on_line[mu=0.1]")
    good.write_text(json.dumps(claim))
    claim["transitions"][0]["time"]["high"] = claim["transitions"][0]["time"]["low"]
    bad.write_text(json.dumps(claim))
    other.write_text("{}")
    assert main([str(good)]) == 0
    assert main([str(good), str(bad)]) == 1
    assert main([str(other)]) == 2
    assert [line.partition(":")[0] for line in capsys.readouterr().out.splitlines()] == [
        "confirmed", "confirmed", "not confirmed", "not checked",
    ]  # fmt: skip
