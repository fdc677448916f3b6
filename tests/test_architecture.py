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


def imported_modules(file: Path) -> set[str]:
    """The modules of `reference` that one of its files imports, by their first name below `reference`."""
    folder = file.parent.relative_to(ROOT).parts
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = (*folder[: len(folder) - node.level + 1], *(node.module or "").split("."))
            found |= {base[1]} if len(base) > 1 and base[1] else {alias.name for alias in node.names}
    return found


def test_literal_system_knows_neither_the_eliminated_equations_nor_the_event_loop():
    # What the fast form is tested against must not lean on it.
    files = sorted((ROOT / "reference" / "paper").glob("*.py"))
    assert len(files) > 3
    for file in files:
        assert imported_modules(file) <= {"paper"}, file


def test_the_second_formulation_does_not_know_the_literal_system_either():
    for file in (ROOT / "reference").glob("*.py"):
        if file.stem == "contact_frame" or file.stem.startswith("second_") and file.stem != "second_contact":
            assert not imported_modules(file) & {"paper", "literal", "system", "eliminated"}, file
