"""The coordinate table: what it accepts, and the line of every refusal."""

import numpy as np
import pytest

from rsc.errors import DataError
from rsc.machine.imports.coordinates import from_labels, read_table


def write(folder, text):
    (folder / "table.csv").write_text(text)
    return folder / "table.csv"


def test_reads_nodes_directions_names_and_positions(tmp_path):
    text = "Node;direction;name;position\n7;x;disc;0.25\n7;Y;;\n7;rx;disc;\n\n7;ry;;\n9;z;;0.5\n9;rz;;\n"
    table = read_table(write(tmp_path, text))
    assert table.node.tolist() == [7, 7, 7, 7, 9, 9] and table.direction.tolist() == ["x", "y", "rx", "ry", "other", "other"]
    assert table.names == {"disc": 7} and table.position == {7: 0.25, 9: 0.5}


REFUSALS = {
    "": "empty",
    "node,direction\n": "without rows",
    "node,dir\n1,x\n": "column 'dir': must be one of node, direction, name, position",
    "node\n1\n": "must have the columns",
    "node,direction\n1,w\n": "line 2: direction 'w'",
    "node,direction\none,x\n": "line 2: node 'one': must be a whole number",
    "node,direction\n1e3,x\n": "must be a whole number",
    "node,direction,position\n1,x,nan\n": "position 'nan': must be a number",
    "node,direction\n1,x,3\n": "line 2: has 3 values for 2 columns",
    "node,direction\n1,x\n1,x\n": "direction x of node 1 occurs twice",
    "node,direction,name\n1,x,disc\n2,x,disc\n": "is used for nodes 1 and 2",
    "node,direction,position\n1,x,1\n1,y,2\n": "positions 1 and 2",
    'node,direction\n"1,x\n': "no text of comma separated values",
}


@pytest.mark.parametrize("text", REFUSALS)
def test_refusals_are_one_line(text, tmp_path):
    with pytest.raises(DataError) as caught:
        read_table(write(tmp_path, text))
    assert REFUSALS[text] in str(caught.value) and "\n" not in str(caught.value)


def test_binary_rubbish_is_refused(tmp_path):
    (tmp_path / "table.csv").write_bytes(bytes(range(256)))
    with pytest.raises(DataError, match="not a text"):
        read_table(tmp_path / "table.csv")


def test_labels_turn_with_the_axis_and_stay_right_handed():
    labels = np.array([(1, k) for k in range(8)])
    across = {}
    for axis in "zxy":
        table = from_labels(labels, axis)
        across[axis] = {direction: int(np.flatnonzero(table.direction == direction)[0]) for direction in ("x", "y", "rx", "ry")}
        basis = np.eye(3)
        i, j, along = across[axis]["x"] - 1, across[axis]["y"] - 1, "xyz".index(axis)
        assert np.array_equal(np.cross(basis[i], basis[j]), basis[along])
        assert (across[axis]["rx"], across[axis]["ry"]) == (i + 4, j + 4)
    with pytest.raises(DataError, match="must be x, y or z"):
        from_labels(labels, "w")
