"""What the page is made of: the answer table, motions for the player, vendored libraries."""

from __future__ import annotations

import hashlib
import json
import math
import re
import zlib
from base64 import b85decode
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cases
from adapters import Setting
from cases import Mode, Transition
from reference.proofs.record import DecimalInterval
from reports.analysis import verdict
from reports.analysis.columns import Table
from reports.page import chapters, evidence, html, motions, vendor
from reports.page.case_matrix import matrix
from reports.page.engine_rows import engine_rows
from reports.page.fragments import anchor, short_percent
from reports.page.table_files import Tables, with_short_numbers, write
from reports.running.records import Experiment, Truth
from tests.judging.test_verdict import experiment, run

CASE = cases.load("disc_on_line", mu=0.1)
ROLLS = Truth(method="taylor", transitions=(Transition(0.5, Mode.SLIP_FORWARD, Mode.ROLL),), error_bars=(1e-15,))


def decode(planes: bytes, rest: int) -> np.ndarray:
    """The numbers of an array, as `numbers` of state.js reads them."""
    bytes_ = np.frombuffer(planes, np.uint8).reshape(4, -1)
    zigzag = np.ascontiguousarray(bytes_.T).view("<u4").ravel().astype(np.int64)
    changes = (zigzag >> 1) ^ -(zigzag & 1)
    codes = np.cumsum(np.cumsum(changes)).astype("<i4").astype(np.int64)
    words = (abs(codes) << rest) | np.where(codes < 0, 0x80000000, 0)
    return words.astype("<u4").view("<f4")


def test_numbers_travel_with_the_digits_that_are_asked_for():
    values = np.concatenate(
        [[0.0, -0.0, np.nan], np.random.default_rng(1).normal(size=500) * 10.0 ** np.arange(-250, 250)]
    )
    values = values[np.isnan(values) | (abs(values) < 3e38)]
    for bits in (8, 13, 16, 23):
        found = decode(motions.encode(values, bits), 23 - bits)
        sound = abs(values) > 1e-37  # smaller ones have fewer digits in 32 bits
        assert np.all(abs(found[sound] - values[sound]) <= 2.0**-bits * abs(values[sound]))
        assert np.array_equal(np.isnan(found), np.isnan(values))


def test_a_motion_in_the_page_has_its_facts_and_its_arrays():
    numbers = motions.Numbers
    facts = {"label": "a<b", "t": numbers(np.arange(3.0), 23), "runs": [{"off": numbers(np.ones(2), 8)}]}
    script = motions.script(facts)
    assert "<" not in script
    said, heads, planes = zlib.decompress(b85decode(script.replace(",", "<"))).split(b"\0", 2)
    assert json.loads(said) == {"label": "a<b", "t": 0, "runs": [{"off": 1}]} and json.loads(heads) == [[3, 0], [2, 15]]
    assert decode(planes[:12], 0).tolist() == [0.0, 1.0, 2.0] and decode(planes[12:], 15).tolist() == [1.0, 1.0]


def test_the_pages_copy_of_a_file_has_its_cells_and_times_have_all_digits(tmp_path):
    frame = pd.DataFrame({"time": [1 / 3, 2.0], "error": [1 / 3, -1.2345678901e-7], "reason": ['a "b", c', "0.1"]})
    words = Table("t", dict.fromkeys(frame.columns, "a text"))
    write(Tables({"one": frame, "none": frame.head(0)}, {"one": words, "none": words}), tmp_path, "make it")
    columns = [c.split("\x1f") for c in _read(html._columns(tmp_path / "one.csv")).split("\x1e")]
    assert columns[0] == ["time", repr(1 / 3), "2.0"] and columns[2] == ["reason", 'a "b", c', "0.1"]
    assert columns[1] == ["error", "0.333333333", "-1.23456789e-07"]
    assert _read(html._columns(tmp_path / "none.csv")) == "time\x1eerror\x1ereason"


def _read(text: str) -> str:
    return zlib.decompress(b85decode(text.replace(",", "<"))).decode()


def test_samples_of_a_motion_hold_its_transitions():
    case = cases.load("disc_in_circle[mu=0.2]")
    t = np.linspace(0.0, 2.5, 1500)
    samples = {"t": t, **{name: np.sin(t) for name in motions.TRUE}}
    truth = replace(ROLLS, samples=samples, first_mode=Mode.SLIP_FORWARD)
    said = motions.motion(Experiment((case,), {case.label: truth}, ()), case)
    times = said["t"].values
    assert len(times) == motions.SAMPLES and 0.5 in times
    assert said["lanes"] == [("", [(0.0, "slip_forward", ""), (0.5, "roll", "")])]
    pose, forces = (numbers.values for numbers in said["truth"])
    assert len(pose) + len(forces) == len(motions.TRUE) and np.allclose(pose[0], np.sin(times), atol=2e-5)
    assert motions.motion(Experiment((case,), {case.label: Truth(failure="none")}, ()), case) is None


def test_the_player_has_the_supports_and_the_contacts_on_them():
    """The walls were missing, and their contacts stood on the track."""
    case = cases.load("disc_between_hills")
    t = np.linspace(0.0, 0.5, 11)
    samples = {"t": t, **{name: np.zeros(11) for name in motions.TRUE}, "y": np.ones(11)}
    of_contact = {"t": t, **{name: np.zeros(11) for name in motions.OF_CONTACT}}
    names = ("plate/track", "plate/track 2", "plate/right", "plate/another")
    truth = replace(
        ROLLS, samples=samples, first_mode=Mode.SLIP_FORWARD, contact_samples=dict.fromkeys(names, of_contact)
    )
    said = motions.motion(Experiment((case,), {case.label: truth}, ()), case)
    assert [one["name"] for one in said["contacts"]] == list(names[:3])
    (right,) = said["supports"]
    x, y = right["points"].values
    assert right["name"] == "right" and right["period"] and right["high"] - right["low"] == pytest.approx(2 * np.pi)
    assert np.hypot(x - 1.5 * np.sin(0.3 * np.pi), y) == pytest.approx(1.0, abs=1e-9)


def test_the_player_has_the_modes_of_each_contact_and_a_plate_that_does_not_turn_sticks():
    t = np.linspace(0.0, 1.0, 11)
    one = replace(ROLLS, samples={"t": t, "theta": np.minimum(t, 0.5)}, first_mode=Mode.SLIP_FORWARD)
    assert motions._lanes(one) == [("", [(0.0, "slip_forward", ""), (0.5, "stick", "")])]
    turning = replace(one, samples={"t": t, "theta": t})
    assert motions._lanes(turning)[0][1][1][1] == "roll"
    phases = {name: SimpleNamespace(phases=(SimpleNamespace(mode=mode),))
              for name, mode in (("plate/track", Mode.ROLL), ("upper/plate", Mode.FLIGHT))}  # fmt: skip
    events = (Transition(0.3, Mode.ROLL, Mode.SLIP_BACKWARD, contact="plate/track"),)
    several = replace(turning, scales=phases, transitions=events)
    assert motions._lanes(several) == [
        ("plate/track", [(0.0, "roll", ""), (0.3, "slip_backward", "")]), ("upper/plate", [(0.0, "flight", "")]),
    ]  # fmt: skip


def test_libraries_are_the_files_that_were_fetched_each_with_its_licence():
    packages = vendor.libraries()
    assert {one["package"] for one in packages} == {"uplot", "datatables.net"}
    for one in packages:
        assert one["licence"] == "MIT" and any(name.endswith("LICENSE") for name in one["files"])
        for name, digest in one["files"].items():
            assert hashlib.sha256((vendor.FOLDER / name).read_bytes()).hexdigest() == digest, name


def test_failures_are_counted_once_for_each_reason_and_the_worst_unusable_run_is_named():
    def run(case, outcome, grade, reason, off=math.nan):
        names = {"case": case, "solver": "pymunk", "route": "native"}
        return names | {"outcome": outcome, "grade": grade, "reason": reason, "off": off}

    frame = pd.DataFrame(
        [
            run("a", "answered", "good", "fine", 0.005),
            run("a", "unsupported", "", "no springs"),
            run("b", "unsupported", "", "no springs"),
            run("b", "crashed", "", "SIGSEGV"),
            run("c", "answered", "unusable", "slip velocity: 60 %", 0.6),
            run("d", "answered", "unusable", "pose: 900 %", 9.0),
        ]
    )
    rows = [[cell.text for cell in row.cells] for row in chapters.failures(frame).rows]
    assert rows == [
        ["unusable", "pymunk native", "2", "c, d", "d: pose: 900 %"],
        ["crashed", "pymunk native", "1", "b", "SIGSEGV"],
        ["unsupported", "pymunk native", "2", "a, b", "no springs"],
    ]


@pytest.mark.parametrize(
    "off, text",
    [(2.78, "278"), (0.31, "31"), (0.0995, "10"), (0.021, "2.1"), (0.00995, "1.0"), (0.0027, ".27"), (5.1e-5, ".01"),
     (4.9e-5, "<.01"), (0.0, "<.01"), (44.58, "4,458")],
)  # fmt: skip
def test_off_in_a_cell_has_two_digits_at_least(off, text):
    assert short_percent(off) == text


def test_an_enclosure_is_its_two_ends_with_their_common_digits_once():
    for low, high, text in (
        ("0.6307", "0.6308", "0.630[7, 8]"),
        ("2.1", "2.12", "2.[1, 12]"),
        ("0.749", "0.75", "0.7[49, 5]"),
    ):
        shown = evidence.enclosure(DecimalInterval(low, high))
        assert shown == text
        common, ends = shown[:-1].split("[")
        assert [common + end for end in ends.split(", ")] == [low, high]


def test_no_two_cases_have_the_same_anchor():
    labels = ["a[slope=+0.3]", "a[slope==0.3]", "a[slope=0.3]", "a", "a_b", "a-b", "a[b]", "a[b"]
    labels += [case.label for name in cases.names() for case in cases.select(name)]
    anchors = [anchor(label) for label in labels]
    assert len(set(anchors)) == len(labels) and all(re.fullmatch(r"case-[\w-]+", anchor) for anchor in anchors)


def test_the_table_of_all_cases_has_two_cells_for_each_route_and_why_there_is_no_motion():
    results = experiment(
        run("a", "one", "native", 0.46, Setting.of(rung="defaults")), run("a", "one", "native", 1e-3),
        replace(run("b", "one", "native", 0.1), outcome="crashed", score=None, reason="SIGSEGV"),
    )  # fmt: skip
    results = replace(results, cases=tuple(replace(CASE, name=name, parameters={}) for name in "ab"))
    data = matrix(results, [("one", "native")])
    rows = {row.cells[1].text.removesuffix("*"): row.cells[3:] for row in data.rows}
    assert [(head.solver, head.route) for head in data.heads[3:]] == 2 * [("one", "native")]
    default, finest = rows["a"]
    assert (default.text, default.order, finest.text) == ("46", "0.46", ".10")
    assert default.tip.startswith("46 % ± ")
    assert [cell.text for cell in rows["b"]] == ["–", "–"]
    assert rows["b"][1].tip == "crashed: SIGSEGV"
    assert all(cell.kind == "number none" and cell.order == "1e308" for cell in rows["b"])


@pytest.mark.parametrize(
    ("offs", "text"),
    [
        # Within 1 % by luck at the second rung, and from the fourth on.
        (
            (0.3, 0.005, 0.02, 0.008, 0.001),
            "one needs a step of 2 ms instead of 17 ms and 640 facets instead of 64 for 1 % ",
        ),
        ((0.3, 0.2, 0.1, 0.05, 0.02), "one does not come within 1 % with the settings tried."),
    ],
)
def test_what_to_change_for_one_percent_is_confirmed_by_all_finer_settings(offs, text):
    steps = [(10e-3, 64), (5e-3, 160), (4e-3, 320), (2e-3, 640), (1e-3, 1280)]
    ladder = [
        run("a", "one", "native", off, Setting.of(h=h, facets=n)) for off, (h, n) in zip(offs, steps, strict=True)
    ]
    usual = run("a", "one", "native", 0.46, Setting.of(rung="defaults", h=1 / 60, facets=64))
    results = experiment(usual, *ladder)
    (row,) = engine_rows(results, verdict.rows(results), verdict.scenes(results), [], "a")
    assert row["so"].startswith(text)
    assert row["cells"]["default settings"] == ("46 % off", "more than 10 % in 1 of 1 scenes")


@given(st.floats(1e-300, 1e300))
def test_an_error_bar_has_four_digits_and_is_never_smaller(bar):
    short = with_short_numbers(pd.DataFrame({"truth_error_bar": [bar]}))["truth_error_bar"][0]
    assert bar <= short == pytest.approx(bar, rel=1e-3)
    assert float(f"{short:.3e}") == short


def test_errors_keep_all_digits_and_other_values_stay():
    row = {"error": 1 / 3, "doubt": 1e-3, "floor_error": "a word", "reading_doubt": None, "off_doubt": 2 / 3}
    short = with_short_numbers(pd.DataFrame([row], dtype=object)).to_dict("records")
    assert short == [row]
