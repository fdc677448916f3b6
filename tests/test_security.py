"""No text that the suite reads is run; docs/security.md says which inputs are code, and which may be a stranger's."""

import json
import os
import pickle
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import cases
from adapters.common import exported
from cases import CaseError, Curve, Load, kept, registry
from cases.effects import MOTION
from reports.analysis.columns import Table
from reports.page import folder, text
from reports.running import external, packing, store

SCENE = Path(__file__).resolve().parents[1]


@pytest.fixture
def mark(tmp_path, monkeypatch):
    """A file that an attack makes: it must not be there afterwards. The attacks are run from an empty folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "taken"
    yield path
    assert not path.exists(), "text was run as code"


def attacks(mark: Path) -> list[str]:
    """The same thing said in the ways that have run in one tool or another."""
    shell = f"touch {mark}"
    return [
        f"__import__('os').system({shell!r})",
        f"().__class__.__base__.__subclasses__() or __import__('os').system({shell!r})",
        f"(lambda: __import__('os').system({shell!r}))()",
        f"[__import__('os').system({shell!r})][0]",
        f"exec('open({str(mark)!r}, chr(119))')",
        f"open({str(mark)!r}, 'w')",
        f"s if __import__('os').system({shell!r}) else s",
        f"sin(__import__('os').system({shell!r}))",
        f"f'{{open({str(mark)!r}, chr(119))}}'",
        f"$(touch {mark})",
        f"`touch {mark}`",
        f"; touch {mark} #",
        f"=cmd|' /C touch {mark}'!A0",
        f"!!python/object/apply:os.system ['touch {mark}']",
        f"{{{{ cycler.__init__.__globals__.os.system('touch {mark}') }}}}",
    ]


def refused(call, *arguments, **named) -> None:
    with pytest.raises(CaseError):
        call(*arguments, **named)


def test_no_formula_is_run(mark):
    for attack in attacks(mark):
        for wrap in (attack, [attack], {attack: 1}, (attack,), {attack}, np.array([attack]), attack.encode()):
            refused(Load, wrap)
            refused(Load, 0.0, moment=wrap)
            refused(Curve, ("s", wrap))
            refused(Curve, lambda s, wrap=wrap: (s, wrap))
            refused(cases.library.from_support, lambda s, wrap=wrap: wrap)
        refused(Curve(("s", "s**2")).at, attack)


def test_no_name_parameter_or_path_is_run(mark):
    for attack in attacks(mark):
        refused(cases.load, attack)
        refused(cases.load, f"disc_in_circle[mu={attack}]")
        refused(cases.load, "disc_in_circle", mu=attack)
        refused(cases.select, f"{attack}[mu=1]")
        refused(cases.load_file, attack)
        refused(Curve.from_csv, attack, closed=True)
        refused(exported.read_table, attack)
        refused(external.from_options, [f"{attack}=nothing.csv"], [], [])


def test_no_cell_of_a_file_is_run(mark, tmp_path):
    rows = "".join(f"{i / 60},0,0.1,0\n" for i in range(60))
    for attack in attacks(mark):
        quoted = '"' + attack.replace('"', '""') + '"'
        for content in (
            f"t,x,y,theta\n{quoted},0,0.1,0\n{rows}",
            f"t,x,y,{quoted}\n{rows}",
            f"{quoted}\n{rows}",
            f"t,x,y,theta\n{rows}{attack}",
        ):
            (tmp_path / "motion.csv").write_text(content)
            refused(exported.read_table, tmp_path / "motion.csv")
        (tmp_path / "points.csv").write_text(f"0,0\n{quoted},1\n" + "".join(f"{i},{i * i}\n" for i in range(20)))
        refused(Curve.from_csv, tmp_path / "points.csv", closed=False)


class Bomb:
    """A pickle that runs a command when it is read."""

    def __init__(self, mark: Path):
        self.mark = mark

    def __reduce__(self):
        return os.system, (f"touch {self.mark}",)


def test_no_pickle_is_read_from_a_store_or_an_array(mark, tmp_path):
    content = pickle.dumps(Bomb(mark))
    (tmp_path / "bomb.csv").write_bytes(content)
    refused(exported.read_table, tmp_path / "bomb.csv")
    refused(Curve.from_csv, tmp_path / "bomb.csv", closed=True)
    place = tmp_path / "store"
    results = store.Store(place)
    assert results.problem() == ""
    key = {"what": "a run"}
    results.put("run", key, 1.0)
    (file,) = place.glob("run-*.npz")
    file.write_bytes(content)
    assert store.Store(place).get("run", key, float) is None
    np.savez(file, record=np.array([Bomb(mark)], dtype=object))
    assert store.Store(place).get("run", key, float) is None


def test_a_folder_with_an_odd_manifest_is_somebodys(tmp_path):
    (tmp_path / "mine.txt").write_text("precious")
    for odd in ("[" * 200_000, "9" * 5000, "{}", "nonsense", '{"files": 3}'):
        (tmp_path / "manifest.json").write_text(odd)
        assert folder.foreign_file(tmp_path) != ""


def test_a_record_says_nothing_about_what_code_runs(mark):
    """What JSON names a type or a function is data of the type that is asked for, or an error."""
    said = json.loads(json.dumps({"__reduce__": ["os.system", f"touch {mark}"], "py/object": "os.system"}))
    for kind in (float, tuple[float, ...], cases.Transition):
        with pytest.raises((ValueError, TypeError, KeyError)):
            packing.unpack(kind, said, {})


@pytest.mark.parametrize("open_to", [0o777, 0o770, 0o707])
def test_what_others_could_have_put_into_the_cache_is_not_read(mark, tmp_path, monkeypatch, open_to, caplog):
    cache = tmp_path / "cache"
    cache.mkdir(mode=0o700)
    monkeypatch.setenv(kept.VARIABLE, str(cache))
    made = kept.kept("jet", ("a secret", open_to), Path(kept.__file__).parent, lambda: 1.0)
    assert made == 1.0
    (file,) = cache.glob("*.kept")
    content = pickle.dumps(Bomb(mark))
    import hashlib

    file.write_bytes(hashlib.sha256(content).digest() + content)
    file.chmod(0o600 | open_to)
    assert kept.kept("jet", ("a secret", open_to), Path(kept.__file__).parent, lambda: 2.0) == 2.0


def test_text_is_inert_in_tables(mark, tmp_path):
    texts = [*attacks(mark), "=1+1", "+1+1", "-1+1", "@SUM(A1)", "\t=1", "<script>alert(1)</script>", "-1.5", "plain"]
    frame = pd.DataFrame({"solver": texts, "value": [-1.5] * len(texts)})
    text.write({"t": frame}, {"t": Table("what a test holds")}, tmp_path, "make")
    back = pd.read_csv(tmp_path / "t.csv", dtype=str)
    for cell in back["solver"]:
        assert cell == "-1.5" or not cell.lstrip().startswith(("=", "+", "-", "@")), cell
    assert list(back["value"]) == ["-1.5"] * len(texts)
    assert "<script" not in (tmp_path / "t.md").read_text()


def test_names_stay_in_their_folder():
    case = cases.load("disc_in_circle")
    for name in ("../up", "/etc/passwd", "a\0b", "", "a" * 1000, ".hidden", "<b>", "$x$", 3, "a\nb", "\ud800"):
        refused(cases.Case, case.track, case.plate, case.effects, case.start, 1.0, name=name)


def test_no_error_carries_what_a_terminal_acts_on():
    problem = CaseError("a \x1b[2J b \ud800 c\x00")
    assert str(problem).isprintable()


def test_an_expression_is_built_from_two_tables_alone():
    """Every name and node that Python knows, tried as a formula."""
    import builtins
    import sys

    for name in {
        *dir(builtins),
        *sys.stdlib_module_names,
        *dir(cases),
        "e",
        "E",
        "S",
        "Symbol",
        "Function",
        "lambdify",
    }:
        if name not in ("pow",) and name not in cases.expressions.FUNCTIONS and name not in [s.name for s in MOTION]:
            refused(Load, name)
            refused(Load, f"{name}(t)")


def test_a_case_file_is_code_and_is_held_to_a_time(tmp_path, monkeypatch):
    from cases.patience import patience

    (tmp_path / "endless.py").write_text("while True:\n    try:\n        pass\n    except Exception:\n        pass\n")
    with pytest.raises(CaseError, match="does not end"), patience("endless.py", 0.5):
        registry.load_file(tmp_path / "endless.py")
