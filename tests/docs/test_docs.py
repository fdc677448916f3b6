"""What README, the pages and the gallery show is run: code as it stands there, commands by their names and options."""

import importlib.util
import json
import re
from itertools import islice
from pathlib import Path

import pytest

import reference
from cases.pictures import animation
from reference.proofs import command
from reports import cli, options
from reports.analysis import levels, time_to_accuracy
from reports.analysis.columns import COLUMNS
from reports.analysis.table_list import TABLES
from reports.judging.grades import LIMITS
from reports.running.names import REFERENCE

ROOT = Path(__file__).parent.parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
_NOT_RUN = re.compile(r"<!-- not run: .*? -->\s*```python\n.*?```", flags=re.S)


@pytest.fixture
def desk(tmp_path, monkeypatch, catalogue):
    """A folder to write into, films of few pictures, and of sweeps that go on for minutes the first chunks."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(animation, "FRAMES_A_SECOND", 1)
    whole = reference.sweep_chunks
    monkeypatch.setattr(reference, "sweep_chunks", lambda *of, **over: islice(whole(*of, **over), 2))
    return tmp_path


def codes(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", _NOT_RUN.sub("", page.read_text(encoding="utf-8")), flags=re.S)


WITH_CODE = [page for page in PAGES if codes(page, "python")]


@pytest.mark.parametrize("page", WITH_CODE, ids=lambda page: page.name)
def test_the_code_of_a_page_runs_from_top_to_bottom(page, desk):
    names: dict = {"__name__": "page"}
    for number, code in enumerate(codes(page, "python"), start=1):
        exec(compile(code, f"{page.name}, block {number}", "exec"), names)


COMMANDS = [
    (page.name, line.partition("#")[0].strip())
    for page in PAGES
    for block in codes(page, "sh")
    for line in block.splitlines()
    if line.startswith(("slip-to-roll ", "python -m"))
]


@pytest.mark.parametrize(("page", "line"), COMMANDS, ids=[line for _, line in COMMANDS])
def test_a_command_of_a_page_exists_and_takes_its_options(page, line):
    words = line.split()
    name = next((one for one in (" ".join(words[1:3]), words[1]) if one in cli.COMMANDS), "")
    assert importlib.util.find_spec(cli.COMMANDS[name][0] if name else words[2]) is not None
    known = {f"--{name.replace('_', '-')}" for name in options._OPTIONS}
    known |= {option for action in command.parser()._actions for option in action.option_strings}
    assert set(re.findall(r"--[a-z-]+", line)) <= known


def test_the_page_on_reports_has_the_limits_of_the_grades():
    page = (ROOT / "docs" / "report.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([a-z ]+) \| ([0-9.]+) \|$", page, flags=re.M)
    assert {name: float(limit) for name, limit in rows} == {str(name): limit for name, limit in LIMITS.items()}


def test_links_lead_somewhere():
    for page in (*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"):
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_site_leaves_no_page_out():
    outcome_text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    for page in (ROOT / "docs").iterdir():
        assert page.suffix not in (".md", ".ipynb") or f": {page.name}\n" in outcome_text, page.name


def test_the_page_on_reports_lists_every_value_of_reached_and_names_columns_and_tables_that_exist():
    page = (ROOT / "docs" / "report.md").read_text(encoding="utf-8")
    names = vars(levels) | vars(time_to_accuracy)
    values = {v for n, v in names.items() if n.isupper() and isinstance(v, str)} - {REFERENCE}
    assert set(re.findall(r"^\| `([^`]+)` \|", page, flags=re.M)) == values
    tables = {f"{name}.csv" for name in TABLES}
    assert {name for name in re.findall(r"(\w+\.csv)", page)} <= tables
    columns = set(re.findall(r"`([a-z]+(?:_[a-z]+)+)`", page))
    assert columns and columns <= COLUMNS.keys() | {"timed_out"}


@pytest.mark.slow  # code of the other pages runs in the quick tests
def test_the_gallery_runs_and_shows_itself(desk):
    shown = cells_shown(ROOT / "docs" / "gallery.ipynb")
    assert {"Case", "Trajectory", "Picture", "Animation", "Comparison", "DataFrame"} <= set(shown)


def cells_shown(notebook: Path) -> list[str]:
    """The types of what the cells of a notebook end with: each is run, and shows itself as a notebook asks for it."""
    names: dict = {"__name__": "gallery"}
    shown = []
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            *before, last = "".join(cell["source"]).split("\n")
            exec("\n".join(before), names)
            thing = eval(last, names)
            rich = [getattr(thing, name)() for name in ("_repr_html_", "_repr_png_") if hasattr(thing, name)]
            shown += [type(thing).__name__]
            assert any(text and len(text) > 100 for text in rich), type(thing)
            assert len(repr(thing)) < 1000
    return shown


def test_the_gallery_has_the_outputs_of_all_cells_and_is_small():
    file = ROOT / "docs" / "gallery.ipynb"
    cells = [cell for cell in json.loads(file.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    kinds = {kind for cell in cells for output in cell["outputs"] for kind in output.get("data", {})}
    assert len(cells) > 25 and all(cell["outputs"] for cell in cells) and {"image/png", "text/html"} <= kinds
    assert not any(output["output_type"] == "error" for cell in cells for output in cell["outputs"])
    assert file.stat().st_size < 1_000_000


def test_the_pages_are_in_the_order_tutorial_how_to_reference_explanation():
    """Both in the index, which links to every page, and in the navigation of the site."""
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    groups = ["Tutorial", "How-to guides", "Reference", "Explanation"]
    assert re.findall(r"^## (.*)$", index, flags=re.M) == groups
    assert re.findall(r"^  - (.*):$", navigation, flags=re.M) == groups
    pages = re.findall(r": (\w+\.\w+)$", navigation, flags=re.M)
    assert ["index.md", *re.findall(r"^\| \[[^]]*\]\((\w+\.\w+)\)", index, flags=re.M)] == pages
