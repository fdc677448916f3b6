"""No text that the suite reads is run; docs/security.md says which inputs are code, and which may be a stranger's."""

import json
import os
import pickle
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import cases
import cases.formulas.expressions
from adapters.common import motion_table
from cases import CaseError, Curve, Load
from cases.files.command_line import status
from cases.files.owned_folder import LIST, digest
from cases.formulas import expressions
from reports import compare_builds, options
from reports.analysis.columns import Table
from reports.page import table_files
from reports.running import external_motions, submissions
from reports.running.storage import result_store
from reports.sweeping import sweep_folder


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


# What may be in the place of a file: a pipe, a folder, links to a device without end, to nowhere and to a user's file.
ODD_FILES = (
    os.mkfifo,
    os.mkdir,
    lambda file: file.symlink_to("/dev/zero"),
    lambda file: file.symlink_to("nowhere"),
)


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
            refused(cases.constructions.natural, lambda s, wrap=wrap: wrap, 1.0)
            refused(expressions.integral, lambda s, wrap=wrap: wrap, 1.0)
            refused(Curve, lambda s, wrap=wrap: (s, expressions.sqrt(wrap)))
            for function in expressions.FUNCTIONS.values():
                refused(function, wrap)
        refused(Curve(("s", "s**2")).at, attack)


def test_no_name_parameter_or_path_is_run(mark):
    for attack in attacks(mark):
        refused(cases.load, attack)
        refused(cases.load, f"disc_in_circle[mu={attack}]")
        refused(cases.load, "disc_in_circle", mu=attack)
        refused(cases.select, f"{attack}[mu=1]")
        refused(cases.load_file, attack)
        refused(Curve.spline, attack, closed=True)
        refused(motion_table.read, attack)
        refused(external_motions.from_options, [f"{attack}=nothing.csv"], [], [])


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
            refused(motion_table.read, tmp_path / "motion.csv")
        (tmp_path / "points.csv").write_text(f"0,0\n{quoted},1\n" + "".join(f"{i},{i * i}\n" for i in range(20)))
        refused(Curve.spline, tmp_path / "points.csv", closed=False)


class Bomb:
    """A pickle that runs a command when it is read."""

    def __init__(self, mark: Path):
        self.mark = mark

    def __reduce__(self):
        return os.system, (f"touch {self.mark}",)


def rows_of(path: Path, asked: dict) -> list:
    """The rows of somebody's sweep, whose list of files says of each that it is unchanged."""
    names = [file for file in path.rglob("*") if file.is_file() and file.name != LIST]
    entries = [f"{digest(file)}  {file.relative_to(path).as_posix()}\n" for file in names]
    (path / LIST).write_text("".join(["# slip-to-roll sweep\n", *entries]))
    folder = sweep_folder.Folder(path)
    with folder.exclusive(asked):
        return list(folder.rows("rows"))


def test_no_file_of_a_stranger_is_run(mark, tmp_path):
    """Each of their files holds a pickle, each attack in its turn, what is no text, nothing at all, or is a pipe."""
    names = ("report", "sweep", "engine/1.0", "motions", "points")
    report, sweep, hand_in, motions, points = (tmp_path / name for name in names)
    ours = {"asked": {"plan": 1}}
    for place, name, whole in (
        (report, "manifest.json", "{}"),
        (report, "tables/truth.csv", "case,event,time\na,1,0.1\n"),
        (sweep, "sweep.json", json.dumps(ours)),
        (sweep, "rows/part-000000000000.parquet", ""),
        (hand_in, "submission.toml", 'engine = "engine"\nversion = "1.0"\n'),
        (motions, "motion.csv", "t,x,y,theta\n"),
        (points, "points.csv", "0,0\n"),
    ):
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(whole)
    reading = {
        report: lambda: compare_builds.summary_lines(compare_builds.compare(report, report), report, report),
        sweep: lambda: rows_of(sweep, ours["asked"]),
        hand_in: lambda: submissions.read(hand_in),
        motions: lambda: motion_table.read(motions / "motion.csv"),
        points: lambda: Curve.spline(points / "points.csv", closed=True),
    }
    contents = [pickle.dumps(Bomb(mark)), b"\xff\x00\x1b[2J", b"", b"[" * 100_000]
    contents += [attack.encode() for attack in attacks(mark)]
    for place, read in reading.items():
        for file in [path for path in sorted(place.rglob("*")) if path.is_file()]:
            whole = file.read_bytes()
            for content in contents:
                file.write_bytes(content)
                refused(read)
            for odd in ODD_FILES:
                file.unlink()
                odd(file)
                refused(read)
                if odd is os.mkdir:
                    file.rmdir()
                    file.touch()
            file.unlink()
            file.write_bytes(whole)


def test_a_record_of_a_store_is_text_and_its_time_is_printable_or_damaged(tmp_path, capsys):
    results, key = result_store.Store(tmp_path), {"what": "a text"}
    results.put("run", key, "two\nlines\x1b[2J", str)

    def work(words):
        print(results.get("run", key, str))

    assert status("test", work, []) == 0 and capsys.readouterr().out == "two\nlines\\x1b[2J\n"
    (file,) = tmp_path.glob("run-*.npz")
    file.write_bytes(result_store._archive({"key": key, "when": "\x1b[2J", "record": "a text"}, []))
    assert results.get("run", key, str) is None and "could not be read" in results.trouble()[0]


@pytest.mark.parametrize("text", ["\x1b]0;title\x07", "\x9b2J", "\u202e", "\udcff", "\r", "\x7f"])
def test_whatever_a_command_prints_is_text(text, capsys):
    def work(words):
        print(f"written: {words[0]}")
        print(words[0], file=sys.stderr)
        raise OSError(words[0])

    assert status("test", work, [text]) == 1
    for output in capsys.readouterr():
        assert output.replace("\n", "").isprintable() and ascii(text)[1:-1] in output
    assert options.command("reports.build", [text]).isprintable()


def test_a_strangers_report_says_nothing_that_a_terminal_acts_on(tmp_path):
    for name, said in (("one", "\x1b[2J"), ("other", "")):
        (tmp_path / name / "tables").mkdir(parents=True)
        (tmp_path / name / "manifest.json").write_text(json.dumps({"machine": said}))
        (tmp_path / name / "tables" / "truth.csv").write_text(f"case,event,time\na,1,0.1{said}\n")
    one, other = tmp_path / "one", tmp_path / "other"
    output = compare_builds.summary_lines(compare_builds.compare(one, other), one, other)
    assert "machine" in output and "0.1" in output and "\x1b" not in output


def test_text_is_inert_in_tables(mark, tmp_path):
    texts = [*attacks(mark), "=1+1", "+1+1", "-1+1", "@SUM(A1)", "\t=1", "<script>alert(1)</script>", "-1.5", "plain"]
    frame = pd.DataFrame({"solver": texts, "value": [-1.5] * len(texts)})
    words = {"t": Table("t", dict.fromkeys(frame.columns, "a text"))}
    table_files.write(table_files.Tables({"t": frame}, words), tmp_path, "make it")
    back = pd.read_csv(tmp_path / "t.csv", dtype=str)
    for cell in back["solver"]:
        assert cell == "-1.5" or not cell.lstrip().startswith(("=", "+", "-", "@")), cell
    assert list(back["value"]) == ["-1.5"] * len(texts)


def test_names_stay_in_their_folder():
    case = cases.load("disc_in_circle")
    for name in ("../up", "/etc/passwd", "a\0b", "", "a" * 1000, ".hidden", "<b>", "$x$", 3, "a\nb", "\ud800"):
        refused(cases.Case, case.track, case.plate, case.effects, case.start, 1.0, name=name)
