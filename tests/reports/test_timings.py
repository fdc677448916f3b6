"""The timed pass: every time belongs to the contestant it was measured of, whatever the order and wherever from."""

from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cases
from adapters import Setting
from reports.running import clock, cold, parts, timings
from reports.running.calls import Calls
from reports.running.clock import Contestant
from reports.running.store import Store

from .watch import Here, Watch

LINE = cases.load("disc_on_line", mu=0.1)
VERSIONS = {"pymunk": "7.2.0", "exudyn": "1.9.0", "reference": "0.1.0"}
# How many times as long as the cheapest each takes: no two contestants may be confused without a difference.
COSTS = {"reference": 1, "pymunk": 2, "exudyn": 4}
WHO = [
    Contestant(case, name, route, Setting.of(cost=cost * (1.0 if route == "native" else 1.25) * (1 + place)), 0.01)
    for place, case in enumerate((LINE, cases.load("disc_on_line", mu=0.2)))
    for name, cost in COSTS.items()
    for route in ("native", "assisted")
]
BUILD, RUN, READ = 0.04, 0.02, 0.01


@pytest.fixture
def engines(monkeypatch) -> Watch:
    """Engines of known cost at a clock that only they move on, in this process."""
    watch = Watch()
    engine = watch.engine(BUILD, RUN, READ)
    for module in (clock, cold, parts):
        monkeypatch.setattr(module, "time", watch)
        monkeypatch.setattr(module, "solver", lambda name: engine)
    for module in (clock, cold):
        monkeypatch.setattr(module, "calibrate", lambda: 1e-3)
    monkeypatch.setattr(clock, "neighbours", lambda: False)
    monkeypatch.setattr(cold, "_apart", lambda function, argument: function(argument))
    return watch


def calls(folder) -> Calls:
    made = Calls(1, store=Store(folder), versions=VERSIONS)
    made._pool = Here()
    return made


@pytest.mark.parametrize("measured", ["timings", "cold starts"])
def test_each_time_is_its_contestant_s_in_every_order_and_from_the_store(measured, engines, tmp_path):
    """As after `--solver pymunk exudyn reference` on the store of a default build."""

    @given(st.permutations(WHO))
    def holds(who):
        made = calls(tmp_path)
        if measured == "timings":
            found, failed = timings.time_together(who, 10.0, 10.0, made)
            assert not failed and [one for one, _ in found] == list(who)
            took = {one: (t.setup_s, t.cpu_s, t.read_s) for one, t in found}
        else:
            found = timings._measured(partial(timings._cold_starts, made), who, 10.0)
            took = {one: (c.build_s, c.run_s, c.read_s) for one in who for c in [found[one.key]]}
        for one, seconds in took.items():
            cost = one.setting["cost"]
            assert seconds == pytest.approx((BUILD * cost, RUN * cost, READ * cost), rel=1e-3)
        pools.append(made._pool)

    pools: list[Here] = []
    holds()
    # The first made them, and the others took them from the store: else their order would prove nothing.
    assert [len(pool.made) for pool in pools] == [1, *[0] * (len(pools) - 1)] and len(pools) > 10
