"""Scenes with a shaft by its stations: places, bearings over the speed, unbalance, contacts, clearances, what is refused."""

import numpy as np
import pytest

import rsc
from rsc.machine.model.modes import slowest_modes
from rsc.scene.bodies.bearing_table import read_bearing_table
from rsc.system.assemble import assemble
from shaft_scenes import text


def scene(**others):
    return rsc.Scene.from_toml(text(**others))


@pytest.fixture(scope="module")
def plain():
    return scene(rotor='gravity = 9.81\nunbalance = [{at = "impeller", amount = "120 g mm", angle = "90 deg"}]')


def test_a_shaft_becomes_a_reduced_machine(plain):
    model = plain.reductions[0].model
    assert plain.rotor.model == "reduced" and "elements" in plain.rotor.origin and "change by at most" in plain.rotor.origin
    assert plain.contact.diameter == 0.06  # that of the shaft there
    full, own = (np.linalg.eigvals(np.linalg.solve(part.mass, part.stiffness)) for part in (model, assemble(plain).rotor))
    assert np.sort(own.real)[0] == pytest.approx(np.sort(full.real)[0], rel=1e-3)  # it lies above the band
    assert abs(np.sum(np.array(assemble(plain).rotor.load))) > 0.0
    assert rsc.Scene.from_toml(plain.to_toml()) == plain


def test_its_weight_and_deflection_are_those_of_statics(plain):
    """Both bearings together carry the weight, whose figure is worked out by hand."""
    model, shaft = plain.reductions[0].model, 7850.0 * np.pi / 4.0
    weight = shaft * (0.12 * 0.04**2 + 0.3 * (0.06**2 - 0.02**2) + 0.08 / 3.0 * (0.06**2 + 0.06 * 0.04 + 0.04**2))
    disk = shaft * 0.03 * (0.2**2 - 0.06**2)  # its bore is the shaft
    total = (weight + 12.0 + disk) * 9.81
    moving = (model.kind == "displacement").astype(float)
    down = np.linalg.solve(model.stiffness, 9.81 * model.mass @ moving)
    other = next(node for node, place in model.position.items() if abs(place - 0.48) < 1e-9)
    assert 5e7 * (model.row_at("drive end") + model.row_at(other)) @ down == pytest.approx(total, rel=1e-9)


PLACES = ['"330 mm"', "0.33", '{section = "seat", left = "210 mm"}', '{section = "seat", right = "90 mm"}']


@pytest.mark.parametrize("place", PLACES)
def test_a_place_may_be_given_from_either_end(place):
    made = scene(at=place)
    node = made.reductions[0].model.names
    assert any(made.reductions[0].model.position[n] == pytest.approx(0.33) for n in node.values())
    assert made.rotor.stiffness[0][0] == pytest.approx(scene().rotor.stiffness[0][0], rel=1e-9)


def test_a_contact_on_a_disk_has_its_diameter_unless_it_names_one():
    assert scene(at='"400 mm"').contact.diameter == 0.2
    own = text(at='"400 mm"').replace("friction = 0.15", 'friction = 0.15\ndiameter = "150 mm"')
    assert rsc.Scene.from_toml(own).contact.diameter == 0.15


def test_a_grade_is_shared_by_mass():
    """G 6.3 at 50 Hz of the whole rotor, in two planes: their sum is mass times eccentricity."""
    made = scene(rotor='unbalance = "G 6.3"')
    model = made.reductions[0].model
    moving = (model.kind == "displacement").astype(float)
    full = made.reductions[0].full.unbalance.sum(axis=1)
    assert abs(moving @ full) == pytest.approx(moving @ model.mass @ moving * 6.3e-3 / (100.0 * np.pi), rel=1e-9)
    assert np.count_nonzero(full) == 2
    one = scene(rotor='unbalance = [{at = 0.2, amount = "G 6.3"}]')
    assert abs(one.reductions[0].full.unbalance).sum() == pytest.approx(abs(full).sum(), rel=1e-9)


def test_a_grade_at_a_speed_is_that_of_no_other():
    both = [scene(rotor=f'unbalance = "{grade}"').reductions[0].full.unbalance for grade in ("G 6.3", "G 6.3 at 12000 rpm")]
    assert abs(both[0]).sum() == pytest.approx(4.0 * abs(both[1]).sum(), rel=1e-9)


def test_a_table_in_x_and_y_is_that_in_y_and_z(tmp_path):
    """k_yy is the second direction of one and the first of the other."""
    rows = "1000,50,7,-9,40,10,1,2,8000\n4000,30,7,-9,20,5,1,2,4000\n"
    read = []
    for first, second in ("xy", "yz"):
        pairs = [first + first, first + second, second + first, second + second]
        head = ["speed [rpm]", *(f"k_{pair} [MN/m]" for pair in pairs), *(f"c_{pair} [N s/m]" for pair in pairs)]
        (tmp_path / "bearing.csv").write_text(",".join(head) + "\n" + rows)
        read.append(read_bearing_table(tmp_path / "bearing.csv")[1])
    assert (read[0] == read[1]).all() and read[0][0].tolist() == [50e6, 7e6, -9e6, 40e6, 10.0, 1.0, 2.0, 8000.0]


def test_coefficients_of_a_table_follow_the_speed(tmp_path):
    head = "speed [rpm], kxx [MN/m], k_yy [MN/m], c_xx [kN*s/m], c_yy [N.s/m]"
    (tmp_path / "bearing.csv").write_text(f"{head}\n1000,50,40,10,8000\n4000,30,20,5,4000\n")
    bearings = '[{at = 0.02, stiffness = 5e7, damping = 1e4}, {at = 0.48, table = "bearing.csv"}]'
    (tmp_path / "scene.toml").write_text(text(bearings=bearings))
    made = rsc.load_scene(tmp_path / "scene.toml")
    model = made.reductions[0].model
    assert made.rotor.knot_speeds is not None and not model.isotropic
    for rpm, k_xx, k_yy in ((1000.0, 5e7, 4e7), (2500.0, 4e7, 3e7), (4000.0, 3e7, 2e7)):
        own = model.at_speed(rpm / 60.0)
        i = int(np.argmin(np.abs(np.array([model.position[n] for n in model.node]) - 0.48)))
        assert own.anisotropic_stiffness[i, i] == pytest.approx(0.5 * (k_xx - k_yy), rel=1e-9)


def test_clearances_loads_and_observers_have_places():
    more = '[[clearance]]\nname = "labyrinth"\nat = "impeller"\ngap = "0.3 mm"'
    made = scene(more=more, rotor='load = [{at = "270 mm", force = [0.0, "-100 N"]}]\nobservers = ["450 mm"]')
    assert made.rotor.observers == ("450 mm", "impeller") and made.clearances[0].rotor_node == "impeller"
    assert rsc.Scene.from_toml(made.to_toml()) == made


def test_several_contacts_along_one_shaft():
    own = text().replace("[contact]", '[[contact]]\nname = "seal"', 1)
    second = '[[contact]]\nname = "ring"\nat = "200 mm"\ngap = "0.3 mm"\nfriction = 0.1\nstiffness = 1e8\n[drive]'
    made = rsc.Scene.from_toml(own.replace("[drive]", second, 1))
    assert [contact.diameter for contact in made.contacts] == [0.06, 0.06] and made.rotor.contact_masses is not None


def test_a_column_may_be_the_stator():
    """A tube that is clamped at its upper end: the static deflection of its lower end is L^3/3EI + L/kGA + that of the clamp."""
    column = """[stator]
model = "shaft"
sections = [{length = "1 m", diameter = "200 mm", bore = "180 mm"}]
bearings = [{at = 0, stiffness = 1e9, tilt_stiffness = 1e8, damping = 1e4, tilt_damping = 1e3}]
"""
    made = rsc.Scene.from_toml(text(stator=column).replace('gap = "0.2 mm"', 'gap = "0.2 mm"\nstator_at = "1 m"'))
    inertia, area, share = np.pi / 64.0 * (0.2**4 - 0.18**4), np.pi / 4.0 * (0.2**2 - 0.18**2), (1.0 + 0.81) ** 2
    kappa = 6.0 * 1.3 * share / ((7.0 + 1.8) * share + (20.0 + 3.6) * 0.81)
    bent = 1.0 / (3.0 * 210e9 * inertia) + 1.0 / (kappa * 210e9 / 2.6 * area) + 1e-9 + 1e-8
    soft = np.linalg.inv(np.array(made.stator.stiffness))[0, 0]
    assert made.stator.model == "reduced" and soft == pytest.approx(bent, rel=1e-5)


def test_a_run_of_a_shaft_and_its_result(tmp_path, plain):
    result = rsc.simulate(plain.with_values({"drive.duration": 0.01}))
    assert result.status == "finished" and np.isfinite(result.contact_rotor()).all()
    assert slowest_modes(plain.reductions[0].model, 50.0, 2)[0].growth_rate < 0.0


REFUSED = [
    ({"sections": '[{length = 0, diameter = "40 mm"}]'}, r"rotor\.sections, section 1, length = 0: must be a number > 0 and"),
    ({"sections": '[{length = "0 mm", diameter = "40 mm"}]'}, r"sections, section 1, length = '0 mm': must be a number > 0"),
    (
        {"sections": '[{length = 0.5, diameter = "40 mm", bore = "41 mm"}]'},
        r"rotor\.sections, section 1, bore = '41 mm': must be less than the diameter at its left end, 40 mm",
    ),
    (
        {"sections": '[{length = 0.5, diameter = ["40 mm", "20 mm"], bore = "30 mm"}]'},
        r"bore = '30 mm': must be less than the diameter at its right end, 20 mm",
    ),
    ({"sections": "[]"}, r"rotor\.sections = .*: must be a list of tables"),
    ({"sections": "[{length = 0.5}]"}, r"rotor\.sections, section 1, diameter = \(missing\): must be given"),
    ({"sections": "[{lenght = 0.5, diameter = 0.1}]"}, r"rotor\.sections, section 1, lenght = 0\.5: .*did you mean"),
    ({"at": '"600 mm"'}, r"contact\.at = '600 mm': must be on the shaft, 0 to 500 mm from its left end"),
    ({"at": '"-1 mm"'}, r"contact\.at = '-1 mm': must be on the shaft"),
    ({"at": '"propeller"'}, r"contact\.at = 'propeller': must be a position: .*\(names: impeller, drive end\)"),
    ({"at": '{section = "seat", left = "301 mm"}'}, r"contact\.at\.left = '301 mm': must be a number >= 0 and <= 0\.3 m"),
    ({"at": '{section = "neck", left = 0.1}'}, r"contact\.at\.section = 'neck': must be the name of a section \(names: seat\)"),
    ({"disks": '[{at = "501 mm", diameter = 0.2, width = 0.03}]'}, r"rotor\.disks, disk 1, at = '501 mm': must be on the shaft"),
    (
        {"disks": "[{at = 0.2, diameter = 0.2, width = 0.1}, {at = 0.29, diameter = 0.2, width = 0.1}]"},
        r"rotor\.disks, disk 2, at = 0\.29: must be at least 100 mm from the disk at 200 mm: they overlap",
    ),
    (
        {"disks": "[{at = 0.2, diameter = 0.05, width = 0.1}]"},
        r"rotor\.disks, disk 1, diameter = 0\.05: must be more than that of the shaft there, 60 mm",
    ),
    ({"disks": "[{at = 0.2, mass = 3}]"}, r"rotor\.disks, disk 1, polar_inertia = \(missing\): must be given: mass"),
    ({"disks": "[{at = 0.2}]"}, r"rotor\.disks, disk 1, mass = \(missing\): must be given"),
    (
        {"disks": "[{at = 0.2, mass = 3, polar_inertia = 0.1, diametral_inertia = 0.04}]"},
        r"polar_inertia = 0\.1: must be at most twice",
    ),
    ({"bearings": "[]"}, r"rotor\.bearings = .*: must be bearings that support the rotor \(.*1 rigid-body"),
    (
        {"bearings": "[{at = 0.33, stiffness = 1e7}]"},
        r"rotor\.bearings = .*: must be bearings that support the rotor \(.*places must hold the rotor: 1 rigid-body",
    ),
    (
        {"bearings": "[{at = 0.1}, {at = 0.4, stiffness = 1e7}]"},
        r"rotor\.bearings, bearing 1, stiffness = \(missing\): must be given, or table instead",
    ),
    (
        {"bearings": '[{at = 0.1, stiffness = "5 mm"}, {at = 0.4, stiffness = 1e7}]'},
        r"rotor\.bearings, bearing 1, stiffness = '5 mm': must be a number in N/m",
    ),
    ({"rotor": 'material = "wood"'}, r"rotor\.material = 'wood': must be one of \"steel\""),
    (
        {"rotor": 'material = {density = 7850, youngs_modulus = "210 GPa", poisson = 0.7}'},
        r"rotor\.material\.poisson = 0\.7: must be",
    ),
    ({"rotor": "unbalance = [{at = 0.9, amount = 1e-5}]"}, r"rotor\.unbalance, unbalance 1, at = 0\.9: must be on the shaft"),
    ({"rotor": 'unbalance = "G6,3"'}, r"rotor\.unbalance = 'G6,3': must be a grade"),
    ({"rotor": "contact = 3"}, r"rotor\.contact = 3: must be a key"),
    # of units
    ({"sections": "[{length = 0.5, diameter = 40}]"}, r"section 1, diameter = 40: .* \(a number without a unit is in m\)"),
    ({"at": "330"}, r"contact\.at = 330: must be on the shaft, 0 to 500 mm .* \(a number without a unit is in m\)"),
    ({"rotor": "material = {density = 7.85, youngs_modulus = 2.1e11}"}, r"material\.density = 7\.85: must be 0 .*7850 kg/m\^3"),
    (
        {"rotor": 'material = {density = 7850, youngs_modulus = "206 MPa"}'},
        r"rotor\.material\.youngs_modulus = '206 MPa': must be at least 1 GPa for a material of 7850 kg/m\^3",
    ),
    (
        {"disks": '[{name = "wheel", at = 0.2, mass = "12 g", polar_inertia = 0.12, diametral_inertia = 0.07}]'},
        r"rotor\.disks, disk 1 \(wheel\), mass = '12 g': must be a mass whose radius of gyration .*500 mm \(3162\.28 mm",
    ),
    ({"drive": "speed = 9000"}, r"drive\.speed = 9000\.0: must be .*60 mm.*500 m/s.*\(at 9000 Hz .*9000 rpm"),
    # of places and surfaces
    ({"contact": 'diameter = "20 mm"'}, r"contact\.diameter = '20 mm': must be at least that of the shaft at 330 mm, 60 mm"),
    ({"contact": "gap = 0.2"}, r"contact\.gap = 0\.2: must be less than the radius of the rotor there, 30 mm \(a number without"),
    ({"sections": '[{name = "seat", length = 0.5, diameter = 0.06, id = 0.02}]'}, r"section 1 \(seat\), id = .*called bore"),
    ({"sections": '[{length = 0.2, diameter = 0.05}, {name = "seat", length = 0.3, diameter = 0.06, bore = "7 cm"}]'},
     r"rotor\.sections, section 2 \(seat\), bore = '7 cm': must be less than the diameter at its left end, 60 mm"),
]


@pytest.mark.parametrize("changes, message", REFUSED)
def test_what_cannot_be_is_refused_with_station_and_value(changes, message):
    own = dict(changes)
    contact, drive = own.pop("contact", None), own.pop("drive", None)
    content = text(**own)
    if contact is not None:  # the table has a gap already
        content = content.replace('gap = "0.2 mm"', contact if "gap" in contact else f'gap = "0.2 mm"\n{contact}')
    content = content.replace('speed = "3000 rpm"', drive or 'speed = "3000 rpm"')
    with pytest.raises(rsc.SceneError, match=message) as caught:
        rsc.Scene.from_toml(content)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "table, message",
    [
        ("speed,k_xx,k_yy\n1,2,3\n2,3,4\n", r"column 'speed' must have its unit"),
        ("speed [rpm], k_xx [N/m], k_yy\n1,2,3\n2,3,4\n", r"column 'k_yy' must have its unit"),
        ("speed [rpm], k_xx [mm], k_yy [N/m]\n1,2,3\n2,3,4\n", r"column 'k_xx \[mm\]': its unit must be a number in N/m"),
        ("speed [rpm], k_xx [N/m], k_zz [N/m]\n1,2,3\n2,3,4\n", r"has columns of x and of z"),
        ("speed [rpm], k_xx [N/m]\n1,2\n2,3\n", r"must have the columns speed, k_yy and k_zz"),
        ("speed [rpm], k_xx [N/m], k_yy [N/m]\n2,2,3\n1,3,4\n", r"line 3: the speed must exceed"),
        ("speed [rpm], k_xx [N/m], k_yy [N/m]\n2,2,3\n", r"has 1 rows of coefficients"),
        ("speed [rpm], k_xx [N/m], k_yy [N/m]\n2,x,3\n3,3,4\n", r"line 2: k_xx"),
        ("", "an empty table"),
    ],
)
def test_tables_of_bearings_are_refused_without_units_or_order(table, message, tmp_path):
    (tmp_path / "b.csv").write_text(table)
    (tmp_path / "scene.toml").write_text(text(bearings='[{at = 0.02, stiffness = 5e7}, {at = 0.48, table = "b.csv"}]'))
    with pytest.raises(rsc.SceneError, match=r"rotor\.bearings, bearing 2, table = 'b\.csv': must be a CSV file") as caught:
        rsc.load_scene(tmp_path / "scene.toml")
    with pytest.raises(rsc.SceneError, match=message):
        raise caught.value


def test_a_contact_at_a_shoulder_may_be_at_the_smaller_diameter():
    sections = "[{length = 0.2, diameter = 0.05}, {length = 0.3, diameter = 0.06}]"
    own = text(sections=sections, at='"200 mm"').replace('gap = "0.2 mm"', 'gap = "0.2 mm"\ndiameter = "50 mm"')
    assert rsc.Scene.from_toml(own).contact.diameter == 0.05


def test_a_place_along_no_shaft_is_refused():
    own = text().replace('model = "shaft"', 'model = "laval"').replace("[reduction]\nband = [-100.0, 100.0]", "")
    lines = [line for line in own.splitlines()]
    start, end = lines.index("sections = ["), lines.index("[contact]")
    simple = "\n".join([*lines[:start], "mass = 1.0", "frequency = 30.0", *lines[end:]])
    told = r'contact\.at = \'330 mm\': must be left out \(the rotor does not have model "shaft"'
    with pytest.raises(rsc.SceneError, match=told):
        rsc.Scene.from_toml(simple)
    without = text().replace('at = "330 mm"', "")
    with pytest.raises(rsc.SceneError, match=r"contact\.at = \(missing\): must be given: the position along the shaft"):
        rsc.Scene.from_toml(without)
