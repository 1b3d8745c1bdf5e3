"""Coefficients over the vibration frequency as first-order states: closed forms exactly, anything else with its error."""

import doctest
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

import rsc
import rsc.machine.imports.rational
from fe_bodies import rotor
from matrix_writers import written_fe
from rsc.analysis.paper.receptance import receptance_rotor
from rsc.cli import main
from rsc.errors import DataError
from rsc.machine import fit_states
from rsc.scene.bodies.states import MagneticBearing, of_bearing
from rsc.scene.scene import Scene
from rsc.system.assemble import assemble
from scenes import LAVAL, changed

TWO_PI = 2.0 * np.pi
FREQUENCY = np.linspace(2.0, 250.0, 60)


def table(stiffness):
    """(frequency, k, c) of a dynamic stiffness, a function of s."""
    D = stiffness(TWO_PI * 1j * FREQUENCY)
    return FREQUENCY, D.real, D.imag / (TWO_PI * FREQUENCY)


def zener(s, k=1e6, k_1=2e5, rate=300.0):
    """A spring beside a spring and a dashpot in series."""
    return k + k_1 * s / (s + rate)


MAGNET = {"negative_stiffness": 5e4, "proportional": 3e5, "integral": 1e6, "derivative": 200.0, "derivative_filter": 1e4,
          "amplifier": 500.0}  # fmt: skip


def magnet(s):
    lag, corner = TWO_PI * 500.0, 1e4
    return lag / (s + lag) * (3e5 + 1e6 / s + 200.0 * corner * s / (s + corner)) - 5e4


EXACT = {  # function of s, k, c, poles
    "spring": (lambda s: 3e6 + 0.0 * s, 3e6, 0.0, []),
    "Kelvin-Voigt": (lambda s: 3e6 + 400.0 * s, 3e6, 400.0, []),
    "Zener": (zener, 1e6, 0.0, [-300.0]),
    "two Maxwell elements and a dashpot": (lambda s: zener(s) + 50.0 * s + 4e4 * s / (s + 40.0), 1e6, 50.0, [-300.0, -40.0]),
    "mass on a spring": (lambda s: 1e6 + 1e8 * s / (s**2 + 60.0 * s + 4e5), 1e6, 0.0, [-30 + 631.74361j, -30 - 631.74361j]),
    "magnetic bearing": (magnet, None, 0.0, [-1e4, -TWO_PI * 500.0, 0.0]),
}


@pytest.mark.parametrize("name", EXACT)
def test_closed_forms_are_found_exactly(name):
    stiffness, k, c, poles = EXACT[name]
    fit = fit_states(*table(stiffness))
    assert fit.error < 1e-12 and fit.damping == pytest.approx(c, rel=1e-9)
    assert k is None or fit.stiffness == pytest.approx(k, rel=1e-9)
    found = np.sort_complex(scipy.linalg.eigvals(fit.matrix)) if poles else np.zeros(0)
    np.testing.assert_allclose(found, np.sort_complex(np.array(poles, complex)), rtol=1e-6, atol=1e-6)
    outside = np.array([0.3, 700.0])  # a closed form holds beyond its table
    np.testing.assert_allclose(fit.dynamic_stiffness(outside), stiffness(TWO_PI * 1j * outside), rtol=1e-8)


def test_the_states_of_a_magnetic_bearing_make_the_same_rotor():
    """Whirls and their stability, by the matrices of the fit and by the bearing itself, whose states are others."""
    fit = fit_states(*table(magnet))
    own = of_bearing(MagneticBearing(**MAGNET, off=None), np.ones(1), np.ones(1))
    assert len(own.matrix) == len(fit.matrix) == 3
    rotor = {"model": "laval", "mass": 5.0, "damping": fit.damping, "stiffness": fit.stiffness, "states": fit.states()}
    held = {"model": "laval", "mass": 5.0, "damping": 0.0, "stiffness": 0.0, "magnetic_bearings": [[0, MAGNET]]}
    whirls = [rsc.predict(Scene.from_dict(changed(LAVAL, rotor=one)), 50.0) for one in (rotor, held)]
    assert len(whirls[0]) == len(whirls[1]) > 0
    for one, other in zip(*whirls, strict=True):
        for value in ("frequency", "normal_force", "growth_rate"):
            assert getattr(one, value) == pytest.approx(getattr(other, value), rel=1e-6)


def elastomer(s):
    """A loss factor that hardly depends on the frequency: of no finite number of states."""
    return 1e6 * (s / 100.0) ** 0.2


@pytest.mark.parametrize("tolerance", [3e-2, 1e-3, 1e-4])
def test_the_stated_error_is_the_largest_of_the_table(tolerance):
    fit = fit_states(*table(elastomer), tolerance=tolerance)
    D = elastomer(TWO_PI * 1j * FREQUENCY)
    off = np.abs(fit.dynamic_stiffness(FREQUENCY) / D - 1.0).max()
    assert 0.0 < fit.error <= tolerance and fit.error == pytest.approx(off, rel=1e-6)
    assert scipy.linalg.eigvals(fit.matrix).real.max() < 0.0 and fit.damping >= 0.0 and (fit.low, fit.high) == (2.0, 250.0)
    with pytest.raises(DataError, match=r"with 0 stable states the fit of its coefficients is off by [0-9]+ %, more than 10 %"):
        fit_states(*table(elastomer), most=0)


def test_noise_is_not_fitted():
    """With an error that no number of states mends the fewest are taken, and poles stay in the left half plane."""
    rng = np.random.default_rng(3)
    for _ in range(10):
        noise = 1.0 + 0.01 * (rng.normal(size=60) + 1j * rng.normal(size=60))
        f, k, c = table(zener)
        D = (k + TWO_PI * 1j * f * c) * noise
        fit = fit_states(f, D.real, D.imag / (TWO_PI * f))
        poles = scipy.linalg.eigvals(fit.matrix)
        assert len(poles) <= 3 and poles.real.max() <= 0.0 and 0.01 < fit.error < 0.04
        assert fit.stiffness == pytest.approx(1e6, rel=0.02)


def test_an_unstable_table_has_no_unstable_fit():
    """A pole in the right half plane fits it exactly; what stays in the left one is further off, and says so."""
    fit = fit_states(*table(lambda s: 1e6 - 5e6 / (s - 60.0)))
    assert scipy.linalg.eigvals(fit.matrix).real.max() <= 0.0 and fit.error > 1e-3


def test_a_dashpot_that_drives_is_not_fitted_as_one():
    """Negative damping of the whole table stays with the states, which have to decay; or the table is refused."""
    fit = fit_states(*table(lambda s: zener(s) - 60.0 * s))
    assert fit.damping >= 0.0 and fit.error > 1e-6 and scipy.linalg.eigvals(fit.matrix).real.max() <= 0.0


def test_where_a_fit_feeds_energy_beyond_its_table_is_told():
    """The lag of an amplifier, above what was measured: the phase is that of a negative damping."""
    inside = np.linspace(20.0, 200.0, 40)
    D = magnet(TWO_PI * 1j * inside)
    assert D.imag.min() > 0.0
    fit = fit_states(inside, D.real, D.imag / (TWO_PI * inside))
    assert fit.driving is not None and magnet(TWO_PI * 1j * fit.driving).imag < 0.0
    assert fit_states(*table(zener)).driving is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([1.0, 2.0], [1e6]), "must be lists of one length"),
        (([1.0, "x"], [1e6, 1e6]), "must be numbers"),
        (([1.0, np.nan], [1e6, 1e6]), "must be finite"),
        (([-1.0, 2.0], [1e6, 1e6]), "must be different, and not negative"),
        (([1.0, 1.0], [1e6, 1e6]), "must be different, and not negative"),
        (([1.0, 2.0], [0.0, 0.0]), "its coefficients are all zero"),
    ],
)
def test_what_is_no_table_is_refused(arguments, words):
    with pytest.raises(DataError, match=words):
        fit_states(*arguments)


def test_the_example_gives_what_it_shows():
    (example,) = doctest.DocTestFinder(recurse=False).find(fit_states, "fit_states", globs={"np": np, "fit_states": fit_states})
    assert doctest.DocTestRunner().run(example).failed == 0


def write(folder, tables, extra=""):
    """A table of supports: node -> function of s."""
    lines = [f"node,hz,k_xx,k_yy,c_xx,c_yy{extra}"]
    for node, stiffness in tables.items():
        f, k, c = table(stiffness)
        rows = zip(f.tolist(), k.tolist(), c.tolist(), strict=True)
        lines += [f"{node},{a!r},{b!r},{b!r},{d!r},{d!r}" + ",3e5" * bool(extra) for a, b, d in rows]
    (folder / "supports.csv").write_text("\n".join(lines) + "\n")
    return str(folder / "supports.csv")


def test_an_imported_rotor_stands_on_them(tmp_path, capsys):
    """Its receptance is that of all coordinates with D(omega) put in."""
    free = rotor(bearing=((0.0, 0.0), (0.0, 0.0)))
    supports = {0: zener, 6: lambda s: elastomer(s) + 100.0 * s}
    output = tmp_path / "shaft.toml"
    command = ["import", "fe", *written_fe(tmp_path, free), "-o", str(output), "--contact", "2"]
    assert main([*command, "--supports-by-frequency", write(tmp_path, supports)]) == 0
    told = capsys.readouterr().out
    assert "node 0: coefficients over the vibration frequency from 2 to 250 Hz fitted by 1 first-order states, error" in told
    scene = rsc.load_scene(output)
    assert scene.rotor.n_states >= 4 and "# node, N/m, N s/m; those that are fitted" in output.read_text()
    matrices, _, directions = free
    own = np.isin(directions, ["x", "y", "rx", "ry"])
    M, C, K, G = (matrices[name][np.ix_(own, own)] for name in ("mass", "damping", "stiffness", "gyroscopic"))
    Omega, Psi = TWO_PI * 20.0, TWO_PI * np.array([-200.0, -60.0, 35.0, 150.0])
    exact = []
    for w in Psi:
        A = K - w**2 * M + 1j * w * (C + Omega * G)
        for node, stiffness in supports.items():
            for row in (4 * node, 4 * node + 1):
                A[row, row] += stiffness(1j * abs(w)) if w > 0.0 else np.conj(stiffness(1j * abs(w)))
        push = np.zeros(len(A), complex)
        push[[8, 9]] = 1.0, -1j
        exact.append(np.linalg.solve(A, push)[8])
    np.testing.assert_allclose(receptance_rotor(assemble(scene), Psi, Omega), exact, rtol=5e-3)
    assert main(["predict", str(output), "--speed", "20"]) == 0


def test_supports_that_cannot_be_fitted_are_refused_in_one_line(tmp_path, capsys):
    files = written_fe(tmp_path, rotor(bearing=((0.0, 0.0), (0.0, 0.0))))
    for extra, change, problem in (
        (",k_xy", None, "node 0: its directions differ or are coupled"),
        ("", ("node,hz", "node,speed"), "speed"),
        ("", ("2.0,", "-2.0,"), "node 0: frequencies must be different, and not negative"),
    ):
        path = write(tmp_path, {0: zener, 6: zener}, extra)
        if change:
            Path(path).write_text(Path(path).read_text().replace(*change, 1))
        command = ["import", "fe", *files, "-o", str(tmp_path / "s.toml"), "--contact", "2", "--supports-by-frequency", path]
        assert main(command) == 4
        error = capsys.readouterr().err
        assert problem in error and error.count("\n") == 1 and not (tmp_path / "s.toml").exists()
    command = ["import", "fe", *files, "-o", str(tmp_path / "s.npz"), "--contact", "2", "--supports-by-frequency",
               write(tmp_path, {0: zener, 6: zener})]  # fmt: skip
    assert main(command) == 4 and "must be a scene (.toml), which has the fitted supports" in capsys.readouterr().err
