"""matplotlib's settings while rsc draws: those that it comes with, whatever a matplotlibrc or the calling program has set.

So a picture has the same bytes everywhere, and no text becomes LaTeX code because somebody has set `text.usetex`. Whatever draws
imports this module before matplotlib, which reads the settings of the user when it is loaded.
"""

import contextlib
import sys
import threading
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

try:
    import matplotlib
except (UnicodeDecodeError, OSError):  # a matplotlibrc that it cannot read; the first one it looks for is in the current folder
    for name in [name for name in sys.modules if name.startswith("matplotlib.")]:
        del sys.modules[name]  # halves of what could not be loaded
    with contextlib.chdir(Path(find_spec("matplotlib").origin, "..", "mpl-data").resolve()):  # type: ignore[union-attr, arg-type]
        matplotlib = import_module("matplotlib")

NO_PICTURE = ("backend", "backend_fallback", "interactive")  # these would switch windows of the calling program
DEFAULTS = {name: value for name, value in matplotlib.rcParamsDefault.items() if name not in NO_PICTURE}
DEFAULTS |= {"svg.hashsalt": "rsc"}  # else the names in an SVG are random
_ONE = threading.RLock()  # the settings are those of the whole process


@contextlib.contextmanager
def default_settings() -> Iterator[None]:
    """Inside, or as `@default_settings()` inside a function, matplotlib has its defaults; one thread at a time."""
    with _ONE, matplotlib.rc_context(DEFAULTS):
        yield
