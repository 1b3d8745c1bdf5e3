"""The numbers that a rotor keeps of its shaft: masses and inertias, bearings as they were given."""

import numpy as np
import pytest
from scipy.integrate import quad

import rsc
from rsc.machine.shaft.parts import Material, Section
from rsc.show.words.machine import machine_lines, machine_tables
from rsc.show.words.units import shown_in
from shaft_scenes import text

BEARINGS = '[{name = "left", at = 0.02, stiffness = [5e7, 1e6, -2e6, 4e7], damping = 1e4}, {at = 0.48, table = "bearing.csv"}]'
TABLE = "speed [rpm], k_yy [MN/m], k_zz [MN/m], c_yy [kN s/m], c_zz [kN s/m]\n1000,50,40,10,8\n4000,30,20,5,4\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shaft")
    (folder / "bearing.csv").write_text(TABLE)
    (folder / "scene.toml").write_text(text(bearings=BEARINGS))
    return rsc.load_scene(folder / "scene.toml")


def test_sums_are_those_of_the_elements(made):
    """A rigid motion of the full model: displacement 1 gives the mass, a tilt about the left end first moment and inertia."""
    model, parts = made.reductions[0].model, made.rotor.parts
    place = np.array([model.position[node] for node in model.node])
    shift, tilt = (model.kind == "displacement").astype(float), np.where(model.kind == "displacement", place, 1.0)
    mass, first, second = (float(a @ (model.mass @ b)) for a, b in ((shift, shift), (shift, tilt), (tilt, tilt)))
    polar = float(tilt @ (model.gyroscopic @ tilt))
    assert sum(part.mass for part in parts) == pytest.approx(mass, rel=1e-9)
    assert sum(part.mass * part.place for part in parts) == pytest.approx(first, rel=1e-6)
    assert sum(part.polar_inertia for part in parts) == pytest.approx(polar, rel=1e-3)
    about_end = sum(part.diametral_inertia + part.mass * part.place**2 for part in parts)
    assert about_end == pytest.approx(second, rel=1e-3)
    told = dict(machine_lines(made))
    assert f"mass {mass:.4g} kg" in told["rotor"] and "length 500 mm" in told["rotor"]
    assert told["centre of gravity"] == f"{1e3 * first / mass:.4g} mm from the left end"


@pytest.mark.parametrize("outer", [(0.06, 0.06), (0.06, 0.04), (0.03, 0.08)])
def test_a_hollow_cone_has_the_integrals_over_its_slices(outer):
    inner, length, density = (0.02, 0.025), 0.13, 7850.0
    section = Section(length, outer, inner, Material(density, 2e11, 0.3))

    def over(f):
        def slices(s):
            d, b = (left + (right - left) * s / length for left, right in (outer, inner))
            return density * f(s, np.pi / 4.0 * (d**2 - b**2), np.pi / 32.0 * (d**4 - b**4))
        return quad(slices, 0.0, length, epsabs=0.0, epsrel=1e-12)[0]

    mass = over(lambda s, area, polar: area)
    centre = over(lambda s, area, polar: s * area) / mass
    assert section.mass == pytest.approx(mass) and section.centre == pytest.approx(centre)
    polar = over(lambda s, area, polar: polar)
    assert section.inertias == pytest.approx((polar, over(lambda s, area, polar: 0.5 * polar + (s - centre) ** 2 * area)))


def test_bearings_are_those_of_the_scene_also_in_a_result_and_in_the_mirror(made):
    rows = made.rotor.bearing_rows
    assert [(row.name, row.place) for row in rows] == [("left", 0.02), ("", 0.48), ("", 0.48)]
    assert rows[0].speed == 0.0 and rows[0].coefficients == (5e7, 1e6, -2e6, 4e7, 1e4, 0.0, 0.0, 1e4)
    assert rows[2].speed == pytest.approx(4000.0 / 60.0) and rows[2].coefficients[:4] == pytest.approx((3e7, 0.0, 0.0, 2e7))
    assert rsc.Scene.from_toml(made.to_toml()) == made
    other = made.mirrored().rotor.bearing_rows
    assert other[0].coefficients == (5e7, -1e6, 2e6, 4e7, 1e4, 0.0, 0.0, 1e4) and other[2].speed == -rows[2].speed
    assert made.mirrored().mirrored() == made


def test_the_tables_have_every_part_in_the_units_that_are_shown(made):
    tables = {title: (header, rows) for title, header, rows in machine_tables(made)}
    assert list(tables) == ["Sections", "Disks", "Bearings", "Contacts"]
    rows = tables["Sections"][1]
    assert [row[2:6] for row in rows] == [("0", "120", "40", "-"), ("120", "420", "60", "20"), ("420", "500", "60 .. 40", "-")]
    assert tables["Disks"][1][0][:3] == ("impeller", "270", "12")
    assert tables["Bearings"][1][0][:5] == ("left", "20", "all", "5e+07", "1e+06")
    assert tables["Contacts"][1][0][1:4] == ("330", "60", "0.2")
    with shown_in("us"):
        assert "in from the left end" in dict(machine_lines(made))["centre of gravity"]
