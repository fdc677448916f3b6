"""Packages whose names are imported at their first use: nothing is missing, and lists of cases need no SymPy."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import cases
from cases import commands, registry
from tests.taylor.conftest import default_method  # noqa: F401 - a fixture

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("package", ["cases", "adapters.laws", "reference"])
def test_every_public_name_is_what_type_checkers_read(package):
    module = importlib.import_module(package)
    tree = ast.parse(Path(module.__file__).read_bytes())
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    typed = {name.name: line.module for line in block.body for name in line.names}
    assert typed == module._MODULE_OF
    for name in module.__all__:
        assert getattr(module, name) is not None
    for name, place in typed.items():
        assert getattr(module, name) is getattr(importlib.import_module(f"{package}.{place}"), name)


def test_the_list_read_from_source_is_the_catalogue():
    entries = {name: cases.entry(name) for name in cases.names() if cases.entry(name).is_own}
    lines = [line for file in registry._catalogue_files() for line in registry._summaries_in(file)]
    assert len(lines) == len(entries) > 50
    for line in lines:
        assert (line.summary, line.is_hard) == (entries[line.name].summary, bool(entries[line.name].hard))
    shown = commands.listing(200)
    assert all(line.name in shown for line in lines)


def test_the_list_of_cases_is_printed_without_numpy_or_sympy():
    code = "import sys, cases.commands as c; c.main([]); sys.exit(bool({'numpy', 'sympy'} & sys.modules.keys()))"
    subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, cwd=ROOT)


def test_curves_of_the_library_and_their_motions_need_no_sympy():
    """SymPy takes longer to import than all the rest. (heyoka imports it, too.)"""
    code = (
        "import sys; sys.modules |= {'sympy': None, 'heyoka': None}\n"
        "import cases, reference\n"
        "from cases import library as curves\n"
        "curves.ellipse(0.3, 0.2), curves.cosine(0.3, 2.0), curves.catenary(0.5), curves.catenary_hill(0.5, 1.0)\n"
        "curves.cycloid(0.2), curves.trochoid(0.3, 0.1), curves.superellipse(0.3, 0.2), curves.parabola(0.4)\n"
        "curves.logarithmic_spiral(0.1, 0.2), curves.rounded_polygon(0.1, 3), curves.hill(0.3), curves.line()\n"
        "for name in ('bouncing_disc', 'block_into_bowl', 'disc_on_free_wedge', 'disc_over_edge', 'row_of_discs'):\n"
        "    cases.load(name)\n"
        "print(reference.simulate(cases.load('disc_in_circle'), method='dop853').status)"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert (answer.stdout.strip(), answer.stderr) == ("completed", "")
