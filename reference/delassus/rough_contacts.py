"""Forces of perfectly rough contacts, whose coefficient is a large number in the complementarity problem."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .plate_state import MOVES


def slips_at_rough_contact(delassus: np.ndarray, free: np.ndarray, force: np.ndarray, rough: np.ndarray) -> bool:
    """Whether a perfectly rough contact, whose coefficient is a large number here, would slip with these forces: it
    would have to pull in order not to."""
    rates = np.abs(delassus @ force + free)
    small = MOVES * max(float(np.abs(free).max()), float(np.abs(delassus).max() * np.abs(force).max()))
    count = len(rough)
    return bool((rough & (rates[:count] <= small) & (rates[count : 2 * count] > small)).any())


def pressing_forces(
    delassus: np.ndarray, free: np.ndarray, senses: Sequence[float | None], arms: np.ndarray
) -> list[np.ndarray]:
    """The forces with which a contact presses and does not slip; with rolling resistance, of one sense of the rotation
    and one arm (over the radius of gyration), that also resist it, and prevent it where they can."""
    if not senses:
        held = -np.linalg.solve(delassus, free)
        return [held] if held[0] > 0.0 else []
    (sense,), answers = senses, list[np.ndarray]()
    for turn in (0.0, 1.0, -1.0) if sense is None else (sense,):
        columns = np.eye(3) if turn == 0.0 else np.array([[1.0, 0.0], [0.0, 1.0], [-turn * arms[0], 0.0]])
        rows = columns.shape[1]
        force = -columns @ np.linalg.solve((delassus @ columns)[:rows], free[:rows])
        begins = turn * float((delassus @ force + free)[2]) > 0.0 if turn else abs(force[2]) <= arms[0] * force[0]
        if force[0] > 0.0 and (begins or sense is not None):
            answers.append(force)
    return answers
