"""Which tests run: of a claim over many cases marked `sampled` the quick tests run a sample, the slow ones the others;
which files hold no test for the marks chosen."""

import pytest

from tests.conftest import QUICK, holds_none, mark_outside_samples


class Item:
    """A collected test with its marks."""

    def __init__(self, nodeid: str, *marks):
        self.nodeid, self.marks = nodeid, [mark.mark for mark in marks]

    def get_closest_marker(self, name: str):
        return next((mark for mark in self.marks if mark.name == name), None)

    def add_marker(self, mark) -> None:
        self.marks.append(mark.mark)


def quick(*marks, slow: tuple[int, ...] = ()) -> list[int]:
    """Which of eight cases of a test with these marks are quick; those of the numbers `slow` are slow by themselves."""
    items = [Item(f"file.py::test[{i}]", *marks, *([pytest.mark.slow] if i in slow else [])) for i in range(8)]
    mark_outside_samples([*items, Item("file.py::other", *marks)])
    return [i for i, item in enumerate(items) if item.get_closest_marker("slow") is None]


def test_every_so_many_th_case_is_quick():
    assert quick(pytest.mark.sampled(3)) == [0, 3, 6]
    assert quick(pytest.mark.sampled(3, first=2)) == [2, 5]


def test_cases_that_are_slow_anyway_are_not_counted():
    assert quick(pytest.mark.sampled(2), slow=(0, 1)) == [2, 4, 6]


def test_without_the_mark_all_cases_are_quick():
    assert quick() == [*range(8)]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("number", range(4))
def test_a_sample_of_a_collected_test_runs(number, request):
    whole = any("::" in argument for argument in request.config.args)
    assert whole or (request.node.get_closest_marker("slow") is None) == (number % 2 == 0)


def test_only_files_without_a_test_for_the_marks_are_not_imported():
    file = "import pytest\n\npytestmark = pytest.mark.builds\n\n\ndef test_a(): ...\n"
    both = file.replace("pytest.mark.builds", "[pytest.mark.builds, pytest.mark.taylor]")
    function = "import pytest\n\n\n@pytest.mark.builds\ndef test_a(): ...\n\n\ndef test_b(): ...\n"
    without = "def test_b(): ...\n"
    assert [holds_none(text, QUICK[0]) for text in (file, both, function, without)] == [True, True, False, False]
    assert [holds_none(text, QUICK[1]) for text in (file, both, function, without)] == [False, False, False, True]
    assert not any(holds_none(text, "not timed") for text in (file, both, function, without))
