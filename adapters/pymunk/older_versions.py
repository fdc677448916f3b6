"""Parts of pymunk's interface that versions before 7 lack: the batch record (6.6) and `Space.on_collision` (7.0).

Each looks at the installed interface, not at a version number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import version as package_version
from typing import Any

import numpy as np
import pymunk

try:
    from pymunk import batch
except ImportError:
    batch = None  # type: ignore[assignment]

# The numbers of a body in a record.
_NUMBERS = 6


def version() -> str:
    """The version of the package; `pymunk.version` of 7.0.0 is 2.0.0."""
    return package_version("pymunk")


def recorder(space: pymunk.Space, bodies: Sequence[pymunk.Body]) -> tuple[Callable[[], None], Callable[[], np.ndarray]]:
    """A function that records the bodies now, the space's first ones, and one that returns the rows (x, y, theta, vx,
    vy, omega) of each, shape (n, bodies, 6).

    Reading the numbers one by one takes longer than a native step; the engine's own record needs pymunk 6.6.
    """
    if batch is None:
        return _recorder_in_python(bodies)
    fields = (
        batch.BodyFields.POSITION
        | batch.BodyFields.ANGLE
        | batch.BodyFields.VELOCITY
        | batch.BodyFields.ANGULAR_VELOCITY
    )
    buffer = batch.Buffer()

    def rows() -> np.ndarray:
        # A copy: the engine's memory is freed with the model. The track's static body comes last.
        return np.frombuffer(buffer.float_buf()).reshape(-1, len(bodies) + 1, _NUMBERS)[:, :-1].copy()

    return partial(batch.get_space_bodies, space, fields, buffer), rows


def _recorder_in_python(bodies: Sequence[pymunk.Body]) -> tuple[Callable[[], None], Callable[[], np.ndarray]]:
    record: list[tuple[float, ...]] = []

    def note() -> None:
        for body in bodies:
            record.append((*body.position, body.angle, *body.velocity, body.angular_velocity))

    return note, lambda: np.array(record).reshape(-1, len(bodies), _NUMBERS)


def on_collision(space: pymunk.Space, one: int, other: int, pre_solve: Callable[[Any, Any, Any], None]) -> None:
    """Call a function in every step before the contact of two collision types is solved."""
    if hasattr(space, "on_collision"):
        space.on_collision(one, other, pre_solve=pre_solve)
        return

    def accept(arbiter: Any, space: Any, data: Any) -> bool:
        pre_solve(arbiter, space, data)
        return True  # before version 7 the result says whether the contact acts

    handler: Any = space.add_collision_handler(one, other)  # type: ignore[attr-defined]
    handler.pre_solve = accept
