"""NLRGAP of Nastran decks read as contacts: three forms of fields, tables, units, what is refused, and the scene that follows."""

import pytest

import rsc
from fe_bodies import rotor
from matrix_writers import DECK, written_fe
from rsc.cli import main
from rsc.errors import DataError
from rsc.machine.imports.gaps import RadialGap, gaps_at, read_gaps

SEAL = RadialGap(11, 40, "z", 2.5e7, 2e-4, 0.15, 0.025)
FREE = """\
NLRGAP,21,11,40,XY,3,10,6,0.025
TABLED1,3,LINEAR,LINEAR
,0.0,2.5e7,SKIP,SKIP,1.0,2.5E+7,ENDT
TABLED1,10
+,0.,2.-4,1.,2.-4
+,ENDT
TABLED1,6
+,0.,.15,1.,.15,ENDT
"""
WIDE = """\
NLRGAP* 21              11              40              XY
*       3               10              6               .025
TABLED1*3
*
*       0.0             2.5D+7          1.0             2.5D+7
*       ENDT
TABLED1 10
        0.0     2.0E-4  1.0     2.0E-4  ENDT
TABLED1 6
        0.0     .15     1.0     .15     ENDT
"""


def deck(folder, text):
    path = folder / "gap.bdf"
    path.write_text(text)
    return path


@pytest.mark.parametrize("text", [DECK, FREE, WIDE], ids=["small", "free", "wide"])
def test_every_form_of_fields_says_the_same(text, tmp_path):
    assert read_gaps(deck(tmp_path, text)) == [SEAL]


def test_a_force_over_the_penetration_has_its_slope_as_stiffness(tmp_path):
    text = FREE.replace("XY,3,", "XY,-3,").replace(",0.0,2.5e7,SKIP,SKIP,1.0,2.5E+7", ",-1.0,0.0,0.0,0.0,1e-4,2500.0,2e-4,5000.0")
    assert read_gaps(deck(tmp_path, text)) == [SEAL]
    bent = text.replace("5000.0", "6000.0")
    with pytest.raises(DataError, match="TABLED1 3 is not proportional to the penetration; rsc needs a single number"):
        read_gaps(deck(tmp_path, bent))
    with pytest.raises(DataError, match="TABLED1 3 does not start at penetration 0"):
        read_gaps(deck(tmp_path, text.replace("-1.0,0.0", "-1.0,1.0")))


def test_millimetres_and_a_clockwise_shaft(tmp_path):
    """N/mm and mm; a negative coefficient belongs to a shaft that turns clockwise."""
    text = FREE.replace("2.5e7", "2.5e4").replace("2.5E+7", "2.5E+4").replace("2.-4", "0.2").replace("0.025", "25.")
    (gap,) = read_gaps(deck(tmp_path, text.replace(".15", "-.15")), "mm")
    numbers = [(one.stiffness, one.gap, one.friction, one.radius) for one in (gap, SEAL)]
    assert numbers[0] == pytest.approx(numbers[1], rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        (",0.,2.-4,1.,2.-4", ",0.,2.-4,1.,3.-4", "the clearance of TABLED1 10 varies with time"),
        (",0.,.15,1.,.15", ",0.,.15,1.,.2", "the friction of TABLED1 6 varies with time"),
        ("1.0,2.5E+7", "1.0,2.6E+7", "the stiffness of TABLED1 3 varies with time"),
        ("TABLED1,6", "TABLED1,7", "it has no TABLED1 6"),
        ("LINEAR,LINEAR", "LINEAR,LOG", "TABLED1 3 has a logarithmic axis"),
        (",XY,", ",QR,", "the plane 'QR' of an NLRGAP is not XY, YZ or ZX"),
        ("NLRGAP", "NLRGAQ", "it has no NLRGAP"),
        ("2.-4", "-2.-4", "no positive stiffness and clearance"),
        ("0.025", "much", "'much' found where a number is expected"),
        (",11,", ",1x,", "'1x' found where an integer is expected"),
        (",0.,2.-4,1.,2.-4", "", "the clearance of TABLED1 10"),
    ],
)
def test_what_rsc_has_not_is_refused_in_a_line(old, new, wanted, tmp_path):
    assert old in FREE
    with pytest.raises(DataError, match=wanted) as refused:
        read_gaps(deck(tmp_path, FREE.replace(old, new)))
    assert str(refused.value).count("\n") == 0


def test_of_several_one_is_chosen_by_its_shaft_and_the_plane_must_fit(tmp_path):
    path = deck(tmp_path, FREE + "NLRGAP,21,12,40,XY,3,10,6,0.03\n")
    own, others = gaps_at(path, "12", "z")
    assert [gap.radius for gap in own] == [0.03] and others == [SEAL]
    assert gaps_at(path, None, "z") == (read_gaps(path), [])
    with pytest.raises(DataError, match="no NLRGAP at node 13"):
        gaps_at(path, "13", "z")
    with pytest.raises(DataError, match="that of a rotor about z, not about x"):
        gaps_at(path, "11", "x")
    with pytest.raises(DataError, match="no such file"):
        read_gaps(tmp_path / "none.bdf")


def test_the_scene_of_an_import_has_the_contact_of_the_deck(tmp_path, capsys):
    files, scene = written_fe(tmp_path, rotor()), tmp_path / "shaft.toml"
    command = ["import", "fe", *files, "-o", str(scene)]
    assert main(command) == 2
    assert "--contact" in capsys.readouterr().err
    assert main([*command, "--gap", str(deck(tmp_path, DECK.replace("      11", "       3")))]) == 0
    contact = rsc.load_scene(scene).contact
    assert (contact.gap, contact.friction, contact.stiffness, contact.diameter) == (2e-4, 0.15, 2.5e7, 0.05)
    assert "of the NLRGAP at node 3" in scene.read_text()
    assert main(["predict", str(scene), "--speed", "30"]) == 0


def several(*nodes):
    """Bulk data with the tables of FREE and a gap for each (inner, outer, plane)."""
    cards = "".join(f"NLRGAP,21,{inner},{outer},{plane},3,10,6,0.03\n" for inner, outer, plane in nodes)
    return FREE.replace("NLRGAP,21,11,40,XY,3,10,6,0.025\n", cards)


def test_of_several_gaps_one_is_the_contact_and_the_others_are_watched(tmp_path, capsys):
    files, scene = written_fe(tmp_path, rotor()), tmp_path / "shaft.toml"
    path = deck(tmp_path, several((3, 40, "XY"), (5, 41, "XY"), (6, 42, "XY"), (6, 43, "XY")))
    assert main(["import", "fe", *files, "-o", str(scene), "--gap", str(path), "--contact", "3"]) == 0
    read = rsc.load_scene(scene)
    assert (read.contact.gap, read.contact.diameter) == (2e-4, 0.06)
    watched = [(place.name, place.rotor_node, place.gap) for place in read.clearances]
    assert watched == [("node_5", "5", 2e-4), ("node_6_42", "6", 2e-4), ("node_6_43", "6", 2e-4)]
    assert main(["predict", str(scene), "--speed", "30"]) == 0


def test_without_a_node_every_gap_is_a_contact(tmp_path, capsys):
    files, scene = written_fe(tmp_path, rotor()), tmp_path / "shaft.toml"
    path = deck(tmp_path, several((3, 40, "XY"), (5, 41, "XY"), (5, 42, "XY")))
    assert main(["import", "fe", *files, "-o", str(scene), "--gap", str(path)]) == 0
    read = rsc.load_scene(scene)
    told = [(contact.name, contact.rotor_coordinate, contact.gap, contact.diameter) for contact in read.contacts]
    assert told == [("node_3", 0, 2e-4, 0.06), ("node_5_41", 1, 2e-4, 0.06), ("node_5_42", 1, 2e-4, 0.06)]
    assert "contact at [3, 5]" in read.rotor.origin and not read.clearances
    assert main(["predict", str(scene), "--speed", "30"]) == 0


def test_more_gaps_than_contacts_are_refused_in_a_line_and_leave_no_file(tmp_path, capsys):
    files, scene = written_fe(tmp_path, rotor()), tmp_path / "shaft.toml"
    path = deck(tmp_path, several(*((5, 100 + i, "XY") for i in range(9))))
    assert main(["import", "fe", *files, "-o", str(scene), "--gap", str(path)]) == 2
    told = capsys.readouterr().err
    assert "one to 8 tables" in told and told.count("\n") == 1 and not scene.exists()


@pytest.mark.parametrize(
    ("nodes", "wanted"),
    [
        (((3, 40, "XY"), (5, 41, "XY"), (5, 41, "XY")), "it has two NLRGAP between the nodes 5 and 41"),
        (((3, 40, "XY"), (5, 41, "YZ")), "the plane of its NLRGAP is that of a rotor about x, not about z"),
        (((3, 40, "XY"), (3, 41, "XY")), "2 NLRGAP at node 3"),
        (((3, 40, "XY"), (77, 41, "XY")), "no node 77"),
        (((3, 40, "XY"), *((5, 100 + i, "XY") for i in range(17))), "at most 16"),
    ],
)
def test_gaps_that_cannot_be_watched_are_refused_in_a_line_and_leave_no_file(nodes, wanted, tmp_path, capsys):
    files, scene = written_fe(tmp_path, rotor()), tmp_path / "shaft.toml"
    path = deck(tmp_path, several(*nodes))
    assert main(["import", "fe", *files, "-o", str(scene), "--gap", str(path), "--contact", "3"]) in (2, 4)
    told = capsys.readouterr().err
    assert wanted in told and told.count("\n") == 1
    assert not scene.exists() and not scene.with_suffix(".npz").exists()
