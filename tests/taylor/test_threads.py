"""Threads: whatever several of them ask for at once is what one alone gets, to the last bit."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

import cases
from tests.scenes import bits

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


# --- what threads share, part by part ---------------------------------------------------------------------------------


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
