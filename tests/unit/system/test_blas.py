"""The linear algebra that bits depend on: told by its name and the processor it is set to."""

import os
import platform
import subprocess
import sys

import pytest

from rsc.simulation.run import versions
from rsc.system.blas import product

TOLD = "from rsc.simulation.run import versions; print(versions())"


def test_versions_name_the_linear_algebra():
    assert f" with {product()}, " in versions()


@pytest.mark.skipif("openblas" not in product() or platform.machine() not in ('x86_64', 'AMD64'), reason="needs OpenBLAS on x86")
def test_another_kernel_of_openblas_is_another_version():
    """Its numbers differ in their last digits, and with the same text a run would be resumed with other bits."""
    def told(kind):
        environment = os.environ | {"OPENBLAS_CORETYPE": kind, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        return subprocess.run([sys.executable, "-c", TOLD], env=environment, capture_output=True, text=True, check=True).stdout

    assert "openblas Haswell" in told("Haswell") and "openblas Haswell" not in told("Prescott")
