"""The independent checker confirms true records and rejects those of provers with planted faults."""

from __future__ import annotations

import ast
import json
from fractions import Fraction
from pathlib import Path

import pytest

import cases
from tests.test_architecture import imported

pytest.importorskip("flint")

from reference import proof_checker  # noqa: E402
from reference.proof_checker import NotConfirmed, check  # noqa: E402
from reference.proof_checker.__main__ import main  # noqa: E402
from reference.proof_checker.formulas import derivative, parse  # noqa: E402
from reference.proofs import equations, motion, prove, rounding  # noqa: E402


def record_of(label: str, digits: int = 10, transitions: int | None = None) -> dict:
    return json.loads(prove(cases.load(label), digits, transitions).as_json())


@pytest.mark.parametrize(
    "label",
    [
        "almost_rolling[slip=1e-12]",
        "disc_in_weightless_ring",
        "disc_on_incline[slope=0.2]",
        "disc_on_line[mu=0.1]",
        "disc_on_spring",
        "driven_disc",
        "thrown_with_spin[backspin=-2.5]",
    ],
)
def test_whole_record_is_confirmed(label):
    assert "status completed" in check(record_of(label))


@pytest.mark.parametrize("label", ["disc_in_circle[mu=0.2]", "disc_sliding_off_hill"])
def test_first_transition_is_confirmed(label):
    assert "1 transitions" in check(record_of(label, 6, 1))


@pytest.mark.slow  # interval arithmetic in Python: seconds each
@pytest.mark.parametrize(
    "label",
    [
        "disc_in_circle[mu=0.01]",
        "disc_in_circle[mu=0.1]",
        "disc_in_circle[mu=0.2]",
        "disc_in_parabola",
        "released_at_an_inflection[power=3]",
        "rolling_loop[ratio=3.5]",
    ],
)
def test_whole_sequence_on_a_curve_is_confirmed(label):
    check(record_of(label, 14))


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


def test_ends_that_are_not_rounded_outward_are_rejected(monkeypatch):
    def nearest(number: Fraction, places: int, up: bool) -> str:
        return str(float(round(number, places)))

    monkeypatch.setattr(rounding, "_decimal", nearest)
    with pytest.raises(NotConfirmed, match="time of transition 1"):
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


# --- the record as data -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["__import__('os').getcwd()", "s.real", "(lambda: s)()", "open(s)", "s if s else 1"])
def test_nothing_of_a_record_is_executed(text):
    claim = record_of("disc_on_line[mu=0.1]")
    claim["scene"]["track"][0] = text
    with pytest.raises(ValueError, match="a record has"):
        check(claim)


@pytest.mark.parametrize(
    "text",
    ["s**3 - 2*s", "cos(2*s)*exp(-s)", "sqrt(1 + s**2)", "log(2 + sin(s))/3", "tanh(s)*cosh(s)", "(1 + s**2)**(-1/2)"],
)
def test_derivatives_are_those_of_sympy(text):
    import sympy as sp

    s = sp.Symbol("s")
    ours = sp.sympify(ast.unparse(derivative(parse(text))), {"s": s})
    assert abs(float((ours - sp.diff(sp.sympify(text, {"s": s}), s)).subs(s, 0.7))) < 1e-12


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
