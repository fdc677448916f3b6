"""The direction of the arrows: who may import whom."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ALLOWED = {
    "cases": set(),
    "reference": {"cases"},
    "adapters": {"cases"},
    "reports": {"cases", "reference", "adapters"},
}


def imported_rooms(file: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module.split(".")[0])
    return found & ALLOWED.keys()


@pytest.mark.parametrize("room", ALLOWED)
def test_rooms_import_only_what_the_design_allows(room):
    files = sorted((ROOT / room).rglob("*.py"))
    assert files
    for file in files:
        assert imported_rooms(file) <= ALLOWED[room] | {room}, file


def imported_parts(file: Path) -> set[str]:
    """The parts of `reference` (folders, or files beside them) that one of its files imports."""
    folder = file.parent.relative_to(ROOT).parts
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom):
            base = folder[: len(folder) - node.level + 1] if node.level else ()
            names = (*base, *filter(None, (node.module or "").split(".")))
            if names and names[0] == "reference":
                found |= {names[1]} if len(names) > 1 else {alias.name for alias in node.names}
    return found


# From the top down: each may import what stands below it. Two formulations and the paper's letters know nothing of
# each other, or they could not witness for each other.
PARTS = {
    "paper": set(),
    "minimal": set(),
    "contact_frame": set(),
    "literal": {"minimal", "paper"},
    "solve": {"minimal", "literal"},
    "narration": {"solve"},
    "errata": {"paper", "solve", "minimal"},
    "certification": {"solve", "minimal", "contact_frame"},
}


@pytest.mark.parametrize("part", PARTS)
def test_parts_of_the_reference_import_only_what_stands_below_them(part):
    place = ROOT / "reference" / part
    files = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    assert files
    for file in files:
        assert imported_parts(file) <= PARTS[part] | {part}, file


def test_every_part_of_the_reference_has_its_place():
    parts = {p.stem for p in (ROOT / "reference").iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    assert parts - {"__init__", "__main__"} == PARTS.keys()
