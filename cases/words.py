"""The words of a command line: what all commands' parsers share."""

from __future__ import annotations

import argparse
from typing import NoReturn

from .errors import BadValue, unknown


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence, by the suite's own error; an option is not guessed from its beginning."""

    def __init__(self, **how):
        super().__init__(allow_abbrev=False, **how)

    def error(self, message: str) -> NoReturn:
        """Raises UnknownName for an option that there is not, BadValue for anything else."""
        stray = message.removeprefix("unrecognized arguments: ")
        if stray != message:
            options = [o for action in self._actions for o in action.option_strings if o.startswith("--")]
            raise unknown("option", (stray.split() or [""])[0], options)
        raise BadValue(f"{message}; see {self.prog} --help")
