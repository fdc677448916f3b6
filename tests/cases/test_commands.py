"""The command `python -m cases`, tried as a new user would, with a deliberate mistake at each step."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

import cases
from cases import registry
from cases.commands import TEMPLATE, main
from reference import narration
from reports import export, show


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """An empty working folder, a catalogue that forgets what is loaded, and the suite's own commands installed."""
    monkeypatch.chdir(tmp_path)
    cases.names()
    monkeypatch.setattr(registry, "_entries", dict(registry._entries))
    commands = {"show": show.run, "export": export.run, "check": narration.check}
    monkeypatch.setattr(
        "cases.commands.entry_points", lambda group, name: [SimpleNamespace(load=lambda: commands[name])]
    )
    return tmp_path


def run(capsys, *words) -> tuple[int, str, str]:
    status = main(list(words))
    out, err = capsys.readouterr()
    return status, out, err


def refused(capsys, *words) -> str:
    status, out, err = run(capsys, *words)
    assert status == 2 and not out
    assert err.startswith("cases: ") and err.count("\n") == 1
    return err


def test_without_words_every_case_is_listed_in_one_line(capsys):
    status, out, _ = run(capsys)
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == cases.names()


def test_new_then_check_then_show_works_without_an_edit(desk, capsys):
    assert run(capsys, "new", "my_valley")[0] == 0
    status, out, _ = run(capsys, "check", "my_valley.py")
    assert status == 0 and "my_valley: fits" in out
    status, out, _ = run(capsys, "show", "my_valley", "mu=0.2")  # it is found where one works
    assert status == 0 and "mu = 0.2" in out and "reference: runs it" in out
    assert (desk / "my_valley.png").stat().st_size > 10_000


def test_check_runs_the_motion_and_says_what_happens(desk, capsys):
    """A third in a curve is an ordinary number; a motion that ends early says why."""
    text = TEMPLATE.format(name="my_bowl")
    text = text.replace("-depth * cos(2 * s)", "depth * s**2 / 3").replace("mu=0.1):", "mu=0.05):")
    (desk / "my_bowl.py").write_text(text)
    status, out, _ = run(capsys, "check", "my_bowl.py")
    assert status == 0 and re.search(r"my_bowl: fits; slides forward for 1\.05 s, then rolls", out)
    text = (
        TEMPLATE.format(name="my_hill")
        .replace("-depth * cos(2 * s)", "-(s + 1)**2")
        .replace("Start(xi1", "Start(slip=2, xi1")
    )
    (desk / "my_hill.py").write_text(text)
    status, out, _ = run(capsys, "check", "my_hill.py")
    assert status == 0 and "lift_off" in out and "normal force vanished" in out


@pytest.mark.parametrize(("effects", "says"), [("Unilateral()", "gravity pulls it off"), ("", "hangs there")])
def test_check_notices_a_plate_on_the_wrong_side(desk, capsys, effects, says):
    """The valley run through from right to left has its left below it; run as the template has it, nothing is said."""
    text = TEMPLATE.format(name="my_valley").replace(", Unilateral()", f", {effects}")
    turned = text.replace("(s, -depth", "(-s, -depth").replace("xi1=-1.0", "xi1=1.0")
    assert turned != text
    for file, told in (("my_valley", text), ("turned", turned.replace("def my_valley", "def turned"))):
        (desk / f"{file}.py").write_text(told)
        status, out, _ = run(capsys, "check", file)
        assert status == 0 and ("Note: the plate lies on the left" in out) == (says in out) == (file == "turned"), out


def test_check_of_a_motion_that_fails_says_so_in_a_line(desk, capsys, monkeypatch):
    (desk / "my_valley.py").write_text(TEMPLATE.format(name="my_valley"))

    def fails(case):
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr(narration, "simulate", fails)
    assert "the motion fails: ZeroDivisionError" in refused(capsys, "check", "my_valley.py")


def test_points_beside_a_case_file_are_read_from_there(desk, capsys, tmp_path_factory, monkeypatch):
    """What the template advises: a path counts from the case file, wherever one works and however the file is named."""
    text = TEMPLATE.format(name="my_points")
    before = "Curve(lambda s: (s, -depth * cos(2 * s)), domain=(-3, 3))"
    assert before in text
    text = text.replace(before, 'Curve.from_csv("points.csv", closed=False)').replace("xi1=-1.0", "xi1=-0.8")
    s = np.linspace(-1.5, 1.5, 20)
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (desk / "scenes").mkdir()
    (desk / "scenes" / "my_points.py").write_text(text)
    np.savetxt(desk / "scenes" / "points.csv", np.column_stack([s, 0.3 * s**2]), delimiter=",")
    status, out, err = run(capsys, "check", "scenes/my_points.py")
    assert status == 0, err
    monkeypatch.chdir(elsewhere)  # as the workers of a report do
    assert cases.load("my_points").duration == 2.0
    status, out, err = run(capsys, "check", str(desk / "scenes" / "my_points.py"))
    assert status == 0 and "fits" in out, err


def test_the_template_advises_what_works():
    """Its comment on measured points is a call that Curve.from_csv takes."""
    (advice,) = re.findall(r"Curve\.from_csv\(.*?\)", TEMPLATE)
    assert eval(advice, {"Curve": SimpleNamespace(from_csv=lambda path, closed: (path, closed))}) == (
        "points.csv",
        False,
    )


def test_export_holds_what_a_scene_needs(desk, capsys):
    assert run(capsys, "export", "disc_on_line", "mu=0.1")[0] == 0
    scene = json.loads((desk / "disc_on_line" / "scene.json").read_text())
    (first,) = scene["transitions"]
    assert abs(first["time"]["value"] - 1 / (0.3 * 9.81)) <= first["time"]["bar"]
    assert scene["effects"]["Gravity"]["g"] == 9.81 and scene["start"]["slip"] == 1.0
    s, x, y, nx, ny, bend = np.loadtxt(desk / "disc_on_line" / "outline.csv", delimiter=",", skiprows=1).T
    assert bend == pytest.approx(10.0 + 0 * s)
    assert nx * x + ny * y == pytest.approx(-0.1 + 0 * s)  # the left normal points to the centre


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["shwo"], "choose from"),
        (["new"], "new NAME"),
        (["new", "my valley"], "cannot name a case"),
        (["new", "class"], "cannot name a case"),
        (["new", "disc_on_line"], "already a case"),
        (["check", "nowhere.py"], "no case file"),
        (["check"], "check FILE"),
        (["show"], "NAME"),
        (["show", "disc_on_lime"], "disc_on_line"),
        (["show", "disc_on_line", "mew=0.3"], "mu"),
        (["show", "disc_on_line", "mu=slippery"], "parameter=number"),
        (["show", "disc_on_line", "--colour"], "--colour"),
        (["show", "disc_on_line", "--out"], "--out"),
        (["export", "disc_on_line", "mu=-1"], "zero"),
    ],
)
def test_a_mistake_on_the_command_line_gives_one_line(desk, capsys, words, says):
    assert says in refused(capsys, *words)


@pytest.mark.parametrize(
    ("before", "after", "line", "says"),
    [
        ("domain=(-3, 3)", "domain=(3, -3)", True, "smaller number first"),
        ("cos(2 * s)", "cos(2 * t)", True, "'t' is not defined"),
        ("cos(2 * s)", "cos(2 * s", True, "never closed"),
        ("radius=0.1", "radius=3.0", True, "smaller plate"),
        ("xi1=-1.0", "xi1=-7.0", True, "outside the track's domain"),
        ("Start(", "Strat(", True, "Strat"),
        ("import cos", "import cosinus", True, "cosinus"),
        ("@case ", "# ", False, "@case"),
        ("return Case(", "Case(", False, "return a Case"),
    ],
)
def test_a_mistake_in_a_file_is_told_in_one_line_with_its_place(desk, capsys, before, after, line, says):
    text = TEMPLATE.format(name="my_valley")
    assert before in text
    (desk / "my_valley.py").write_text(text.replace(before, after))
    told = refused(capsys, "check", "my_valley.py")
    assert says in told and "my_valley.py" in told
    assert bool(re.search(r"my_valley\.py:\d+", told)) == line


def test_a_suite_that_is_not_installed_says_how_to_show(capsys, monkeypatch):
    monkeypatch.setattr("cases.commands.entry_points", lambda group, name: [])
    assert "python -m reports.show" in refused(capsys, "show", "disc_on_line")


def test_cases_of_an_installed_package_are_found(monkeypatch):
    loaded = []
    found = SimpleNamespace(value="their_package.cases", load=lambda: loaded.append(True))
    monkeypatch.setattr(registry, "entry_points", lambda group: [found] if group == "slip_to_roll.cases" else [])
    registry._import_catalogue.cache_clear()
    cases.names()
    assert loaded
