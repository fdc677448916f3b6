"""The documentation is plain technical English: words of the project's former dialect do not come back."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# Its table is written from the adapters by `python -m tests.benchmarks.meanings`.
GENERATED = {"engine_parameters.md"}
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "adapters" / "executables" / "README.md",
    ROOT / "docs" / "gallery.ipynb",
    *(page for page in sorted((ROOT / "docs").glob("*.md")) if page.name not in GENERATED),
]
# A pattern, and what to write instead: the field's word, or the literal one.
DIALECT = {
    r"told|tells?|telling": "report, show, say",
    r"anew": "again",
    r"beside": "next to, compared with, in addition to",
    r"whom|whoever|whose time|(a|the) (solver|engine|program)s? who": "which solver, that, you; time breakdown",
    r"strangers?": "untrusted input, third party",
    r"alike": "a tie, the same",
    r"as (it|they) comes?": "default settings",
    r"from cold": "cold start",
    r"by chance": "by luck",
    r"for sure": "significantly",
    r"lets? go|let go|letting go": "released",
    r"stands?|stood": "is, is defined, is listed",
    r"it is said|is said|are said": "the note gives the reason",
    r"came of": "outcome",
    r"came out|comes? out": "resulted in",
    r"what is long": "the slow tests",
    r"rule of the house": "project rules",
    r"nothing is lost": "say what is kept, and where",
    r"(is|are|was|were|be) refused": "is not supported (solver), is rejected (input)",
    r"witnesses for": "confirms",
    r"some (\d[\d,.]*|two|three|four|five|ten|twenty|fifty)": "about",
    r"the very (same|time|one|place)": "the exact",
    r"knows? nothing of": "without",
    r"goes? on|went on": "continues",
    r"(of|for) (ours|others)": "third-party, the suite's",
    r"in turns?": "alternately",
    r"quicker|quickest": "faster, fastest",
}
_CODE = re.compile(r"```.*?```|`[^`\n]*`|^    [^\n]*$|\]\([^)]*\)|<!--.*?-->", flags=re.S | re.M)


def read_page(page: Path) -> str:
    """The text of a page; of a notebook, that of its Markdown cells."""
    content = page.read_text(encoding="utf-8")
    if page.suffix != ".ipynb":
        return content
    cells = json.loads(content)["cells"]
    return "\n\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")


def prose(page: str) -> str:
    """The text without code, link targets and comments."""
    return _CODE.sub(" ", page)


def dialect(page: str) -> list[str]:
    """Each word of the dialect with the words before it and what to write instead."""
    text = prose(page)
    return [
        f"“{match[0].strip()}”: write {instead}"
        for pattern, instead in DIALECT.items()
        if re.search(rf"\b(?:{pattern})\b", text, flags=re.I)  # much faster than with the words before it
        for match in re.finditer(rf"(?:\S+\s+){{0,3}}\b(?:{pattern})\b", text, flags=re.I)
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_word_of_the_dialect_is_on_a_page(page):
    assert dialect(read_page(page)) == []


def test_words_of_the_dialect_are_reported_and_code_is_not_prose():
    assert len(dialect("A contact beside the first is told: as they come from strangers, it is said whom to ask.")) == 6
    assert dialect("`award` is `by chance`.\n\n```python\ntold = 1\n```\n\n    whom to trust\n") == []
