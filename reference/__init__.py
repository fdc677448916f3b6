"""The certified solver: a plate with friction on a fixed curve, by the paper's augmented system (27)."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .certification.certificate import certify
    from .impulses import impacts
    from .laws_check.broken_laws import BrokenLaw
    from .laws_check.full_check import check
    from .parameter_derivatives import Derivatives, NoDerivative, derivatives
    from .proofs.prover import prove
    from .solve import METHODS, simulate
    from .sweeping import sweep, sweep_chunks

__all__ = [
    "METHODS",
    "BrokenLaw",
    "Derivatives",
    "NoDerivative",
    "certify",
    "check",
    "derivatives",
    "impacts",
    "prove",
    "simulate",
    "sweep",
    "sweep_chunks",
]

_MODULE_OF = {
    "certify": "certification.certificate",
    "BrokenLaw": "laws_check.broken_laws",
    "check": "laws_check.full_check",
    **dict.fromkeys(("Derivatives", "NoDerivative", "derivatives"), "parameter_derivatives"),
    "impacts": "impulses",
    "prove": "proofs.prover",
    **dict.fromkeys(("METHODS", "simulate"), "solve"),
    **dict.fromkeys(("sweep", "sweep_chunks"), "sweeping"),
}


def __getattr__(name: str) -> Any:
    """Import each name on first use, so that help needs none, and a simulation neither certification nor sweeps."""
    if name == "certification":
        return import_module(".certification", __name__)
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        value = getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)
    except ModuleNotFoundError as problem:
        if problem.name != "flint":
            raise
        message = 'reference.prove needs python-flint; type: pip install "slip-to-roll[proofs]"'
        raise AttributeError(message) from problem
    if _MODULE_OF[name] == "solve":  # from now on an attribute
        globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
