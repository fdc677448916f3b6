"""The contacts and the plates of a motion that is known at its samples only."""

from __future__ import annotations

import numpy as np

from .trajectory import ContactColumns, State


class SampledContacts:
    """The contacts of a sampled motion: (name, times) -> ContactColumns, interpolated linearly between the samples;
    with None instead of times those of its samples."""

    def __init__(self, t: np.ndarray, columns: dict[str, ContactColumns]):
        self.t, self.columns = t, columns

    def __call__(self, name: str, times: np.ndarray | None) -> ContactColumns:
        own = self.columns[name]
        if times is None:
            return own
        keep = np.append(np.diff(self.t) > 0, True)
        return ContactColumns(*(_interpolated(times, self.t[keep], column[..., keep]) for column in own))


class SampledPlates:
    """The plates of a sampled motion: (name, times) -> State without contact columns, interpolated linearly between the
    samples; with None instead of times those of its samples. `columns`: x, y, θ, vx, vy and ω, (6, n) each."""

    def __init__(self, t: np.ndarray, columns: dict[str, np.ndarray]):
        self.t, self.columns = t, columns

    def __call__(self, name: str, times: np.ndarray | None) -> State:
        own = self.columns[name]
        if times is not None:
            keep = np.append(np.diff(self.t) > 0, True)
            own = _interpolated(times, self.t[keep], own[:, keep])
        return State(*own, *np.full((5, own.shape[1]), np.nan))


def _interpolated(times: np.ndarray, t: np.ndarray, column: np.ndarray) -> np.ndarray:
    if column.ndim == 1:
        return np.interp(times, t, column)
    return np.array([np.interp(times, t, row) for row in column])
