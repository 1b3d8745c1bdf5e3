"""What both systems have in common."""

from rsc.errors import RscError


class UnsafeFolder(RscError):
    """A folder that cannot be used, or that others may write: which one and why, in one line."""
