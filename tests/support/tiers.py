"""Which of many combinations `make test` runs, and which are left to `make nightly`."""

import pytest


def nightly(*values):
    """A case of a parametrized test that only `make nightly` runs."""
    return pytest.param(*values, marks=pytest.mark.nightly)


def first(cases, count=1):
    """The first of some equal cases in `make test`, the others in `make nightly`."""
    return [case if i < count else nightly(case) for i, case in enumerate(cases)]


def alternating(names, methods, slow=()):
    """Pairs (name, method): every name with one method in `make test`, in turn, and with the others in `make nightly`; slow names
    in `make nightly` only."""
    pairs = [(i, name, k, method) for i, name in enumerate(names) for k, method in enumerate(methods)]
    return [
        pytest.param(name, method) if i % len(methods) == k and name not in slow else nightly(name, method)
        for i, name, k, method in pairs
    ]
