"""Memory limit for readers of data files: what will be held is counted before it is read."""

MOST_FILE = 2**29  # bytes of a file
MOST = 2**30  # bytes of the numbers read from it
NUMBER = 8  # bytes of a float64, which every number becomes


class TooLarge(ValueError):
    """The numbers of a file need too much memory; one-line message without the file name."""


class Memory:
    """The remaining memory budget of one file.

    Parameters
    ----------
    most : int
        Bytes of all numbers together.
    """

    def __init__(self, most: int = MOST) -> None:
        self.most = self.left = most

    def take(self, what: str, count: int, width: int = NUMBER) -> None:
        """Count numbers that will be held in memory.

        Parameters
        ----------
        what : str
            What the numbers are, for the message.
        count : int
            How many.
        width : int
            Bytes of each in the file; a narrower number becomes a float64.

        Raises
        ------
        TooLarge
            They do not fit into the remaining budget.
        """
        wanted = count * max(width, NUMBER)
        if wanted > self.left:
            most = f"at most {_size(self.most)} of a file are held"
            raise TooLarge(f"{what} takes too much memory: {count} numbers are {_size(wanted)}; {most}")
        self.left -= wanted


def _size(count: int) -> str:
    return f"{count / 2**20:.0f} MB" if count >= 2**20 else f"{count} bytes"
