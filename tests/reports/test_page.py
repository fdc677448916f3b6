"""What the page is made of: the answer table, motions for the player, vendored libraries."""

from __future__ import annotations

import hashlib
import re
import zlib
from base64 import b64decode
from dataclasses import replace

import numpy as np
import pandas as pd

import cases
from cases import Mode, Transition
from reports.page import chapters, motions, vendor
from reports.page.fragments import table, verbatim
from reports.running.records import Experiment, Truth

ROLLS = Truth(method="taylor", transitions=(Transition(0.5, Mode.SLIP_FORWARD, Mode.ROLL),), error_bars=(1e-15,))


def unpacked(text: str) -> np.ndarray:
    data = np.frombuffer(zlib.decompress(b64decode(text)), np.uint8)
    return np.ascontiguousarray(data.reshape(4, -1).T).view("<f4").ravel()


def test_numbers_travel_with_five_digits_times_with_seven_and_differences_with_three():
    values = np.concatenate(
        [[0.0, -0.0, np.nan], np.random.default_rng(1).normal(size=500) * 10.0 ** np.arange(-250, 250)]
    )
    values = values[np.isnan(values) | (abs(values) < 3e38)]
    for bits, bound in ((16, 2.0**-16), (23, 2.0**-23), (10, 2.0**-10)):
        found = unpacked(motions.pack(values, bits))
        sound = abs(values) > 1e-37  # smaller ones have fewer digits in 32 bits
        assert np.all(abs(found[sound] - values[sound]) <= bound * abs(values[sound]))
        assert np.array_equal(np.isnan(found), np.isnan(values))


def test_samples_of_a_motion_hold_its_transitions():
    case = cases.load("disc_in_circle[mu=0.2]")
    t = np.linspace(0.0, 2.5, 1500)
    samples = {"t": t, **{name: np.sin(t) for name in motions.TRUE}}
    truth = replace(ROLLS, samples=samples, first_mode=Mode.SLIP_FORWARD)
    said = motions.motion(Experiment((case,), {case.label: truth}, (), 0.0), case)
    times = unpacked(said["t"])
    assert len(times) == motions.SAMPLES and np.float32(0.5) in times
    assert said["modes"] == [(0.0, "slip_forward", ""), (0.5, "roll", "")]
    assert np.allclose(unpacked(said["truth"]).reshape(len(motions.TRUE), -1)[0], np.sin(times), atol=2e-5)
    assert motions.motion(Experiment((case,), {case.label: Truth(failure="none")}, (), 0.0), case) is None


def test_cases_stand_in_the_families_of_the_catalogue():
    assert motions.family(cases.load("bouncing_disc")) == "Bounces and flights"
    assert motions.family(replace(cases.load("bouncing_disc"), name="mine")) == "Your own"


def test_libraries_are_the_files_that_were_fetched_each_with_its_licence():
    packages = vendor.libraries()
    assert {one["package"] for one in packages} == {"uplot", "datatables.net"}
    for one in packages:
        assert one["licence"] == "MIT" and any(name.endswith("LICENSE") for name in one["files"])
        for name, digest in one["files"].items():
            assert hashlib.sha256((vendor.FOLDER / name).read_bytes()).hexdigest() == digest, name


def test_numbers_stand_as_people_write_them_and_are_sorted_as_numbers():
    assert [verbatim(text) for text in ("1.1e-07", "-3.0e+05", "0.0e+00", "2.5e-12")] == [
        "1.1e-7",
        "-3.0e5",
        "0",
        "2.5e-12",
    ]
    frame = pd.DataFrame({"solver": ["pymunk"], "route": ["native"], "error": [1.23456789e-07], "steps": [1712.5]})
    (row,) = table(frame, {"error": "error", "steps": "steps"})["rows"]
    assert row["solver"], row["route"] == ("pymunk", "native")
    assert row["cells"][0] == {"text": "1.2e-7", "kind": "number", "order": None}
    assert row["cells"][1] == {"text": "1,700", "kind": "number", "order": "1712.5"}


def test_no_two_cases_have_the_same_anchor():
    labels = ["a[slope=+0.3]", "a[slope==0.3]", "a[slope=0.3]", "a", "a_b", "a-b", "a[b]", "a[b"]
    labels += [case.label for name in cases.names() for case in cases.select(name)]
    anchors = [chapters.anchor(label) for label in labels]
    assert len(set(anchors)) == len(labels) and all(re.fullmatch(r"case-[\w-]+", anchor) for anchor in anchors)
