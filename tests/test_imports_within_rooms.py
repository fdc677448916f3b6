"""Imports inside `cases`, `reference` and `adapters`: only downwards, and without circles.

Which room may import which other one is in `test_architecture`.
"""

from __future__ import annotations

import ast
from functools import cache
from graphlib import TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path

import pytest

from adapters import engines
from adapters.lookup import NO_ADAPTERS

pytestmark = pytest.mark.style

ROOT = Path(__file__).parent.parent


def modules(room: str) -> dict[str, Path]:
    """The modules of a room by their names; a package is its `__init__`."""
    found = {}
    for path in sorted((ROOT / room).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(name: str, path: Path, known: dict[str, Path]) -> set[str]:
    """The modules of `known` that a module imports anywhere in its code, `importlib.import_module("…")` included."""
    package = name if path.stem == "__init__" else name.rpartition(".")[0]
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            # `from package import module` imports the module; the package's own names come from the package.
            inside = {f"{base}.{alias.name}" for alias in node.names} & known.keys()
            names |= inside or {base}
        elif isinstance(node, ast.Call):
            names |= {importlib_name(node, package)}
    return (names & known.keys()) - {name}


def importlib_name(call: ast.Call, package: str) -> str:
    """The module that a call of `import_module` imports, if its name is a literal; "" for other calls."""
    function = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if function != "import_module" or not isinstance(call.args[0], ast.Constant):
        return ""
    name = str(call.args[0].value)
    return resolve_name(name, package) if name.startswith(".") else name


@cache
def arrows(room: str) -> dict[str, set[str]]:
    known = modules(room)
    return {name: imports(name, path, known) for name, path in known.items()}


def reached(start: str, graph: dict[str, set[str]]) -> set[str]:
    """All that a module imports, directly or not."""
    found, waiting = set(), [start]
    while waiting:
        for name in graph[waiting.pop()] - found:
            found.add(name)
            waiting.append(name)
    return found


@pytest.mark.parametrize("room", ["cases", "reference", "adapters"])
def test_room_has_no_circle(room):
    graph = arrows(room)
    # Cases of the catalogue import `cases`, like a user's case; the registry lists the folder.
    graph = {name: below for name, below in graph.items() if not name.startswith("cases.catalogue")}
    assert list(TopologicalSorter(graph).static_order())


@pytest.mark.parametrize(
    "module", ["cases.contact.geometry", "cases.curves", "cases.formulas.expressions", "cases.effects"]
)
def test_geometry_and_formulas_know_no_case(module):
    known = reached(module, arrows("cases"))
    assert known and not known & {"cases", "cases.contact"}
    assert not {name.split(".")[1] for name in known} & {"scene", "motion", "moving_frame", "registry", "catalogue"}


def floor(module: str) -> str:
    """Of `adapters`: its second name, or "engine" for the modules of one."""
    part = (module.split(".") + [""])[1]
    return part if part in NO_ADAPTERS else "engine" if part else "face"


MAY_IMPORT = {
    "interface": set(),
    "face": {"interface", "lookup"},
    "common": {"interface"},
    "gate": {"interface"},
    "laws": {"interface", "lookup", "gate"},
    "lookup": {"interface", "by_process"},
    "by_process": {"interface", "common"},
    "engine": {"interface", "common"},
}


def test_adapters_import_downwards_and_no_engine_knows_another():
    for module, below in arrows("adapters").items():
        for name in below:
            if floor(module) == floor(name):
                same_engine = module.split(".")[1:2] == name.split(".")[1:2]
                assert floor(module) != "engine" or same_engine, f"{module} imports {name}"
            else:
                # `adapters` itself is the face, which everything imports by being in it; nobody asks it for names.
                assert floor(name) in MAY_IMPORT[floor(module)], f"{module} imports {name}"


def test_what_is_no_adapter_is_listed_and_every_adapter_is_there():
    own = {path.stem for path in (ROOT / "adapters").iterdir() if path.suffix in ("", ".py") and path.stem[0] != "_"}
    assert own - NO_ADAPTERS == {"box2d", "exudyn", "pybullet", "pymunk"} <= set(engines())


def test_the_checks_see_an_arrow_upwards(tmp_path):
    known = {"cases.scene.case_class": Path(), "cases.contact.geometry": Path()}
    wrong = tmp_path / "geometry.py"
    for text in (
        "from ..scene.case_class import Case",
        "from cases.scene.case_class import Case",
        "import cases.scene.case_class",
        "from ..scene import case_class",
        "importlib.import_module('cases.scene.case_class')",
        "import_module('..scene.case_class', __name__)",
    ):
        wrong.write_text(f"def late():\n    {text}\n")
        assert imports("cases.contact.geometry", wrong, known) == {"cases.scene.case_class"}, text
