"""Adapters with side effects: what each does to its process while it builds a model, and what its row says."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from . import fake_adapter


class Effect(NamedTuple):
    """What is done, in Python, the outcome of the run, and a part of its row's reason."""

    code: str
    outcome: str = "answered"
    reason: str = ""


def _replaced(name: str, by: str = "lambda *given, **options: 0.0", fails: str = "") -> Effect:
    """A function or number, named in full, that is replaced by one that returns nothing useful. Its motion is judged in
    another process, as good as it is; `fails`: what the engine's own process says where it needs the function."""
    outcome, reason = ("crashed", fails) if fails else ("answered", "less than 0.0001 %")
    return Effect(f"import {name.rpartition('.')[0]}; {name} = {by}", outcome, reason)


WRONG = "import cases, dataclasses; case = dataclasses.replace(case, plate=cases.disc(0.13, 1.0))"
EFFECTS = {
    # Functions that motions are computed and judged with.
    "numpy_hypot": _replaced("numpy.hypot", fails="'float' object has no attribute"),
    "numpy_interp": _replaced("numpy.interp"),
    "numpy_solve": _replaced("numpy.linalg.solve"),
    "math_sin": _replaced("math.sin"),
    "math_pi": _replaced("math.pi", by="3.0"),
    "builtins_abs": _replaced("builtins.abs", fails="ZeroDivisionError"),
    "builtins_sorted": _replaced("builtins.sorted", by="lambda given, **options: list(given)"),
    "scipy_brentq": _replaced("scipy.optimize.brentq"),
    "scipy_solve_ivp": _replaced("scipy.integrate.solve_ivp"),
    "sympy_lambdify": _replaced("sympy.lambdify"),
    "mpmath_findroot": _replaced("mpmath.findroot"),
    "pickle_dumps": _replaced("pickle.dumps"),
    "process_time": _replaced("time.process_time"),
    "cases_load": _replaced("cases.load"),
    "case_mechanics": _replaced("cases.motion.mechanics.energy"),
    "reference_simulate": _replaced("reference.simulate"),
    "judging_transitions": _replaced("reports.judging.transitions.read_motion"),
    "judging_distances": _replaced("reports.judging.distances.differences"),
    "adapters_gate": _replaced("adapters.gate.motion", fails="'float' object has no attribute"),
    "limits_of_grades": Effect(
        "from reports.judging import grades; grades.LIMITS[grades.Grade.EXCELLENT] = 1e9",
        reason="less than 0.0001 %",
    ),
    "code_of_score": Effect(
        "from reports.judging import score; score.score_and_reading.__code__ = (lambda *given: None).__code__",
        reason="less than 0.0001 %",
    ),
    "track_speed": Effect("type(case.track).speed = lambda *given: 1.0", reason="less than 0.0001 %"),
    # A wrong motion; and the same where what judges it is replaced.
    "wrong": Effect(WRONG),
    "wrong_and_flattered": Effect(
        f"{WRONG}; from reports.judging import grades, score; grades.LIMITS[grades.Grade.EXCELLENT] = 1e9; "
        "score.score_and_reading.__code__ = (lambda *given: 1 / 0).__code__; "
        "import numpy; numpy.hypot = lambda *given: 0.0",
    ),
    # Settings of the process.
    "random_state": Effect("import random, numpy; random.seed(1); numpy.random.seed(1)"),
    "numpy_errors": Effect("import numpy; numpy.seterr(all='raise')"),
    "warnings_are_errors": Effect("import warnings; warnings.simplefilter('error')"),
    "decimal_context": Effect("import decimal; decimal.getcontext().prec = 2"),
    "recursion_limit": Effect("import sys; sys.setrecursionlimit(100)"),
    "locale": Effect("import locale; locale.setlocale(locale.LC_ALL, 'C.UTF-8')"),
    "working_folder": Effect("import os; os.chdir('/')"),
    "environment": Effect("import os; os.environ.clear()"),
    "umask": Effect("import os; os.umask(0o777)"),
    "rounding": Effect("import ctypes; ctypes.CDLL('libm.so.6').fesetround(0x800)"),
    "garbage": Effect("import gc; gc.disable(); gc.set_threshold(1)"),
    "logging": Effect("import logging; logging.disable(); logging.basicConfig(level=1, force=True)"),
    "trace": Effect("import sys; sys.settrace(lambda *given: None); sys.setprofile(lambda *given: None)"),
    "switch_interval": Effect("import sys; sys.setswitchinterval(1e-6)"),
    # Imports.
    "search_path": Effect("import sys; sys.path.clear(); sys.path_hooks.clear()"),
    "import_hook": Effect(
        "import sys; sys.meta_path.insert(0, type('Hook', (), {'find_spec': lambda *given: 1 / 0})())"
    ),
    "modules": Effect("import sys; sys.modules.update({'scipy': None, 'json': None})"),
    # Signals and limits.
    "ignores_signals": Effect(
        "import signal; [signal.signal(n, signal.SIG_IGN) for n in (signal.SIGTERM, signal.SIGINT, signal.SIGCHLD)]"
    ),
    "blocks_signals": Effect("import signal; signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())"),
    "alarm": Effect(
        "import signal, time; signal.setitimer(signal.ITIMER_REAL, 0.05); time.sleep(5)", "crashed", "SIGALRM"
    ),
    "limit_of_memory": Effect(
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (1, 1)); bytearray(2**28)", "crashed", "MemoryError"
    ),
    "limit_of_files": Effect(
        "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0)); open('/dev/null')",
        "crashed", "open files",
    ),
    "limit_of_time": Effect(
        "import resource, itertools; resource.setrlimit(resource.RLIMIT_CPU, (1, 1)); sum(itertools.repeat(0))",
        "crashed", "ended by signal",
    ),
    # Files, streams, threads and processes.
    "removes_its_folder": Effect("import os, shutil; shutil.rmtree(os.getcwd())"),
    "closes_streams": Effect("import os, sys; sys.stdout.close(); sys.stderr = None; os.close(0)"),
    "thread": Effect("import threading, time; threading.Thread(target=time.sleep, args=(60,)).start()"),
    "child": Effect("import subprocess; subprocess.Popen(['sleep', '600'], start_new_session=True)"),
    "fork": Effect("import os; os.fork()"),
    "at_exit": Effect("import atexit, os; atexit.register(os._exit, 9)"),
    "exits": Effect("import sys; sys.exit('had enough')", "crashed", "had enough"),
    "vanishes": Effect("import os; os._exit(3)", "crashed", "exit code 3"),
}  # fmt: skip

_BUILD = """


def build(case, route, setting):
    {code}
    return case, setting["how"]
"""


def install(folder: Path, name: str) -> None:
    """Put the adapter of an effect into the folder, as an installed package would bring it."""
    fake_adapter.install(folder, ["wait 0", "wait 1"], name=name)
    with (folder / f"{name}_adapter_of_tests.py").open("a") as file:
        file.write(_BUILD.format(code=EFFECTS[name].code))
