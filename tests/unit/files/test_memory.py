"""The memory that the numbers of a file may take: counted as what they become, before anything is read."""

import pytest

from rsc.files.memory import Memory, TooLarge


def test_numbers_are_counted_as_the_float64_that_they_become():
    memory = Memory(1000)
    memory.take("X", 100, width=1)
    assert memory.left == 200
    memory.take("Y", 12, width=16)  # complex ones stay what they are
    assert memory.left == 8
    with pytest.raises(TooLarge, match="Z takes too much memory: 2 numbers are 16 bytes; at most 1000 bytes of a file are held"):
        memory.take("Z", 2, width=2)
    assert memory.left == 8
