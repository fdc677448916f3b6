"""The adapters' translations for older versions of their engines, tried with the installed one in the older form."""

from __future__ import annotations

import numpy as np
import pymunk

import adapters.pymunk as adapter
import cases
from adapters.pymunk import older_versions

CASE = "disc_in_circle"


class WithoutOnCollision:
    """A space of pymunk 6 as the adapter sees it: a collision handler with a `pre_solve` that returns a bool."""

    def __init__(self, space: pymunk.Space):
        self._space = space
        self.accepted: list[bool] = []

    def add_collision_handler(self, one: int, other: int):
        owner, space = self, self._space

        class Handler:
            def __setattr__(self, name, function):
                assert name == "pre_solve"
                space.on_collision(one, other, pre_solve=lambda *now: owner.accepted.append(function(*now)))

        return Handler()


def run(route: str) -> np.ndarray:
    case = cases.load(CASE)
    model = adapter.build(case, route, adapter.ladder(case, route)[1])
    adapter.run(model)
    return model.rows()


def test_the_record_of_pymunk_before_6_6_is_that_of_today_to_the_last_bit(monkeypatch):
    today = run("native")
    monkeypatch.setattr(older_versions, "batch", None)
    np.testing.assert_array_equal(run("native"), today)


def test_the_collision_handler_of_pymunk_6_gives_the_motion_of_today_and_accepts_every_contact(monkeypatch):
    today, translate, spaces = run("assisted"), older_versions.on_collision, []

    def as_in_6(space, one, other, pre_solve):
        spaces.append(WithoutOnCollision(space))
        translate(spaces[-1], one, other, pre_solve)

    monkeypatch.setattr(older_versions, "on_collision", as_in_6)
    np.testing.assert_array_equal(run("assisted"), today)
    assert len(spaces[0].accepted) > 100 and all(accepted is True for accepted in spaces[0].accepted)


def test_the_version_of_pymunk_is_that_of_its_package(monkeypatch):
    monkeypatch.setattr(pymunk, "version", "2.0.0")
    assert older_versions.version() != "2.0.0"
    assert adapter.version().startswith(older_versions.version())
