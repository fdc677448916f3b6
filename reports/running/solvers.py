"""Solvers by name: the reference and the engines. `solver` and `version` load an engine and are called in workers
only."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution, requires
from typing import Any

from packaging.requirements import Requirement

import adapters
from adapters.interface import ReturnsOnce, returns_once
from adapters.processes import worker
from adapters.processes.pool import WorkerPool
from cases.errors import legible
from cases.version import in_clone

from . import versions
from .names import REFERENCE
from .storage import source_code

_LONGEST_VERSION = 100
# The worker groups of calls that name several engines, and of engines that are not installed.
SEVERAL, _ABSENT = "several engines", "absent engines"


def names() -> tuple[str, ...]:
    """Names of all solvers: the reference, then the engines in alphabetical order. Loads no engine."""
    return (REFERENCE, *adapters.engines())


def solver(name: str) -> Any:
    """A solver by name, an engine or the reference; raises ImportError if it, or the version in its name, is not
    installed."""
    if name == REFERENCE:
        from . import reference_adapter

        return ReturnsOnce(reference_adapter)  # like an engine, so that timings are comparable
    if worker.group == "":
        raise RuntimeError(f"{name} was requested in a worker whose calls must not load an engine")
    versions.demand(name)
    return ReturnsOnce(returns_once(adapters.engine)(versions.split_version(name)[0]))


# The outcome of an engine that is not installed; it is not counted.
NOT_INSTALLED = "not_installed"


def version(name: str) -> str:
    """The version of a solver; NOT_INSTALLED and the missing module if it is not installed."""
    try:
        return legible(solver(name).version(), _LONGEST_VERSION)
    except ImportError as problem:
        return f"{NOT_INSTALLED}: {legible(problem.name or problem, _LONGEST_VERSION)}"


def is_missing(version: str) -> bool:
    """Whether a solver's version says that it is not installed."""
    return version.startswith(NOT_INSTALLED)


def pool(jobs: int) -> WorkerPool:
    """Workers in which every engine, and every version of one, has processes of its own."""
    return WorkerPool(jobs, groups_of, versions.paths)


def groups_of(calls: Iterable[Iterable]) -> list[str]:
    """The worker group of each call, by the engines that its arguments name.

    Each engine, and each version of one, has its own workers, so that its changes to a process affect no other engine.
    "" is for calls without engines. Engines that are not installed share a group, and so do calls that name several.
    """
    engines = names()[1:]

    def group(call: Iterable) -> str:
        mentions = sorted(named_in(call, lambda text: versions.split_version(text)[0] in engines))
        if len(mentions) == 1:
            return mentions[0] if is_installed(mentions[0]) else _ABSENT
        return SEVERAL if mentions else ""

    return [group(call) for call in calls]


def named_in(arguments: Iterable, is_solver: Callable[[str], bool]) -> set[str]:
    """The solvers named in arguments, also inside tuples and lists."""
    result: set[str] = set()
    for argument in arguments:
        if isinstance(argument, str) and is_solver(argument):
            result.add(argument)
        elif isinstance(argument, tuple | list):
            result |= named_in(argument, is_solver)
    return result


@lru_cache(maxsize=256)
def is_installed(name: str) -> bool:
    """Whether the package in an adapter's `KNOWN` is installed, or there is none; loads no engine."""
    engine, version = versions.split_version(name)
    try:
        package = source_code.literal_of(engine, "KNOWN")
        return bool(version) or not isinstance(package, str) or bool(distribution(Requirement(package).name))
    except PackageNotFoundError:
        return False
    except (SyntaxError, ValueError, LookupError, OSError, ImportError):  # the import reports an unreadable source
        return True


def missing_words(versions: Mapping[str, str]) -> list[str]:
    """A line for each solver that is not installed, and the command that installs those that are extras."""
    missing = {name: text.partition(": ")[2] for name, text in versions.items() if is_missing(text)}
    lines = [f"{name}: {NOT_INSTALLED.replace('_', ' ')} (it needs {needs})" for name, needs in missing.items()]
    extras = dict(sorted(pair for needs in missing.values() if (pair := _extra(needs))))
    if extras:
        make, pip = f'make report EXTRAS="{" ".join(extras)}"', f"pip install {' '.join(extras.values())}"
        lines.append(f"{make if in_clone() else pip} adds {'them' if len(extras) > 1 else 'it'}")
    return lines


def _extra(module: str) -> tuple[str, str] | None:
    """The extra of this suite whose package contains a module, with that package; None if no extra has it."""
    try:
        needs = requires("slip-to-roll") or []
    except PackageNotFoundError:
        return None
    result = [re.fullmatch(r"""([\w-]+).*;.*extra\s*==\s*['"]([\w-]+)['"].*""", need) for need in needs]
    own = {match[1].replace("-", "_"): (match[2], match[1]) for match in result if match}
    return own.get(module.partition(".")[0])


def routes(name: str) -> tuple[str, ...]:
    """The routes of a solver; () if its source does not list them. Loads no engine.

    Raises ImportError if an import of the adapter is not installed, LookupError if it has no source file.
    """
    return (
        tuple(map(str, solver(name).routes))
        if name == REFERENCE
        else source_code.routes_of(versions.split_version(name)[0])
    )
