"""Proofs of transitions: enclosures against independent values, and planted faults that must make a proof fail."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from pathlib import Path

import pytest

import cases
from cases import NotSupported
from reference.certification import read

flint = pytest.importorskip("flint")
from flint import arb  # noqa: E402

import reference  # noqa: E402
from reference.proofs import equations, prove, steps  # noqa: E402
from reference.proofs.command import main  # noqa: E402
from tests.sampling import quick_every  # noqa: E402

# Section 4.2 of the paper with 50 digits. The first 20 digits of each were computed with mpmath by a quadrature of the
# linear equation for the square of the speed (`tests/authorities/paper_application.py`).
PAPER = {0.01: "1.0854336058486487598", 0.1: "0.80999527777318536126", 0.2: "0.63005376392730307737"}
# The page with the theorems has the lower ends of the intervals, by coefficient.
PAGE = Path(__file__).parents[2] / "docs" / "proofs.md"
SHOWN = dict(re.findall(r"^\| (0\.\d+) \| ([\d.]{50,}) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE))

SLOW = [
    "at_any_size[length=1e-06,mass=1e-09]",
    "disc_in_circle[mu=0.01]",
    "disc_in_circle[mu=0.1]",
    "disc_in_cosine",
    "disc_in_parabola",
    "released_at_an_inflection[power=3]",
]
QUICK = [
    "almost_rolling[slip=1e-12]",
    "disc_in_circle[mu=0.2]",
    "disc_in_weightless_ring",
    "disc_on_line[mu=0.1]",
    "disc_on_spring",
    "disc_rolling_off_hill",
    "disc_rolling_to_rest",
    "disc_sliding_off_hill",
    "driven_disc",
    "guided_loop",
    "rolling_loop[ratio=3.5]",
    "sliding_loop[ratio=4.9]",
    "thrown_with_spin[backspin=-2.5]",
    "thrown_with_spin[shape=0.4]",
]


@quick_every(4)
@pytest.mark.parametrize("label", [*QUICK, *(pytest.param(label, marks=pytest.mark.slow) for label in SLOW)])
def test_whole_sequence_is_proved_inside_the_witnessed_bars(label):
    proof, truth = prove(cases.load(label)), read()[label]
    assert proof.complete and proof.status == truth.status
    assert [(t.before, t.after) for t in proof.transitions] == [(str(t[0]), str(t[1])) for t in truth.transitions]
    for proved, (_, _, time, place) in zip(proof.transitions, truth.transitions, strict=True):
        assert proved.time.width < 1e-12
        assert proved.time.inside(*time)
        assert proved.xi1.inside(*place)


@quick_every(3, first=2)
@pytest.mark.parametrize("mu", PAPER)
def test_papers_transition_to_fifty_digits(mu):
    (first,) = prove(cases.load("disc_in_circle", mu=mu), digits=50, transitions=1).transitions
    assert first.time.width < 1e-50 * first.time.middle * 1.1
    assert abs(Fraction(first.time.low) - Fraction(PAPER[mu])) < Fraction(1, 10**18)
    assert Fraction(SHOWN[f"{mu:g}"]) == Fraction(first.time.low)
    # The paper claims that rolling follows; it needs friction outside the cone for the two smaller coefficients.
    share = first.rolling_share
    assert Fraction(share.low) > 1 if mu < 0.2 else Fraction(share.high) < 1
    assert first.after == ("roll" if mu == 0.2 else "slip_backward")


def test_proof_agrees_with_closed_forms():
    (line,) = prove(cases.load("disc_on_line", mu=0.1), digits=40).transitions
    assert Fraction(line.time.low) <= Fraction(1, 3) / (Fraction("0.1") * Fraction("9.81")) <= Fraction(line.time.high)
    (slide,) = prove(cases.load("long_slide"), digits=30).transitions
    assert Fraction(slide.time.low) <= 1 / (3 * Fraction("1e-6") * Fraction("9.81")) <= Fraction(slide.time.high)
    (ring,) = prove(cases.load("disc_in_weightless_ring"), digits=40).transitions
    assert 0.75 in ring.time


# --- planted faults ---------------------------------------------------------------------------------------------------


def test_wrong_sign_of_friction_proves_nothing(monkeypatch):
    """With the sign of the paper's printed (32) friction drives the slip: no mode is consistent with the start."""
    right = equations.Dynamics._ratio
    monkeypatch.setattr(equations.Dynamics, "_ratio", lambda self, regime: -right(self, regime))
    proof = prove(cases.load("disc_on_line", mu=0.1))
    assert not proof.transitions


def test_step_encloses_an_exact_solution():
    """ẋ = x² from 1 is 1/(1 − t)."""
    now = steps.step(lambda x: ([x[0] * x[0]], {"x": x[0]}), [arb(1)], arb("0.25"), 0.0, 30, arb("1e-12"))
    for part in (0, 0.25, 0.5, 1):
        s = now.length * part
        assert now.states[0](s).overlaps(1 / (1 - s))
        assert now.guards["x"](s).overlaps(1 / (1 - s))


@pytest.mark.parametrize("shift", ["0", "1e-30"])
def test_double_zero_is_not_proved(shift):
    """(s − 1)² + e with an uncertain e: a touch is neither a zero nor none."""
    guard = steps.StateExpansion((1 + arb(0, "1e-20") + arb(shift), arb(-2), arb(1), arb(0)))
    with pytest.raises(steps.NotProved, match="grazing"):
        steps.first_zero(guard, arb(3), "test")


# --- the command ------------------------------------------------------------------------------------------------------


def test_command_writes_a_record_and_overwrites_none(tmp_path, capsys):
    path = tmp_path / "record.json"
    assert main(["--prove", "disc_on_line[mu=0.1]", "--out", str(path)]) == 0
    data = json.loads(path.read_text())
    assert data["kind"] == "proved" and data["transitions"][0]["after"] == "roll"
    before = path.read_text()
    assert main(["--prove", "disc_on_line[mu=0.1]", "--out", str(path)]) == 2
    assert path.read_text() == before
    assert "exists already" in capsys.readouterr().err


def test_flights_are_not_covered():
    with pytest.raises(NotSupported, match="begins in flight"):
        reference.prove(cases.load("bouncing_disc", e=0.5))
    proof = reference.prove(cases.load("disc_off_ramp"))
    assert [t.after for t in proof.transitions] == ["slip_forward", "flight"]
    assert proof.status == "unproved" and "flights" in proof.reason
