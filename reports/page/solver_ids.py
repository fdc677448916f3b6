"""Names of solvers in style sheets and element identifiers."""

from __future__ import annotations


def identifier(name: str) -> str:
    """A solver's name with only the characters that a CSS identifier allows."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)
