"""A refusal says which of two it is: the engine cannot, by a documented limit, or its adapter does not yet."""

from __future__ import annotations

import pickle
from types import SimpleNamespace

import pytest

import cases
from adapters import Refusal, refusal, refusal_kind
from adapters.lookup import engine
from cases import NotSupported
from reports.running import tasks

CANNOT, NOT_YET = "the engine cannot: ", "the adapter does not yet"


@pytest.mark.parametrize(
    ("name", "route", "label", "limit"),
    [
        ("exudyn", "native", "disc_rolling_to_rest", "no such parameter"),
        ("exudyn", "native", "slider_on_belt", "dynamicFriction"),
        ("exudyn", "native", "slider_on_belt_falling_law", "StribeckFunction"),
        ("exudyn", "native", "guided_loop", ""),
        ("exudyn", "native", "disc_in_cosine", ""),
        ("exudyn", "native", "half_disc_rocking", ""),
        ("pymunk", "native", "slider_on_belt", "Shape.friction"),
        ("pymunk", "native", "guided_loop", ""),
        ("pymunk", "assisted", "sliding_box", ""),
        ("box2d", "native", "slider_on_belt", "friction is one number"),
        ("pybullet", "assisted", "slider_on_belt", ""),
    ],
)
def test_a_refusal_names_the_engine_s_limit_or_its_adapter(name, route, label, limit):
    pytest.importorskip({"box2d": "pyb2d3"}.get(name, name))
    case = next(case for case in cases.select(label) if refusal(engine(name), case, route))
    reason = refusal(engine(name), case, route)
    assert reason and reason.endswith(".") and ". " not in reason
    kind = refusal_kind(reason)
    assert kind.startswith(CANNOT) and limit in kind if limit else kind == NOT_YET


def test_every_refusal_of_the_catalogue_is_one_sentence():
    for name in ("exudyn", "pymunk"):
        adapter = engine(name)
        for case in (one for label in cases.names() for one in cases.select(label)):
            for route in adapter.routes:
                reason = refusal(adapter, case, route)
                assert reason is None or (reason.endswith(".") and ". " not in reason), (case.label, route, reason)


def test_the_kind_reaches_the_report_s_rows_from_an_adapter_and_from_a_program(monkeypatch):
    reason = Refusal("It has no belts.", "manual, belts")
    assert pickle.loads(pickle.dumps(reason)).limit == "manual, belts"
    (offer,) = tasks.survey(cases.load("disc_rolling_to_rest"), "pymunk")[:1]
    assert (offer.outcome, offer.refusal) == ("unsupported", "the engine cannot: no such attribute of pymunk.Shape")

    def run(model):
        raise NotSupported(reason, reason.limit)

    program = SimpleNamespace(
        NAME="mine", routes=("process",), build=lambda *_: None, run=run, read=None, refuses=lambda *_: None
    )
    monkeypatch.setattr(tasks, "solver", lambda name: program)
    row = tasks.Run("case", "mine", "process", tasks.Setting.of(), 1, outcome="")
    row = tasks.attempt(row, cases.load("disc_in_circle"), lambda row, motion: row)
    assert (row.outcome, row.reason, row.refusal) == ("unsupported", str(reason), "the engine cannot: manual, belts")
