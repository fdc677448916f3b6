"""The command as a user meets it: what it refuses, what it writes."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import cases
from adapters import Setting
from cases.files.owned_folder import LIST
from reports import build, options
from reports.analysis.table_list import TABLES
from reports.drawing import figure_files
from reports.page import report_folder, table_files
from reports.running import solvers
from reports.running.records import Experiment, Run, Truth


def test_list_tells_of_a_case_that_fails_and_goes_on(tmp_path, catalogue, capsys):
    file = tmp_path / "broken.py"
    file.write_text("from cases import case\n\n\n@case\ndef broken_case():\n    return 1 / 0\n")
    assert build.main(["--list", "--case-file", str(file)]) == 0
    output = capsys.readouterr().out
    assert "ZeroDivisionError" in output and "disc_in_circle[mu=0.2]" in output


def test_what_is_listed_is_read_from_code_and_no_engine_is_imported():
    listed = (
        "import sys; from reports.build import main; assert main(sys.argv[1:]) == 0;"
        "assert not {'exudyn', 'pymunk', 'pandas', 'matplotlib'} & set(sys.modules)"
    )
    output = subprocess.run([sys.executable, "-c", listed, "--list"], capture_output=True, text=True, check=True).stdout
    assert "  pymunk: native, assisted\n" in output and "  exudyn: native, integrator\n" in output


def test_ladders_are_thinned_in_quick_reports_and_in_the_breadth_of_the_catalogue():
    settings = (Setting.of(rung="defaults"), *(Setting.of(h=10.0**-i) for i in range(7)))
    few, fewer = (settings[0], settings[1], settings[3], settings[5]), (settings[0], settings[5])

    def kept(effort, asked, case, solver="pymunk", route="native"):
        return options.BuildPlan(Path("x"), (), (), (), effort, 1, (), asked).select_rungs(
            case, solver, route, settings
        )

    assert kept("quick", True, "disc_in_circle[mu=0.2]") == few
    assert kept("default", False, "disc_in_circle[mu=0.2]") == settings
    assert kept("default", False, "disc_in_circle[mu=0.1]") == fewer
    assert kept("default", False, "littlewood_hoop") == fewer
    assert kept("default", False, "littlewood_hoop", "reference") == (settings[0], settings[-1])
    # The paper's matrix is dear: its whole ladder where ladders are whole, else its two coarsest tolerances.
    assert kept("default", False, "littlewood_hoop", "reference", "augmented") == settings[:2]
    assert kept("default", False, "disc_in_circle[mu=0.2]", "reference", "augmented") == settings
    assert kept("default", True, "littlewood_hoop", "reference", "augmented") == settings
    assert kept("full", False, "littlewood_hoop", "reference", "augmented") == settings
    assert kept("default", True, "littlewood_hoop") == settings
    assert kept("full", False, "littlewood_hoop") == settings


@pytest.fixture(scope="module")
def report(tmp_path_factory, in_process):
    """A small report of two solvers, made by the command."""
    out = tmp_path_factory.mktemp("made") / "deep" / "report"
    argv = [
        "--out",
        str(out),
        "--quick",
        "--case",
        "disc_on_line",
        "disc_on_incline",
        "--solver",
        "reference",
        "pymunk",
    ]
    with in_process():
        assert build.main(argv) == 0
    return out


def test_report_has_every_promised_file_and_no_other(report):
    files = {*report_folder.of_report(report).names()}
    assert holds(report) == files | {LIST}
    promised = {"index.html", "manifest.json", "figures/headline.png"}
    promised |= {f"tables/{name}.csv" for name, table in TABLES.items() if not table.is_timed}
    promised |= {"tables/columns.md", "tables/datapackage.json"}
    assert promised <= files
    assert [p.name for p in report.parent.iterdir()] == ["report"]  # no partial report is left beside it


def test_manifest_tells_how_it_was_made(report):
    manifest = json.loads((report / "manifest.json").read_text())
    assert manifest["made_by"] == report_folder.MADE_BY and "--quick" in manifest["command"]
    assert {"numpy", "scipy"} <= manifest["packages"].keys() and manifest["python"].startswith("3.")
    assert set(manifest["solvers"]) == {"reference", "pymunk"}
    phases = manifest["phases"]
    assert {"versions", "truth", "survey", "runs", "figures", "tables", "page"} <= phases.keys()
    assert all(seconds >= 0.0 for phase in phases.values() for seconds in phase.values())
    assert phases["runs"]["wall_s"] > 0.0
    whole = sum(phase["wall_s"] for phase in phases.values())
    assert manifest["seconds"] == pytest.approx(whole, abs=0.01 * len(phases))


def test_tables_have_the_promised_columns(report):
    promised = {
        "transitions": "case,solver,version,route,setting,event,before,after,time,reference_time,error,"
        "truth_error_bar,pairing,contact,reading_doubt",
        "trajectories": "case,solver,version,route,setting,outcome,grade,off,off_doubt,mu_equivalent,friction_factor,"
        "reason,refusal,sequence,pose_score,mode_score,slip_score,creep,status,first_mode,transitions_true,paired,"
        "missed,spurious,centre_max,centre_rms,angle_max,angle_rms,slip_max,slip_rms,final_pose,normal_force_mean,"
        "energy_mean,cpu_s,setup_s,steps,run_at,law_error,law_error_at",
        "convergence": "case,solver,version,route,quantity,order,order_low,order_high,finest_error,settings_used,note,"
        "saturation,saturated_from,saturated_error,settings,order_in_time,order_in_time_low,order_in_time_high",
    }
    for name, columns in promised.items():
        assert (report / "tables" / f"{name}.csv").read_text().splitlines()[0] == columns


def test_page_is_self_contained_and_tells_how_to_make_it_again(report):
    page = (report / "index.html").read_text()
    bare = re.sub(r"<(script|pre)\b.*?</\1>", "", page, flags=re.DOTALL)
    assert not re.search(r"<script[^>]*src=|@import|url\((?!%23)", bare)
    assert not re.search(r"<img[^>]*src", bare) and bare.count('<svg class="figure"') == 3
    for target in re.findall(r'href="([^#"][^"]*)"', bare.replace('href="data:,"', "")):
        assert (report / target).exists(), target
    for target in re.findall(r'href="#([^"]+)"', bare):
        assert f'id="{target}"' in bare, target
    remake = "slip-to-roll report --quick --solver reference pymunk --case &#34;NAME&#34;"
    assert remake in page


def test_a_report_that_fails_half_way_leaves_the_old_one_standing(report, monkeypatch, capsys, in_process):
    before = (report / "index.html").read_bytes()

    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(table_files, "write", full)
    argv = ["--out", str(report), "--quick", "--case", "disc_on_incline[slope=0.2]", "--solver", "reference"]
    with in_process():
        assert build.main(argv) == 1
    assert "no space left" in capsys.readouterr().err
    assert (report / "index.html").read_bytes() == before
    assert [p.name for p in report.parent.iterdir()] == ["report"]


def holds(place: Path) -> set[str]:
    return {path.relative_to(place).as_posix() for path in place.rglob("*") if path.is_file()}


def test_names_of_files_fit_in_every_file_system():
    long = "case[" + ",".join(f"parameter_{i}=0.1" for i in range(40)) + "]"
    names = {figure_files.file_name(long), figure_files.file_name(long + "2"), figure_files.file_name("µ" * 300)}
    assert len(names) == 3 and all(len(f"prefix_{name}.svg".encode()) < 255 for name in names)
    assert re.fullmatch(r"disc_on_line_mu_0\.1_[0-9a-f]{8}", figure_files.file_name("disc_on_line[mu=0.1]"))


def test_a_report_takes_the_place_of_an_older_one_and_runs_nothing_twice(report, tmp_path, capsys, in_process):
    out = tmp_path / "report"
    shutil.copytree(report, out)
    argv = ["--out", str(out), "--quick", "--case", "disc_in_circle[mu=0.2]", "--solver", "reference"]
    with in_process():
        assert build.main(argv) == 0
    assert "disc_on_line" not in (out / "tables" / "truth.csv").read_text()
    assert [p.name for p in tmp_path.iterdir()] == ["report"]
    before = {p.name: p.read_bytes() for p in (out / "figures").iterdir()}
    capsys.readouterr()
    with in_process():
        assert build.main(argv) == 0
    assert (
        " runs and 1 truth taken from the store" in (output := capsys.readouterr().out) and "nothing made now" in output
    )
    assert {p.name: p.read_bytes() for p in (out / "figures").iterdir()} == before


# --- engines that fail ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("in_clone", [True, False])
def test_what_is_not_installed_is_a_line_and_the_command_that_adds_it(in_clone, monkeypatch):
    monkeypatch.setattr(solvers, "in_clone", lambda: in_clone)
    versions = {"fine": "1.0", "box2d": "not_installed: pyb2d3", "ghost": "not_installed: no_such_engine"}
    lines = solvers.missing_words(versions)
    assert lines[:2] == ["box2d: not installed (it needs pyb2d3)", "ghost: not installed (it needs no_such_engine)"]
    # Without the suite's own metadata nobody knows its extras.
    assert lines[2:] in ([], ['make report EXTRAS="box2d" adds it' if in_clone else "pip install pyb2d3 adds it"])
    assert solvers.missing_words({"fine": "1.0"}) == []


@pytest.mark.parametrize(("outcome", "status"), [("answered", 0), ("unsupported", 3), ("crashed", 3)])
def test_a_named_case_that_no_solver_could_run_shows_in_the_exit_status(outcome, status, tmp_path, monkeypatch, capsys):
    case = cases.load("disc_on_line[mu=0.1]")
    runs = (
        Run(case.label, "reference", "taylor", Setting.of(), 0, "unsupported", "it has no series for that curve"),
        Run(case.label, "pymunk", "native", Setting.of(), 0, outcome),
    )
    ran = Experiment((case,), {case.label: Truth()}, runs)
    monkeypatch.setattr("reports.running.experiment.run_cases", lambda *_: ran)
    monkeypatch.setattr(build, "_study", lambda *_: [])
    monkeypatch.setattr(build, "_write", lambda *arguments: ([], []))
    argv = ["--quick", "--case", case.label, "--out", str(tmp_path / "report"), "--store", str(tmp_path / "store")]
    assert build.main(argv) == status
    sentence = "no solver could run disc_on_line[mu=0.1]; reference unsupported: it has no series"
    assert (sentence in capsys.readouterr().err) == (status == 3)


def test_a_case_that_lost_its_truth_shows_in_the_exit_status_though_nobody_named_it(tmp_path, monkeypatch, capsys):
    case = cases.load("disc_on_line[mu=0.1]")
    ran = Experiment((case,), {case.label: Truth(failure="its process was ended")}, ())
    monkeypatch.setattr("reports.running.experiment.run_cases", lambda *_: ran)
    monkeypatch.setattr(build, "_write", lambda *arguments: ([], []))
    assert build.main(["--quick", "--out", str(tmp_path / "report"), "--store", str(tmp_path / "store")]) == 3
    assert "no truth for disc_on_line[mu=0.1]: its process was ended" in capsys.readouterr().err
