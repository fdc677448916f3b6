"""The certified solver: a plate with friction on a fixed curve, by the paper's augmented system (27)."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .certification.certificate import certify
    from .laws_check import BrokenLaw, check
    from .proofs.prover import prove
    from .solve import METHODS, simulate
    from .sweeping import sweep, sweep_chunks

__all__ = ["METHODS", "BrokenLaw", "certify", "check", "prove", "simulate", "sweep", "sweep_chunks"]


def __getattr__(name: str) -> Any:
    """Import each name on first use, so that help needs none, and a simulation neither certification nor sweeps."""
    if name in ("METHODS", "simulate"):  # from now on an attribute
        value = globals()[name] = getattr(import_module(".solve", __name__), name)
        return value
    if name == "certify":
        from .certification.certificate import certify

        return certify
    if name in ("BrokenLaw", "check"):
        return getattr(import_module(".laws_check", __name__), name)
    if name == "prove":
        try:
            from .proofs.prover import prove
        except ModuleNotFoundError as problem:
            if problem.name != "flint":
                raise
            message = 'reference.prove needs python-flint; type: pip install "slip-to-roll[proofs]"'
            raise AttributeError(message) from problem
        return prove
    if name in ("sweep", "sweep_chunks"):
        return getattr(import_module(".sweeping", __name__), name)
    if name == "certification":
        return import_module(".certification", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
