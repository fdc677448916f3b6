"""The command `python -m cases`, tried as a new user would, with a deliberate mistake at each step."""

import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import cases
from cases import lookup
from cases.commands import TEMPLATE, main
from cases.files import command_line, owned_folder, trial
from reports import animate, build, options


@pytest.fixture
def desk(tmp_path, monkeypatch, catalogue):
    """An empty working folder, and a catalogue that forgets what is loaded. The commands are those that are installed:
    where pyproject.toml is newer than the installation, `pip install -e .` (or make) declares them."""
    monkeypatch.chdir(tmp_path)
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


def test_new_then_check_then_show_works_without_an_edit(desk, capsys, in_process):
    assert run(capsys, "new", "my_valley")[0] == 0
    status, out, _ = run(capsys, "check", "my_valley.py")
    assert status == 0 and "my_valley: fits" in out
    with in_process():
        status, out, _ = run(capsys, "show", "my_valley", "mu=0.2")  # it is found where one works
    assert status == 0 and "mu = 0.2" in out and "reference: runs it" in out
    assert (desk / "my_valley.png").stat().st_size > 10_000


def test_check_runs_the_motion_and_says_what_happens(desk, capsys):
    """A third in a curve is an ordinary number; a motion that ends early says why."""
    text = TEMPLATE.format(name="my_bowl")
    text = text.replace("-depth * cos(2 * s)", "depth * s**2 / 3").replace("mu=0.1,", "mu=0.05,")
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
    for file, output in (("my_valley", text), ("turned", turned.replace("def my_valley", "def turned"))):
        (desk / f"{file}.py").write_text(output)
        status, out, _ = run(capsys, "check", file)
        assert status == 0 and ("Note: the plate lies on the left" in out) == (says in out) == (file == "turned"), out


def test_points_beside_a_case_file_are_read_from_there(desk, capsys, tmp_path_factory, monkeypatch):
    """What the template advises: a path counts from the case file, wherever one works and however the file is named."""
    text = TEMPLATE.format(name="my_points")
    before = "Curve(lambda s: (s, -depth * cos(2 * s)), domain=(-3, 3))"
    assert before in text
    text = text.replace(before, 'Curve.spline("points.csv", closed=False)').replace("xi1=-1.0", "xi1=0.8")
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
    output = refused(capsys, "check", "my_valley.py")
    assert says in output and "my_valley.py" in output
    assert bool(re.search(r"my_valley\.py:\d+", output)) == line


# Files of an author who makes a mistake of the more surprising kind: what they hold, and what is said of them.
ODD = {
    "no_text": ("raise Exception", "odd.py:1: the case file odd.py fails: Exception"),
    "no_text_in_its_case": (
        "from cases import case\n@case\ndef odd():\n    raise AssertionError",
        "odd.py:4: odd cannot be made with its own parameters: AssertionError",
    ),
    "text_that_fails": (
        "class Odd(Exception):\n    def __str__(self):\n        raise ValueError\nraise Odd",
        "odd.py:4: the case file odd.py fails: Odd: (its text cannot be read)",
    ),
    "no_exception": (
        "class Odd(BaseException):\n    pass\nraise Odd('a b')",
        "odd.py:3: the case file odd.py fails: Odd: a b",
    ),
    "interrupt": ("raise KeyboardInterrupt", "odd.py:1: KeyboardInterrupt"),
    "exit": (
        "import os\nprint('so long')\nos._exit(7)",
        "the case file odd.py ends the process (exit status 7) instead of returning a case",
    ),
    "signal": (
        "import os, signal\nos.kill(os.getpid(), signal.SIGTERM)",
        "the case file odd.py ends the process (signal SIGTERM) instead of returning a case",
    ),
    "thread": (
        f"import threading, time\nthreading.Thread(target=time.sleep, args=(1e6,), name='odd').start()\n"
        f"{TEMPLATE.format(name='odd')}",
        "the case file leaves the thread 'odd' running; end it, or give it daemon=True",
    ),
    "asks": ("input('your name?')", "odd.py:1: the case file odd.py fails: EOFError: EOF when reading a line"),
    "endless": (
        "import signal\nsignal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())\nwhile True:\n    pass",
        "the case file odd.py does not end within 1.5 s; look for a loop without end in it",
    ),
}


@pytest.mark.parametrize("way", ODD)
def test_a_file_that_fails_in_an_odd_way_is_one_line_of_every_command(way, desk, capfd, monkeypatch):
    monkeypatch.setattr(trial, "SECONDS", 1.5)
    text, says = ODD[way]
    (desk / "odd.py").write_text(text)
    for command, main_of, words in (
        ("cases", main, ["check", "odd.py"]),
        ("reports.build", build.main, ["--list", "--case-file", "odd.py"]),
        ("reports.animate", animate.main, ["odd.py"]),
    ):
        if (way, command) == ("no_text_in_its_case", "reports.build"):
            continue  # which lists such a case, and why it cannot be made
        assert main_of(words) == 2
        out, err = capfd.readouterr()
        assert out == "" and err.startswith(f"{command}: {says}") and err.count("\n") == 1, err
    assert [path.name for path in desk.iterdir() if path.name != "__pycache__"] == ["odd.py"]


TWO = '''
import cases
from cases import case


@case(variants=[dict(mu=0.1), dict(mu=0.3)])
def slow_one(mu=0.2):
    """It slides. Source: this test."""
    return cases.load("disc_on_line", mu=mu)


@case
def fast_one(mu=0.2):
    """It slides. Source: this test."""
    return cases.load("disc_on_line", mu=mu, v0=2.0)
'''


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("disc_in_circle", [f"disc_in_circle[mu={mu}]" for mu in (0.01, 0.1, 0.2)]),
        ("disc_on_line[mu=0.25]", ["disc_on_line[mu=0.25]"]),
        ("two.py", ["slow_one[mu=0.1]", "slow_one[mu=0.3]", "fast_one"]),
        ("two", ["slow_one[mu=0.1]", "slow_one[mu=0.3]", "fast_one"]),
        ("two.py:slow_one", ["slow_one[mu=0.1]", "slow_one[mu=0.3]"]),
        ("two:fast_one[mu=0.3]", ["fast_one[mu=0.3]"]),
    ],
)
def test_a_case_is_found_by_name_variant_file_and_function(text, labels, desk, capsys):
    (desk / "two.py").write_text(TWO)
    assert [case.label for case in lookup.case_name(text).every()] == labels
    found, files = options.choose_cases([text], "default")
    assert [case.label for case in found] == labels
    assert files == ((str(desk / "two.py"),) if "two" in text else ())
    out = run(capsys, "check", text)[1]
    assert [line.partition(":")[0] for line in out.splitlines() if ": fits; slides" in line] == labels


@pytest.mark.parametrize(
    ("words", "file"),
    [
        (["new", "my_valley"], "my_valley.py"),
        (["show", "disc_on_line"], "disc_on_line.png"),
        (["export", "disc_on_line"], "disc_on_line/outline.csv"),
    ],
)
def test_a_file_that_is_there_is_overwritten_only_by_force(desk, capsys, words, file, in_process):
    """Whoever wrote it, whatever it says, and whatever stands beside it."""
    (desk / file).parent.mkdir(exist_ok=True)
    (desk / file).write_text("my notes on slip-to-roll")
    if words[0] == "export":
        (desk / "disc_on_line" / "scene.json").write_text('{"made_by": "slip-to-roll export"}')
    assert "exists already; give another name, or --force to overwrite it" in refused(capsys, *words)
    assert (desk / file).read_text() == "my notes on slip-to-roll"
    with in_process():
        assert run(capsys, *words, "--force")[0] == 0
    assert (desk / file).stat().st_size > 100
    assert "exists already" in refused(capsys, *words)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_command_that_is_ended_leaves_no_unfinished_file(number, code, tmp_path, capsys):
    def work(words):
        with owned_folder.atomic_path(tmp_path / "result") as partial, owned_folder.TemporaryFolder(tmp_path):
            assert partial.exists()
            os.kill(os.getpid(), number)
            time.sleep(60.0)

    # A shell's command in the background ignores Ctrl-C; there is none here.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert command_line.status("test", work, []) == code
    finally:
        signal.signal(signal.SIGINT, before)
    assert list(tmp_path.iterdir()) == [] and capsys.readouterr().err == "\ntest: stopped\n"
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


def test_a_reader_that_has_enough_hears_nothing_more():
    """As `head`, which closes the pipe."""
    run = [sys.executable, "-m", "cases", "list"]
    with subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 128 + signal.SIGPIPE


@pytest.mark.parametrize("module", ["cases", "reports.build"])
def test_a_shell_without_address_space_is_told_so_at_once(module, tmp_path):
    """In 0.9 GB the BLAS of SciPy waits for ever for its buffers."""
    words = f"ulimit -v 900000; exec {sys.executable} -m {module} {'show disc_on_line' if module == 'cases' else ''}"
    output = subprocess.run(["bash", "-c", words], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert output.returncode == 2 and output.stderr.count("\n") == 1 and list(tmp_path.iterdir()) == []
    assert output.stderr.endswith(
        "the shell limits the address space to 0.86 GB, and 2 GB are needed; type: ulimit -v unlimited\n"
    )
