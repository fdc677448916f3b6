"""Conversion of records (dataclasses, named tuples, enums, tuples, mappings, arrays) to JSON data and bytes, and back.

The type annotations define how a record is read, so no content of a file decides which code runs. `pack` also reads
what it has written: a value of a wrong type raises an error when it is stored, not when it is read.

Two libraries were measured on the 16 stored types with random values. cattrs 26.2 reads 6 of them: in a module with
`from __future__ import annotations` it does not resolve the annotations of named tuples. msgspec 0.22 reads 15 of them
and saves about 60 lines for one more compiled dependency; a build with 1,000 stored runs would be 0.05 s faster.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping, Sequence
from enum import Enum
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

import cases

# Allowed kinds of an array's elements: booleans, signed and unsigned integers, floats.
_ELEMENTS = "biuf"


def pack(kind: Any, value: Any) -> tuple[Any, list[bytes]]:
    """Convert a value of type `kind` to JSON data and the bytes of its arrays.

    Raises ValueError for a value of another type, or a type that cannot be stored.
    """
    arrays: list[bytes] = []
    try:
        plain = _pack(value, arrays)
        unpack(kind, plain, arrays)
    except Exception as problem:  # a value of another type can raise anything
        raise ValueError(f"it cannot be stored as {getattr(kind, '__name__', kind)}: {problem}") from problem
    return plain, arrays


def unpack(kind: Any, data: Any, arrays: Sequence[bytes]) -> Any:
    """The value of type `kind` that `pack` converted. Data of another form can raise anything."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is np.ndarray:
        return _array(data, arrays)
    if origin in (Union, UnionType):
        return _unpack_union(arguments, data, arrays)
    if origin is tuple:
        kinds = (arguments[0],) * len(data) if arguments[-1] is ... else arguments
        return tuple(unpack(k, d, arrays) for k, d in zip(kinds, data, strict=True))
    if origin is list:
        return [unpack(arguments[0], d, arrays) for d in data]
    if origin is dict:
        return {unpack(arguments[0], k, arrays): unpack(arguments[1], d, arrays) for k, d in data}
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(data)
    if _is_record(kind):
        hints = _hints(kind)
        if data.keys() != hints.keys():
            raise ValueError(f"it is not a {kind.__name__}")
        return kind(**{name: unpack(hints[name], d, arrays) for name, d in data.items()})
    if kind is float and type(data) is int:
        return float(data)
    # A count written as 100.0 is a count.
    if kind is int and type(data) is float and data.is_integer():
        return int(data)
    if type(data) is not kind:
        raise ValueError(f"{data!r} is not a {getattr(kind, '__name__', kind)}")
    return data


def _unpack_union(kinds: tuple, data: Any, arrays: Sequence[bytes]) -> Any:
    if type(data) in kinds:
        return data
    others = [kind for kind in kinds if kind is not NoneType]
    if len(others) != 1:
        raise ValueError(f"{data!r} has none of the types {kinds}")
    return unpack(others[0], data, arrays)


def _array(data: Any, arrays: Sequence[bytes]) -> np.ndarray:
    place, elements, shape = data
    if (dtype := np.dtype(elements)).kind not in _ELEMENTS:
        raise ValueError(f"an array of {dtype} is never stored")
    # Raises ValueError if content and shape do not agree. A copy, because an array on a bytes object is read-only.
    return np.frombuffer(arrays[place], dtype).reshape(shape).copy()


def _pack(value: Any, arrays: list[bytes]) -> Any:
    if isinstance(value, np.ndarray):
        arrays.append(value.tobytes())
        return [len(arrays) - 1, value.dtype.str, list(value.shape)]
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    kind: Any = type(value)
    if _is_record(kind):
        return {name: _pack(getattr(value, name), arrays) for name in _hints(kind)}
    if isinstance(value, Mapping):
        value = list(value.items())
    if isinstance(value, tuple | list):
        return [_pack(v, arrays) for v in value]
    raise TypeError(f"a {kind.__name__} cannot be stored in a file")


def _is_record(kind: Any) -> bool:
    return dataclasses.is_dataclass(kind) or (isinstance(kind, type) and hasattr(kind, "_fields"))


_PUBLIC = {name: getattr(cases, name) for name in cases.__all__}


@cache
def _hints(kind: Any) -> dict[str, Any]:
    """The names and types of a record's fields."""
    # Names that a module imports only for type checkers are names of `cases`.
    hints = get_type_hints(kind, {**_PUBLIC, **vars(sys.modules[kind.__module__])})
    names = [f.name for f in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else kind._fields
    return {name: hints[name] for name in names}
