"""Whether two records are the same to the last bit; it shares no code with what writes, reads or compares them."""

from __future__ import annotations

import dataclasses
import struct
from enum import Enum
from typing import Any

import numpy as np


def identical(one: Any, other: Any) -> bool:
    """Of the same types throughout and the same to the last bit, NaN included."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, float):
        return struct.pack("d", one) == struct.pack("d", other) or (one != one and other != other)
    if dataclasses.is_dataclass(one) and not isinstance(one, type):
        names = [f.name for f in dataclasses.fields(one)]
        return all(identical(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, tuple | list) and not isinstance(one, Enum):
        return len(one) == len(other) and all(map(identical, one, other))
    if isinstance(one, dict):
        return identical(list(one.items()), list(other.items()))
    return one == other
