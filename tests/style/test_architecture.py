"""The direction of the arrows: which part of each room may import which; and that docs/architecture.md says so."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path

import pytest

from adapters.lookup import NO_ADAPTERS
from reference.endings import STATUSES
from reports.running.storage import source_code

ROOT = Path(__file__).parents[2]
ALLOWED = {
    "cases": set(),
    "reference": {"cases"},
    "adapters": {"cases"},
    "reports": {"cases", "reference", "adapters"},
}
# Of `reports`, from the top: each may import what stands below it. Those of one floor do not import each other.
FLOORS = (
    {"cli"},
    {
        "build", "compare", "compare_builds", "comparison", "gate", "history", "publish", "submit",
        "study", "show", "export", "sweep", "animate", "cite", "deposit", "benchmark", "readers", "engine_tests",
    },
    {"options"},
    {"page"},
    {"studies"},
    {"sweeping"},
    {"drawing"},
    {"analysis"},
    {"running"},
    {"judging"},
)  # fmt: skip
# Commands that name one case with the same words, and `compare` with its two questions about reports.
NEIGHBOURS = {
    "export": {"show"}, "animate": {"show"}, "submit": {"compare"}, "publish": {"deposit"}, "benchmark": {"deposit"},
    "compare": {"compare_builds", "gate"}, "gate": {"compare_builds"},
}  # fmt: skip


@cache
def nodes(source: str) -> list[ast.AST]:
    """All nodes of a source text; a text is parsed once for all tests."""
    return [*ast.walk(ast.parse(source))]


@cache
def imported(file: Path, only_at_once: bool = False) -> set[str]:
    """The modules a file may import, by their full names, wherever in it the import stands, `import_module("…")`
    included; or those alone that are imported with the file itself."""
    package = ".".join(file.parent.relative_to(ROOT).parts)
    found = set[str]()
    for node in ast.parse(file.read_text()).body if only_at_once else nodes(file.read_text()):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), package) if node.level else str(node.module)
            # `from package import module` imports the module; the package's own names come from the package.
            inside = {f"{base}.{alias.name}" for alias in node.names}
            found |= {name for name in inside if is_module(name)} or {base, *inside}
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            if getattr(node.func, "attr", getattr(node.func, "id", "")) == "import_module":
                name = str(node.args[0].value)
                found.add(resolve_name(name, package) if name.startswith(".") else name)
    return found


def is_module(name: str) -> bool:
    """Whether the suite has a module or a package of that name."""
    path = ROOT / name.replace(".", "/")
    return path.is_dir() or path.with_suffix(".py").is_file()


def modules(room: str) -> dict[str, Path]:
    """The modules of a room by their full names."""
    names = {file.relative_to(ROOT).with_suffix(""): file for file in sorted((ROOT / room).rglob("*.py"))}
    return {".".join(name.parts).removesuffix(".__init__"): file for name, file in names.items()}


def part_of(module: str) -> str:
    """The part of its room that a module belongs to: its second name; of `adapters` "engine" for those of engines."""
    room, _, rest = module.partition(".")
    part = rest.partition(".")[0]
    return "engine" if room == "adapters" and part and part not in NO_ADAPTERS else part


def arrows(room: str, only_at_once: bool = False) -> Iterator[tuple[str, str]]:
    """Which module of a room imports which other one; the room itself has the names of all its parts."""
    known = modules(room)
    for name, file in known.items():
        for other in imported(file, only_at_once) & known.keys() - {room, name}:
            if name != room:
                yield name, other


@pytest.mark.parametrize("room", ALLOWED)
def test_rooms_import_only_what_the_design_allows(room):
    files = modules(room).values()
    assert files
    for file in files:
        assert {name.split(".")[0] for name in imported(file)} & ALLOWED.keys() <= ALLOWED[room] | {room}, file


# Parts of `reference`: each may import what stands beside it here. Two formulations and the paper's letters know
# nothing of each other, or they could not witness for each other. Scales have units and roundings, and no law.
PARTS = {
    "scales": set(),
    "time_limit": set(),
    "paper": set(),
    "curvature_proof": set(),
    "endings": set(),
    "effect_laws": set(),
    "minimal": {"effect_laws", "scales", "time_limit", "curvature_proof", "endings"},
    "augmented_integrator": {"effect_laws", "minimal", "paper"},
    "solver": {"effect_laws", "minimal", "scales", "time_limit", "endings", "curvature_proof"},
    "witness": {"scales", "time_limit"},
    "solve": {"minimal", "augmented_integrator", "solver", "solution_check", "endings", "impulses"},
    "narration": {"solve"},
    "laws_check": {"scales", "curvature_proof", "endings"},
    "parameter_derivatives": {"certification", "solve"},
    "impulses": {"laws_check"},
    "solution_check": {"minimal", "solver", "laws_check", "endings"},
    "errata": {"paper", "solve"},
    "proofs": set(),
    "proof_checker": set(),
    "certification": {"solve", "minimal", "witness", "proofs", "laws_check", "time_limit", "endings"},
    "sweeping": {
        "effect_laws",
        "certification",
        "solve",
        "minimal",
        "laws_check",
        "solution_check",
        "curvature_proof",
        "endings",
        "scales",
    },
}
# Parts of `cases`, a folder or a module at the top: each may import the parts in its row, and all may import the
# errors and the lock. Formulas know no curve, curves no contact, contacts no case, and cases no motion.
BASE = {"errors", "derivation"}
CASE_PARTS = {
    "derivation": set(),
    "errors": {"derivation"},
    "version": set(),
    "fits": set(),
    "files": set(),
    "formulas": set(),
    "curves": {"files", "formulas"},
    "library": {"curves", "formulas"},
    "constructions": {"curves", "formulas"},
    "moving_surface": {"formulas"},
    "own_effects": {"formulas"},
    "slip_laws": {"formulas"},
    "effects": {"formulas", "moving_surface", "own_effects", "slip_laws"},
    "pictures": {"curves", "files"},
    "contact": {"curves", "effects", "formulas", "moving_surface"},
    "scene": {"contact", "curves", "effects", "library", "moving_surface", "own_effects", "pictures"},
    "motion": {"contact", "effects", "files", "moving_surface", "own_effects", "pictures", "scene"},
    "moving_frame": {"contact", "effects", "formulas", "motion", "scene"},
    "catalogue": {"curves", "effects", "library", "moving_surface"},
    "registry": {"catalogue", "curves", "files", "scene"},
    "lookup": {"files", "registry", "scene"},
    "commands": {"files", "lookup", "registry"},
    "__main__": {"commands"},
}
# Arrows against the table, which import nothing when the module itself is imported.
CASE_PARTS_LATE = {
    ("curves", "pictures"): "`Curve.plot` imports what draws when it is called",
    ("contact", "scene"): "the classes Case and Plate, for type checkers alone",
}
ADAPTER_PARTS = {
    "executables": set(),
    "interface": set(),
    "common": {"interface"},
    "gate": {"interface"},
    "laws": {"interface", "lookup", "gate", "processes"},
    "lookup": {"interface", "by_process"},
    "processes": {"common", "lookup"},
    "by_process": {"interface", "common"},
    "engine": {"interface", "common"},
}
REPORT_PARTS = {
    name: set().union(*FLOORS[number + 1 :]) | NEIGHBOURS.get(name, set())
    for number, floor in enumerate(FLOORS)
    for name in floor
}
TABLES = {"cases": CASE_PARTS, "reference": PARTS, "adapters": ADAPTER_PARTS, "reports": REPORT_PARTS}


def upward(room: str, only_at_once: bool = False) -> set[tuple[str, str]]:
    """The arrows between parts of a room that its table does not allow."""
    table = TABLES[room]
    between = {(part_of(a), part_of(b)) for a, b in arrows(room, only_at_once)}
    base = BASE if room == "cases" else set()
    return {(a, b) for a, b in between if a != b and a != "__main__" and b not in table[a] | base}


@pytest.mark.parametrize("room", TABLES)
def test_parts_of_a_room_import_only_what_stands_below_them(room):
    assert {part_of(name) for name in modules(room)} - {"", "__main__"} == TABLES[room].keys() - {"__main__"}
    assert list(TopologicalSorter(TABLES[room]).static_order())
    late = CASE_PARTS_LATE.keys() if room == "cases" else set()
    assert upward(room) == late
    assert not upward(room, only_at_once=True) & late


def test_parts_of_the_reference_import_only_what_stands_below_them():
    """The witnesses share no code: neither formulation reaches the other, the paper's letters or the proofs."""
    for one, other in (("minimal", "witness"), ("solver", "witness"), ("proof_checker", "proofs"), ("paper", "solver")):
        assert not {(a, b) for a, b in arrows("reference") if {part_of(a), part_of(b)} == {one, other}}


@pytest.mark.parametrize("room", TABLES)
def test_a_room_has_no_circle(room):
    graph = {name: set[str]() for name in modules(room)}
    for name, other in arrows(room):
        # Cases of the catalogue import `cases`, like a user's case. A module's package is imported by its being there.
        if not name.startswith(("cases.catalogue", f"{other}.")):
            graph[name].add(other)
    list(TopologicalSorter(graph).static_order())


def test_no_engine_knows_another():
    engines = [(a, b) for a, b in arrows("adapters") if part_of(a) == part_of(b) == "engine"]
    assert engines and all(a.split(".")[1] == b.split(".")[1] for a, b in engines)


def test_an_arrow_upwards_is_seen(tmp_path, monkeypatch):
    (tmp_path / "reports" / "judging").mkdir(parents=True)
    (tmp_path / "reports" / "running").mkdir()
    (tmp_path / "reports" / "running" / "tasks.py").touch()
    monkeypatch.setattr(f"{__name__}.ROOT", tmp_path)
    for number, text in enumerate(("from ..running import tasks", "import_module('..running.tasks', __name__)")):
        file = tmp_path / "reports" / "judging" / f"wrong{number}.py"
        file.write_text(f"def late():\n    {text}\n")
        assert "reports.running.tasks" in imported(file)
    assert "running" not in REPORT_PARTS["judging"] and "judging" in REPORT_PARTS["running"]


def test_keys_of_results_know_the_floors_of_reports():
    floors = [*reversed([name for floor in FLOORS if len(floor) == 1 for name in floor])]
    assert tuple(floors[: len(source_code.LAYERS)]) == source_code.LAYERS


# --- what is said of it -----------------------------------------------------------------------------------------------

TEXT = (ROOT / "docs" / "architecture.md").read_text()


def test_every_place_that_is_named_is_there():
    facts = [line for line in TEXT.splitlines() if line.startswith("|") and "`" in line]
    assert len(facts) >= 20
    for line in facts:
        places = re.findall(r"`([^`]+)`", line.split("|")[2])
        assert places and all((ROOT / place).exists() for place in places), line


QUESTIONS = [
    [re.findall(r"`([^`]+)`", cell) or cell.strip() for cell in line.split("|")[1:4]]
    for line in TEXT.partition("## Questions")[2].partition("\n## ")[0].splitlines()
    if "`" in line and line.startswith("|")
]
# Questions that have one answer for one contact and another one for several: there may be fewer, never more.
TWOFOLD = {"where a contact opens", "the law of impact"}


@pytest.mark.parametrize(("question", "files", "names"), QUESTIONS, ids=[question for question, *_ in QUESTIONS])
def test_the_file_that_answers_a_question_defines_the_name(question, files, names):
    assert len(files) == len(names) == (2 if question in TWOFOLD else 1)
    for file, name in zip(files, names, strict=True):
        assert name in top_level_names((ROOT / file).read_text()), f"{file} has no {name}: {question}"


def top_level_names(source: str) -> set[str]:
    """The functions, classes and constants that a module defines itself."""
    body = ast.parse(source).body
    values = [node for node in body if isinstance(node, ast.Assign | ast.AnnAssign)]
    targets = [
        target for node in values for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
    ]
    functions = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    return functions | {target.id for target in targets if isinstance(target, ast.Name)}


# Statuses that are names of guards and causes, too.
ALSO_NAMES = {"landing", "track_end", "outline_end"}
# The independent witnesses share no code with the first formulation, and have statuses of their own.
FIRST_FORMULATION = ("effect_laws", "minimal", "solver", "sweeping", "laws_check", "solve.py", "solution_check.py")


def test_statuses_are_made_in_one_file():
    """Nowhere else in the first formulation is a status a text; lists of statuses that sweeps expect are no endings."""
    folders = [ROOT / "reference" / name for name in FIRST_FORMULATION]
    files = [file for path in folders for file in ([path] if path.is_file() else sorted(path.rglob("*.py")))]
    for file in files:
        texts = {
            node.value
            for node in nodes(re.sub(r"(?m)^.*USUAL = .*$", "", file.read_text()))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
        assert not texts & (STATUSES.keys() - ALSO_NAMES), f"{file}: {texts & STATUSES.keys()}"


def test_the_picture_shows_every_room_in_its_order():
    words = TEXT.split("```")[1].split()
    for upper, lower in zip(FLOORS, FLOORS[1:], strict=False):
        assert max(map(words.index, upper)) < min(map(words.index, lower))
    folders = {path.parent.name for path in (ROOT / "reports").glob("*/__init__.py")}
    assert folders == set().union(*FLOORS[FLOORS.index({"options"}) + 1 :])


# Calls outside `cases/files/owned_folder.py` that delete or rename files, and why they may.
REMOVALS = {
    (
        "adapters/processes/worker.py",
        "rmtree",
    ): "the folder that the worker made for a call, and its content",
    ("reports/running/versions.py", "unlink"): "the note, in the suite's own cache, of why an environment was not made",
    ("reports/running/versions.py", "rename"): "an environment in the suite's own cache, when it is complete",
}


def removals(source: str) -> set[str]:
    """Names of the functions in a module's source that delete, rename or replace files and folders."""
    found = set()
    for node in nodes(source):
        if not isinstance(node, ast.Attribute | ast.Name):
            continue
        name = node.attr if isinstance(node, ast.Attribute) else node.id
        owner = getattr(node.value, "id", "") if isinstance(node, ast.Attribute) else None
        if name in ("rmtree", "unlink", "rmdir", "removedirs", "renames") or (owner is not None and name == "rename"):
            found.add(name)
        elif owner in ("os", "shutil") and name in ("remove", "replace", "move"):
            found.add(name)
    for node in nodes(source):  # Path.replace takes one argument, str.replace two
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "replace":
            found |= {"replace"} if len(node.args) == 1 and not node.keywords else set()
    return found


def test_only_one_module_deletes_and_renames_files():
    found = {
        (file.relative_to(ROOT).as_posix(), name)
        for room in ALLOWED
        for file in (ROOT / room).rglob("*.py")
        for name in removals(file.read_text())
    }
    owned = {(file, name) for file, name in found if file == "cases/files/owned_folder.py"}
    assert {name for _, name in owned} >= {"unlink", "replace"}
    assert found - owned == REMOVALS.keys()
    # What no module has is seen, and what only looks alike is not.
    assert removals("shutil.move(a, b)") and removals("list(map(os.remove, a))") and removals("path.replace(other)")
    assert not removals("a.replace('b', 'c'), replace(run, reason=''), found.remove(a)")
