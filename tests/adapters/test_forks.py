"""An engine that forks and lets both processes come back does not multiply what calls it."""

import subprocess
import sys

# Were the copies to come back, each call would double them, so that this is a program of its own with few calls.
PROGRAM = """
import os, sys
from adapters.interface import ReturnsOnce, returns_once

class Engine:
    NAME = "forks"

    def run(self, model):
        os.fork()
        if model == "raises":
            raise RuntimeError(model)
        return model

adapter = ReturnsOnce(Engine())
assert adapter.NAME == "forks" and not hasattr(adapter, "bare_run")
for word in ("one", "two", "three"):
    os.write(1, f"{adapter.run(word)}\\n".encode())
for call in (adapter.run, returns_once(Engine().run)):
    try:
        call("raises")
    except RuntimeError as problem:
        os.write(1, f"{problem}\\n".encode())
while True:
    try:
        os.wait()
    except ChildProcessError:
        break
"""


def test_a_call_comes_back_in_the_process_that_made_it_and_in_no_other():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=60.0)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == ["one", "two", "three", "raises", "raises"]
