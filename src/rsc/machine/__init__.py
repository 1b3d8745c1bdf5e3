"""Machines from other programs: finite-element models of rotors and stators, and their reduction to a few coordinates."""

from rsc.machine.imports.ross import from_ross

__all__ = ["from_ross"]
