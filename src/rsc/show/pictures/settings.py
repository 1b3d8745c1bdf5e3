"""matplotlib's settings while rsc draws: those that it comes with, whatever a matplotlibrc or the calling program has set.

So a picture has the same bytes everywhere, and no text becomes LaTeX code because somebody has set `text.usetex`.
"""

import contextlib
import threading
from collections.abc import Iterator

import matplotlib

NO_PICTURE = ("backend", "backend_fallback", "interactive")  # these would switch windows of the calling program
DEFAULTS = {name: value for name, value in matplotlib.rcParamsDefault.items() if name not in NO_PICTURE}
DEFAULTS |= {"svg.hashsalt": "rsc"}  # else the names in an SVG are random
_ONE = threading.RLock()  # the settings are those of the whole process


@contextlib.contextmanager
def default_settings() -> Iterator[None]:
    """Inside, or as `@default_settings()` inside a function, matplotlib has its defaults; one thread at a time."""
    with _ONE, matplotlib.rc_context(DEFAULTS):
        yield
