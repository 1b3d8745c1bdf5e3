"""Definitions common to all operating systems."""

from rsc.errors import RscError


class UnsafeFolder(RscError):
    """A folder that cannot be used or that others may write; the message names it and the reason in one line."""
