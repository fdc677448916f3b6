"""What a certificate promises: bars that hold, witnesses that are named, sentences that do not blame the scene."""

import json
from dataclasses import replace

import pytest
import sympy as sp

import cases
from cases import Case, CoulombFriction, Curve, Gravity, Start, Transition, Unilateral, disc
from cases import curves as c
from reference import __main__ as command
from reference import simulate
from reference.__main__ import main
from reference.certification import certificate as certification
from reference.certification import rebuild, truth_file, witnesses
from reference.certification.certificate import Certificate, NotCertified, certify
from reference.minimal.integrators import taylor
from tests.authorities.many_digits import STATES, TIMES, computed
from tests.scenes import second as second_states

BOWLED = cases.load("disc_on_line[mu=0.1]")


@pytest.fixture(scope="module")
def bowled() -> Certificate:
    return certify(BOWLED)


def test_bars_hold_where_all_witnesses_share_a_rounding():
    """A disc that slides round a loop without friction does not turn. Each witness of the first formulation holds its
    spin as a difference of two speeds of 70 rad/s, which leaves 7e-15 rad/s: they agree, and are wrong alike."""
    certificate = certify(cases.load("sliding_loop[ratio=5.1]"))
    for quantity in ("theta", "omega"):
        assert all(abs(one.value) <= one.bar for one in certificate.samples[quantity]), quantity


def test_each_part_of_the_truth_has_its_witnesses(bowled):
    assert bowled.confirmations["sequence, status and times"] == bowled.witnesses
    assert bowled.confirmations["places and poses"] == bowled.witnesses[:-1]
    assert bowled.confirmations["forces and impacts"] == bowled.confirmations["uniqueness"] == ("check of laws",)


def test_what_all_witnesses_agree_on_breaks_no_law(monkeypatch):
    """All share a friction that is 3 % too large: they agree, and the laws of the scene say no."""
    wrong = replace(BOWLED, effects=(Gravity(9.81), CoulombFriction(0.103), Unilateral()))
    every = witnesses.witnesses(wrong)
    monkeypatch.setattr(certification, "witnesses", lambda case: every)
    with pytest.raises(
        NotCertified, match=r"breaks a law, Coulomb's law in slip at plate/track: broken by .* \(0.03 μN\)"
    ):
        certify(BOWLED)


@pytest.mark.slow
@pytest.mark.parametrize("label", STATES)
def test_samples_hold_a_computation_with_many_digits(label):
    certificate = certify(cases.load(label))
    assert certificate.times == pytest.approx(TIMES[label], abs=1e-15)
    for quantity, values in STATES[label].items():
        for one, exact in zip(certificate.samples[quantity], values, strict=True):
            assert abs(sp.Float(repr(one.value), 40) - sp.Float(exact, 40)) <= one.bar, (quantity, exact)


def test_the_many_digits_are_computed_again():
    """The first moments of a kept computation, made anew."""
    label = "sliding_loop[ratio=5.1]"
    again = computed(label, TIMES[label][:3])
    for quantity, values in again.items():
        for one, kept in zip(values, STATES[label][quantity], strict=False):
            assert abs(one - sp.Float(kept, 30)) < 1e-19


@pytest.mark.slow
def test_a_bar_grows_where_the_motion_is_unstable():
    """Balanced on its tip, an ellipse moves away from rest by its eigenvalue: what a rounding of its angle makes of its
    place after a second is what the bar says, to an order of magnitude."""
    case = cases.load("balanced_on_its_tip[duration=1]")
    certificate = certify(case)
    bars = [one.bar for one in certificate.samples["theta"]]
    assert bars[-1] > 3 * bars[0]
    moved = replace(case, start=replace(case.start, xi2=case.start.xi2 + 1e-9), name="moved")
    change = abs(simulate(moved, rtol=1e-13).theta[-1] - simulate(case, rtol=1e-13).theta[-1])
    assert bars[-1] >= 2.0**-52 * change / 1e-9


# --- witnesses --------------------------------------------------------------------------------------------------------


def test_one_witness_alone_certifies_nothing(monkeypatch):
    able, _ = witnesses.witnesses(BOWLED)
    monkeypatch.setattr(certification, "witnesses", lambda case: (able[:1], ["the others cannot run: a reason"]))
    with pytest.raises(NotCertified, match="a certificate needs at least two.*a reason"):
        certify(BOWLED)


def disagreeing(monkeypatch, change, number: int = -1) -> str:
    """What the certificate says where one witness of a disc on a line, the last one, says something else."""
    able, missing = witnesses.witnesses(BOWLED)
    every = [*able]
    every[number] = change(able[number])
    monkeypatch.setattr(certification, "witnesses", lambda case: (every, missing))
    with pytest.raises(NotCertified) as error:
        certify(BOWLED)
    text = str(error.value)
    assert "\n" not in text and "ill-conditioned" not in text
    assert able[0].name in text and able[number].name in text and "one of the two may be wrong" in text
    return text


def test_witnesses_that_tell_different_stories_are_named_and_the_scene_is_not_blamed(monkeypatch):
    text = disagreeing(monkeypatch, lambda w: w._replace(transitions=(), status="lift_off"))
    assert "roll at 0.3397" in text and "lift_off at" in text


def test_witnesses_that_tell_different_times_are_named_with_them(monkeypatch):
    def late(witness):
        (t,) = witness.transitions
        return witness._replace(transitions=(Transition(t.time + 1e-5, t.before, t.after, t.xi1, t.xi2),))

    assert "roll at 0.33978933" in disagreeing(monkeypatch, late)


@pytest.mark.skipif(not taylor.AVAILABLE, reason="without heyoka no other witness has places")
def test_a_bar_that_is_no_use_makes_no_certificate(monkeypatch):
    """A place that is known to a hundredth of the plate only."""

    class Elsewhere(witnesses.Witness):
        def states(self, times):
            return super().states(times) | {"x": super().states(times)["x"] + 0.002}

    text = disagreeing(monkeypatch, lambda witness: Elsewhere(*witness), number=-2)
    assert "a thousandth of the plate" in text and "0.002 m" in text


def test_a_scene_that_hangs_on_the_last_bit_is_called_so():
    """The slip of a swinging disc that just touches zero: a rounding decides whether it does."""
    with pytest.raises(NotCertified, match="roundings gives .*ill-conditioned"):
        certify(cases.load("touching_slip[above=0]"))


# --- second contacts --------------------------------------------------------------------------------------------------


def wide_disc() -> Case:
    track = Curve(lambda s: (s, -0.5 * c.cos(2 * s)), domain=(-3, 3))
    return Case(track, disc(0.6, 1.0), (Gravity(9.81), CoulombFriction(0.2), Unilateral()), Start(-1.2), 3.0)


def test_a_second_contact_is_seen_by_both_formulations():
    """A disc too wide for a valley's bottom touches both flanks with its centre above the bottom."""
    case = wide_disc()
    first, second = simulate(case, rtol=1e-13), second_states.motion(case, rtol=1e-13)
    assert first.status == second.status == "second_contact"
    assert second.end == pytest.approx(first.t[-1], abs=1e-11)


# --- python -m reference ----------------------------------------------------------------------------------------------


@pytest.fixture
def kept(tmp_path, bowled, monkeypatch):
    """A file of two certificates, of which one is to be made again."""
    path = tmp_path / "truth.json"
    rows = [
        replace(bowled, case=label, status="as it was") for label in ("disc_on_line[mu=0.1]", "disc_on_line[mu=0.3]")
    ]
    truth_file.write(rows, path)
    monkeypatch.setattr(rebuild, "certify", lambda case: replace(bowled, case=case.label))
    truth_file.read.cache_clear()
    yield path
    truth_file.read.cache_clear()


def statuses(path) -> dict[str, str]:
    return {row["case"]: row["status"] for row in json.loads(path.read_text())}


def test_a_part_of_the_truth_is_rebuilt_and_the_rest_stays(kept, capsys):
    assert main(["--only", "disc_on_line[mu=0.3]", "--jobs", "1"], kept) == 0
    assert statuses(kept) == {"disc_on_line[mu=0.1]": "as it was", "disc_on_line[mu=0.3]": "completed"}
    assert "1/1 disc_on_line[mu=0.3]" in capsys.readouterr().out


def test_a_case_without_a_certificate_is_told_and_the_others_are_kept(kept, monkeypatch, bowled, capsys):
    def some(case):
        if case.label == "disc_on_line[mu=0.1]":
            raise NotCertified("disc_on_line[mu=0.1]: a reason")
        return replace(bowled, case=case.label)

    monkeypatch.setattr(rebuild, "certify", some)
    assert main(["--only", "disc_on_line", "--jobs", "1"], kept) == 1
    assert statuses(kept) == {"disc_on_line[mu=0.3]": "completed"}
    assert "not certified: disc_on_line[mu=0.1]: a reason" in capsys.readouterr().out


def test_help_and_mistakes_rebuild_nothing(kept, monkeypatch, capsys):
    monkeypatch.setattr(rebuild, "certify", None)
    before = kept.read_bytes()
    with pytest.raises(SystemExit) as stopped:
        main(["--help"], kept)
    assert stopped.value.code == 0
    assert main(["--out", str(kept)]) == 2 and f"{kept} exists; give the name of a new file" in capsys.readouterr().err
    monkeypatch.setattr(command, "in_clone", lambda: False)
    assert main([]) == 2 and "an installed package are not changed" in capsys.readouterr().err
    for words in (["--only", "disc_on_lime"], ["--jobs", "many"], ["--jobs", "0"], ["--colour"], ["disc_on_line"]):
        assert main(words, kept) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert kept.read_bytes() == before
