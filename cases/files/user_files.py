"""Read files that a user names: checked before reading, limited in size, with errors in one sentence."""

from __future__ import annotations

from pathlib import Path

from ..errors import BadValue, UnknownName


def place(what: str, path: object) -> Path:
    """The path with ~ expanded; raises BadValue, in a sentence that calls it `what`, if it is no valid path."""
    if isinstance(path, str) and not path:
        raise BadValue(f"the {what} is empty; give a path")
    try:
        file = Path(path).expanduser()  # type: ignore[arg-type]
        file.exists()
        str(file.resolve()).encode()  # a page, and a list of files, hold its name
    except (TypeError, ValueError, RuntimeError, OSError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem).partition("\n")[0]
        raise BadValue(
            f"the {what} is {_display_path(path)}, which is no path here ({_display_path(reason)}); give another"
        ) from None
    return file


def existing(what: str, path: object, follow: bool = True) -> Path:
    """The path of an existing regular file; raises BadValue or UnknownName.

    `follow`: whether it may be a link. Of files from outside none may: messages quote them, and the target is not
    theirs.
    """
    file = place(what, path)
    if not follow and file.is_symlink():
        raise BadValue(f"the {what} {_display_path(path)} is a link; give the file itself")
    if not file.exists():
        raise UnknownName(f"there is no {what} {_display_path(path)}")
    if not file.is_file():
        raise BadValue(f"the {what} is {_display_path(path)}, which is no ordinary file; give a file")
    return file


def content(what: str, path: object, most: int, follow: bool = True) -> bytes:
    """The content of a file of at most `most` bytes; raises BadValue or UnknownName, as `existing`."""
    file = existing(what, path, follow)
    try:
        with file.open("rb") as stream:
            data = stream.read(most + 1)
    except OSError as problem:
        raise BadValue(f"the {what} {_display_path(path)} cannot be read ({problem.strerror}); give another") from None
    if len(data) > most:
        size = f"{most / 2**20:g} MB" if most >= 2**20 else f"{most:,} bytes"
        raise BadValue(f"the {what} {_display_path(path)} is larger than {size}; give a smaller one")
    return data


def text(what: str, path: object, most: int, follow: bool = True, form: str = "CSV") -> str:
    """The content of a file as UTF-8 text, without a byte-order mark; raises BadValue or UnknownName."""
    try:
        decoded_text = content(what, path, most, follow).decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        raise BadValue(
            f"the {what} {_display_path(path)} is no {form} text ({problem.reason}); write it in UTF-8"
        ) from None
    if "\0" in decoded_text:
        raise BadValue(f"the {what} {_display_path(path)} is no {form} text (it holds NUL bytes); write it in UTF-8")
    return decoded_text


def _display_path(path: object) -> str:
    line = repr(str(path) if isinstance(path, Path) else path)
    return line if len(line) <= 120 else f"{line[:80]} … {line[-30:]}"
