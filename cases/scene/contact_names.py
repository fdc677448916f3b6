"""The names of a case's first plate, of its track among the supports, and of the contact of both."""

from ..errors import BadValue

FIRST, TRACK = "plate", "track"
# Further contacts with the track are numbered from 2.
CONTACT = f"{FIRST}/{TRACK}"


def contact_name(plate: str, support: str, number: int) -> str:
    """The name of a contact of a plate: "plate/wall"; those of its further corners, or that touch later, have numbers
    from 2 on."""
    return f"{plate}/{support}" if number == 1 else f"{plate}/{support} {number}"


def check_word(part: str, name: object, example: str, *taken: str) -> None:
    """Raise BadValue unless the name of a part of a case is a word, and none of those that are taken."""
    is_word = isinstance(name, str) and name.replace("_", "").replace("-", "").isalnum() and len(name) <= 30
    if not is_word or name in taken:
        usual = f'"{taken[0]}" is the case\'s {taken[0]}'
        raise BadValue(f'the name of a {part} is {name!r}; give a word such as "{example}" ({usual})')
