"""Which answers are kept, of which calls, and where calls are made: by a pool whose answers a test gives."""

import pytest

import cases
from adapters.processes.worker import CallResult
from reports.running import calls
from reports.running.calls import Calls, StorePolicy
from reports.running.storage.result_store import Store

LINE = cases.load("disc_on_line")
KEEP = StorePolicy()


def work(case: cases.Case, solver: str, how: str) -> str:
    """Stands for what is called: the pool answers in its place."""
    return how


class Pool:
    """Answers as they are given by the last argument of a call; `made` are the calls, the last one answered first."""

    def __init__(self, answers):
        self.answers, self.made, self.limits = answers, [], []

    def run(self, function, arguments, limit, skip, groups, brief):
        self.limits.append(limit)
        self.groups = groups
        for i in reversed(range(len(arguments))):
            given = skip(i)
            if given is None:
                self.made.append(arguments[i][-1])
                given = self.answers.get(arguments[i][-1]) or CallResult("done", value=arguments[i][-1])
            yield i, given


ANSWERS = {
    "late": CallResult("timed_out", reason="late"),
    "dies": CallResult("died", reason="of itself"),
    "ended": CallResult("died", reason="from outside", lasting=False),
    "raises": CallResult("raised", reason="an error"),
}


@pytest.fixture
def made(tmp_path):
    """made(hows, …) -> answers and pool, by the same store each time."""

    def make(*hows, keep: StorePolicy | None = KEEP, limit=None, **how):
        pool = Pool(ANSWERS)
        asked = Calls(1, 60.0, store=Store(tmp_path), versions={"reference": "1"})
        asked._pool = pool
        found = asked.all("work", work, [(LINE, "reference", h) for h in hows], keep=keep, limit=limit, **how)
        return found, pool, asked

    return make


@pytest.mark.parametrize(
    "how, keep, again",
    [
        ("a", StorePolicy(), False),
        ("late", StorePolicy(), False),
        ("dies", StorePolicy(), False),
        ("ended", StorePolicy(), True),  # it comes out otherwise another time
        ("raises", StorePolicy(), True),
        ("late", StorePolicy(failures=False), True),
        ("dies", StorePolicy(failures=False), True),
        ("a", StorePolicy(worth=lambda value: value != "a"), True),
        ("a", None, True),
    ],
)
def test_what_is_made_again(how, keep, again, made):
    first, _, _ = made(how, keep=keep)
    second, pool, _ = made(how, keep=keep)
    assert pool.made == [how] * again
    assert (second[0].outcome, second[0].reason) == (first[0].outcome, first[0].reason)
    assert not keep or first[0].when.startswith("20")


def test_a_failure_stands_for_its_own_limit_and_an_answer_for_all(made):
    for limit, again in ((1.0, ["a", "late"]), (1.0, []), (2.0, ["late"]), (None, ["late"]), (60.0, [])):
        _, pool, _ = made("late", "a", limit=limit)
        assert sorted(pool.made) == again and (not again or pool.limits == [60.0 if limit is None else limit])


def test_calls_that_ran_out_of_time_before_are_told_to_who_skips(made):
    slow_seen = []

    def skip(call, slow):
        slow_seen.append([other[-1] for other in slow])
        return None

    made("late")
    made("late", "a", skip=skip)
    assert slow_seen == [["late"]]


def test_code_function_and_arguments_decide(made, monkeypatch):
    made("a")
    assert made("a")[1].made == []
    with monkeypatch.context() as patch:
        patch.setattr(calls, "sources", lambda module, apart: "other code")
        assert made("a")[1].made == ["a"]
    with monkeypatch.context() as patch:
        patch.setattr(work, "__qualname__", "other_work")
        assert made("a")[1].made == ["a"]
    assert made("b")[1].made == ["b"]


class Cluster:
    def __init__(self):
        self.pool = Pool({})
        self.run = self.pool.run


@pytest.mark.parametrize(
    "kind, there", [("truth", True), ("run", True), ("trial", True), ("timing", False), ("", False)]
)
def test_a_cluster_makes_what_does_not_depend_on_the_machine(kind, there):
    asked = Calls(2, versions={"reference": "1"}, cluster=Cluster())
    asked._pool = Pool({})
    asked.all("work", work, [(LINE, "reference", "a")], keep=StorePolicy(kind) if kind else None)
    assert (asked.cluster.pool.made == ["a"]) == there and (asked._pool.made == ["a"]) == (not there)
