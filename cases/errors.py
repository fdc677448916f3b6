"""What the suite says when it is asked for something it cannot do: one sentence each, with what to change."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from math import isfinite
from numbers import Real

# A sentence longer than this is cut in its middle, where a long input was quoted.
LONGEST = 500


class CaseError(ValueError):
    """Base of every error a wrong question raises; its text is one sentence that says what to change."""

    def __init__(self, text: str):
        # What a terminal or a page would act on, or cannot write (control characters, half surrogates), is no text.
        line = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in " ".join(str(text).split()))
        half = LONGEST // 2
        super().__init__(line if len(line) <= LONGEST else f"{line[:half]} … {line[-half:]}")


def described(problem: BaseException) -> str:
    """An exception in one line: its type and its text, if it has one. Raises nothing, whatever its `__str__` does."""
    try:
        text = str(CaseError(str(problem)))
    except Exception:
        text = "(its text cannot be read)"
    if isinstance(problem, CaseError) and text:
        return text
    return f"{type(problem).__name__}: {text}" if text else type(problem).__name__


class BadValue(CaseError):
    """A number or a type that no scene can have (NaN, a negative mass, a word where a number belongs)."""


class BadCurve(CaseError):
    """A curve that cannot be a track or an outline (a cusp, a value that is not finite, no derivative)."""


class DoesNotFit(CaseError):
    """A plate that cannot touch its track as the start asks."""


class UnknownName(CaseError):
    """A case, parameter, solver or option that does not exist."""


class NotSupported(CaseError):
    """A well-posed question this solver has no equations for."""


# More names than a reader takes in at a glance are counted.
MOST_NAMES = 16


def unknown(kind: str, name: str, known: Iterable[str]) -> UnknownName:
    """The error for a name that is not there: the nearest known names, or all of them where none is near."""
    choices = sorted(known)
    near = difflib.get_close_matches(name, choices, n=3, cutoff=0.5)
    # A short list is shown whole: the nearest spelling is seldom the best guess for names of one or two letters.
    if near and len(choices) > 8:
        return UnknownName(f"there is no {kind} {name!r}; did you mean {' or '.join(near)}?")
    if not choices:
        return UnknownName(f"there is no {kind} {name!r}, and none can be given here")
    shown = ", ".join(choices[:MOST_NAMES]) + (f", … ({len(choices)} in all)" if len(choices) > MOST_NAMES else "")
    return UnknownName(f"there is no {kind} {name!r}; choose from {shown}")


def finite(what: str, value: object) -> float:
    """`value` as a float; raises BadValue unless it is a finite real number."""
    if type(value) is float and isfinite(value):
        return value  # at a quarter of the price: scenes are made again and again
    if isinstance(value, bool) or not isinstance(value, Real):
        raise BadValue(f"{what} is {value!r}; give a number")
    try:
        number = float(value)
    except OverflowError:
        number = float("inf")
    if not isfinite(number):
        raise BadValue(f"{what} is {number}; give a finite number")
    return number


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


def not_negative(what: str, value: object) -> float:
    """`value` as a float; raises BadValue unless it is finite and at least zero."""
    number = finite(what, value)
    if number < 0.0:
        raise BadValue(f"{what} is {number:g}; give zero or more")
    return number
