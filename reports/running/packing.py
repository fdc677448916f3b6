"""Plain records (dataclasses, named tuples, enums, tuples, mappings, arrays) <-> what JSON and arrays can hold.

The type's own annotations say how to read a record back, so nothing in a file decides what code runs.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping
from enum import Enum
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

import cases


def pack(value: Any) -> tuple[Any, dict[str, np.ndarray]]:
    """What JSON can hold, and the arrays by number (a path may hold what no file's name can); raises TypeError for any
    other kind."""
    arrays: dict[str, np.ndarray] = {}
    return _packed(value, "value", arrays), arrays


def unpack(kind: Any, data: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    """The record of type `kind` that `pack` took apart; raises ValueError, KeyError or TypeError if it is not one."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is Any:
        return data
    if kind is np.ndarray:
        return arrays[data]
    if origin in (Union, UnionType):
        return _unpacked_union(arguments, data, arrays)
    if origin is tuple:
        kinds = (arguments[0],) * len(data) if arguments[-1] is ... else arguments
        return tuple(unpack(k, d, arrays) for k, d in zip(kinds, data, strict=True))
    if origin is list:
        return [unpack(arguments[0], d, arrays) for d in data]
    if origin is dict:
        pairs = data.items() if arguments[0] is str else data
        return {unpack(arguments[0], k, arrays): unpack(arguments[1], d, arrays) for k, d in pairs}
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(data)
    if _is_record(kind):
        hints = _hints(kind)
        if data.keys() != set(_fields(kind)):
            raise ValueError(f"it is no {kind.__name__}")
        return kind(**{name: unpack(hints[name], d, arrays) for name, d in data.items()})
    if kind is float and type(data) is int:
        return float(data)
    # A count that came as 100.0 is a count.
    if type(data) is not kind and not (kind is int and type(data) is float):
        raise ValueError(f"{data!r} stands where {kind} belongs")
    return data


def _hints(kind: type) -> dict[str, Any]:
    """The types of a record's fields; what its module imports for type checkers alone are names of `cases`."""
    return get_type_hints(kind, {**vars(cases), **vars(sys.modules[kind.__module__])})


def _unpacked_union(kinds: tuple, data: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if data is None and NoneType in kinds:
        return None
    left = [kind for kind in kinds if kind is not NoneType]
    if type(data) in left:
        return data
    if len(left) != 1:
        raise ValueError(f"{data!r} is none of {kinds}")
    return unpack(left[0], data, arrays)


def _packed(value: Any, path: str, arrays: dict[str, np.ndarray]) -> Any:
    if isinstance(value, np.ndarray):
        name = str(len(arrays))
        arrays[name] = value
        return name
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if _is_record(type(value)):
        return {n: _packed(getattr(value, n), f"{path}.{n}", arrays) for n in _fields(type(value))}
    if isinstance(value, Mapping) and all(type(key) is str for key in value):
        return {key: _packed(v, f"{path}.{key}", arrays) for key, v in value.items()}
    if isinstance(value, Mapping):
        value = list(value.items())
    if isinstance(value, tuple | list):
        return [_packed(v, f"{path}.{i}", arrays) for i, v in enumerate(value)]
    raise TypeError(f"{path} is a {type(value).__name__}, which cannot be kept in a file")


def _is_record(kind: Any) -> bool:
    return dataclasses.is_dataclass(kind) or (isinstance(kind, type) and issubclass(kind, tuple) and kind is not tuple)


def _fields(kind: Any) -> tuple[str, ...]:
    return tuple(f.name for f in dataclasses.fields(kind)) if dataclasses.is_dataclass(kind) else kind._fields
