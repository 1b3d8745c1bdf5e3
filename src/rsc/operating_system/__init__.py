"""Everything that depends on the operating system; no other code distinguishes between systems.

posix.py is for Linux and macOS, windows.py for Windows; both define the same names with the same meaning. windows.py was written
from documentation and is tested on Linux without what Windows lacks (tests/support/without_posix) and under Wine (tools/wine.py),
not on Windows itself.
"""

import sys
from importlib.util import find_spec
from typing import TYPE_CHECKING

from rsc.operating_system.shared import UnsafeFolder

if sys.platform == "win32" or (not TYPE_CHECKING and find_spec("fcntl") is None):
    from rsc.operating_system.windows import (
        CACHES,
        NEAR_CODE,
        SENT_TWICE,
        STOPS,
        Claim,
        Folder,
        address_space,
        explained,
        free_memory,
        hdf5_library,
        is_own,
        lock,
        open_to_read,
        own_folder,
        process_memory,
        processors,
        prove_writable,
        read_at,
        refuse_in_use,
        remove,
        user_caches,
    )
else:
    from rsc.operating_system.posix import (
        CACHES,
        NEAR_CODE,
        SENT_TWICE,
        STOPS,
        Claim,
        Folder,
        address_space,
        explained,
        free_memory,
        hdf5_library,
        is_own,
        lock,
        open_to_read,
        own_folder,
        process_memory,
        processors,
        prove_writable,
        read_at,
        refuse_in_use,
        remove,
        user_caches,
    )

__all__ = [
    "CACHES",
    "NEAR_CODE",
    "SENT_TWICE",
    "STOPS",
    "Claim",
    "Folder",
    "UnsafeFolder",
    "address_space",
    "explained",
    "free_memory",
    "hdf5_library",
    "is_own",
    "lock",
    "open_to_read",
    "own_folder",
    "process_memory",
    "processors",
    "prove_writable",
    "read_at",
    "refuse_in_use",
    "remove",
    "user_caches",
]
