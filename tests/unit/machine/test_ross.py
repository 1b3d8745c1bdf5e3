"""ROSS's rotors from the files it wrote (data/reference/machines) and from an object with its methods; no test needs ROSS."""

import shutil
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.io
from threadpoolctl import threadpool_limits

from rsc.errors import DataError
from rsc.machine import from_ross
from rsc.machine.formats import read_matrices
from rsc.machine.imports.ross import read_ross

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
FOLDER = ROOT / "data" / "reference" / "machines"
ROSS = tomllib.loads((FOLDER / "ross_frequencies.toml").read_text())
LATERAL = {"ross_rotor": 14, "ross_coaxrotor": 38, "ross_rub_rotor": 68, "ross_compressor": 112}


def frequencies(mass, damping, stiffness):
    """|roots| of M q'' + C q' + K q = 0, rad/s."""
    n = len(mass)
    lower = np.linalg.solve(mass, np.hstack([-stiffness, -damping]))
    return np.abs(np.linalg.eigvals(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])))


@pytest.mark.parametrize("name", ROSS)
def test_frequencies_are_those_of_ross_itself(name):
    """ROSS's modal analysis of the rotor: each of its lowest 40 frequencies is lateral, axial or torsional."""
    speed, wanted = ROSS[name]["speed"], np.array(ROSS[name]["frequencies"])
    model = read_ross(FOLDER / f"{name}.mat", speed)
    assert model.n == LATERAL[name] and model.speed == speed and len(wanted) == 40
    with threadpool_limits(1):
        lateral = frequencies(*model.with_conjugate(speed))
    raw = read_matrices(FOLDER / f"{name}.mat").matrices
    n_nodes = raw["nodes"].size
    rows = [6 * node + k for node in range(n_nodes) for k in (2, 5)] + list(range(6 * n_nodes + 2, len(raw["M"]), 3))
    mass, stiffness, damping, gyroscopic = (raw[key][np.ix_(rows, rows)] for key in "MKCG")
    both = np.concatenate([lateral, frequencies(mass, damping + 2.0 * np.pi * speed * gyroscopic, stiffness)])
    assert max(np.min(np.abs(both - wn)) / wn for wn in wanted) < 1e-8
    assert sum(np.min(np.abs(lateral - wn)) / wn < 1e-8 for wn in wanted) > 15


def test_what_each_rotor_holds():
    names = ("rub_rotor", "compressor", "coaxrotor", "rotor")
    rub, compressor, coax, simple = (read_ross(FOLDER / f"ross_{name}.mat") for name in names)
    assert coax.isotropic and coax.skew_stiffness is None and not simple.isotropic
    assert compressor.skew_stiffness is not None and not compressor.isotropic
    i = int(np.flatnonzero(rub.row_at(31))[0])  # bearing: kxx 9.5e5, kyy 1.09e8
    assert rub.anisotropic_stiffness[i, i] == pytest.approx((9.5e5 - 1.09e8) / 2.0)
    assert rub.position[33] == pytest.approx(0.914) and rub.speed is None
    assert np.flatnonzero(np.diag(rub.anisotropic_stiffness)).size == 2


class Rotor:
    """What `from_ross` asks of a ROSS rotor: matrices from a file, elements with diameters, tags."""

    def __init__(self, name):
        self.raw, self.calls = scipy.io.loadmat(FOLDER / f"{name}.mat"), []
        self.nodes_pos = self.raw["nodes"].ravel().tolist()
        outer = [0.05, 0.05, 0.06, 0.05, 0.05, 0.05]  # diameters at the right of the elements
        self.shaft_elements = [SimpleNamespace(n=n, odl=0.05, odr=right) for n, right in enumerate(outer)]
        self.disk_elements = [SimpleNamespace(n=2, tag="Disk 0")]
        self.bearing_elements = [SimpleNamespace(n=0, tag="Bearing 0"), SimpleNamespace(n=6, tag="Bearing 1")]

    def M(self, frequency=None, synchronous=False):
        self.calls.append(frequency)
        return self.raw["M"]

    def K(self, frequency):
        self.calls.append(frequency)
        return self.raw["K"]

    def C(self, frequency):
        self.calls.append(frequency)
        return self.raw["C"]

    def G(self):
        return self.raw["G"]


class LaterRotor(Rotor):
    """The same with matrices asked by frequency and speed."""

    def C(self, frequency, speed):
        self.calls += [frequency, speed]
        return self.raw["C"]


@pytest.mark.parametrize("kind", [Rotor, LaterRotor])
def test_the_live_object_gives_the_model_of_its_file_and_more(kind):
    rotor = kind("ross_rotor")
    live, filed = from_ross(rotor, speed=20.0), read_ross(FOLDER / "ross_rotor.mat", 20.0)
    for name in ("mass", "damping", "gyroscopic", "stiffness", "anisotropic_stiffness"):
        assert np.array_equal(getattr(live, name), getattr(filed, name))
    assert set(rotor.calls) == {2.0 * np.pi * 20.0}  # rad/s
    assert live.row_at("Disk 0").tolist() == live.row_at(2).tolist()
    assert live.diameter_at(3) == 0.06 and live.diameter_at("Bearing 0") == 0.05 and filed.diameter_at(3) is None


def test_several_speeds_are_knots_between_which_coefficients_are_linear():
    class Followed(Rotor):
        """Its left bearing grows with the speed, by 1 kN/m for each rad/s, crosswise too."""

        def K(self, frequency):
            stiffness = np.array(self.raw["K"])
            stiffness[:2, :2] += 1e3 * frequency * np.array([[1.0, 0.3], [-0.3, 1.0]])
            return stiffness

    rotor, Omega = Followed("ross_rotor"), 2.0 * np.pi * 30.0
    model = from_ross(rotor, speeds=[20.0, 60.0])
    own, plain = model.at_speed(30.0), from_ross(Rotor("ross_rotor"))
    assert own.stiffness[0, 0] == pytest.approx(plain.stiffness[0, 0] + 1e3 * Omega, rel=1e-12)
    assert own.skew_stiffness[0, 0] == pytest.approx(-0.3e3 * Omega, rel=1e-12)
    assert model.speed is None and "damping" not in model.knots.parts
    with pytest.raises(DataError, match="must be above the previous one, 60 Hz"):
        from_ross(rotor, speeds=[60.0, 20.0])
    with pytest.raises(DataError, match="need 2 to 100 speeds"):
        from_ross(rotor, speeds=[20.0])


class MagneticBearingElement(SimpleNamespace):
    """Named as ROSS's own: stiffness and damping by the frequency of a vibration, rad/s."""

    def K(self, frequency):
        return np.diag([2e3 * frequency, 2e3 * frequency, 0.0])

    def C(self, frequency):
        return np.diag([5.0 * frequency, 5.0 * frequency, 0.0])


class Levitated(Rotor):
    """The left bearing is magnetic, the right one has a table over the speed."""

    def __init__(self, name):
        super().__init__(name)
        self.bearing_elements[0] = MagneticBearingElement(n=0, n_link=None, tag="Levitation", frequency=np.array([1.0, 1e3]))
        self.bearing_elements[1].frequency = 2.0 * np.pi * np.array([10.0, 50.0])

    def K(self, frequency):
        stiffness = np.array(self.raw["K"])
        stiffness[:3, :3] += self.bearing_elements[0].K(frequency)
        stiffness[36:38, 36:38] += 1e3 * frequency * np.eye(2)
        return stiffness

    def C(self, frequency):
        damping = np.array(self.raw["C"])
        damping[:3, :3] += self.bearing_elements[0].C(frequency)
        return damping


def test_a_magnetic_bearing_is_taken_at_the_frequency_of_the_whirl_and_it_is_said():
    """Films and seals at the rotor speed, what a controller makes of a vibration at the size of the whirl's frequency."""
    rotor, plain, Omega, Psi = Levitated("ross_rotor"), from_ross(Rotor("ross_rotor")), 2.0 * np.pi * 20.0, 2.0 * np.pi * 70.0
    for model, vibration in ((from_ross(rotor, 20.0), Omega), (from_ross(rotor, 20.0, -70.0), Psi)):
        more = np.diag(model.stiffness - plain.stiffness)
        assert more[[0, -2]] == pytest.approx([2e3 * vibration, 1e3 * Omega], rel=1e-9)
        assert np.diag(model.damping - plain.damping)[0] == pytest.approx(5.0 * vibration, rel=1e-9)
    note = "magnetic bearings (Levitation) have their coefficients for a vibration at 70 Hz."
    assert note in from_ross(rotor, 20.0, -70.0).notes
    assert "at 20 Hz; for whirl at another frequency use" in from_ross(rotor, 20.0).notes[-1]
    with pytest.raises(DataError, match="depend on the vibration frequency, not the rotor speed; give a frequency"):
        from_ross(rotor, speeds=[15.0, 40.0])
    over = from_ross(rotor, frequency=-70.0, speeds=[15.0, 40.0])
    more = np.diag(over.at_speed(20.0).stiffness - plain.stiffness)
    assert more[[0, -2]] == pytest.approx([2e3 * Psi, 1e3 * Omega], rel=1e-9)
    with pytest.raises(DataError, match=r"Levitation has coefficients from 0\.1592 to 159\.2 Hz, but not at 200 Hz"):
        from_ross(rotor, 20.0, -200.0)


def test_a_later_ross_is_asked_at_the_speed_and_at_the_frequency():
    rotor = LaterRotor("ross_rotor")
    notes = from_ross(rotor, 20.0, -70.0).notes
    assert rotor.calls[-2:] == pytest.approx([2.0 * np.pi * 70.0, 2.0 * np.pi * 20.0])
    assert "for a rotor speed of 20 Hz, those that depend on the vibration frequency for 70 Hz, forward" in notes[-1]


def test_what_is_no_rotor_of_ross_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"not a rotor of ROSS 2\.3 or 3"):
        from_ross(SimpleNamespace(M=3))
    scipy.io.savemat(tmp_path / "a.mat", {"M": np.eye(12), "K": np.eye(12)})
    with pytest.raises(DataError, match="it has no C, G, nodes"):
        read_ross(tmp_path / "a.mat")
    scipy.io.savemat(tmp_path / "b.mat", {**{key: np.eye(13) for key in "MKCG"}, "nodes": [0.0, 1.0]})
    with pytest.raises(DataError, match="13 rows are not six for each of 2 nodes"):
        read_ross(tmp_path / "b.mat")
    rotor = Rotor("ross_rotor")
    rotor.raw["K"] = rotor.raw["K"] * np.nan
    with pytest.raises(DataError, match="not real and finite"):
        from_ross(rotor)


def test_coefficients_that_follow_the_speed_are_asked_for_where_they_are_known(tmp_path):
    rotor = Rotor("ross_rotor")
    rotor.bearing_elements[0].frequency = 2.0 * np.pi * np.array([10.0, 50.0])
    with pytest.raises(DataError, match=r"has coefficients from 10 to 50 Hz, but not at 0 Hz; give a speed"):
        from_ross(rotor)
    assert from_ross(rotor, 20.0).speed == 20.0
    raw = read_matrices(FOLDER / "ross_rotor.mat").matrices
    held = {role: raw[role] for role in ("M", "C", "G", "nodes")}
    tilts = np.diag(np.where(np.arange(len(raw["K"])) % 6 > 2, 1e5, 0.0))  # and nothing else
    scipy.io.savemat(tmp_path / "free.mat", held | {"K": tilts})
    with pytest.raises(DataError, match=r"no stiffness.*may have none at 0 Hz: rotor.save_mat\(file, speed\)"):
        read_ross(tmp_path / "free.mat")


@pytest.mark.parametrize(("speed", "at"), [(None, "the rotor speed at which the file was saved"), (80.0, "80 Hz, at which")])
def test_a_file_of_save_mat_says_of_which_frequency_magnetic_bearings_are(speed, at, tmp_path):
    path = shutil.copy(FOLDER / "ross_rotor.mat", tmp_path / "ross.mat")
    (note,) = (note for note in read_ross(path, speed).notes if "magnetic" in note)
    assert at in note and "a whirl of another frequency meets others" in note
