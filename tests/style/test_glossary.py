"""The glossary names one class or column for each central noun, at the file that defines it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from reports.analysis.columns import COLUMNS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
COLUMNS_HOME = "reports/analysis/columns.py"


def rows(page: str) -> list[tuple[str, str, str]]:
    """The noun, name and home of each line of the glossary."""
    lines = [line for line in page.splitlines() if line.startswith("|")][2:]
    found = [re.fullmatch(r"\| ([^|]+) \| [^|]+ \| `([\w.]+)` \| `([\w./]+)` \|", line) for line in lines]
    assert all(found), [line for line, match in zip(lines, found, strict=True) if not match]
    return [match.groups() for match in found if match]


@cache
def defined(home: str) -> set[str]:
    """The classes, functions and class attributes that a module defines, attributes as `Class.name`."""
    return set(_defined(ast.parse((ROOT / home).read_text(encoding="utf-8"))))


def _defined(tree: ast.Module) -> Iterator[str]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        if isinstance(node, ast.ClassDef):
            for item in node.body:
                if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
                    yield f"{node.name}.{item.target.id}"
                elif isinstance(item, ast.FunctionDef):
                    yield f"{node.name}.{item.name}"


def missing(page: str) -> list[str]:
    """The names of the glossary that do not exist at their homes."""
    absent = []
    for noun, name, home in rows(page):
        if not (ROOT / home).is_file():
            absent.append(f"{noun}: no file {home}")
        elif name not in (COLUMNS if home == COLUMNS_HOME else defined(home)):
            absent.append(f"{noun}: no {name} in {home}")
    return absent


def public_classes() -> dict[str, list[str]]:
    """The modules of the suite that define each public class, by the class's name."""
    homes: dict[str, list[str]] = {}
    for room in ("cases", "reference", "adapters", "reports"):
        for file in sorted((ROOT / room).rglob("*.py")):
            for name in re.findall(r"^class ([A-Za-z]\w*)", file.read_text(encoding="utf-8"), flags=re.M):
                homes.setdefault(name, []).append(file.relative_to(ROOT).as_posix())
    return homes


def test_each_noun_is_listed_once_with_its_name_and_home():
    nouns = [noun for noun, _, _ in rows(PAGE)]
    assert 20 <= len(nouns) <= 30 and len(nouns) == len(set(nouns))
    assert len({(name, home) for _, name, home in rows(PAGE)}) == len(nouns)


def test_each_class_and_column_exists_at_its_home():
    assert missing(PAGE) == []


def test_no_central_class_shares_its_name_with_another_class():
    homes = public_classes()
    central = {name.partition(".")[0] for _, name, home in rows(PAGE) if home != COLUMNS_HOME}
    duplicates = {name: homes[name] for name in sorted(central & homes.keys()) if len(homes[name]) > 1}
    assert duplicates == {}
