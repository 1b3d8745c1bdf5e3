"""Zeros of several smooth functions over one line, also pairs of zeros between two samples, all at once."""

import numpy as np

_HALVINGS = 40
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_GRADES = 4.0 ** -np.arange(1, 25)  # of the distance to the next sample: beside a zero, where branches end with a root


def zeros(functions, x):
    """Zeros of functions between samples.

    Parameters
    ----------
    functions : function of (m,) to (k, m) float
    x : (n,) float, rising

    Returns
    -------
    (z,) float, rising
        Every sign change between samples, and both of a pair where a function has an extremum beyond zero beside a sample.
    """
    y = functions(x)
    which, i = np.nonzero(y[:, :-1] * y[:, 1:] < 0.0)
    brackets = [(which, x[i], x[i + 1])]
    size, sign = np.abs(y), np.sign(y)
    dips = (size[:, 1:-1] <= size[:, :-2]) & (size[:, 1:-1] <= size[:, 2:])
    dips &= (sign[:, 1:-1] == sign[:, :-2]) & (sign[:, 1:-1] == sign[:, 2:]) & (sign[:, 1:-1] != 0.0)
    which, i = np.nonzero(dips)
    low, high = x[i], x[i + 2]
    lowest = _least(functions, which, sign[which, i + 1], low, high)
    beyond = _chosen(functions, lowest, which) * sign[which, i + 1] < 0.0
    which, lowest = which[beyond], lowest[beyond]
    brackets += [(which, low[beyond], lowest), (which, lowest, high[beyond])]
    return np.unique(_bisected(functions, *(np.concatenate(parts) for parts in zip(*brackets, strict=True))))


def beside(z, x):
    """Samples beside zeros z, ever closer to them, between their neighbours among the samples x (rising)."""
    i = np.clip(np.searchsorted(x, z), 1, len(x) - 1)
    below, above = (z - x[i - 1])[:, None] * _GRADES, (x[i] - z)[:, None] * _GRADES
    return np.concatenate([z, (z[:, None] - below).ravel(), (z[:, None] + above).ravel()])


def _chosen(functions, x, which):
    """Of each x the value of its own function."""
    return functions(x)[which, np.arange(len(x))] if len(x) else np.zeros(0)


def _bisected(functions, which, low, high):
    sign = np.sign(_chosen(functions, low, which))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        alike = _chosen(functions, middle, which) * sign > 0.0
        low, high = np.where(alike, middle, low), np.where(alike, high, middle)
    return 0.5 * (low + high)


def _least(functions, which, sign, low, high):
    """Places of the least sign * function in ranges, by golden section."""
    inner = [high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)]
    values = [sign * _chosen(functions, place, which) for place in inner]
    for _ in range(_HALVINGS):
        left = values[0] < values[1]
        low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
        new = np.where(left, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        value = sign * _chosen(functions, new, which)
        inner = [np.where(left, new, inner[1]), np.where(left, inner[0], new)]
        values = [np.where(left, value, values[1]), np.where(left, values[0], value)]
    return np.where(values[0] < values[1], inner[0], inner[1])
