"""Names in the code: nouns for values, verbs for functions, one class for one name, modules named by their contents.

Counted are the identifiers of the four rooms. Tests are not: a test's name is a sentence, which has verbs in all forms.
"""

from __future__ import annotations

import io
import keyword
import re
import tokenize
from collections import Counter, defaultdict
from functools import cache
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("cases", "reference", "adapters", "reports")
# Participles say what was done to a value and not what it is. In diffrax, BenchOpt, skyfield and SciPy's integrate they
# are 0.2 % of the identifiers by this count; in this project they were 2.8 %.
MOST_PARTICIPLES = 0.003
IRREGULAR = frozenset(
    "told found known unknown left kept made given taken seen held drawn written gone done sent built lost met said "
    "shown spent begun broken chosen driven fallen grown hidden".split()
)
# Words that end in "ed" and are no participles, or are nouns of programming.
NO_PARTICIPLES = frozenset(
    "speed seed need feed embed exceed proceed red bed shed reversed sorted searchsorted argsorted closed optimised "
    "certified fixed compressed".split()
)
# Names that Python and libraries prescribe.
OF_LIBRARIES = frozenset(
    "K_extended NotImplemented StrictUndefined TimeoutExpired WEXITED ZIP_DEFLATED distributed duplicated "
    "get_diskcache_enabled imap_unordered isenabled padded rasterized set_diskcache_enabled sleeping_enabled typed "
    "undefined yaxis_inverted".split()
)
# Standard terms: a side, the augmented system, a route.
STANDARD_TERMS = frozenset("left augmented assisted".split())
# Functions called `run` are prescribed by an interface: of adapters, studies, pools of workers and commands.
RUN_INTERFACES = re.compile(
    r"adapters/\w+(/__init__|/adapter|/engine)?\.py|reports/running/reference_adapter\.py|reports/studies/\w+(/study)?\.py|"
    r"adapters/processes/pool\.py|reports/running/cluster\.py|reports/(animate|export|show)\.py"
)
# Folders of one room that hold the same parts of different things: each engine, each study, each way to solve.
PARALLEL = re.compile(
    r"adapters/\w+/\w+\.py|reports/studies/.*\.py|reports/study\.py|"
    r"reference/(minimal|witness|proofs|proof_checker|paper|sweeping)/.*\.py"
)
# It shares no code with the suite, so it has classes of its own for the same things.
INDEPENDENT = "reference/proof_checker/"
# Names of modules that say nothing of their contents.
VAGUE = frozenset(
    "apart base core helper helpers looks main misc other room stuff things tools util utils various".split()
)


@cache
def texts() -> dict[str, str]:
    """The source of each module of the four rooms, by its path."""
    files = [file for room in ROOMS for file in sorted((ROOT / room).rglob("*.py"))]
    return {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in files}


@cache
def words(text: str) -> list[str]:
    """All names and keywords of a source text, as often as they occur; read once for all tests."""
    result: list[str] = []
    inside = 0  # from Python 3.12 on names in f-strings are tokens of their own: nowhere are they counted
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        inside += {"FSTRING_START": 1, "FSTRING_END": -1}.get(tokenize.tok_name[token.type], 0)
        if token.type == tokenize.NAME and not inside:
            result.append(token.string)
    return result


def identifiers(text: str) -> list[str]:
    """All names of a source text, as often as they occur."""
    return [word for word in words(text) if not keyword.iskeyword(word)]


def is_participle(name: str) -> bool:
    """Whether the last word of a name is a participle and the name no predicate (`is_…`, `has_…`, `Not…`)."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower().strip("_").split("_")
    if words[-1] in NO_PARTICIPLES or words[0] in ("is", "has", "was", "not"):
        return False
    return words[-1] in IRREGULAR or (words[-1].endswith("ed") and len(words[-1]) > 4)


def participles(sources: list[str]) -> tuple[float, Counter[str]]:
    """The fraction of participles among the names of some texts, and which they are."""
    names = Counter(name for text in sources for name in identifiers(text))
    allowed = OF_LIBRARIES | STANDARD_TERMS
    those = Counter({name: n for name, n in names.items() if is_participle(name) and name not in allowed})
    return those.total() / names.total(), those


def defined(text: str, kind: str) -> list[str]:
    """The names of all classes ("class") or functions ("def") of a source text, wherever they are."""
    return [name for word, name in pairwise(words(text)) if word == kind]


def namesakes(paths: list[str]) -> dict[str, list[str]]:
    """Modules of one room that share a name, by room and name; without those of parallel folders."""
    homes: dict[str, list[str]] = defaultdict(list)
    for path in paths:
        if not Path(path).stem.startswith("__"):
            homes[f"{path.partition('/')[0]}: {Path(path).stem}"].append(path)
    return {n: where for n, where in homes.items() if len([p for p in where if not PARALLEL.fullmatch(p)]) > 1}


def test_few_names_are_participles():
    fraction, those = participles([*texts().values()])
    assert fraction < MOST_PARTICIPLES, f"{fraction:.2%}: {those.most_common(40)}"


def test_a_participle_is_counted():
    fraction, those = participles(["told = found\nis_told = speed = left\nclass Measured: pass\n"])
    assert set(those) == {"told", "found", "Measured"} and fraction == 3 / 6


def test_one_name_one_class():
    homes: dict[str, list[str]] = defaultdict(list)
    for path, text in texts().items():
        for name in defined(text, "class") if not path.startswith(INDEPENDENT) else ():
            homes[name].append(path)
    assert len(homes) > 200
    assert not {name: where for name, where in homes.items() if len(where) > 1}


def test_only_interfaces_prescribe_a_function_called_run():
    runs = {path for path, text in texts().items() if "run" in defined(text, "def")}
    assert len(runs) > 10 and not {path for path in runs if not RUN_INTERFACES.fullmatch(path)}


def test_no_two_modules_of_a_room_share_a_name():
    assert not namesakes([*texts()])


def test_modules_are_named_by_their_contents():
    stems = {Path(path).stem for path in texts()}
    assert not {stem for stem in stems if stem in VAGUE or is_participle(stem) and stem not in STANDARD_TERMS}
