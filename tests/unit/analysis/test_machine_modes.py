"""Modes of a machine: closed forms, the real equations of y and z, a run that dies away, and machines of ROSS."""

import json
import math
import re
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg

import rsc
from rsc.analysis.alone.modes import critical_speeds, modes_at
from rsc.analysis.paper.predict import refuse_speeds
from rsc.analysis.paper.receptance import coupled_frequencies
from rsc.cli import main
from rsc.errors import SceneError
from rsc.machine.imports.ross import read_ross
from rsc.machine.imports.store import load_model
from rsc.machine.model.modes import slowest_modes
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES, changed
from systems import TWO_PI, random_system, with_anisotropy, with_skew
from systems import changed as with_values
from two_contacts import two

MACHINES = Path(__file__).parents[3] / "data" / "reference" / "machines"


def scene(**tables):
    return rsc.Scene.from_dict(changed(LAVAL, **tables))


def test_a_laval_rotor_has_its_closed_form():
    zeta, natural = 0.02, 30.0
    found = rsc.modes(scene(), 50.0)
    assert [mode.sense for mode in found.rotor] == ["backward", "forward"]
    for mode, sign in zip(found.rotor, (-1.0, 1.0), strict=True):
        assert mode.frequency == pytest.approx(sign * natural * math.sqrt(1.0 - zeta**2), rel=1e-12)
        assert mode.undamped == pytest.approx(sign * natural, rel=1e-12)
        assert mode.decrement == pytest.approx(TWO_PI * zeta / math.sqrt(1.0 - zeta**2), rel=1e-10)
        assert mode.damping_ratio == pytest.approx(zeta, rel=1e-10)
        assert mode.share == pytest.approx(1.0) and mode.remark == ""
    masses, springs = 1.0 + 0.25, 1.0 * (TWO_PI * 30.0) ** 2 + 0.25 * (TWO_PI * 150.0) ** 2
    dampers = 2 * 0.02 * TWO_PI * 30.0 + 2 * 0.1 * 0.25 * TWO_PI * 150.0
    both = found.coupled[1]
    assert both.undamped == pytest.approx(math.sqrt(springs / masses) / TWO_PI, rel=1e-10)
    assert both.growth_rate == pytest.approx(-dampers / masses / 2.0, rel=1e-10)
    assert [mode.frequency for mode in found.stator] == [mode.frequency for mode in rsc.modes(scene(), 10.0).stator]


def real_eigenvalues(body, speed):
    """Eigenvalues of the equations of [y, z], written out: the real and imaginary part of those of r."""
    def real(own, other):
        own = np.zeros_like(body.mass) + (0.0 if own is None else own)
        other = np.zeros_like(body.mass) + (0.0 if other is None else other)
        return np.block([[own.real + other.real, -own.imag + other.imag], [own.imag + other.imag, own.real - other.real]])

    skew = [0.0 if part is None else part for part in (body.skew_damping, body.skew_stiffness)]
    mass = real(body.mass.astype(complex), None)
    damping = real(body.damping - 1j * TWO_PI * speed * body.gyroscopic + 1j * skew[0], body.anisotropic_damping)
    stiffness = real(body.stiffness + 1j * skew[1], body.anisotropic_stiffness)
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    return scipy.linalg.eigvals(np.block([[zero, one], [-stiffness, -damping]]), np.block([[one, zero], [zero, mass]]))


@pytest.mark.parametrize("seed", range(12))
def test_modes_are_the_eigenvalues_of_the_real_equations(seed):
    rng = np.random.default_rng(seed)
    system = random_system(rng, least_stator=1)
    system = with_skew(rng, system) if seed % 3 else system
    system = with_anisotropy(rng, system) if seed % 2 else system
    found = modes_at(system, 40.0)
    for body, own in ((system.rotor, found.rotor), (system.stator, found.stator)):
        wanted = real_eigenvalues(body, 40.0)
        told = np.array([complex(mode.growth_rate, TWO_PI * mode.frequency) for mode in own])
        told = np.concatenate([told, told.conj()])
        if not body.isotropic:  # each that does not oscillate counts for half
            told = np.concatenate([told[np.abs(told.imag) > 0.0], told[told.imag == 0.0][: (told.imag == 0.0).sum() // 2]])
        largest = np.abs(wanted).max()
        assert len(told) == len(wanted)
        for value in wanted:
            assert np.abs(told - value).min() < 1e-7 * largest
        for mode in own:
            assert mode.remark in ("", "unstable", "undamped", "does not oscillate")
            assert (mode.growth_rate > 0.0) == (mode.remark == "unstable" or (mode.remark == "" and mode.decrement < 0.0))


@pytest.mark.parametrize("name", ["whirl, unbalance, run-up", "gyroscopic disk", "rigid wall"])
def test_both_joined_have_the_frequencies_that_the_prediction_calls_coupled(name):
    system = assemble(rsc.Scene.from_dict(SCENES[name]))
    found = modes_at(system, 45.0)
    wanted = coupled_frequencies(system, TWO_PI * 45.0) / TWO_PI
    assert sorted(mode.undamped for mode in found.coupled) == pytest.approx(np.sort(wanted), rel=1e-9)


def test_a_run_without_contact_dies_away_by_the_decrement():
    for name in ("whirl, unbalance, run-up", "gyroscopic disk"):
        content = changed(SCENES[name], rotor={"eccentricity": 0.0}, drive={"speed": 25.0, "duration": 1.0})
        content["rotor"].pop("angular_eccentricity", None)
        content["start"] = {"rotor": [[1e-4, 0.0]] + [[0.0, 0.0]] * (len(assemble(rsc.Scene.from_dict(content)).rotor.mass) - 1)}
        content["solver"] = {"rtol": 1e-9}
        run = rsc.simulate(rsc.Scene.from_dict(content))
        system = assemble(run.scene)
        modes = modes_at(system, 25.0).rotor
        rates = np.array([complex(mode.growth_rate, TWO_PI * mode.frequency) for mode in modes])
        signal = run.contact_rotor()
        # the motion is a sum of these modes and of nothing else
        basis = np.exp(np.outer(run.time, rates))
        part = np.linalg.lstsq(basis, signal, rcond=None)[0]
        np.testing.assert_allclose(basis @ part, signal, atol=1e-6 * np.abs(signal).max())


def test_a_rotor_that_turns_backwards_is_the_mirror_image():
    own = rsc.Scene.from_dict(SCENES["gyroscopic disk"])
    forward, turned = modes_at(assemble(own), 40.0), modes_at(assemble(own.mirrored()), -40.0)
    pairs = [sorted(m, key=lambda mode: abs(mode.frequency)) for m in (forward.rotor, turned.rotor)]
    for mode, mirror in zip(*pairs, strict=True):
        assert mirror.frequency == pytest.approx(-mode.frequency) and mirror.sense == mode.sense
        assert mirror.decrement == pytest.approx(mode.decrement)


def test_modes_that_need_words_have_them():
    free = rsc.modes(scene(rotor={"stiffness": 0.0, "frequency": None, "damping_ratio": None, "damping": 0.0}), 50.0)
    assert {mode.remark for mode in free.rotor} == {"free: nothing opposes it"} and free.rotor[0].sense == "-"
    slow = rsc.modes(scene(rotor={"damping_ratio": 1.2}), 50.0).rotor
    assert {mode.remark for mode in slow} == {"does not oscillate"} and all(math.isinf(mode.decrement) for mode in slow)
    assert {mode.remark for mode in rsc.modes(scene(rotor={"damping_ratio": 0.0}), 50.0).rotor} == {"undamped"}
    pushed = scene(rotor={"supports": [[0, [4e3, 2e3, -2e3, 4e3], [2.0, 0.0, 0.0, 2.0]]]})
    by_sense = {mode.sense: mode for mode in rsc.modes(pushed, 50.0).rotor}
    assert by_sense["forward"].remark == "unstable" and by_sense["forward"].decrement < 0.0
    assert by_sense["backward"].decrement > 0.0
    unequal = scene(rotor={"supports": [[0, [4e4, 0.0, 0.0, 1e3], [2.0, 0.0, 0.0, 2.0]]]})
    assert {mode.sense for mode in rsc.modes(unequal, 0.0).rotor} == {"straight"}


def test_critical_speeds_are_where_a_vibration_turns_with_the_rotor():
    disk = assemble(rsc.Scene.from_dict(SCENES["gyroscopic disk"]))
    still = with_values(disk, damping_r=0.0 * disk.rotor.damping)
    square = scipy.linalg.eigvals(still.rotor.stiffness, still.rotor.mass - still.rotor.gyroscopic)
    wanted = np.sort(np.sqrt(square.real[square.real > 0.0])) / TWO_PI
    found = critical_speeds(still, 0.0, 3.0 * wanted.max())
    assert found == pytest.approx(wanted, rel=1e-9)
    over = rsc.modes(rsc.Scene.from_dict(SCENES["gyroscopic disk"]), [10.0, 60.0])
    assert len(over) == 2 and over.criticals == pytest.approx(critical_speeds(disk, 10.0, 60.0))
    assert len(over.table().rows) == sum(len(own) for each in over for own in each.parts.values())
    unequal = assemble(scene(rotor={"supports": [[0, [4e4, 0.0, 0.0, 1e3], [2.0, 0.0, 0.0, 2.0]]]}))
    assert len(critical_speeds(unequal, 1.0, 100.0)) == 2  # one for each direction


def test_machines_have_the_modes_that_ross_computes():
    """run_modal of ROSS 2.3: the pair beside the running speed with its decrements, and all frequencies of a rotor with disks."""
    wanted = tomllib.loads((MACHINES / "ross_decrements.toml").read_text())
    model = read_ross(MACHINES / "ross_compressor.mat", wanted["speed"])
    found = slowest_modes(model, wanted["speed"], 16)
    for frequency, decrement in wanted["pair"]:
        mode = min(found, key=lambda mode: abs(mode.frequency - frequency))
        assert mode.frequency == pytest.approx(frequency, rel=1e-6) and mode.decrement == pytest.approx(decrement, rel=1e-5)
    listed = tomllib.loads((MACHINES / "ross_frequencies.toml").read_text())["ross_rotor"]
    model = read_ross(MACHINES / "ross_rotor.mat", listed["speed"])
    natural = np.array([abs(complex(m.growth_rate, TWO_PI * m.frequency)) for m in slowest_modes(model, listed["speed"], 10)])
    for value in natural:  # ROSS lists |lambda|, axial and torsional motions among them
        assert np.abs(np.array(listed["frequencies"]) / value - 1.0).min() < 1e-6


def test_inverse_iteration_finds_the_same_modes_as_the_whole_problem(monkeypatch):
    for file, speed in (("ross_rotor.mat", 20.0), ("ross_compressor.mat", 150.0)):
        model = read_ross(MACHINES / file, speed)
        whole = slowest_modes(model, speed, 6)
        monkeypatch.setattr("rsc.machine.model.modes.FEW", 0)
        few = slowest_modes(model, speed, 6)
        monkeypatch.undo()
        for name in ("frequency", "growth_rate"):
            values = [np.array([getattr(mode, name) for mode in own]) for own in (whole, few)]
            np.testing.assert_allclose(*values, rtol=1e-6, atol=1e-6)


@pytest.fixture
def imported(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    file = MACHINES / "ross_rub_rotor.mat"
    assert main(["import", "ross", str(file), "-o", "rotor.toml", "--contact", "12", "--speed", "20"]) == 0
    return capsys.readouterr().out


def test_an_import_tells_its_slowest_modes_and_a_reduced_machine_keeps_them(imported, capsys):
    assert "lowest modes at 20 Hz of the full model: -28.9 Hz (decrement 0.0386), 29.88 Hz" in imported
    assert main(["modes", "rotor.npz", "--speed", "20", "--json"]) == 0
    read = json.loads(capsys.readouterr().out)
    assert main(["modes", "rotor.toml", "--speed", "20", "--json"]) == 0
    kept = json.loads(capsys.readouterr().out)["rotor"]
    for mode, other in zip(read[:4], kept[:4], strict=True):
        assert other["frequency"] == pytest.approx(mode["frequency"], rel=1e-4)
        assert other["growth_rate"] == pytest.approx(mode["growth_rate"], rel=1e-2)


@pytest.mark.parametrize("backwards", [False, True])
def test_how_far_a_reduced_machine_is_from_the_one_that_was_read_is_told(imported, backwards, capsys):
    """The largest distance of an eigenvalue, of all eigenvalues of the full matrices and those of the reduced ones; a rotor that
    turns backwards is told as its mirror image. A coarser reduction is further off."""
    sign, model = "-" if backwards else "", load_model("rotor.npz")[0]
    fine = told_difference("1e-6", sign, capsys)
    number, off, growth, at = told_difference("1e-2", sign, capsys)
    reduced = rsc.load_scene("other.toml").turning_forward()
    full = free_eigenvalues(model.with_conjugate(-20.0 if backwards else 20.0))  # each with its conjugate
    own = [(mode.growth_rate, mode.frequency) for mode in rsc.modes(reduced, 20.0).rotor[:8] if abs(mode.frequency) <= 300.0]
    distances = [full[abs(full - complex(*value)).argmin()] - complex(*value) for value in np.array(own) * [1.0, TWO_PI]]
    worst = int(np.abs(distances).argmax())
    assert number == len(own) == 7 and at == pytest.approx(own[worst][1], rel=1e-4)
    assert (off, growth) == pytest.approx((abs(distances[worst].imag) / TWO_PI, abs(distances[worst].real)), rel=0.06)
    assert fine[1] < 1e-3 * off
    Path("kept.toml").write_text(reduced.to_toml())
    assert main(["modes", "kept.toml", "--speed", "20"]) == 0
    assert "as it was read" not in capsys.readouterr().out  # without its file the full machine is not known


def told_difference(tolerance, sign, capsys):
    """The numbers of the line that `rsc modes` ends with."""
    text = Path("rotor.toml").read_text().replace("tolerance = 1e-4", f"tolerance = {tolerance}\nband = [-300.0, 300.0]")
    Path("other.toml").write_text(re.sub("speed = .*# .guess.", f'speed = ["0 rpm", "{sign}3000 rpm"]', text))
    capsys.readouterr()
    assert main(["modes", "other.toml", "--speed", f"{sign}1200 rpm"]) == 0
    line = capsys.readouterr().out.splitlines()[-1]
    assert line.startswith("the 7 modes of the rotor above that lie in the band of its reduction are those of the machine as it")
    return [float(number) for number in re.findall(r"[-\d.e]+(?= modes| Hz\)?| 1/s)", line)]


def free_eigenvalues(matrices):
    """Eigenvalues of M q'' + D q' + K q = 0."""
    mass, damping, stiffness = matrices
    n = len(mass)
    return np.linalg.eigvals(np.block([
        [np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
    ]))  # fmt: skip


def test_several_contacts_are_joined_at_all_of_them():
    own, system = two(), assemble(two())
    told = rsc.modes(own, 50.0)
    alone = modes_at(system.at_contact("seal"), 50.0)
    assert [mode.frequency for mode in told.rotor] == [mode.frequency for mode in alone.rotor]  # free modes need no contact
    assert len(told.rotor) == 2 * system.n_rotor and len(told.coupled) == 2 * (system.n_rotor + system.n_stator - 2)
    mass, stiffness = system.joined().mass, system.joined().stiffness
    rows = np.array([np.concatenate([contact.rotor, -contact.stator]) for contact in system.contacts])
    # the same with springs that hold both together
    squares = scipy.linalg.eigvalsh(stiffness + 1e13 * rows.T @ rows, mass)
    wanted = np.sqrt(squares[:1]) / (2.0 * np.pi)
    found = np.unique([round(mode.undamped, 6) for mode in told.coupled if mode.frequency > 0.0])
    np.testing.assert_allclose(found[:1], wanted, rtol=1e-3)


def test_a_speed_as_the_refusal_prints_it_is_taken():
    reduced = SimpleNamespace(rotor=SimpleNamespace(model="reduced", speeds=(0.0, 24.0 + 2.0 / 3.0)))
    refuse_speeds("modes", "speed", reduced, np.array([24.6667]))
    with pytest.raises(SceneError, match=r"within 0 to 24\.6667 Hz"):
        refuse_speeds("modes", "speed", reduced, np.array([24.67]))


def test_the_command_prints_tables_and_draws_a_campbell_picture(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    own = rsc.Scene.from_dict(SCENES["gyroscopic disk"])
    Path("disk.toml").write_text(own.to_toml())
    assert main(["modes", "disk.toml", "--speed", "3000 rpm"]) == 0
    told = capsys.readouterr().out
    assert "modes at 50.00 Hz (3000 rpm)" in told and "both, joined at the contact: 4 modes" in told
    assert f"{rsc.modes(own, 50.0).rotor[0].frequency:.5g}" in told
    assert main(["modes", "disk.toml", "--speeds", "0:6000 rpm:11", "-o", "campbell.png"]) == 0
    told = capsys.readouterr().out
    assert len(told.splitlines()) == 2 + 2 + 11 + 1 and "critical speeds: " in told
    assert Path("campbell.png").read_bytes().startswith(b"\x89PNG")
    assert main(["modes", "disk.toml", "--speeds", "0:100:3", "-o", "campbell.csv"]) == 0
    assert len(Path("campbell.csv").read_text().splitlines()) == 1 + 3 * (4 + 2 + 4)


BAD = {
    "two kinds of speeds": (["--speed", "3", "--speeds", "0:1:3"], "cannot be combined with --speed"),
    "a picture of one speed": (["-o", "x.png"], "requires --speeds"),
    "no range": (["--speeds", "0-100"], "FROM:TO:NUMBER"),
    "a range of one": (["--speeds", "3:3:5"], "FROM:TO:NUMBER"),
    "one speed": (["--speeds", "0:100:1"], "FROM:TO:NUMBER"),
    "a speed beyond all": (["--speed", "1e9"], "a speed in Hz between"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_is_refused_in_one_line(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("laval.toml").write_text(scene().to_toml())
    options, wanted = BAD[name]
    assert main(["modes", "laval.toml", *options]) == 2
    line = capsys.readouterr().err.strip()
    assert wanted in line and "\n" not in line


def test_a_speed_outside_a_reduced_range_is_refused(imported, capsys):
    assert main(["modes", "rotor.toml", "--speed", "100000 rpm"]) == 2
    assert "for which the rotor was reduced" in capsys.readouterr().err
    with pytest.raises(SceneError):
        rsc.modes(rsc.load_scene("rotor.toml"), [10.0, 5000.0])
