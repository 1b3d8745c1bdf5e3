"""The memory that readers of data files may take: what will be held is counted before anything of it is read."""

MOST_FILE = 2**29  # bytes of a file
MOST = 2**30  # bytes of the numbers that are taken from it
NUMBER = 8  # bytes of a float64, which every number becomes


class TooLarge(ValueError):
    """Why the numbers of a file are not read, in one line without the file's name."""


class Memory:
    """What is left of the bytes that one file may take.

    Parameters
    ----------
    most : int
        Bytes of all numbers together.
    """

    def __init__(self, most: int = MOST) -> None:
        self.most = self.left = most

    def take(self, what: str, count: int, width: int = NUMBER) -> None:
        """Count numbers that will be held.

        Parameters
        ----------
        what : str
            Whose numbers they are, for the message.
        count : int
            How many.
        width : int
            Bytes of each in the file; a narrower number becomes a float64.

        Raises
        ------
        TooLarge
            Where they do not fit beside what was taken before.
        """
        wanted = count * max(width, NUMBER)
        if wanted > self.left:
            most = f"at most {_size(self.most)} of a file are held"
            raise TooLarge(f"{what} takes too much memory: {count} numbers are {_size(wanted)}; {most}")
        self.left -= wanted


def _size(count: int) -> str:
    return f"{count / 2**20:.0f} MB" if count >= 2**20 else f"{count} bytes"
