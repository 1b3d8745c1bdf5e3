"""Natural frequencies of ROSS's example rotors: its own modal analysis beside rsc's matrices in complex coordinates.

    python bench/ross_models.py              prints the table; needs ROSS (pip install "ross-rotordynamics==2.3.0" "plotly<7")
    python bench/ross_models.py --write      keeps it in bench/results/ross_models.md, of ROSS 3 in bench/results/ross_models_3.md
    python bench/ross_models.py --export     writes the models and frequencies of data/reference/machines, by ROSS's own save_mat

For each rotor and speed every frequency of `run_modal(sparse=False)` must be one of the lateral ones, from
`Model.with_conjugate`, or one of the axial and torsional ones, from the rows that the complex coordinates leave out. ROSS 2.3
stands beside rsc in one environment on Python 3.11; version 3 needs Python 3.13.
"""

import sys
import tomllib
import warnings
from pathlib import Path

import numpy as np
import scipy.io
import scipy.linalg

from rsc.errors import DataError
from rsc.machine import from_ross

ROOT = Path(__file__).parent.parent
MACHINES = ROOT / "data" / "reference" / "machines"
RUB = ROOT / "data" / "reference" / "raw" / "ross_rub_rotor.toml"
POISSON = 0.2992610837438423  # of the rub rotor's steel, in ROSS's tests/test_rubbing.py; its shear modulus depends on it
SPEEDS = (0.0, 20.0, 60.0)  # Hz
MODES, TOLERANCE = 40, 1e-8
EXPORTED = {"rotor_example": 20.0, "coaxrotor_example": 20.0, "rub rotor": 20.0, "compressor_example": 150.0}
sys.path[:0] = [str(ROOT / "tools")]

from pages import RESULTS, write_page  # noqa: E402


def rub_rotor(ross):
    """The rotor of ROSS's tests/test_rubbing.py from its data in this repository."""
    data = tomllib.loads(RUB.read_text())
    shaft, disc = data["shaft"], data["disc"]
    steel = ross.Material(name="Steel", rho=shaft["density"], E=shaft["youngs_modulus"], Poisson=POISSON)
    lengths = np.diff(np.array(shaft["node_positions_mm"])) / 1000.0
    elements = [
        ross.ShaftElement(
            length, 0.0, shaft["outer_diameter"], material=steel, alpha=shaft["rayleigh_alpha"], beta=shaft["rayleigh_beta"]
        )
        for length in lengths
    ]
    inertias = {"m": disc["mass"], "Id": disc["diametral_inertia"], "Ip": disc["polar_inertia"]}
    discs = [ross.DiskElement(n=node, **inertias) for node in disc["nodes"]]
    bearings = [
        ross.BearingElement(n=bearing["node"], **{key: bearing[key] for key in ("kxx", "kyy", "cxx", "cyy")}, kzz=0, czz=0)
        for bearing in data["bearing"]
    ]
    return ross.Rotor(elements, discs, bearings)


def rotors(ross):
    """Name -> function that builds it: all examples of ROSS and the rub rotor."""
    import ross.rotor_assembly as examples

    built = {name: getattr(examples, name) for name in sorted(dir(examples)) if "_example" in name}
    return {**built, "rub rotor": lambda: rub_rotor(ross)}


def eigenvalues(mass, damping, stiffness):
    """Eigenvalues of M q'' + C q' + K q = 0, 1/s."""
    n = len(mass)
    below = scipy.linalg.solve(mass, np.hstack([-stiffness, -damping]))
    return scipy.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [below[:, :n], below[:, n:]]]))


def left_out(rotor, omega):
    """Eigenvalues of the rows that the complex coordinates leave out: axial and torsional motion."""
    size, n_nodes = rotor.ndof, len(rotor.nodes_pos)
    rows = [6 * node + k for node in range(n_nodes) for k in (2, 5)] + list(range(6 * n_nodes + 2, size, 3))
    parts = (rotor.M(omega), rotor.C(omega) + omega * rotor.G(), rotor.K(omega))
    return eigenvalues(*(np.asarray(part)[np.ix_(rows, rows)] for part in parts))


def compare(rotor, speed):
    """Row of the table at a speed in Hz: sizes, frequencies, differences, what the model holds."""
    omega = 2.0 * np.pi * speed
    model = from_ross(rotor, speed)
    ours = np.concatenate([eigenvalues(*model.with_conjugate(speed)), left_out(rotor, omega)])
    again = eigenvalues(rotor.M(omega), rotor.C(omega) + omega * rotor.G(), rotor.K(omega))
    theirs = rotor.run_modal(omega, sparse=False, num_modes=2 * MODES).wn
    theirs = theirs[theirs > 1.0]
    difference, rounding = (max(np.min(np.abs(np.abs(values) - wn)) / wn for wn in theirs) for values in (ours, again))
    skew = model.skew_stiffness is not None or model.skew_damping is not None
    holds = ", ".join(word for word, there in (("anisotropic", not model.isotropic), ("cross-coupled", skew)) if there)
    shown = f"{difference:.0e}" if difference <= max(TOLERANCE, 10.0 * rounding) else f"**{difference:.0e}**"
    return f"{rotor.ndof} | {model.n} | {speed:g} | {len(theirs)} | {shown} | {rounding:.0e} | {holds or 'isotropic'}"


def table(ross):
    """Lines of the page."""
    lines = [
        f"ROSS {ross.__version__}: the lowest {MODES} natural frequencies of its own modal analysis against those of rsc's",
        "complex coordinates (lateral motion) and of the rows they leave out (axial and torsional motion), largest relative",
        "difference. The same for ROSS's own matrices, solved a second time, shows what rounding does to a frequency.",
        "",
        "| rotor | coordinates | complex | speed Hz | frequencies | difference | rounding | matrices |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, build in rotors(ross).items():
        for speed in SPEEDS:
            try:
                lines.append(f"| {name} | {compare(build(), speed)} |")
            except DataError as error:
                lines.append(f"| {name} | | | {speed:g} | | refused: {error.problem} | | |")
    return lines


def export(ross):
    """Matrices by save_mat, packed, and the lowest frequencies of ROSS's own modal analysis."""
    lines = [
        "# ROSS's own natural frequencies, run_modal(sparse=False).wn in rad/s, of the models beside this file; axial and",
        f"# torsional ones are among them. Written by `python bench/ross_models.py --export` with ROSS {ross.__version__}.",
    ]
    for name, speed in EXPORTED.items():
        rotor, path = rotors(ross)[name](), MACHINES / f"ross_{name.replace('_example', '').replace(' ', '_')}.mat"
        omega = 2.0 * np.pi * speed
        rotor.save_mat(path, speed=omega)
        matrices = {key: value for key, value in scipy.io.loadmat(path).items() if not key.startswith("__")}
        scipy.io.savemat(path, matrices, do_compression=True)
        wn = rotor.run_modal(omega, sparse=False, num_modes=2 * MODES).wn
        shown = ", ".join(f"{value:.15g}" for value in wn[wn > 1.0])
        lines += ["", f"[{path.stem}]", f"speed = {speed}", f"frequencies = [{shown}]"]
    (MACHINES / "ross_frequencies.toml").write_text("\n".join(lines) + "\n")


def main():
    """Print, keep or export."""
    warnings.simplefilter("ignore")
    try:
        import ross
    except ImportError:
        sys.exit('ROSS is not installed: pip install "ross-rotordynamics==2.3.0" "plotly<7"')
    if "--export" in sys.argv:
        export(ross)
        return
    lines = table(ross)
    print("\n".join(lines))
    if "--write" in sys.argv:
        title, command = "ROSS's rotors in complex coordinates", "python bench/ross_models.py --write"
        page = f"ross_models{'' if ross.__version__.startswith('2.') else '_3'}.md"
        write_page(RESULTS / page, title, command, "\n".join(lines))


if __name__ == "__main__":
    main()
