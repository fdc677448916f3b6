"""A case function in a script, a notebook or a file: its case has its name, and every call finds it."""

import pytest

import cases
import reference
from cases import BadValue

FILE = """
import cases

@cases.case
def on_a_table(mu=0.2, mass=1.0):
    return cases.load("disc_on_line", mu=mu)
"""


pytestmark = pytest.mark.usefixtures("catalogue")


def in_a_cell(text: str, number: int):
    """The function of a notebook's cell: each cell is compiled under a file name of its own."""
    names = {"__name__": "__main__"}
    exec(compile(text, f"/tmp/ipykernel_1/{number}.py", "exec"), names)
    return names["on_a_table"]


def test_a_call_names_its_case_and_keeps_the_numbers():
    make = in_a_cell(FILE, 1)
    assert make().label == "on_a_table"
    assert make(0.3, mass=2).label == "on_a_table[mu=0.3,mass=2]"
    assert make(mu=0.3) == cases.load("on_a_table", mu=0.3)
    assert len(reference.sweep(make(), mu=[0.1, 0.2])) == 2  # a case of a function is of the catalogue


def test_a_cell_defines_its_case_again():
    in_a_cell(FILE, 1)
    assert in_a_cell(FILE.replace("mu=0.2", "mu=0.1"), 2)().effect(cases.CoulombFriction).mu == 0.1


def test_a_case_of_the_catalogue_is_not_replaced():
    with pytest.raises(BadValue, match="already a case 'disc_on_line'"):
        in_a_cell(FILE.replace("on_a_table", "disc_on_line"), 1)


def test_a_file_is_a_name_for_load_and_sweep(tmp_path):
    file = tmp_path / "table.py"
    file.write_text(FILE)
    assert cases.load(file).label == cases.load(str(file)).label == "on_a_table"
    assert cases.load(f"{file}:on_a_table[mu=0.4]", mass=2).label == "on_a_table[mu=0.4,mass=2]"
    assert list(reference.sweep(str(file), mu=[0.1, 0.3])["mu"]) == [0.1, 0.3]
    file.write_text(FILE + FILE.replace("on_a_table", "second"))
    with pytest.raises(BadValue, match=r"give one: .*table\.py:on_a_table"):
        cases.load(str(file))


def test_simulate_says_how_to_call_a_function():
    with pytest.raises(BadValue, match=r"call it: on_a_table\(\)"):
        reference.simulate(in_a_cell(FILE, 1))
