"""Hostile and unlucky input: whatever is given is run, or refused by a typed error in one sentence."""

import pytest

from . import harness
from .harness import kinds, sweep

KINDS = kinds()
# What `make test-all` tries at least.
WHOLE = 3000


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    """What commands write, they write into an empty folder."""
    monkeypatch.chdir(tmp_path)


def swept(request, kind, count, seed, long=False):
    """The counts, noted before anything is asserted: user properties travel with the report, and conftest prints
    them as one table."""
    counts, failures = sweep(kind, count, seed, long)
    row = (kind.name, counts.total(), counts["ran"], counts["refused"], counts["else"])
    request.node.user_properties.append(("fuzz", row))
    assert not failures, f"{len(failures)} of {kind.name}, seed {seed}\n" + "\n".join(failures)
    return counts


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_input_runs_or_is_refused_in_a_sentence(kind, request):
    swept(request, kind, kind.sample, 0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_input_runs_or_is_refused_in_a_sentence(kind, request):
    counts = swept(request, kind, kind.whole, harness.seed(), long=True)
    assert counts["refused"] > 0, "a kind that nothing of is refused is no fuzz"


def test_the_whole_fuzz_is_large():
    assert sum(kind.whole + len(kind.found) + len(kind.long) for kind in KINDS) >= WHOLE
