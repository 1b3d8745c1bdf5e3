"""What the operating system says of a file that is not there: other words on Windows."""

import os


def _said():
    try:
        os.stat("a name that no file has")
    except OSError as error:
        return error.strerror.lower().rstrip(". ")


MISSING = _said()
