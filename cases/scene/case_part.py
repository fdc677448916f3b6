"""Parts of a case that are cases of their own: one plate, or a piece of its outline, on one curve, or a piece of it."""

from __future__ import annotations

from typing import Any, Self

from .case_class import FIELDS, Case
from .plate import Plate


class CasePart(Case):
    """A part of the case `whole`, unchecked; `key`: which of the parts of its kind it is."""

    whole: Case
    key: tuple[int, ...]

    @classmethod
    def of(cls, whole: Case, key: tuple[int, ...], **values: Any) -> Self:
        """The part with these values of its own, and the others of the whole."""
        part = object.__new__(cls)
        vars(part).update({name: vars(whole)[name] for name in FIELDS} | values, whole=whole, key=key)
        return part

    def __eq__(self, other) -> bool:
        return type(other) is type(self) and self.key == other.key and self.whole == other.whole

    def __hash__(self) -> int:
        return hash((self.whole, self.key))


def with_outline(plate: Plate, outline: Any) -> Plate:
    """A plate with a piece or a corner of its outline, unchecked."""
    part = object.__new__(Plate)
    vars(part).update(vars(plate), outline=outline)
    return part
