"""Finite-element models: files, complex coordinates, shafts from stations, reduction. Public: `from_ross`, `fit_states`."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rsc.machine.imports.rational import fit_states
    from rsc.machine.imports.ross import from_ross

__all__ = ["fit_states", "from_ross"]


def __getattr__(name: str) -> Any:
    # reading a model loads scipy.linalg, which a run without one does not need
    if name in __all__:
        from rsc.machine.imports import rational, ross

        return getattr(ross if name == "from_ross" else rational, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
