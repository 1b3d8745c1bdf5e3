"""Machines whose coefficients follow the rotor speed: ROSS's compressor over its speed, tables of supports, rotating damping, and
their reduction, against full solutions at speeds and frequencies of their own."""

import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
import scipy.sparse

import rsc
from fe_bodies import rotor
from machines import on_unequal_bearings, random_machine, shaft
from rsc.cli import main
from rsc.errors import DataError, ReductionError
from rsc.machine.imports.bearings import Bearing, with_bearings
from rsc.machine.imports.build import rotor_model
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.imports.ross import read_ross_over_speed
from rsc.machine.imports.store import load_model, save_model
from rsc.machine.imports.supports import read_supports, with_supports
from rsc.machine.model.following import over_speed
from rsc.machine.model.modes import slowest_modes
from rsc.machine.reduction.body import FEW, dynamic_stiffness
from rsc.machine.reduction.directions import BOTH_LINES, FrequencyPoint, reduce_unequal, responses
from rsc.machine.reduction.points import compared_speeds, natural_frequencies
from rsc.machine.reduction.reduction import reduce
from rsc.machine.reduction.shifts import receptance_error
from rsc.system.assemble import assemble
from rsc.system.knots import Knots
from systems import REFERENCE
from tiers import nightly

TWO_PI = 2.0 * np.pi
FOLDER = REFERENCE / "machines"
RPM = (4000, 6000, 8500, 11000)
FILES = [FOLDER / f"ross_compressor_{rpm}rpm.mat" for rpm in RPM]
PAIRS = {row[0]: row[1:] for row in tomllib.loads((FOLDER / "ross_compressor_speeds.toml").read_text())["pairs"]}
FREE = ((0.0, 0.0), (0.0, 0.0))
# node, rpm, k_xx, k_xy, k_yx, k_yy, c_xx, c_xy, c_yx, c_yy
TABLE = """node,rpm,k_xx,k_xy,k_yx,k_yy,c_xx,c_xy,c_yx,c_yy
0,600,3e6,2e5,-4e5,5e6,300,10,-20,500
0,1500,5e6,8e5,-8e5,6e6,200,0,0,300
left end,1,0,0,0,0,0,0,0,0
"""


@pytest.fixture(scope="module")
def compressor():
    return read_ross_over_speed(FILES, [rpm / 60.0 for rpm in RPM])


def pair(modes):
    """(frequency, decrement) of the backward and the forward mode at some 160 Hz."""
    own = [(mode.frequency, mode.decrement) for mode in modes if 150.0 < abs(mode.frequency) < 180.0 and mode.decrement < 3.0]
    return np.array(sorted(own))


@pytest.mark.parametrize("rpm", [rpm if rpm == 4000 else nightly(rpm) for rpm in PAIRS])
def test_the_compressor_has_the_decrements_of_ross_at_every_speed(compressor, rpm):
    """At knots they are those of ROSS's modal analysis; between, where ROSS lays a spline and rsc a line, to 0.2 %."""
    found = pair(slowest_modes(compressor, rpm / 60.0, 24))
    assert found == pytest.approx(np.array(PAIRS[rpm]), rel=1e-6 if rpm in RPM else 2e-3)


@pytest.mark.nightly
def test_the_compressor_from_its_files_to_a_scene(tmp_path, capsys, compressor):
    """The reduced one has the modes of the one that was read to the tolerance, at speeds between knots too."""
    scene = tmp_path / "compressor.toml"
    speeds = [f"{rpm} rpm" for rpm in RPM]
    assert main(["import", "ross", *map(str, FILES), "--speed", *speeds, "-o", str(scene), "--contact", "26"]) == 0
    told = capsys.readouterr().out
    assert "coefficients follow the rotor speed from 66.6667 to 183.333 Hz and are constant beyond." in told
    read = rsc.load_scene(scene)
    assert read.rotor.coordinates_before == 112 and read.rotor.n_coordinates < 30 and read.rotor.coefficients_at is None
    assert read.rotor.directions_error < 1e-4
    for rpm in (3000, 4000, 5000, 9700, 11000):
        own, full = (pair(modes) for modes in (rsc.modes(read, rpm / 60.0).rotor, slowest_modes(compressor, rpm / 60.0, 24)))
        assert own == pytest.approx(full, rel=2e-4)
    assert main(["modes", str(tmp_path / "compressor.npz")]) == 0
    assert "66.67 Hz (4000 rpm)" in capsys.readouterr().out


def test_a_model_is_read_back_with_its_knots(tmp_path, compressor):
    for model in (compressor, sparse_of(compressor)):
        save_model(model, tmp_path / "a.npz")
        again, _ = load_model(tmp_path / "a.npz")
        assert np.array_equal(again.knots.speed, model.knots.speed) and set(again.knots.parts) == set(model.knots.parts)
        for name, part in model.knots.parts.items():
            assert all(abs(one - other).max() == 0.0 for one, other in zip(again.knots.parts[name], part, strict=True))


def sparse_of(model):
    names = ("mass", "damping", "gyroscopic", "stiffness", "skew_damping", "skew_stiffness", "anisotropic_damping",
             "anisotropic_stiffness")  # fmt: skip
    matrices = {name: getattr(model, name) for name in names}
    knots = Knots(model.knots.speed, {name: list(map(scipy.sparse.csc_array, part)) for name, part in model.knots.parts.items()})
    return replace(model, **{name: scipy.sparse.csc_array(m) for name, m in matrices.items() if m is not None}, knots=knots)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda arrays: arrays | {"knots": arrays["knots"][::-1]}, "ValueError"),
        (lambda arrays: arrays | {"knots": arrays["knots"][:1]}, "ValueError"),
        (lambda arrays: arrays | {"knots": arrays["knots"] * np.nan}, "ValueError"),
        (lambda arrays: arrays | {"knots": np.arange(101.0)}, "ValueError"),
        (lambda arrays: arrays | {"knots.stiffness": arrays["knots.stiffness"][:-1]}, "ValueError"),
        (lambda arrays: arrays | {"knots.stiffness": arrays["knots.stiffness"] / 0.0}, "ValueError"),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(tmp_path, compressor, change, problem):
    save_model(compressor, tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as file, np.errstate(all="ignore"):
        np.savez(tmp_path / "b.npz", **change(dict(file)))
    with pytest.raises(DataError, match=rf"not a model written by `rsc import` \({problem}\)"):
        load_model(tmp_path / "b.npz")


def followed(seed, sparse=False, size=None):
    """A random rotor whose two supports follow the speed and whose shaft is damped as it turns; band and speeds."""
    rng = np.random.default_rng(seed)
    if size is None:
        machine = random_machine(rng)
        body, band, speeds = machine.rotor, machine.band, machine.speeds
    else:
        body, band, speeds = shaft(rng, size, True), None, None
    n, static = body.n_coordinates, np.linalg.inv(body.stiffness)
    parts = {name: np.zeros((4, n, n)) for name in ("stiffness", "damping", "skew_stiffness", "skew_damping")}
    for i in 2 * rng.choice(n // 2, 2, replace=False):
        k = 1.0 / static[i, i]
        parts["stiffness"][1:, i, i] = k * np.cumsum(rng.uniform(0.2, 1.0, 3))
        parts["damping"][:, i, i] = k * 1e-4 * rng.uniform(0.0, 2.0, 4)
        parts["skew_stiffness"][:, i, i] = 0.2 * k * rng.uniform(-1.0, 1.0, 4)
        parts["skew_damping"][:, i, i] = k * 1e-5 * rng.uniform(-1.0, 1.0, 4)
    if size is not None:
        natural = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(body.mass, body.stiffness)).real))
        band, speeds = (-1.2 * natural[3], 0.7 * natural[3]), (0.0, 1.5 * natural[0])
    body = replace(body, rotating_damping=1e-5 * body.stiffness, knots=Knots(np.linspace(0.1, 0.9, 4) * speeds[1], parts))
    return body, band, speeds, rng


def by_hand(body, Psi, Omega):
    """A of the coefficients that the body has at a speed, written out once more."""

    def at(name):
        values = body.knots.parts[name]
        below = np.clip(np.searchsorted(body.knots.speed, Omega) - 1, 0, len(values) - 2)
        low, high = body.knots.speed[below : below + 2]
        share = min(max((Omega - low) / (high - low), 0.0), 1.0)
        own = getattr(body, name)
        return (0.0 if own is None else own) + (1.0 - share) * values[below] + share * values[below + 1]

    damping = at("damping") + 1j * at("skew_damping") - 1j * Omega * body.gyroscopic + body.rotating_damping
    stiffness = at("stiffness") + 1j * at("skew_stiffness") - 1j * Omega * body.rotating_damping
    return stiffness + 1j * Psi * damping - Psi**2 * body.mass


def test_the_dynamic_stiffness_and_the_natural_frequencies_are_those_at_the_speed():
    """At knots, between and beyond, for many places at once; undamped frequencies as roots of the polynomial in Psi."""
    body, band, speeds, rng = followed(0)
    Psi, Omega = rng.uniform(*band, 7), np.concatenate([body.knots.speed, [0.0, 0.37 * speeds[1], speeds[1]]])
    for own, one, speed in zip(dynamic_stiffness(body, Psi, Omega), Psi, Omega, strict=True):
        assert own == pytest.approx(by_hand(body, one, speed), rel=1e-12, abs=1e-9 * abs(body.stiffness).max())
    bare = replace(body, damping=0.0 * body.mass, rotating_damping=0.0 * body.mass, skew_stiffness=None, skew_damping=None,
                   knots=body.knots.without(("damping", "skew_stiffness", "skew_damping")))  # fmt: skip
    for speed in (body.knots.speed[2], 0.5 * speeds[1]):
        for frequency in sorted(natural_frequencies(bare, speed), key=abs)[:4]:
            scaled = dynamic_stiffness(bare, np.array([frequency]), np.array([speed]))[0] / np.sqrt(
                np.outer(bare.stiffness.diagonal(), bare.stiffness.diagonal())
            )
            assert np.linalg.svd(scaled, compute_uv=False)[-1] < 1e-6


def test_every_knot_is_a_speed_of_the_training_and_checks_lie_between():
    body, _, speeds, _ = followed(0)
    training, check = (compared_speeds(body, speeds, 5, offset) for offset in (0.0, 0.5))
    assert set(body.knots.speed) <= set(training) and training[[0, -1]].tolist() == list(speeds)
    assert ((training[:-1] < check) & (check < training[1:])).all()
    assert compared_speeds(body, (3.0, 3.0), 5, 0.5).tolist() == [3.0]
    slower = (speeds[0], 0.5 * speeds[1])
    assert compared_speeds(body, slower, 5, 0.0).max() == slower[1]


@pytest.mark.parametrize("seed", range(3))
def test_the_receptance_is_within_the_tolerance_at_speeds_between_knots(seed):
    body, band, speeds, rng = followed(seed)
    reduced = reduce(body, band, speeds, 1e-4)
    assert reduced.error <= 1e-4 and 2 * reduced.body.n_coordinates < body.n_coordinates
    errors, sizes = [], []
    for Omega in rng.uniform(*speeds, 15):
        for Psi in rng.uniform(*band, 15):
            full = body.contact @ np.linalg.solve(by_hand(body, Psi, Omega), body.contact)
            small = np.linalg.solve(by_hand(reduced.body, Psi, Omega), reduced.body.contact)[0]
            errors.append(abs(full - small))
            sizes.append(abs(full))
    errors, sizes = np.array(errors), np.array(sizes)
    clear = sizes > 0.1 * np.median(sizes)
    assert (errors / sizes)[clear].max() <= reduced.error
    for Omega in rng.uniform(*speeds, 30):
        full = body.contact @ np.linalg.solve(by_hand(body, Omega, Omega), body.unbalance[:, 0])
        small = np.linalg.solve(by_hand(reduced.body, Omega, Omega), reduced.body.unbalance[:, 0])[0]
        assert abs(full - small) <= 2e-4 * abs(full)


@pytest.mark.nightly
def test_a_large_sparse_body_is_within_the_tolerance():
    body, band, speeds, rng = followed(3, size=FEW // 2 + 20)
    matrices = {name: scipy.sparse.csr_array(matrix) for name, matrix in body.terms.items()}
    knots = Knots(body.knots.speed, {name: list(map(scipy.sparse.csc_array, part)) for name, part in body.knots.parts.items()})
    reduced = reduce(replace(body, **matrices, knots=knots), band, speeds, 1e-4)
    assert all(check.estimated for check in reduced.checks) and reduced.body.n_coordinates < 30
    for _ in range(40):
        Psi, Omega = rng.uniform(*band), rng.uniform(*speeds)
        full = body.contact @ np.linalg.solve(by_hand(body, Psi, Omega), body.contact)
        small = np.linalg.solve(by_hand(reduced.body, Psi, Omega), reduced.body.contact)[0]
        assert abs(full - small) < 1e-4 * abs(full)
    Psi, Omega, h = 0.3 * band[0], 0.5 * speeds[1], 1e-5 * band[0]
    around = [body.contact @ np.linalg.solve(by_hand(body, Psi + d, Omega), body.contact) for d in (-h, h)]
    assert receptance_error(reduced, Psi, Omega)[1] == pytest.approx((around[1] - around[0]) / (2.0 * h), rel=1e-4)


def test_unequal_directions_that_follow_the_speed_are_within_the_tolerance():
    body, band, speeds, rng = followed(1)
    body, unequal = on_unequal_bearings(rng, body)
    stronger = np.array([1.0, 0.0, -0.5, 0.8])[:, None, None] * np.eye(len(body.mass))
    own = {"anisotropic_stiffness": unequal.stiffness, "anisotropic_damping": unequal.damping}
    parts = {name: stronger * np.diag(matrix) for name, matrix in own.items()}
    unequal = replace(unequal, knots=Knots(body.knots.speed, parts))
    reduced = reduce_unequal(body, unequal, band, speeds, 1e-4)
    small, worst = unequal.projected(reduced.basis), 0.0
    assert reduced.checks[-1].response == BOTH_LINES and reduced.error <= 1e-4
    n, r = body.n_coordinates, reduced.body.n_coordinates
    for Omega in rng.uniform(*speeds, 8):
        E, C = (
            own + sum(body.knots.shares(Omega)[:, None, None] * parts[name])
            for own, name in ((unequal.stiffness, "anisotropic_stiffness"), (unequal.damping, "anisotropic_damping"))
        )
        for Psi in rng.uniform(*band, 8):
            lines = [by_hand(body, Psi, Omega), E + 1j * Psi * C, (E - 1j * Psi * C).conj(), by_hand(body, -Psi, Omega).conj()]
            x = np.linalg.solve(np.block([lines[:2], lines[2:]]), np.concatenate([body.contact, 0.0 * body.contact]))
            y = responses(reduced.body, small, FrequencyPoint(Psi, Omega, [0]))[:, 0]
            true, own = (np.array([v[: len(v) // 2] @ row, v[len(v) // 2 :] @ row]) for v, row in
                         ((x, body.contact), (y, np.eye(r)[0])))  # fmt: skip
            worst = max(worst, abs(true - own).max() / abs(true).max())
    assert worst <= 1e-4 and n > 2 * r


def model(bearing=FREE, free=True, **more):
    matrices, nodes, directions = rotor(n_elements=4, bearing=bearing)
    table = Coordinates(nodes, directions, {"left end": 0}, {i: i / 4 for i in range(5)})
    return rotor_model(matrices | more, table, "a shaft", units="m", free=free)


def supports(tmp_path, text):
    (tmp_path / "supports.csv").write_text(text)
    return read_supports(tmp_path / "supports.csv")


TWO_ENDS = TABLE.replace("left end,1,0,0,0,0,0,0,0,0\n", "4,600,4e6,0,0,4e6,200,0,0,200\n4,3000,4e6,0,0,8e6,200,0,0,200\n")


def test_supports_of_a_table_are_bearings_at_every_speed(tmp_path):
    """At a knot, between, and beyond the rows of a node."""
    whole = with_supports(model(), supports(tmp_path, TWO_ENDS))
    assert whole.knots.speed == pytest.approx(TWO_PI * np.array([10.0, 25.0, 50.0]))
    at = {
        5.0: ((3e6, 2e5, -4e5, 5e6), (300.0, 10.0, -20.0, 500.0), 4e6),
        17.5: ((4e6, 5e5, -6e5, 5.5e6), (250.0, 5.0, -10.0, 400.0), 4.75e6),
        50.0: ((5e6, 8e5, -8e5, 6e6), (200.0, 0.0, 0.0, 300.0), 8e6),
    }
    for speed, (stiffness, damping, right) in at.items():
        bearings = [Bearing("left end", stiffness, damping), Bearing(4, (4e6, 0.0, 0.0, right), (200.0, 0.0, 0.0, 200.0))]
        own, other = whole.at_speed(speed), with_bearings(model(), bearings)
        for one, two in zip(own.with_conjugate(speed), other.with_conjugate(speed), strict=True):
            assert one == pytest.approx(two, rel=1e-12)


SCENE = """
[rotor]
model = "machine"
file = "rotor.npz"
contact = 2
load = [[2, [600.0, 200.0]]]
[reduction]
tolerance = 1e-4
band = [-3000.0, 3000.0]
[stator]
model = "laval"
mass = 2.0
frequency = 60.0
damping_ratio = 0.05
[contact]
gap = {gap}
friction = 0.2
stiffness = 2e7
[drive]
speed = [5.0, 60.0]
duration = 0.2
[solver]
method = "taylor8"
rtol = 1e-9
"""


def scene_of(folder, model, gap=1e-4):
    save_model(model, folder / "rotor.npz")
    (folder / "scene.toml").write_text(SCENE.format(gap=gap))
    return rsc.load_scene(folder / "scene.toml")


@pytest.mark.nightly
def test_a_run_of_the_reduced_machine_is_that_of_its_matrices(tmp_path):
    """A load that acts at once, in and out of contact over all knots, with rotating damping, against a scene of all matrices."""
    whole = with_supports(model(), supports(tmp_path, TWO_ENDS))
    whole = replace(whole, rotating_damping=2e-5 * model().stiffness)
    scene = scene_of(tmp_path, whole)
    assert scene.rotor.coordinates_before == 10 > scene.rotor.n_coordinates
    content = scene.to_dict()
    bare = model()
    tilts = bare.kind == "tilt"
    rows = {node: int(np.flatnonzero(bare.row_at(node))[0]) for node in (0, 2, 4)}
    content["rotor"] = {
        "model": "matrices", "mass": bare.mass.tolist(), "damping": bare.damping.tolist(), "stiffness": bare.stiffness.tolist(),
        "gyroscopic": bare.gyroscopic.tolist(), "tilt_coordinates": np.flatnonzero(tilts).tolist(),
        "rotating_damping": whole.rotating_damping.tolist(),
        "load": np.outer(bare.row_at(2), [600.0, 200.0]).tolist(),
        "supports_by_speed": [
            [rows[int(node)], [[float(speed), own[:4].tolist(), own[4:].tolist()] for speed, own in zip(*table, strict=True)]]
            for node, *table in supports(tmp_path, TWO_ENDS)
        ],
    }  # fmt: skip
    content["contact"]["rotor_coordinate"] = rows[2]
    del content["start"]
    full = rsc.Scene.from_dict(content)
    free = abs(rsc.simulate(scene.with_values({"contact.gap": 1e-3})).contact_rotor()).max()
    for gap in (1e-3, 0.95 * free):
        runs = [rsc.simulate(one.with_values({"contact.gap": gap})) for one in (scene, full)]
        assert gap == 1e-3 or runs[0].contact_releases > 0
        assert abs(runs[0].contact_rotor() - runs[1].contact_rotor()).max() < 1e-5 * free
        own, other = (run.ledger for run in runs)
        assert own.followed_in == pytest.approx(other.followed_in, rel=1e-4) and own.followed_in != 0.0
        assert all(abs(ledger.residual) < 1e-6 * ledger.turnover for ledger in (own, other))


def test_a_scene_of_a_result_keeps_the_knots_and_its_mirror_image(tmp_path):
    whole = with_supports(model(), supports(tmp_path, TWO_ENDS))
    scene = scene_of(tmp_path, replace(whole, rotating_damping=2e-5 * model().stiffness))
    again = rsc.Scene.from_toml(scene.to_toml())
    assert again == scene and again.reductions == ()
    body = assemble(scene).rotor
    assert body.knots.speed == pytest.approx(whole.knots.speed) and not body.isotropic
    mirrored = assemble(scene.mirrored()).rotor
    for Omega in TWO_PI * np.array([7.0, 20.0, 25.0, 44.0]):
        one, other = body.mirror().at_speed(-Omega), mirrored.at_speed(-Omega)
        for name in (*one.terms, "anisotropic_stiffness", "anisotropic_damping"):
            assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-12, abs=1e-12 * abs(one.stiffness).max())
    assert scene.mirrored().mirrored().to_dict() == scene.to_dict()


def changed_reduced(scene, **values):
    content = scene.to_dict()
    content["rotor"] |= values
    return rsc.Scene.from_dict(content)


def test_knots_of_a_reduced_body_that_cannot_be_are_refused(tmp_path):
    scene = scene_of(tmp_path, with_supports(model(), supports(tmp_path, TWO_ENDS)))
    speeds, stiffness = list(scene.rotor.knot_speeds), scene.to_dict()["rotor"]["stiffness_knots"]
    weaker = (-2.0 * np.array(stiffness[1]) - np.array(scene.rotor.stiffness)).tolist()
    for values, problem in (
        ({"knot_speeds": speeds[::-1]}, "knot_speeds.*increasing rotor speeds"),
        ({"knot_speeds": speeds[:1]}, "knot_speeds.*two or more"),
        ({"stiffness_knots": stiffness[:2]}, "stiffness_knots.*each of the 3"),
        ({"knot_speeds": None}, "knot_speeds"),
        ({"stiffness_knots": [stiffness[0], [[1.0]], stiffness[2]]}, r"stiffness_knots\[1\]"),
        ({"stiffness_knots": [stiffness[0], weaker, stiffness[2]]}, r"stiffness_knots\[1\].*positive semidefinite"),
    ):
        with pytest.raises(rsc.SceneError, match=problem) as told:
            changed_reduced(scene, **values)
        assert "\n" not in str(told.value)


def written_fe(folder):
    matrices, nodes, directions = rotor(n_elements=4, bearing=FREE)
    matrices["rotating_damping"] = 1e-5 * matrices["stiffness"]
    for name, matrix in matrices.items():
        scipy.io.mmwrite(folder / f"{name}.mtx", matrix)
    short = {"z": "other", "rz": "other"}
    lines = [f"{node},{short.get(direction, direction)}" for node, direction in zip(nodes, directions, strict=True)]
    (folder / "table.csv").write_text("\n".join(["node,direction", *lines]))
    names = [f"--{name.replace('_', '-')}={folder / name}.mtx" for name in matrices]
    return [*names, "--coordinates", str(folder / "table.csv"), "--contact", "2"]


def test_matrices_with_a_table_of_supports_and_rotating_damping_become_a_scene(tmp_path, capsys):
    files = written_fe(tmp_path)
    (tmp_path / "supports.csv").write_text(TWO_ENDS)
    scene = tmp_path / "shaft.toml"
    assert main(["import", "fe", *files, "--supports", str(tmp_path / "supports.csv"), "-o", str(scene)]) == 0
    assert "coefficients follow the rotor speed from 10 to 50 Hz" in capsys.readouterr().out
    read, _ = load_model(tmp_path / "shaft.npz")
    assert read.rotating_damping == pytest.approx(1e-5 * model().stiffness, rel=1e-6) and read.knots is not None
    loaded = rsc.load_scene(scene)
    assert loaded.rotor.rotating_damping is not None and loaded.rotor.knot_speeds == pytest.approx((10.0, 25.0, 50.0))
    for speed in (12.0, 40.0):
        own = rsc.modes(loaded, speed).rotor[:3]
        full = slowest_modes(read, speed, 3)
        assert [m.growth_rate for m in own] == pytest.approx([m.growth_rate for m in full], rel=1e-3)


def test_rotating_damping_makes_the_shaft_unstable_above_its_threshold(tmp_path):
    """With external damping b and internal D of one mode, m L^2 + (b + D) L + k - i Omega D = 0 grows above w (1 + b/D)."""
    bare = model(bearing=((1e9, 1e9), (1e9, 1e9)), free=False)
    bare = replace(bare, damping=1e-5 * bare.stiffness, gyroscopic=0.0 * bare.gyroscopic, rotating_damping=2e-5 * bare.stiffness)
    first = slowest_modes(replace(bare, rotating_damping=None, damping=0.0 * bare.damping), 0.0, 1)[0]
    threshold = abs(first.frequency) * 1.5
    scene = changed_reduced(scene_of(tmp_path, bare), speeds=[-1e3, 1e3])
    for speed, sign in ((threshold * (1.0 - 1e-5), -1.0), (threshold * (1.0 + 1e-5), 1.0)):
        for modes in (slowest_modes(bare, speed, 2), rsc.modes(scene, speed).rotor[:2]):
            assert sign * max(mode.growth_rate for mode in modes) > 0.0


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("0,1500", "0,500", "line 3: the rotor speed must exceed"),
        ("0,1500,5e6,8e5,-8e5,6e6,200,0,0,300\n", "", "node 0 has one row"),
        ("node,rpm", "node,hz,rpm", "one column for the rotor speed"),
        ("node,rpm", "node,speed", "column 'speed'"),
        ("k_xx", "kxx", "column 'kxx'"),
        ("0,600,3e6", "0,600,soft", "line 2: k_xx 'soft'"),
        ("0,600,3e6", "0,600,nan", "line 2: k_xx 'nan'"),
        ("0,600,3e6,", "0,600,", "line 2: has 9 values"),
        ("0,600,3e6,2e5,-4e5,5e6", "0,600,-3e9,0,0,5e6", "with the supports at 10 Hz: .*indefinite"),
        ("4,600", "9,600", "with the supports at 10 Hz: no node 9"),
        (TWO_ENDS, "node,rpm,k_xx,k_yy\n", "without rows"),
        (TWO_ENDS, "", "an empty table of supports"),
    ],
)
def test_tables_that_cannot_be_are_refused_in_one_line(tmp_path, capsys, old, new, problem):
    files = written_fe(tmp_path)
    text = TWO_ENDS.replace("4,3000", "9,3000") if new == "9,600" else TWO_ENDS
    assert old in text
    (tmp_path / "supports.csv").write_text(text.replace(old, new))
    assert main(["import", "fe", *files, "--supports", str(tmp_path / "supports.csv"), "-o", str(tmp_path / "a.toml")]) != 0
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and re.search(problem, error), error


def test_speeds_and_files_that_do_not_fit_are_refused(tmp_path, capsys):
    for files, speeds, problem in (
        (FILES[:2], ["4000 rpm"], "2 ROSS files need as many rotor speeds"),
        (FILES[:2], ["4000 rpm", "4000 rpm"], "rotor speed 66.6667 Hz must be above the previous one, 66.6667 Hz"),
        ([FILES[0], FOLDER / "ross_rotor.mat"], ["4000 rpm", "6000 rpm"], "its coordinates differ from those of"),
    ):
        command = ["import", "ross", *map(str, files), "--speed", *speeds, "-o", str(tmp_path / "a.toml"), "--contact", "3"]
        assert main(command) != 0
        error = capsys.readouterr().err
        assert problem in error and error.count("\n") == 1
    first = replace(model(bearing=((1e7, 1e7), (1e7, 1e7)), free=False), speed=10.0)
    with pytest.raises(DataError, match="the mass differs at 20 Hz"):
        over_speed([first, replace(first, speed=20.0, mass=1.01 * first.mass)])
    with pytest.raises(DataError, match="need 2 to 100 speeds"):
        over_speed([first])
    body = followed(0)[0]
    crooked = body.knots.parts["stiffness"] + np.triu(np.full(body.mass.shape, 1e5), 1)
    with pytest.raises(ReductionError, match="stiffness of a knot is not symmetric"):
        reduce(replace(body, knots=Knots(body.knots.speed, {"stiffness": crooked})), (-100.0, 100.0), (0.0, 10.0))


def test_what_turns_is_damped_alike_all_round():
    matrices, nodes, directions = rotor(n_elements=4, bearing=((1e7, 1e7), (1e7, 1e7)))
    table = Coordinates(nodes, directions, {}, {})
    unequal = np.diag(np.where(np.arange(len(nodes)) % 6 == 0, 1.0, 0.0))
    with pytest.raises(DataError, match="the rotating damping depends on the direction"):
        rotor_model(matrices | {"rotating_damping": unequal}, table, "a shaft", units="m")
    with pytest.raises(DataError, match="the rotating damping is indefinite"):
        rotor_model(matrices | {"rotating_damping": -1e-5 * matrices["stiffness"]}, table, "a shaft", units="m")
