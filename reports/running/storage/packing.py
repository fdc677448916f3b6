"""Plain records (dataclasses, named tuples, enums, tuples, mappings, arrays) <-> what JSON and raw bytes can hold.

The type's own annotations say how to read a record back, so nothing in a file decides what code runs. `pack` reads what
it has written: a value that is not of its type is refused when it is kept, not found out when it is needed.

Two libraries were measured on the 16 types that are kept, with random values. cattrs 26.2 reads 6 of them back: where a
module has `from __future__ import annotations` it leaves those of named tuples unresolved. msgspec 0.22 reads 15 and
would save some 60 lines for one more compiled dependency; a build that finds 1,000 runs in the store would gain 0.05 s.
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

# What an array's elements may be: truth values, integers with and without a sign, floats.
_ELEMENTS = "biuf"


def pack(kind: Any, value: Any) -> tuple[Any, list[bytes]]:
    """What JSON can hold of a value of type `kind`, and the bytes of its arrays.

    Raises ValueError for a value that is not of this type, or a type that cannot be kept.
    """
    arrays: list[bytes] = []
    try:
        plain = _pack(value, arrays)
        unpack(kind, plain, arrays)
    except Exception as problem:  # what is not of its type can raise anything
        raise ValueError(f"it cannot be kept as {getattr(kind, '__name__', kind)}: {problem}") from problem
    return plain, arrays


def unpack(kind: Any, data: Any, arrays: Sequence[bytes]) -> Any:
    """The value of type `kind` that `pack` wrote. Raises whatever data of another form may raise."""
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
            raise ValueError(f"it is no {kind.__name__}")
        return kind(**{name: unpack(hints[name], d, arrays) for name, d in data.items()})
    if kind is float and type(data) is int:
        return float(data)
    # A count that came as 100.0 is a count.
    if kind is int and type(data) is float and data.is_integer():
        return int(data)
    if type(data) is not kind:
        raise ValueError(f"{data!r} is no {getattr(kind, '__name__', kind)}")
    return data


def _unpack_union(kinds: tuple, data: Any, arrays: Sequence[bytes]) -> Any:
    if type(data) in kinds:
        return data
    others = [kind for kind in kinds if kind is not NoneType]
    if len(others) != 1:
        raise ValueError(f"{data!r} is none of {kinds}")
    return unpack(others[0], data, arrays)


def _array(data: Any, arrays: Sequence[bytes]) -> np.ndarray:
    place, elements, shape = data
    if (dtype := np.dtype(elements)).kind not in _ELEMENTS:
        raise ValueError(f"an array of {dtype} is never kept")
    # ValueError where content and shape do not agree. A copy: what a buffer of bytes holds cannot be changed.
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
    raise TypeError(f"a {kind.__name__} cannot be kept in a file")


def _is_record(kind: Any) -> bool:
    return dataclasses.is_dataclass(kind) or (isinstance(kind, type) and hasattr(kind, "_fields"))


@cache
def _hints(kind: Any) -> dict[str, Any]:
    """The names and types of a record's fields."""
    # What a module imports for type checkers alone are names of `cases`.
    hints = get_type_hints(kind, {**vars(cases), **vars(sys.modules[kind.__module__])})
    names = [f.name for f in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else kind._fields
    return {name: hints[name] for name in names}
