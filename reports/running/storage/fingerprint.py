"""Keys of results: everything that determines a result, in comparable form (code, versions, machine, case).

Two results with the same key are the same result. Files and environment variables that an engine reads itself are not
part of a key.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import platform
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import sympy as sp

from cases import Case, Chain, ContactEffect, Curve
from reference import certification

from .. import reference_adapter, versions
from ..names import REFERENCE
from . import source_code

Key = dict[str, Any]

# Packages whose version can change a digit of any result: arithmetic, code generation, compilers of expressions.
_PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "heyoka")
# Longest argument (characters) that a key contains as text; longer ones are digests.
_LONGEST_ARGUMENT = 1000


def environment_key(versions: Mapping[str, str], solvers: Iterable[str]) -> Key | None:
    """Solvers, their versions and adapters, packages, machine; None if the version of a solver is unknown."""
    engines = {name: versions.get(name) for name in solvers}
    if not all(engines.values()):
        return None
    return {"engines": engines, "adapters": {name: adapter_sources(name) for name in engines}, **surroundings()}


@lru_cache(maxsize=1)
def surroundings() -> Key:
    """The part of every key: Python, packages, machine."""
    packages = {name: installed_packages(name) for name in _PACKAGES}
    python = f"{platform.python_implementation()} {sys.version.split()[0]}"
    return {"python": python, "packages": packages, "machine": machine()}


def machine() -> str:
    """Processor, cores and system, on which times and the last digits of some functions depend."""
    return f"{processor()}, {os.cpu_count()} cores, {platform.machine()}, {platform.system()}"


def processor() -> str:
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


@lru_cache(maxsize=64)
def installed_packages(package: str) -> str:
    """The version of an installed package."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def digest(data: Any) -> str:
    """The digest of any data that JSON can represent."""
    text = json.dumps(data, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()


# --- arguments --------------------------------------------------------------------------------------------------------


def of_argument(value: Any) -> Any:
    """A call's argument in a form that JSON can represent; a digest if it is long.

    None if it contains something that cannot be compared, such as a function."""
    if isinstance(value, Case):
        return content(value)
    try:
        form = plain(value)
    except TypeError:
        return None
    return form if len(json.dumps(form)) <= _LONGEST_ARGUMENT else digest(form)


@lru_cache(maxsize=256)
def content(case: Case) -> str | None:
    """Digest of a case: curves as expressions, plate, effects, start, duration, parameters.

    None if it contains something that cannot be compared, such as a function as a parameter."""
    try:
        return digest(plain(case))
    except TypeError:
        return None


def plain(value: Any) -> Any:
    """A value of any kind as numbers, texts, formulas and digests of arrays; raises TypeError if it cannot be
    compared."""
    if isinstance(value, Chain):
        return [type(value).__name__, [plain(piece) for piece in value.pieces], value.is_closed]
    if isinstance(value, Curve) and value.parts is not None:
        return ["Curve in pieces", plain(value.parts)]
    if isinstance(value, Curve):
        return ["Curve", [sp.srepr(part) for part in value.expression], plain(value.domain)]
    if isinstance(value, sp.Basic):
        return sp.srepr(value)
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return ["ndarray", value.dtype.str, list(value.shape), hashlib.sha256(value.tobytes()).hexdigest()]
    if value is None or isinstance(value, bool | int | float | str | np.generic):
        return [type(value).__name__, repr(value)]
    if isinstance(value, ContactEffect):  # what its fields mean may change with its package
        module, ends = type(value).__module__, [[end.status, end.reason] for end in value.ends()]
        return [module, type(value).__name__, [sp.srepr(formula) for formula in value.formulas], ends]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [type(value).__name__, {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}]
    if isinstance(value, Mapping):
        return [[plain(key), plain(v)] for key, v in value.items()]
    if isinstance(value, tuple | list):
        return [plain(v) for v in value]
    raise TypeError(f"{value!r} has no content that can be compared")


# --- code -------------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=64)
def sources(module: ModuleType, apart: tuple[ModuleType, ...] = ()) -> str:
    """Digest of the code that a module's results may depend on, except that of the modules and packages in `apart`.

    Whole folders count (`source_code.dependency_files`), layout and comments do not.
    """
    return _digest_of(module.__name__, tuple(m.__name__ for m in apart))


@lru_cache(maxsize=64)
def adapter_sources(solver: str) -> str:
    """Digest of the code of a solver's adapter, without loading it or its engine.

    Raises LookupError for a solver without an adapter.
    """
    if solver == REFERENCE:
        return sources(reference_adapter)
    return _digest_of(source_code.of_adapter(versions.split_version(solver)[0]), ())


@lru_cache(maxsize=1)
def truth_key() -> str:
    """Digest of the truths stored with the suite. Raises DamagedTruth before anything is judged by them."""
    certification.read()
    return hashlib.sha256(certification.TRUTH.read_bytes()).hexdigest()


def _digest_of(module: str, apart: tuple[str, ...]) -> str:
    return digest(
        {name: source_code.of(path) for name, path in sorted(source_code.dependency_files(module, apart).items())}
    )
