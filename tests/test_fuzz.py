"""Bad input: whatever is typed is either run or refused by a typed error in one sentence."""

import contextlib
import io
import re
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from math import inf, nan, pi

import numpy as np
import pytest
import sympy as sp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import cases
import reference
from cases import (
    Case,
    CaseError,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    commands,
    disc,
    library,
    registry,
)
from reports import build, compare, study
from tests.reference.test_atlas import within

# What people, files and programs put where a number belongs; some of it is one.
ODD = (
    None,
    True,
    False,
    nan,
    inf,
    -inf,
    0,
    0.0,
    -0.0,
    -1,
    1,
    0.3,
    1e308,
    -1e308,
    5e-324,
    1e-300,
    10**400,
    "",
    "0.3",
    "abc",
    "nan",
    b"0.3",
    [],
    [1.0],
    {},
    (1.0, 2.0),
    set(),
    np.array([]),
    np.array([1.0]),
    np.array([[1.0, 2.0]]),
    np.float32(0.3),
    np.float64(nan),
    np.int64(2),
    1j,
    Decimal("0.3"),
    Fraction(1, 3),
    sp.Symbol("s"),
    sp.pi,
    sp.nan,
    object(),
    int,
    len,
    lambda s: s,
    float("1e-17"),
    "a" * 1000,
    "été",
    "1;2",
    "\n",
    2**63,
)
odd = st.sampled_from(ODD)

CIRCLE, DISC = library.circle(1.0), disc(0.1, 1.0)
ONE_SENTENCE = 600  # characters: a sentence with the longest list of names in it

# Whatever is made by a call, with a right value for each argument.
MAKERS = {
    "Gravity": (Gravity, dict(g=9.81, direction=-pi / 2)),
    "CoulombFriction": (CoulombFriction, dict(mu=0.2, mu_static=0.3)),
    "RollingResistance": (RollingResistance, dict(arm=0.01)),
    "Impact": (Impact, dict(restitution=0.5, law="poisson")),
    "Load": (Load, dict(fx="sin(t)", fy=1.0, moment=0.0)),
    "Start": (Start, dict(xi1=0.1, xi2=0.0, slip=0.0, omega=1.0, gap=0.0, gap_rate=0.0)),
    "disc": (disc, dict(radius=0.1, mass=1.0, inertia=0.005)),
    "Plate": (Plate, dict(outline=CIRCLE, mass=1.0, inertia=1.0)),
    "Case": (Case, dict(track=CIRCLE, plate=DISC, effects=(Gravity(9.81),), start=Start(0.1), duration=1.0)),
    "Curve": (Curve, dict(function=lambda s: (s, s**2), domain=(-1.0, 1.0))),
    "Curve.through": (Curve.through, dict(points=[(0.1 * i, 0.01 * i * i) for i in range(12)], closed=False)),
    "Curve.from_csv": (Curve.from_csv, dict(path="nowhere.csv", closed=True)),
    "simulate": (
        reference.simulate,
        dict(case=Case(CIRCLE, DISC, (Gravity(9.81),), Start(0.1), 0.1), rtol=1e-6, method=None),
    ),
    "line": (library.line, dict(slope=0.1)),
    "circle": (library.circle, dict(radius=1.0)),
    "ellipse": (library.ellipse, dict(a=1.0, b=0.5)),
    "parabola": (library.parabola, dict(focus=0.4, reach=3.0)),
    "cosine": (library.cosine, dict(depth=0.3, wavenumber=2.0, reach=3.0)),
    "cycloid": (library.cycloid, dict(a=0.25, offset=0.1)),
    "trochoid": (library.trochoid, dict(a=0.5, arm=0.3, arches=2)),
    "superellipse": (library.superellipse, dict(a=0.2, b=0.1, exponent=4)),
    "logarithmic_spiral": (library.logarithmic_spiral, dict(start=0.1, growth=0.2, turns=0.5)),
    "rounded_polygon": (library.rounded_polygon, dict(radius=0.1, corners=3, sharpness=0.5)),
}


def refused_well(problem: CaseError) -> None:
    """The error's text is one sentence that a person can read."""
    text = str(problem)
    assert 10 < len(text) <= ONE_SENTENCE, text[:200]
    assert "\n" not in text and "Traceback" not in text


def run_or_refused(call, *arguments, **keywords):
    """What the call returns, or None if it refuses; anything else it may do is a failure."""
    with within(60):
        try:
            return call(*arguments, **keywords)
        except CaseError as problem:
            refused_well(problem)
            return None


# --- values, shapes, types --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MAKERS)
def test_one_odd_argument_is_taken_or_refused_in_a_sentence(name):
    make, right = MAKERS[name]
    for argument in right:
        for value in ODD:
            run_or_refused(make, **(right | {argument: value}))


@given(data=st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
def test_several_odd_arguments_are_taken_or_refused_in_a_sentence(data):
    make, right = MAKERS[data.draw(st.sampled_from(sorted(MAKERS)))]
    run_or_refused(make, **{argument: data.draw(odd | st.just(value)) for argument, value in right.items()})


@given(
    effects=st.lists(
        odd
        | st.sampled_from(
            [
                Gravity(1.0),
                CoulombFriction(0.1),
                Unilateral(),
                Unilateral,
                Flight(),
                Impact(0.5),
                PerfectlyRough(),
                RollingResistance(0.1),
                Load(1.0),
            ]
        ),
        max_size=4,
    )
)
@settings(max_examples=60, deadline=None)
def test_any_list_of_effects_is_taken_or_refused_in_a_sentence(effects):
    run_or_refused(Case, CIRCLE, DISC, effects, Start(0.1), 1.0)


def test_a_refusal_names_what_was_wrong():
    with pytest.raises(CaseError, match="mass"):
        disc(0.1, -1.0)
    with pytest.raises(CaseError, match="radius"):
        disc("large", 1.0)
    with pytest.raises(CaseError, match="rtol"):
        reference.simulate(cases.load("disc_on_line"), rtol=nan)


# --- text -------------------------------------------------------------------------------------------------------------

names = st.sampled_from(["disc_on_line", "disc_in_circle", "sliding_rod", "no_such_case", "", "disc on line"])
insides = st.text(st.sampled_from("mu=0.1,[]v0 \n;-+e9naif'\"\\"), max_size=14)


@given(st.one_of(st.text(max_size=30), st.builds("{}[{}]".format, names, insides)))
@settings(max_examples=150, deadline=None)
def test_any_text_for_a_case_is_taken_or_refused_in_a_sentence(text):
    run_or_refused(cases.load, text)
    run_or_refused(cases.select, text)


@given(name=names, key=st.sampled_from(["mu", "v0", "r", "m", "g", "nothing", ""]), value=odd)
@settings(max_examples=150, deadline=None)
def test_any_parameter_of_a_case_is_taken_or_refused_in_a_sentence(name, key, value):
    run_or_refused(cases.load, name, **{key: value})


FORMULAS = (
    "s",
    "s**2",
    "1/s",
    "s**s",
    "s**0.5",
    "log(s)",
    "cos(2*s)",
    "import os",
    "__import__('os')",
    "s.real",
    "s[0]",
    "s^2",
    "f(s)",
    "x",
    "",
    " ",
    "(",
    "1e999",
    "nan",
    "oo",
    "I*s",
    "s if s else 1",
    "lambda: s",
    "s;s",
    "9**9**9",
    "'s'",
    "0",
    "tan(s)",
    "exp(exp(s))",
    "s//2",
    "abs(s)",
    "s\n",
    "pi",
    "cos",
    "cos(s, s)",
    "sqrt(-1)",
    "10**-400*s",
)


@given(
    x=st.sampled_from(FORMULAS), y=st.sampled_from(FORMULAS), domain=st.sampled_from([None, (-1.0, 1.0), (0.5, 2.0)])
)
@settings(max_examples=120, deadline=None)
def test_any_formula_for_a_curve_is_taken_or_refused_in_a_sentence(x, y, domain):
    run_or_refused(Curve, (x, y), domain)


@pytest.mark.parametrize("formula", FORMULAS)
def test_any_formula_for_a_load_is_taken_or_refused_in_a_sentence(formula):
    run_or_refused(Load, fx=formula.replace("s", "t"))


FUNCTIONS = (
    lambda s: s,
    lambda s: (s,),
    lambda s: (s, s, s),
    lambda s: None,
    lambda: (1, 2),
    lambda s: (s, 1 / 0),
    lambda s: (s, "s"),
    lambda s: (s, nan),
    lambda s: (s, np.array([1.0])),
    lambda s: (np.cos(s), s),
    lambda s: (s, sp.Symbol("q") * s),
    lambda s: (0.0, 0.0),
    lambda s: (s**3, s**2),
    lambda s: (s, sp.Abs(s)),
    lambda s: (s, sp.Piecewise((0, s < 0), (s, True))),
    lambda s: (s, sp.floor(s)),
    lambda s: (s, sp.gamma(s)),
    lambda s: (sp.I * s, s),
    lambda s: (s, sp.Function("f")(s)),
    lambda s: (_ for _ in ()),
    lambda s: {1, 2},
    lambda s: (True, False),
)


@pytest.mark.parametrize("number", range(len(FUNCTIONS)))
@pytest.mark.parametrize("domain", [None, (-1.0, 1.0)])
def test_any_function_for_a_curve_is_taken_or_refused_in_a_sentence(number, domain):
    run_or_refused(Curve, FUNCTIONS[number], domain)


# --- files ------------------------------------------------------------------------------------------------------------

CSVS = (
    b"",
    b"\n\n",
    b"x,y\n",
    b"1,2\n",
    b"x,y\n1,2\n3,abc\n",
    b"1,2,3\n" * 20,
    b"\x00\x01\xff" * 40,
    b"1;2\n" * 20,
    b"nan,nan\n" * 20,
    b"inf,1\n" * 20,
    b"1,2\n" * 20,
    b'"1,2\n' * 20,
    b"\xef\xbb\xbfx,y\n" + b"".join(b"%d,%d\n" % (i, i * i) for i in range(20)),
    b"".join(b"%d,0\n" % i for i in range(20)),
    b"1e999,0\n" * 20,
    b"x" * 100_000,
    b"# only a comment\n",
    b"1,2\r\n" * 20,
)


@pytest.mark.parametrize("number", range(len(CSVS)))
@pytest.mark.parametrize("closed", [True, False])
def test_any_file_of_points_is_taken_or_refused_in_a_sentence(tmp_path, number, closed):
    file = tmp_path / "points.csv"
    file.write_bytes(CSVS[number])
    run_or_refused(Curve.from_csv, file, closed)


def rows(header: str, count: int = 60, change=lambda i, row: row) -> bytes:
    lines = [change(i, [f"{i / count:.6f}", f"{i / count:.6f}", "0.1", f"{-10 * i / count:.6f}"]) for i in range(count)]
    return "\n".join([header, *(",".join(line) for line in lines)]).encode()


MOTIONS = (
    *CSVS,
    rows("t,x,y,theta"),
    rows("t,x,y"),
    rows("t,x,y,theta", 10),
    rows("T,X,Y,THETA"),
    rows("t,x,y,theta,t"),
    rows("t,x,y,theta", change=lambda i, row: [*row, "extra"]),
    rows("t,x,y,theta", change=lambda i, row: row[:2] if i == 7 else row),
    rows("t,x,y,theta", change=lambda i, row: ["0", *row[1:]]),
    rows("t,x,y,theta", change=lambda i, row: [row[0], "1e300", *row[2:]]),
    rows("t,x,y,theta", change=lambda i, row: [row[0], row[1], "nan", row[3]]),
    rows("t;x;y;theta"),
    rows("t,x,y,theta,slip", change=lambda i, row: [*row, "inf"]),
    rows("t,x,y,theta,vx", change=lambda i, row: [*row, "7"]),
)


@pytest.mark.parametrize("number", range(len(MOTIONS)))
def test_any_file_of_a_motion_is_judged_or_refused_in_a_sentence(tmp_path, capsys, number):
    file = tmp_path / "motion.csv"
    file.write_bytes(MOTIONS[number])
    with within(60):
        status = compare.main(["disc_on_line[mu=0.3]", str(file)])
    told = capsys.readouterr()
    assert status in (0, 2)
    assert bool(told.err) == (status == 2) and told.err.count("\n") <= 1 and "Traceback" not in told.err


CASE_FILES = (
    "",
    "x = 1",
    "raise SystemExit",
    "raise SystemExit(3)",
    "1/0",
    "import nothing_like_it",
    "def f(:",
    "\x00",
    "from cases import *\n",
    "from cases import case\n@case\ndef f(): pass",
    "from cases import case\n@case\ndef f(a): pass",
    "from cases import case\n@case(variants=3)\ndef f(): pass",
    "from cases import case\n@case(variants=[3])\ndef f(): pass",
    "from cases import case\n@case(variants=[dict(b=1)])\ndef f(a=1): pass",
    "from cases import case\ncase(3)",
    "from cases import case\n@case\ndef disc_on_line(): pass",
    "from cases import case\n@case(hard='x')\ndef f(): pass",
    "from cases import case\n@case\nclass F: pass",
    "from cases import case\n@case\ndef f(): raise SystemExit",
)


@pytest.fixture
def catalogue(monkeypatch):
    """A catalogue that forgets what is loaded."""
    cases.names()
    monkeypatch.setattr(registry, "_entries", dict(registry._entries))


@pytest.mark.parametrize("number", range(len(CASE_FILES)))
def test_any_case_file_is_taken_or_refused_in_one_line(tmp_path, capsys, catalogue, number):
    file = tmp_path / "mine.py"
    file.write_text(CASE_FILES[number])
    status, _, err = told_by(commands.main, ["check", str(file)])
    assert status == 2 and err.count("\n") == 1 and "Traceback" not in err, err


# --- command lines ----------------------------------------------------------------------------------------------------

WORDS = (
    "stability",
    "formulations",
    "effect_costs",
    "--fresh",
    "--case",
    "--case-file",
    "--solver",
    "--quick",
    "--full",
    "--jobs",
    "--list",
    "--out",
    "--resume",
    "disc_on_line",
    "mu=0.3",
    "disc_on_line[mu=0.1]",
    "disc_on_line[mu=-1]",
    "no_such",
    "reference",
    "exudyn",
    "0",
    "-1",
    "2",
    "nan",
    "",
    " ",
    "--",
    "-x",
    "--colour",
    "/dev/null",
    "/nowhere/at/all",
    ".",
    "..",
    "/",
    "[",
    "]",
    "\n",
    "é" * 300,
    "*",
    "new",
    "check",
    "show",
    "export",
    "my case",
    "--out=",
    "--jobs=two",
    "@file",
)


def told_by(command, words) -> tuple[int, str, str]:
    """Exit status and what a command prints; SystemExit counts as its status."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), within(60):
        try:
            status = command(list(words))
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 1
    return status, out.getvalue(), err.getvalue()


_listing = build.listing


@lru_cache
def _listed_once(files: tuple[str, ...]) -> str:
    return _listing(files)


def _listed(files: Sequence[str]) -> str:
    """The list of cases and solvers, made once: it asks every engine, each time in processes of its own."""
    return _listed_once(tuple(files))


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """An empty working folder; commands plan and refuse, and do not run what takes minutes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(build, "_build", lambda *_: 0)
    monkeypatch.setattr(build, "listing", _listed)
    monkeypatch.setattr(compare, "compare", lambda *_: "judged")
    monkeypatch.setattr(study, "_make", lambda *_: None)
    monkeypatch.setattr(commands, "entry_points", lambda group, name: [])
    return tmp_path


@pytest.mark.parametrize("command", [build.main, compare.main, commands.main, study.main], ids=lambda f: f.__module__)
@given(words=st.lists(st.sampled_from(WORDS), max_size=5))
@settings(max_examples=120, deadline=None, suppress_health_check=list(HealthCheck))
def test_any_command_line_is_taken_or_refused_in_one_line(desk, command, words):
    status, out, err = told_by(command, words)
    assert status in (0, 2), (words, err)
    assert "Traceback" not in err
    if status == 2:
        assert not re.search(r"usage:", err), err
        assert err.strip() and err.count("\n") == 1, err


@pytest.mark.parametrize("command", [build.main, compare.main, commands.main, study.main], ids=lambda f: f.__module__)
def test_help_is_help(desk, command):
    status, out, _ = told_by(command, ["--help"])
    assert status == 0 and len(out) > 100
