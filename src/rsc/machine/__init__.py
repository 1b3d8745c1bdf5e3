"""Finite-element models of rotors and stators."""

from rsc.machine.ross import from_ross

__all__ = ["from_ross"]
