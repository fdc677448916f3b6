"""What the suite says when it is asked for something it cannot do: one sentence each, with what to change."""

from __future__ import annotations

import re
from collections.abc import Iterable
from math import inf, isfinite
from numbers import Integral
from typing import TYPE_CHECKING, TypeVar

from .derivation import LOCK

if TYPE_CHECKING:
    import numpy as np

T = TypeVar("T")

# A number as it is written everywhere: no digits of other alphabets, no underscores. What is not finite is said to be.
_NUMBER = re.compile(r"\s*[+-]?((\d+\.?\d*|\.\d+)(e[+-]?\d+)?|inf|infinity|nan)\s*", re.ASCII | re.IGNORECASE)
# A longer sentence is shortened in its middle, where a long input is quoted.
LONGEST = 500


class CaseError(ValueError):
    """Base of all errors of invalid input; its text is one sentence that says what to change."""

    def __init__(self, text: str):
        # As `printable`, but as one sign: a sentence may quote much of it.
        line = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in " ".join(str(text).split()))
        half = LONGEST // 2
        super().__init__(line if len(line) <= LONGEST else f"{line[:half]} … {line[-half:]}")


def printable(text: str) -> str:
    """A text with characters spelled out that a terminal or a page would interpret or cannot write (control
    characters, lone surrogates), except ends of lines and tabs."""
    if text.replace("\n", "").replace("\t", "").isprintable():  # fast, and usual
        return text
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in text)


# Size limit of a foreign text in characters: the last error message of an engine fits.
_LONGEST_TEXT = 2000


def legible(text: object, most: int = _LONGEST_TEXT) -> str:
    """A foreign text for files and terminals: at most `most` characters, with characters that cannot be printed (a
    lone surrogate, NUL, an escape) spelled out."""
    whole = str(text)
    short = whole if len(whole) <= most else f"{whole[: most - 1]}…"
    return printable(short).replace("\t", r"\t")


def describe(problem: BaseException) -> str:
    """An exception in one line: its type and its text, if it has one. Raises nothing, whatever its `__str__` does."""
    try:
        text = str(CaseError(str(problem)))
    except Exception:
        text = "(its text cannot be read)"
    if isinstance(problem, CaseError) and text:
        return text
    return f"{type(problem).__name__}: {text}" if text else type(problem).__name__


class BadValue(CaseError):
    """A number or a type that no scene can have (NaN, a negative mass, a word instead of a number)."""


class BadCurve(CaseError):
    """A curve that cannot be a track or an outline (a cusp, a value that is not finite, no derivative)."""


class DoesNotFit(CaseError):
    """A plate that cannot touch its track as the start requires."""


class UnknownName(CaseError):
    """A case, parameter, solver or option that does not exist."""


class NotSupported(CaseError):
    """A valid case that the solver has no equations for. `limit`: which documented limit of it says so, if known."""

    def __init__(self, text: str, limit: str = ""):
        super().__init__(text)
        self.limit = limit


# Names shown in a message; of a longer list the message gives the total.
MOST_NAMES = 16
# Names of so many letters have no nearest spelling.
SHORT = 3


def unknown_name(kind: str, name: str, names: Iterable[str]) -> UnknownName:
    """The error for a name that does not exist, with the most similar names, or all names if none is similar."""
    import difflib  # of errors alone

    choices = sorted(names)
    near = difflib.get_close_matches(name, choices, n=3, cutoff=0.5)
    likely = difflib.get_close_matches(name, choices, n=1, cutoff=0.8)
    # A short list is shown completely: the nearest spelling is seldom right for short names.
    if near and len(choices) > 8:
        return UnknownName(f"there is no {kind} {name!r}; did you mean {' or '.join(near)}?")
    if not choices:
        return UnknownName(f"there is no {kind} {name!r}, and none can be given here")
    listing = ", ".join(choices[:MOST_NAMES]) + (f", … ({len(choices)} in all)" if len(choices) > MOST_NAMES else "")
    hint = f"; did you mean {likely[0]}?" if likely and len(name) > SHORT else ""
    return UnknownName(f"there is no {kind} {name!r}; choose from {listing}{hint}")


def choice(kind: str, name: object, names: Iterable[str]) -> str:
    """`name`, if it is one of `names`; raises UnknownName for anything else."""
    choices = tuple(names)
    if not isinstance(name, str) or name not in choices:
        raise unknown_name(kind, str(name), choices)
    return name


def instance(what: str, value: object, *kinds: type[T]) -> T:
    """`value`, if it is of one of the classes; raises BadValue for anything else."""
    if not isinstance(value, kinds):
        raise BadValue(f"the {what} is {value!r}; give a {' or '.join(kind.__name__ for kind in kinds)}")
    return value


def boolean(what: str, value: object) -> bool:
    """`value` as a bool; raises BadValue unless it is a truth value of Python or NumPy."""
    of_numpy = getattr(getattr(value, "dtype", None), "kind", "") == "b" and not getattr(value, "ndim", 0)
    if not isinstance(value, bool) and not of_numpy:
        raise BadValue(f"{what} is {value!r}; give True or False")
    return bool(value)


def real(value: object) -> float | None:
    """A real number of any type as a float (Python's own, Fraction, Decimal, NumPy's, SymPy's), infinite if it is too
    large; None for anything else: text, a truth value, a complex number, an array, a formula."""
    if type(value) is float:
        return value
    if isinstance(value, bool | str | bytes | bytearray) or not hasattr(value, "__float__"):
        return None
    # Only NumPy's integers and floats: its times and truth values can also be converted to float.
    if getattr(getattr(value, "dtype", None), "kind", "f") not in "iuf" or getattr(value, "ndim", 0) != 0:
        return None
    try:
        with LOCK:  # SymPy evaluates its number here
            return float(value)
    except OverflowError:
        return inf
    except (TypeError, ValueError):
        return None


def numbers(what: str, value: object) -> np.ndarray:
    """`value` as an array of floats, shape () for a number; raises BadValue unless it is a real number or an array of
    them. Infinite ones and NaN are accepted."""
    import numpy as np  # help needs none

    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        array = np.asarray(None)
    if array.dtype.kind == "O":  # of numbers of other types, or of anything
        floats = [real(each) for each in array.flat]
        if None not in floats:
            return np.array(floats, dtype=float).reshape(array.shape)
    elif array.dtype.kind in "iuf":
        return array.astype(float, copy=False)
    raise BadValue(f"{what}: {value!r}; give a number or an array of numbers")


def number_in(what: str, text: str) -> float:
    """The number that a text is; raises BadValue for any other text, such as "1_0"."""
    if not _NUMBER.fullmatch(text):
        raise BadValue(f"{what} is {text[:40]!r}; give a number")
    return float(text)


def finite(what: str, value: object) -> float:
    """`value` as a float; raises BadValue unless it is a finite real number."""
    if type(value) is float and isfinite(value):
        return value  # four times as fast: scenes are made many times
    number = real(value)
    if number is None:
        raise BadValue(f"{what} is {value!r}; give a number")
    if not isfinite(number):
        raise BadValue(f"{what} is {number}; give a finite number")
    return number


def items(what: str, value: object) -> tuple:
    """The items of `value`; raises BadValue unless it is a tuple, a list or another iterable that is no text."""
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        raise BadValue(f"{what} is {value!r}; give a tuple or a list")
    return tuple(value)


def point(what: str, value: object) -> tuple[float, float]:
    """`value` as two floats; raises BadValue unless it is a pair of finite real numbers."""
    pair = items(what, value)
    if len(pair) != 2:
        raise BadValue(f"{what} is {value!r}; give a pair of numbers (x, y)")
    return finite(f"x of the {what}", pair[0]), finite(f"y of the {what}", pair[1])


def positive(what: str, value: object) -> float:
    """`value` as a float; raises BadValue unless it is finite and greater than zero."""
    number = finite(what, value)
    if number <= 0.0:
        raise BadValue(f"{what} is {number:g}; give a number greater than zero")
    return number


def whole(what: str, value: object, least: int, most: int) -> int:
    """`value` as an int; raises BadValue unless it is a whole number from `least` to `most`."""
    number = finite(what, value)
    if number != int(number) or not least <= number <= most:
        raise BadValue(f"{what} is {number:g}; give a whole number from {least} to {most}")
    return int(number)


def whole_in(what: str, text: str, least: int, most: int) -> int:
    """The whole number from `least` to `most` that a text is; raises BadValue for any other text."""
    if not _NUMBER.fullmatch(text):
        raise BadValue(f"{what} is {text[:40]!r}; give a whole number from {least} to {most}")
    return whole(what, float(text), least, most)


def between(what: str, value: object, least: float, most: float) -> float:
    """`value` as a float; raises BadValue unless it is a number from `least` to `most`."""
    number = real(value)
    if number is None or not least <= number <= most:
        raise BadValue(f"{what} is {value!r}; give a number between {least:g} and {most:g}")
    return number


def parameter(what: str, value: object) -> float:
    """A case's parameter in its stored form: a whole number as an int, any other as a float.

    Raises BadValue unless it is a finite real number, or a truth value, which counts as 1 or 0.
    """
    if isinstance(value, bool):
        return value
    number = finite(what, value)
    return int(value) if isinstance(value, Integral) else number


def not_negative(what: str, value: object) -> float:
    """`value` as a float; raises BadValue unless it is finite and at least zero."""
    number = finite(what, value)
    if number < 0.0:
        raise BadValue(f"{what} is {number:g}; give zero or more")
    return number
