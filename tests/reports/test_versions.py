"""Versions of an engine beside each other: what may be asked for, what is said where it cannot be, which one runs."""

from importlib.metadata import version

import pandas as pd
import pytest
from packaging.requirements import Requirement

import cases
from cases import CaseError
from reports import build, compare_builds, options
from reports.running import cache_folder, experiment, solvers, versions
from reports.running.calls import Calls
from reports.running.storage import source_code

CASE = "disc_on_line[mu=0.1]"
BOTH = ("pymunk@6.11.1", "pymunk@7.3.1")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache folder of the test's own."""
    monkeypatch.setenv(cache_folder.VARIABLE, str(tmp_path / "cache"))
    return cache_folder.place()


@pytest.fixture
def pretended(cache):
    """The environment of a pymunk that there never was."""
    packages = versions._packages(versions._folder("pymunk@6.99"))
    output = cache.__class__(packages, "pymunk-6.99.dist-info")
    output.mkdir(parents=True)
    (output / "METADATA").write_text("Metadata-Version: 2.1\nName: pymunk\nVersion: 6.99\n")
    return packages


def test_a_solver_is_an_engine_and_perhaps_a_version(cache):
    assert versions.split_version("pymunk") == ("pymunk", "")
    assert versions.split_version("pymunk@6.11.1") == ("pymunk", "6.11.1")
    assert str(versions.needs("box2d@0.11.1")) == "pyb2d3==0.11.1"  # its package has another name
    assert options.choose_solvers(["reference", *BOTH, *BOTH]) == ("reference", *BOTH)


def test_a_version_of_an_engine_that_lists_none_is_refused(cache, monkeypatch):
    monkeypatch.setattr(options, "solvers", lambda: ("fakes",))
    monkeypatch.setattr(source_code, "literal_of", lambda engine, _: None)
    with pytest.raises(CaseError, match="lists no versions"):
        options.choose_solvers(["fakes@1"])
    assert not (cache / "versions").exists()


# What pip says, shortened.
UNKNOWN = "ERROR: Could not find a version that satisfies the requirement pymunk==7.2.9 (from versions: {})\n"


def test_a_version_that_the_index_does_not_have_is_told_with_the_nearest():
    have = ", ".join(["0.8", "6.0.0.dev1", *(f"{a}.{b}.0" for a in (6, 7) for b in range(9))])
    with pytest.raises(CaseError, match=r"no pymunk==7.2.9 .* it has 7.0.0, 7.1.0, 7.2.0, 7.3.0, 7.4.0, 7.5.0, …"):
        versions._why(Requirement("pymunk==7.2.9"), UNKNOWN.format(have))


def test_a_failure_is_a_row_and_another_try_is_made(cache, monkeypatch, in_process):
    tries = []
    monkeypatch.setattr(versions, "_make", lambda package, *_: tries.append(package) or "the index is on holiday")
    (cache / "versions").mkdir()
    case = cases.load("disc_on_line", mu=0.1)
    for _ in range(2):
        versions.make(["reference", "pymunk@6.99"], lambda text: None)
    with in_process(), Calls() as calls:
        (run,) = experiment.run_cases([case], ["pymunk@6.99"], calls).runs
    assert len(tries) == 2
    assert (run.solver, run.outcome) == ("pymunk@6.99", "not_installed") and "the index is on holiday" in run.reason


def test_a_worker_of_a_version_finds_it_first_and_others_do_not(pretended):
    here = version("pymunk")
    pool = solvers.pool(1)
    groups = ["engines", "pymunk@6.99", "", "pymunk@6.99"]
    answers = dict(pool.run(version, [("pymunk",)] * 4, groups=groups))
    pool.close()
    assert [answers[i].value for i in range(4)] == [here, "6.99", here, "6.99"]


def test_no_process_runs_another_version_than_its_row_says(pretended):
    with pytest.raises(ImportError, match="pymunk==6.99"):
        versions.demand("pymunk@6.99")
    versions.demand(f"pymunk@{version('pymunk')}")


@pytest.mark.slow
def test_two_versions_in_one_report(cache, tmp_path, capsys):
    versions.make(BOTH, lambda text: None)
    failed = [file.read_text() for name in BOTH if (file := versions._failure(versions._folder(name))).is_file()]
    if failed:
        pytest.skip(failed[0])
    out = tmp_path / "report"
    words = ["--case", CASE, "--solver", "reference", *BOTH, "--quick", "--out", str(out)]
    assert build.main([*words, "--store", str(tmp_path / "store")]) == 0
    runs = pd.read_csv(out / "tables" / "trajectories.csv", keep_default_na=False)
    for name in BOTH:
        mine = runs[runs["solver"] == name]
        assert len(mine) and mine["version"].str.startswith(name.partition("@")[2]).all()
        assert (mine[mine["route"] == "native"]["outcome"] == "answered").all()
    (refused,) = runs[(runs["solver"] == BOTH[0]) & (runs["route"] == "assisted")].to_dict("records")
    assert refused["outcome"] == "unsupported" and "pymunk 7" in refused["reason"]
    # Natively the two are the same to the last digit; all that changed is the route that one of them does not have.
    found = compare_builds.compare(out, out, BOTH).results
    assert found and all(", assisted" in difference.row for difference in found)
