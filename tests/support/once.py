"""A slow program runs once for all tests that ask it the same."""

import functools
import pickle


def once(function):
    """The function with its answers kept: the methods of a run are compared with one integration, not with one each."""
    kept = {}

    @functools.wraps(function)
    def asked(*args, **named):
        key = pickle.dumps((args, named))
        if key not in kept:
            kept[key] = function(*args, **named)
        return kept[key]

    return asked
