"""Libraries that read the files of laboratories, which are extras."""

import importlib
from types import ModuleType

from rsc.measured.channel import NoColumns

EXTRA = 'pip install "rotor-stator-contact[measured]"'


def imported(module: str, kind: str) -> ModuleType:
    """The library of a format; NoColumns, which says how to get it, where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise NoColumns(f"is {kind}, whose reader is an extra: {EXTRA}") from None
