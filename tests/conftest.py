"""What holds for all tests."""

import os
import signal
import sys

import pytest

# a job in the background of a script begins with SIGINT ignored, and so would every process that a test starts and interrupts
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
# and one under nohup with SIGHUP ignored
if os.name == "posix" and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def pytest_runtest_setup(item):
    if os.name != "posix" and item.get_closest_marker("posix"):
        pytest.skip("needs what Windows does not have")


@pytest.fixture(autouse=True)
def _no_figure_stays_open():
    """pyplot keeps every figure that a `plot()` made, and warns from the twentieth on."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
