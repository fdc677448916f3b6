"""The reference with the interface of an adapter, so that the experiment runs it like an engine.

Its routes are its methods and the paper's own matrix ("augmented"); its ladder is the relative tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

from adapters import Setting
from cases import Case, ContactEffect, Trajectory
from reference import solve

NAME = "reference"
# The compiled package of the Taylor method; the other routes are pure Python.
ENGINE = "heyoka"
routes = solve.ROUTES
SLIP_LAWS = routes
# The paper's matrix is for one contact.
SEVERAL_CONTACTS = tuple(route for route in routes if route != "augmented")
EVERY_SCENE = DRIVEN_CONTACTS = SEVERAL_CONTACTS
OWN_EFFECTS = (ContactEffect,)

# From a coarse tolerance to the limit of double precision.
_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
# The literal matrix takes about fifteen times as long as the eliminated equations with the same steps. Its cost is
# visible without the tightest tolerances, which alone would take longer than the engines.
_LITERAL = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9)


@dataclass
class _Model:
    """A case to integrate; after the run also its solution."""

    problem: solve.InitialValueProblem
    solution: tuple | None = None


def refuses(case: Case, route: str) -> str | None:
    """Always None: unsupported cases are reported by `build`."""
    return None


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Relative tolerances from coarse to fine."""
    return tuple(Setting.of(rtol=rtol) for rtol in (_LITERAL if route == "augmented" else _TOLERANCES))


def build(case: Case, route: str, setting: Setting) -> _Model:
    """Derive and compile the equations of the first mode, later ones when a run enters them; raises NotSupported for an
    unsupported case."""
    problem = solve.initial_value_problem(case, setting["rtol"], route)
    if problem.regime is not None:
        solve.prepare(problem.relative, problem.regime, route, setting["rtol"])
    return _Model(problem)


def run(model: _Model) -> None:
    """Integrate, locate the transitions and search for second contacts: the work of an engine's steps."""
    model.solution = model.problem.solve()


def read(model: _Model) -> Trajectory:
    """The sampled motion with the transitions that the reference located."""
    assert model.solution is not None, "read comes after run"
    return model.problem.trajectory(model.solution)


def version() -> str:
    """The suite's own version: the reference is part of it."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed_version

    try:
        return installed_version("slip-to-roll")
    except PackageNotFoundError:
        return "not installed as a package"
