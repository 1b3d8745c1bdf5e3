"""Finite-element models: files, complex coordinates, shafts from stations, reduction. Public: `from_ross`."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rsc.machine.imports.ross import from_ross

__all__ = ["from_ross"]


def __getattr__(name: str) -> Any:
    # reading a model loads scipy.linalg, which a run without one does not need
    if name in __all__:
        from rsc.machine.imports import ross

        return getattr(ross, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
