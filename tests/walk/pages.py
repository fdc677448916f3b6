"""What each page tells a reader to type, and what is printed then.

A `Step` is a command that is run as it stands there; a `Left` one is not, and says why. Commands with a word in
capitals for what a reader has to put in (CASE, FILE, NAME) are forms, and are not listed here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from .installed import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
_COMMANDS = re.compile(r"```sh\n(?P<block>.*?)```|`(?P<inline>(?:python -m|slip-to-roll) [^`]*)`", flags=re.S)
_FORM = re.compile(r"\b(NAME|CASE|FILE|ENGINE|COMMAND|DIR|YOUR_\w+|A B)\b")


def commands(page: Path) -> list[str]:
    """The commands of a page in their order, each once, without comments; not those that are forms."""
    found: list[str] = []
    for match in _COMMANDS.finditer(page.read_text(encoding="utf-8")):
        lines = (match["block"] or " ".join(match["inline"].split())).splitlines()
        found += [line.partition(" #")[0].strip() for line in lines]
    return list(dict.fromkeys(line for line in found if line and not _FORM.search(line)))


@dataclass(frozen=True)
class Step:
    """A command; `prints` are patterns that are found in what it prints, in this order; `writes` are patterns of files
    that are new after it. `clone`: it is run where the sources are. `needs`: a program without which it is skipped.
    `before`: what a reader does by hand before it, as a line of the shell."""

    command: str
    prints: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    clone: bool = False
    needs: str = ""
    before: str = ""


@dataclass(frozen=True)
class Left:
    """A command that the walk does not run, and why."""

    command: str
    why: str


@dataclass(frozen=True)
class Page:
    """The commands of a page; `files` are what a reader has made before the first of them, by name: the page and the
    language of the block that has the text."""

    steps: tuple[Step | Left, ...]
    files: dict[str, tuple[str, str]] = field(default_factory=dict)


CLONE = "it needs a clone; .ci/run and .ci/nightly make it there"
IN_A_COPY = "test_walk.py runs the page from top to bottom in a copy of the sources"
NODES = "it needs machines that answer to these names; tests/reports/test_sweep_cluster.py has them on loopback"
WHOLE = "a whole default report takes minutes; --quick goes the same way"
OF_A_RELEASE = "it changes the sources, at a release"

NEW = Step(
    "slip-to-roll cases new my_valley",
    (r"^written: my_valley\.py; edit its curve, then slip-to-roll cases check my_valley\.py$",),
    ("my_valley.py",),
)
CHECK = Step(
    "slip-to-roll cases check my_valley.py",
    (r"^my_valley: fits; slides forward for 0\.87 s, then rolls for 0\.022 s, then slides backward to the end of 2 s",),
)
ACCEPTED = Step("pytest --case-file=my_valley.py", (r"my_valley", r"verdict: all \d+ checks are within"), clone=True)
REPORT = ("report/index.html", "report/manifest.json", "report/tables/transitions.csv")
BUILT = (r"^1 case, \d+ runs: \d+ answered \(", r"/report/index\.html$")
ASSISTED = r"^ *pymunk assisted +1 of 1 "
EXPORTED = Step(
    "slip-to-roll cases export disc_in_circle mu=0.2",
    (r"^written: disc_in_circle/scene\.json$", r"^written: disc_in_circle/motion\.csv$"),
    ("disc_in_circle/scene.json", "disc_in_circle/motion.csv"),
)
COMPARED = Step(
    'slip-to-roll compare "disc_in_circle[mu=0.2]" disc_in_circle/motion.csv',
    (
        r"^motion\.csv on disc_in_circle\[mu=0\.2\]: off .*: excellent; friction × 1; ",
        r"slip_forward\s+roll\s+0\.630053",
        r"^Laws broken\nnone$",
    ),
)
SWEPT = (r"map\.svg$", r"^40000 scenarios of disc_in_circle, 40000 of them made now; rows: ")
MAP = ("sweep/sweep.json", "sweep/map.svg")

MY_ENGINE = {"my_engine": ("process_protocol.md", "js")}

WALK = {
    "README.md": Page(
        (
            Left("slip-to-roll release publish", OF_A_RELEASE),
            Left("make report", CLONE),
            Left("make test", CLONE),
            EXPORTED,
            COMPARED,
            Step(
                "slip-to-roll report --quick --engine ./my_engine",
                (
                    r"^ *(\d\. )?my_engine process +1 of 3 ",
                    r"^3 cases, \d+ runs: \d+ answered \(",
                    r"/report/index\.html$",
                ),
                REPORT,
                needs="node",
            ),
            NEW,
            CHECK,
            Step("slip-to-roll report --quick --case-file my_valley.py", (ASSISTED, *BUILT), REPORT),
        ),
        MY_ENGINE,
    ),
    "add_a_case.md": Page(
        (
            NEW,
            CHECK,
            Step(
                "slip-to-roll cases show my_valley mu=0.3",
                (r"^my_valley\[mu=0\.3\]$", r"begins: roll", r"reference: runs it", r"picture: my_valley\.png"),
                ("my_valley.png",),
            ),
            Step("slip-to-roll cases film my_valley", (r"s of animation.*: my_valley\.gif$",), ("my_valley.gif",)),
            ACCEPTED,
            Step(
                "slip-to-roll report --case-file my_valley.py",
                (r"^Off \(100 %: as bad as ignoring friction's law\)", ASSISTED, *BUILT),
                REPORT,
            ),
        )
    ),
    "add_an_engine.md": Page(
        (
            EXPORTED,
            COMPARED,
            Step(
                'slip-to-roll report --case "disc_in_circle[mu=0.2]" --trajectory mine=disc_in_circle/motion.csv',
                (r"^ *(\d\. )?mine file +1 of 1 +– +< 0\.0001 % +0 \+ 1 +1$", ASSISTED, *BUILT),
                REPORT,
            ),
            Step(
                "slip-to-roll report study error_parts",
                (r"^written: .*error_parts/error_parts\.csv$",),
                ("error_parts/error_parts.csv",),
            ),
        )
    ),
    "architecture.md": Page((Step('slip-to-roll report --case "disc_in_circle[mu=0.2]"', (ASSISTED, *BUILT), REPORT),)),
    "cluster.md": Page(
        (
            Step(
                "slip-to-roll sweep disc_in_circle --vary mu=0.01:0.5:200 --vary xi1=0:1.5:200 --jobs 2",
                (*SWEPT, r"5,990  slips forward, then slips backward$"),
                MAP,
            ),
            Step(
                "slip-to-roll sweep disc_in_circle --vary mu=1e-3:10:log --vary xi1=0:1.5 --sample sobol "
                "--number 65536 --out drawn",
                (r"^65536 scenarios of disc_in_circle, 65536 of them made now",),
                ("drawn/sweep.json", "drawn/map.svg"),
            ),
            Step(
                "slip-to-roll sweep disc_in_circle --vary mu=0.01:0.19:4 --vary xi1=0:1.4:8 --refine 1e-10 --out edges",
                (r"^32 scenarios of disc_in_circle, 32 of them made now", r"^boundaries: .*\(\d+ points, \d+ more"),
                ("edges/sweep.json", "edges/map.svg"),
            ),
            Step(
                "slip-to-roll sweep disc_in_circle --vary mu=0.01:0.4:31 --vary xi1=0:1.5:25 "
                "--solver exudyn pymunk --out engines",
                (r"exudyn", r"pymunk", r"^775 scenarios of disc_in_circle, 775 of them made now"),
                ("engines/sweep.json", "engines/map.svg"),
            ),
            Left("node0$ dask scheduler --host node0", NODES),
            Left("node1$ dask worker tcp://node0:8786 --nworkers 16 --nthreads 1", NODES),
            Left("node2$ dask worker tcp://node0:8786 --nworkers 16 --nthreads 1", NODES),
            Left(
                "node0$ slip-to-roll sweep disc_in_circle --vary mu=0.01:0.5:30000 --vary xi1=0:1.5:30000 "
                "--dask tcp://node0:8786",
                NODES,
            ),
            Left("slip-to-roll report --dask tcp://node0:8786", NODES),
        )
    ),
    "engine_history.md": Page(
        (
            Left(
                "slip-to-roll history pymunk exudyn box2d",
                "it installs 40 versions; tests/reports/test_history.py runs two",
            ),
        )
    ),
    "engine_parameters.md": Page((Left("python -m tests.benchmarks.meanings", OF_A_RELEASE),)),
    "index.md": Page((Left("make report", CLONE), Left("make test", CLONE))),
    "install.md": Page(
        (
            Left("python3 -m venv .venv", "the walk installs the wheel in an environment of its own"),
            Left('.venv/bin/pip install -e ".[taylor,test]"', CLONE),
            Left(".venv/bin/slip-to-roll report", CLONE),
            Left(".venv/bin/python -m pytest", CLONE),
            Left('pipx install ".[taylor]"', "the walk installs the wheel in an environment of its own"),
            Step("slip-to-roll report --quick", (r"^3 cases, \d+ runs: \d+ answered \(",), REPORT),
        )
    ),
    "limits.md": Page((Left("python -m cases.scene.limits_page > docs/limits.md", OF_A_RELEASE),)),
    "own_effects.md": Page((Left("slip-to-roll laws", "the form of the command on the page of engines"),)),
    "page.md": Page(
        (
            Left("python -m tests.browser.vendor", OF_A_RELEASE),
            Left("apt-get install chromium", "it changes the system; .ci/nightly does where it may"),
            Left("make browser", CLONE),
            Left(".venv/bin/python -m pytest tests/browser", CLONE),
        )
    ),
    "paper.md": Page((Left("python -m tests.benchmarks paper", CLONE),)),
    "process_protocol.md": Page(
        (
            Step(
                'slip-to-roll report --engine ./my_engine --case "disc_on_line[mu=0.1]"',
                (r"^ *(\d\. )?my_engine process +1 of 1 ", *BUILT),
                REPORT,
                needs="node",
            ),
            Step("slip-to-roll laws ./my_engine", (r"^my_engine: .*\d+ kept",), needs="node"),
            Step(
                "slip-to-roll cases export disc_on_line mu=0.1",
                (r"^written: disc_on_line/motion\.csv$",),
                ("disc_on_line/scene.json", "disc_on_line/motion.csv"),
            ),
            Left("slip-to-roll report --quick --engine ./my_engine", "README has it"),
            Step(
                "slip-to-roll report --quick --engine ./my_engine --points 5001",
                (r"^ *(\d\. )?my_engine process +1 of 3 ", r"/report/index\.html$"),
                REPORT,
                needs="node",
            ),
            Step(
                "slip-to-roll cases export disc_in_circle --points 5001",
                (r"^written: disc_in_circle/scene\.json$",),
                ("disc_in_circle/scene.json", "disc_in_circle/track.csv"),
            ),
        ),
        MY_ENGINE,
    ),
    "proofs.md": Page(
        (
            Left('pip install -e ".[proofs]"', "the walk installs the wheel, and python-flint before the next step"),
            Step(
                'slip-to-roll prove "disc_in_circle[mu=0.2]" --digits 50',
                (
                    r"\[0\.63005376392730307737114978183480012127161082126899",
                    r"^written: disc_in_circle_mu_0\.2\.proof\.json",
                ),
                ("disc_in_circle_mu_0.2.proof.json",),
                before="python -m pip install --quiet --disable-pip-version-check python-flint",
            ),
            Step(
                "slip-to-roll prove check disc_in_circle_mu_0.2.proof.json",
                (r"^confirmed: disc_in_circle\[mu=0\.2\], 4 transitions",),
            ),
        )
    ),
    "published.md": Page(
        (
            Left("slip-to-roll report", WHOLE),
            Left("slip-to-roll release publish report", OF_A_RELEASE),
            Step(
                "slip-to-roll release deposit docs/results/0.3.0",
                (r"^slip-to-roll-results-0\.3\.0\.zip, \d+\.\d MB: upload it",),
                ("slip-to-roll-results-0.3.0.zip",),
                before=f"ln -s {ROOT / 'docs'} docs",
            ),
        )
    ),
    "report.md": Page(
        (
            Left("slip-to-roll report", WHOLE),
            Left(
                "slip-to-roll report --solver pymunk@6.11.1 pymunk@7.3.1",
                "a whole default report; tests/reports/test_versions.py makes a small one",
            ),
            Left(
                "slip-to-roll compare report report --solver pymunk@6.11.1 --solver pymunk@7.3.1",
                "it reads the report above",
            ),
            Left(
                "slip-to-roll history pymunk exudyn box2d",
                "it installs 40 versions; tests/reports/test_history.py runs two",
            ),
            Left(
                "slip-to-roll compare A report --solver exudyn --worse-than 10%",
                "A stands for a report of the reader's",
            ),
            Step(
                'slip-to-roll cases show "disc_in_circle[mu=0.2]" --engines --out disc.pdf',
                (r"^engines: .*disc_engines\.pdf$", r"^errors: .*disc_errors\.pdf$"),
                ("disc.pdf", "disc_engines.pdf", "disc_errors.pdf"),
            ),
            Step("slip-to-roll report --quick --paper", (r"^3 cases, \d+ runs: \d+ answered \(",), REPORT),
            Step(
                "slip-to-roll report study stability",
                (r"stability/stability\.csv",),
                ("stability/stability.csv",),
            ),
            Step(
                "slip-to-roll cases film disc_in_circle mu=0.2 --out disc.gif",
                (r"^2\.5 s of animation, 1 × real time, \d+ kB: disc\.gif$",),
                ("disc.gif",),
            ),
        )
    ),
    "submit.md": Page(
        (
            Step("slip-to-roll cases", (r"^disc_in_circle +",)),
            Step('slip-to-roll cases export "disc_in_circle[mu=0.2]"', EXPORTED.prints, EXPORTED.writes),
            Step(
                "slip-to-roll compare submissions/my_engine/2.1.0",
                (r"^my_engine 2\.1\.0, by Ada Example", r"disc_in_circle\[mu=0\.2\] +answered +excellent "),
                before='cp disc_in_circle/motion.csv "submissions/my_engine/2.1.0/disc_in_circle[mu=0.2].csv"',
            ),
            Step(
                'slip-to-roll report --case "disc_in_circle[mu=0.2]" --submissions submissions',
                (r"^ *(\d\. )?my_engine 2\.1\.0 submission +1 of 1 +– +< 0\.0001 % +0 \+ 1 +1$", ASSISTED, *BUILT),
                REPORT,
            ),
        ),
        {"submissions/my_engine/2.1.0/submission.toml": ("submit.md", "toml")},
    ),
    "test_an_engine.md": Page(
        (
            Left(
                "pip install slip_to_roll-*.whl pytest", "the walk installs the wheel, and pytest before the next step"
            ),
            Step(
                "pytest --slip-to-roll-engine ./my_engine",
                (r"\b1 passed, 6 skipped in ",),
                needs="node",
                before="python -m pip install --quiet --disable-pip-version-check pytest",
            ),
            Step("slip-to-roll release benchmark", (r"canonical-friction-benchmark-[0-9.]+\.zip, .* MB: 48 scenes",)),
        ),
        MY_ENGINE,
    ),
    "tutorial.md": Page(
        (
            Left("python3 -m venv .venv && . .venv/bin/activate", IN_A_COPY),
            Left('pip install -e ".[taylor]"', IN_A_COPY),
        )
    ),
    "truth.md": Page((Left("python -m reference", OF_A_RELEASE),)),
}
