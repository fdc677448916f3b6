"""Threads: whatever several of them ask for at once is what one alone gets, to the last bit."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest

import cases
import reference
from cases import Load, State, Trajectory
from cases.formulas import features
from reference.minimal.integrators.taylor import IntegratorPool
from reference.solve import METHODS
from tests.reference.test_sweep import FAMILIES as SWEPT
from tests.scenes import bits

pytestmark = pytest.mark.taylor

# One of each kind of motion: slip and roll, an outline that is no disc, flight and impacts, rest, a load in time.
FAMILIES = ["disc_in_circle[mu=0.2]", "ellipse_in_circle", "bouncing_disc", "disc_rolling_to_rest", "driven_disc"]
THREADS = 4


@pytest.fixture(autouse=True)
def _switching():
    """Threads that take turns five hundred times as often as usual."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)


def in_threads(asked: Sequence[Callable[[], str]], rounds: int) -> list[list[str]]:
    """The answers to each question, which all threads ask so many times, each in an order of its own."""

    def work(seed: int) -> list[tuple[int, str]]:
        order = [*range(len(asked))] * rounds
        random.Random(seed).shuffle(order)
        return [(i, asked[i]()) for i in order]

    with ThreadPoolExecutor(THREADS) as pool:
        output = [pair for some in pool.map(work, range(THREADS)) for pair in some]
    return [[answer for i, answer in output if i == number] for number in range(len(asked))]


def same_in_threads(asked: Sequence[Callable[[], str]], rounds: int) -> None:
    alone = [question() for question in asked]
    for one, answers in zip(alone, in_threads(asked, rounds), strict=True):
        assert set(answers) == {one}


def test_motions_are_the_same_in_threads():
    # One thread in five hundred changes sides at a bad moment: 6 of 60 motions were wrong, 8 of 240 in another run. The
    # slow test has many more.
    same_in_threads([partial(bits.of_case, cases.load(label)) for label in FAMILIES], rounds=3)


@pytest.mark.slow
def test_samples_read_in_one_thread_while_another_simulates():
    chosen = [cases.load("disc_in_circle", mu=mu) for mu in (0.01, 0.1, 0.2)]
    alone = [bits.of_case(case) for case in chosen]
    motions = [[reference.simulate(case) for _ in range(15)] for case in chosen]
    stop = threading.Event()

    def simulate() -> None:
        while not stop.is_set():
            for case in chosen:
                reference.simulate(case)

    busy = threading.Thread(target=simulate)
    busy.start()
    try:
        read = [[bits.of_motion(motion) for motion in some] for some in motions]
    finally:
        stop.set()
        busy.join()
    for one, answers in zip(alone, read, strict=True):
        assert set(answers) == {one}


@pytest.mark.slow
def test_certificates_and_sweeps_are_the_same_in_threads():
    certificates = [partial(bits.of_certificate, "disc_on_line[mu=0.1]")]
    sweeps = [partial(bits.of_sweep, name, SWEPT[name]) for name in ("disc_in_circle", "disc_on_spring")]
    same_in_threads([*certificates, *sweeps], rounds=1)


@pytest.mark.slow
def test_threads_that_derive_everything_at_once(tmp_path):
    # Alone in a fresh process, where nothing is derived yet and nothing is taken from disk.
    labels = ["driven_disc"]
    program = (
        "import json, sys, threading\n"
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from tests.scenes import bits\n"
        "labels = json.loads(sys.argv[1])\n"
        "sys.setswitchinterval(1e-5)\n"
        "at_once = threading.Barrier(4)\n"
        "def work(i):\n"
        "    at_once.wait()\n"
        "    return [(label, bits.of_label(label)) for label in labels]\n"
        "with ThreadPoolExecutor(4) as pool:\n"
        "    print(json.dumps([pair for some in pool.map(work, range(4)) for pair in some]))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, json.dumps(labels)],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    alone = {label: bits.of_label(label) for label in labels}
    assert [label for label, answer in json.loads(run.stdout) if answer != alone[label]] == []


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_the_whole_catalogue_is_the_same_in_threads(method):
    chosen = [case for name in cases.names() for case in cases.select(name)]
    same_in_threads([partial(bits.of_case, case, method) for case in chosen], rounds=8 if method == "taylor" else 1)


# --- what threads share, part by part ---------------------------------------------------------------------------------


def test_an_integrator_is_in_one_use_at_a_time():
    pool, inside, most = IntegratorPool(lambda: [0]), [], []

    def use(integrator) -> None:
        inside.append(id(integrator))
        now = list(inside)  # other threads come and go between two looks at the list
        most.append(len(now))
        assert len(set(now)) == len(now)
        inside.remove(id(integrator))

    with ThreadPoolExecutor(THREADS) as threads:
        list(threads.map(lambda _: pool.call(use), range(2000)))
    pool.call(lambda one: pool.call(lambda other: one is not other or pytest.fail("it is in use")))
    assert pool.call(id) == pool.call(id)  # alone, the same one again


def test_an_integrator_comes_back_after_an_error():
    pool = IntegratorPool(lambda: [0])
    with pytest.raises(ZeroDivisionError):
        pool.call(lambda integrator: 1 / 0)
    assert pool.call(lambda one: one) is pool.call(lambda one: one)


def test_two_threads_resolve_one_load():
    def clear(seed: int) -> list[float]:
        # Windows of a load that only a step far out needs, asked for by all threads at once.
        return [load.features.clear(t, t + 50.0) for t in np.arange(0.0, 1000.0, 50.0)]

    for _ in range(5):
        load = Load(fx="exp(-((t-500)/0.01)**2)")
        alone = clear(0)
        load = Load(fx="exp(-((t-500)/0.01)**2)")
        assert load.features is not None
        with ThreadPoolExecutor(THREADS) as pool:
            assert all(found == alone for found in pool.map(clear, range(THREADS)))
        windows = load.features._sides[True]
        assert all(one.high == other.low for one, other in zip(windows, windows[1:], strict=False))
    assert isinstance(load.features, features.Features)


def test_two_threads_ask_one_motion_for_its_samples():
    whole = reference.simulate(cases.load("disc_in_circle"))

    def samples() -> tuple[np.ndarray, State]:
        time.sleep(0.01)  # all threads ask before the first has an answer
        return whole.t.copy(), State(*(getattr(whole, name).copy() for name in State._fields))

    motion = Trajectory.on_demand(samples)
    with ThreadPoolExecutor(THREADS) as pool:
        found = list(pool.map(lambda name: getattr(motion, name), State._fields))
    for name, column in zip(State._fields, found, strict=True):
        assert column is getattr(motion, name)  # who changes one in place sees it changed
        assert np.array_equal(column, getattr(whole, name), equal_nan=True)
    assert not hasattr(motion, "nothing")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_copy_of_the_process_can_derive_while_another_thread_did():
    # In a process of its own: a copy of one with many threads may hang for reasons of others.
    program = (
        "import os, threading, cases\n"
        "from cases.derivation import LOCK\n"
        "inside, stop = threading.Event(), threading.Event()\n"
        "def derive():\n"
        "    while not stop.is_set():\n"
        "        with LOCK:\n"
        "            inside.set()\n"
        "            stop.wait(0.01)\n"
        "other = threading.Thread(target=derive, daemon=True)\n"
        "other.start()\n"
        "inside.wait()\n"
        "copy = os.fork()\n"
        "if not copy:\n"
        "    cases.load('disc_in_circle', R=0.777)\n"
        "    os._exit(0)\n"
        "stop.set()\n"
        "raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1]))\n"
    )
    assert subprocess.run([sys.executable, "-W", "ignore", "-c", program], timeout=60).returncode == 0
