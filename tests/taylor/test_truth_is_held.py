"""The kept truth is what was certified, and what the reference's motion says: a damaged or wrong number is not used."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib import import_module

import pytest

import cases
import reference
from cases import Mode
from reference.__main__ import main
from reference.certification import Bar, DamagedTruth, contradiction, is_within_bars, read, stored_or_new, truth_file
from reports.running import tasks
from reports.running.storage import fingerprint

LABEL = "disc_in_circle[mu=0.2]"


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of two rows of the kept truth, in the place of the file."""
    path = tmp_path / "truth.json"
    truth_file.write([read()[LABEL], read()["disc_on_line[mu=0.1]"]], path)
    whole = truth_file.read.__wrapped__
    import_module("reference.certification.rebuild")  # it imports the function that is replaced here, and its cache
    monkeypatch.setattr(truth_file, "read", lambda path=path: whole(path))
    monkeypatch.setattr(fingerprint.certification, "read", truth_file.read)
    return path


# --- a damaged file ---------------------------------------------------------------------------------------------------


DAMAGES = {
    "a digit": lambda text: text.replace("0.630053", "0.631053", 1),
    "a mode": lambda text: text.replace("slip_backward", "slip_forward", 1),
    "a status": lambda text: text.replace("completed", "lift_off", 1),
    "a digest": lambda text: text.replace('"digest": "', '"digest": "0', 1),
    "no digest": lambda text: text.replace('"digest"', '"digits"', 1),
    "another case": lambda text: text.replace("mu=0.2", "mu=0.3", 1),
    "a row twice": lambda text: json.dumps(json.loads(text)[:1] * 2),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_row_is_rejected_with_what_to_type(copy, damage):
    text = copy.read_text()
    copy.write_text(DAMAGES[damage](text))
    assert copy.read_text() != text
    with pytest.raises(DamagedTruth) as output:
        stored_or_new(cases.load("disc_on_line", mu=0.1))  # whole rows of a damaged file are not used either
    assert str(output.value).startswith("truth.json is damaged: the digest of disc_in_circle[mu=0.")
    assert "python -m reference --only" in str(output.value) and "restore the file" in str(output.value)
    with pytest.raises(DamagedTruth):
        fingerprint.truth_key.__wrapped__()


@pytest.mark.parametrize("text", ["", "[", "{}x", "{}", "[1]", '[{"digest": ""}]', "null", '["a"]', "[" * 3000])
def test_a_file_without_rows_is_rejected(copy, text):
    copy.write_text(text)
    with pytest.raises(
        DamagedTruth, match="truth.json cannot be read .*; restore the file .*certifies all cases again"
    ):
        truth_file.read()


def test_the_command_certifies_a_damaged_row_again_and_only_that(copy, capsys):
    whole, damaged = copy.read_bytes(), DAMAGES["a digit"](copy.read_text())
    copy.write_text(damaged)
    assert main(["--only", "disc_on_line[mu=0.1]"], copy) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and said.startswith("reference: truth.json is damaged")
    assert copy.read_text() == damaged
    assert main(["--only", LABEL, "--jobs", "1"], copy) == 0
    rows = truth_file.read()
    assert rows["disc_on_line[mu=0.1]"] == read()["disc_on_line[mu=0.1]"]
    again, before = rows[LABEL].transitions[0][2], read()[LABEL].transitions[0][2]
    assert abs(again.value - before.value) <= again.bar + before.bar
    assert whole and LABEL in capsys.readouterr().out


# --- a certificate that the motion contradicts ------------------------------------------------------------------------


def said(certificate, label=LABEL) -> str:
    """What of a certificate the motion contradicts."""
    case = cases.load(label)
    motion, coarser = (reference.simulate(case, rtol=rtol) for rtol in (1e-13, 1e-12))
    contradicted = contradiction(case, certificate, motion, coarser, reference.METHODS[0])
    # What is within the bars is not compared with the coarser motion.
    assert not (contradicted and is_within_bars(case, certificate, motion))
    return contradicted


def changed(which: int, **how):
    """The certificate with one of its transitions changed."""
    certificate = read()[LABEL]
    row = dict(zip(("before", "after", "time", "xi1"), certificate.transitions[which], strict=True)) | how
    rows = list(certificate.transitions)
    rows[which] = tuple(row.values())
    return replace(certificate, transitions=tuple(rows))


def moved(bar: Bar, by: float) -> Bar:
    return bar._replace(value=bar.value + by)


def test_kept_certificates_and_motions_agree():
    for label in (LABEL, "disc_on_line[mu=0.1]", "bouncing_disc[e=0.5]", "almost_rolling[slip=-1e-12]"):
        assert said(read()[label], label) == ""


def test_each_method_has_its_own_error():
    label = "bouncing_disc[e=0.5]"  # a flight: both methods step over it exactly, so only roundings remain
    case, kept = cases.load(label), read()[label]
    motion = reference.simulate(case, rtol=1e-13, method="dop853")
    before, after, time, xi1 = kept.transitions[0]
    value = motion.transitions[0].time + time.bar + 50 * 2.0**-52 * motion.transitions[-1].time
    other = replace(kept, transitions=((before, after, time._replace(value=value), xi1), *kept.transitions[1:]))
    assert contradiction(case, other, motion, motion, "dop853") == ""
    assert "the time of transition 1" in contradiction(case, other, motion, motion, "taylor")


def test_a_changed_digit_is_contradicted():
    first = read()[LABEL].transitions[0]
    for by in (1e-3, -1e-6, 1e-10):  # the last is ten thousand bars
        output = said(changed(0, time=moved(first[2], by)))
        assert output.startswith(f"the time of transition 1 (to roll) is {first[2].value + by:.15g} ±"), output
    assert said(changed(1, xi1=moved(read()[LABEL].transitions[1][3], 1e-9))).startswith("xi1 of transition 2")
    # What lies within the bars does not count, nor a whole turn on a closed track.
    assert said(changed(0, time=moved(first[2], 0.5 * first[2].bar))) == ""
    assert said(changed(0, xi1=moved(first[3], 2 * 3.141592653589793))) == ""


def test_every_quantity_is_held():
    certificate = read()[LABEL]
    assert said(replace(certificate, end=moved(certificate.end, -1e-6))).startswith("the end is")
    for quantity, bars in certificate.samples.items():
        samples = certificate.samples | {quantity: (*bars[:5], moved(bars[5], 1e-6), *bars[6:])}
        assert said(replace(certificate, samples=samples)).startswith(f"{quantity} at ")
    assert "the status lift_off, the motion" in said(replace(certificate, status="lift_off"))
    assert said(changed(0, after=Mode.REST)).startswith("the certificate has")
    fewer = replace(certificate, transitions=certificate.transitions[1:])
    assert f"the motion {len(certificate.transitions)} transitions" in said(fewer)


def test_a_contradicted_certificate_is_no_truth(monkeypatch):
    case = cases.load("disc_in_circle", mu=0.2)
    assert not tasks.find_truth(case).failure
    wrong = changed(0, time=moved(read()[LABEL].transitions[0][2], 1e-3))
    monkeypatch.setattr(tasks, "stored_or_new", lambda case, use_file: wrong)
    truth = tasks.find_truth(case)
    assert truth.transitions == () and truth.samples == {}
    assert truth.failure.startswith(f"{LABEL}: the time of transition 1 (to roll) is 0.63105376392")
    assert truth.failure.endswith(
        f'; neither is used; please report it with: python -m reference --only "{LABEL}" --out certificate.json'
    )
    monkeypatch.setattr(tasks, "in_catalogue", lambda case: False)
    assert tasks.find_truth(case).failure.endswith("neither is used; please report the scene")
