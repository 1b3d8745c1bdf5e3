"""How many coordinates a reduction needs, by several methods, and whether the errors that it states are true.

    python bench/reduction.py            prints the tables
    python bench/reduction.py --write    keeps them in bench/results (reduction.md, reduction.csv)
    python bench/reduction.py --casing   reduces a casing of 50,000 complex coordinates alone (one process, for time and memory)

The rub rotor is that of ross_rotor.py with all its 68 coordinates; the random machines are those of tests/support/machines.py,
half of them with skew terms. Every error is that of `rsc.machine.points.Scale` at points of their own: random ones in band and
speeds, and some close to every natural frequency and critical speed. The methods compared live here only:

    in series         what `reduce` gives at the same or a finer tolerance, without its fastest modes, whose static compliance is
                      added to the contact's: the fewest coordinates left
    modes             undamped modes at standstill by frequency
    modes + residual  the same and the static deflection that they lack (MacNeal, Rubin)
    Craig-Bampton     static deflection of the contact and modes with it held

A whirl of the full machine is found by Newton's method from that of the reduced one and compared with the shift stated by
`whirl_shift`; of machines without skew terms `whirl_roots` counts the whirls of both.

Rotors on bearings that are stiffer in one direction are reduced by `reduce_unequal`; the error is that of both lines.
"""

import csv
import resource
import sys
import time
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.optimize

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "tools")]

import ross_rotor  # noqa: E402
from casing import casing  # noqa: E402
from machines import on_unequal_bearings, random_machine  # noqa: E402
from pages import RESULTS, write_page  # noqa: E402
from rsc.analysis.paper.whirls import whirl_roots  # noqa: E402
from rsc.machine import directions  # noqa: E402
from rsc.machine.body import Body, checked, projected, solutions, static_solver  # noqa: E402
from rsc.machine.contact import Unbalance, body_of  # noqa: E402
from rsc.machine.directions import BOTH_LINES, Place, Unequal, reduce_unequal, responses  # noqa: E402
from rsc.machine.greedy import SAFETY  # noqa: E402
from rsc.machine.points import Points, Scale, critical_speeds, natural_frequencies  # noqa: E402
from rsc.machine.reduction import reduce  # noqa: E402
from rsc.machine.ross import read_ross  # noqa: E402
from rsc.machine.shifts import natural_shifts, whirl_shift  # noqa: E402
from systems import make_system  # noqa: E402

TWO_PI = 2.0 * np.pi
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6)
MACHINES = 100
BAND, SPEEDS = (-500.0 * TWO_PI, 200.0 * TWO_PI), (0.0, 150.0 * TWO_PI)
GREEDY, IN_SERIES = "greedy (`reduce`)", "greedy, fastest modes in series"


class Truth(NamedTuple):
    """A full body solved at points of its own, and the scale of errors there."""

    body: Body
    places: Points
    scale: np.ndarray

    def error(self, reduced, compliance=0.0):
        """Largest error of the contact's displacement, with a static compliance in series (m/N)."""
        y = solutions(reduced, self.places.Psi, self.places.Omega, reduced.inputs[:, self.places.column])
        found = y @ reduced.contact + np.where(self.places.column == 0, compliance, 0.0)
        return float((np.abs(found - self.places.exact[:, 0]) / self.scale).max())


def truth(body, band, speeds, rng, n=600):
    """Random points, and five close to every natural frequency at three random speeds and to every critical speed."""
    body = checked(body)
    Psi, Omega = [rng.uniform(*band, n)], [rng.uniform(*speeds, n)]
    for speed in rng.uniform(*speeds, 3):
        natural = natural_frequencies(body, speed)
        near = np.outer(natural[(natural > band[0]) & (natural < band[1])], 1.0 + rng.uniform(-0.01, 0.01, 5)).ravel()
        Psi.append(near)
        Omega.append(np.full(near.shape, speed))
    column = [np.zeros(sum(map(len, Psi)), int)]
    for i in range(body.unbalance.shape[1]):
        critical = critical_speeds(body)
        near = np.outer(critical[critical < speeds[1]], 1.0 + rng.uniform(-0.01, 0.01, 5)).ravel()
        synchronous = np.concatenate([rng.uniform(*speeds, n // 2), near])
        Psi.append(synchronous)
        Omega.append(synchronous)
        column.append(np.full(synchronous.shape, 1 + i))
    places = Points(*map(np.concatenate, (Psi, Omega, column)), np.full((sum(map(len, Psi)), len(body.outputs)), np.nan + 0j), {})
    places.solve(body, np.arange(len(places.Psi)))
    static = static_solver(body)
    return Truth(body, places, Scale(body, static(body.inputs), static(body.outputs.T)).of(places, places.exact)[:, 0])


def bases(body):
    """{method: all directions in the order in which it takes them}."""
    static = static_solver(body)(body.contact[:, None])[:, 0]
    square, modes = scipy.linalg.eigh(body.stiffness, body.mass)
    held = scipy.linalg.null_space(body.contact[None, :])
    _, inner = scipy.linalg.eigh(held.T @ body.stiffness @ held, held.T @ body.mass @ held)
    return {
        "modes": lambda r: modes[:, :r],
        "modes + residual": lambda r: np.column_stack(
            [modes[:, : r - 1], static - modes[:, : r - 1] @ ((modes[:, : r - 1].T @ body.contact) / square[: r - 1])]
        ),
        "Craig-Bampton": lambda r: np.column_stack([static, held @ inner[:, : r - 1]]),
    }


def in_series(true, bodies):
    """Coordinates left at each tolerance by bodies of the `TOLERANCES`: the fewest, without as many modes as the error allows."""
    left = []
    for i, tolerance in enumerate(TOLERANCES):
        counts = []
        for body in bodies[i:]:
            square, modes = scipy.linalg.eigh(body.stiffness, body.mass)
            compliances = (modes.T @ body.contact) ** 2 / square
            counts.append(len(square))
            for kept in range(len(square) - 1, 0, -1):
                error = true.error(projected(body, modes[:, :kept]), float(compliances[kept:].sum()))
                if SAFETY * error > tolerance:
                    break
                counts.append(kept)
        left.append(min(counts))
    return left


def needed(true, basis):
    """Coordinates with which a method first has an error below each tolerance at every fifth point; None where none has."""
    found, body, places = {}, true.body, true.places
    few = Points(*(array[::5] for array in (places.Psi, places.Omega, places.column, places.exact)), {})
    true = Truth(body, few, true.scale[::5])
    for r in range(1, body.n_coordinates + 1):
        error = true.error(projected(body, _orthonormal(basis(r), body)))
        found |= {tolerance: r for tolerance in TOLERANCES if error <= tolerance and tolerance not in found}
        if len(found) == len(TOLERANCES):
            break
    return [found.get(tolerance) for tolerance in TOLERANCES]


def _orthonormal(columns, body):
    """The same directions, orthonormal with the stiffness."""
    scale = np.sqrt(np.einsum("ij,ij->j", columns, body.stiffness @ columns))
    columns = columns / np.where(scale > 0.0, scale, 1.0)
    triangle = scipy.linalg.cholesky(body.stiffness)
    turned = scipy.linalg.qr(triangle @ columns, mode="economic")[0]
    return scipy.linalg.solve_triangular(triangle, turned)


def rub_rotor():
    """The rub rotor with all coordinates as a Body, x bearings all round."""
    data = tomllib.loads(ross_rotor.FILE.read_text())
    mass, stiffness, damping, gyroscopic = ross_rotor.plane_matrices(data)
    for bearing in data["bearing"]:
        i = 2 * bearing["node"]
        stiffness[i, i] += bearing["kxx"]
        damping[i, i] += bearing["cxx"]
    unit = np.eye(len(mass))
    unbalance = data["unbalance"]["magnitude"] * unit[2 * data["unbalance"]["node"]]
    return Body(mass, damping, stiffness, unit[2 * data["rub"]["node"]], gyroscopic, unbalance=unbalance[:, None])


class Row(NamedTuple):
    """One machine at one tolerance."""

    machine: int
    skew: bool
    coordinates: int
    tolerance: float
    reduced: int
    stated: float
    true: float
    stator: int
    stator_reduced: int
    seconds: float
    whirls: int
    largest_change: float  # Hz, of a whirl from the reduced to the full machine
    largest_surprise: float  # Hz, of this change against the shift stated
    off: int  # whirls whose change is not the shift stated within a tenth of it, or 1e-10 of the frequency
    counts_agree: bool | None  # of the whirls in the band, with `whirl_roots`; None with skew terms
    largest_natural_change: float  # rad/s per rad/s, stated by `natural_shifts` at the highest speed


def machine_rows(seed):
    """A random machine at every tolerance, and the coordinates that other methods need for its rotor."""
    machine = random_machine(np.random.default_rng(seed))
    rng = np.random.default_rng([1, seed])
    true, stator = (truth(body, machine.band, machine.speeds, rng) for body in (machine.rotor, machine.stator))
    friction, Omega = float(rng.uniform(0.05, 0.5)), machine.speeds[1]
    rows, rotors = [], []
    for tolerance in TOLERANCES:
        start = time.process_time()
        bodies = [reduce(body, machine.band, machine.speeds, tolerance) for body in (machine.rotor, machine.stator)]
        seconds = time.process_time() - start
        whirls = compared_whirls(bodies, Omega, friction)
        skew = machine.rotor.skew_stiffness is not None
        Psi, shift = natural_shifts(bodies[0], Omega)
        row = Row(
            seed,
            skew,
            machine.rotor.n_coordinates,
            tolerance,
            bodies[0].body.n_coordinates,
            max(body.error for body in bodies),
            max(true.error(bodies[0].body), stator.error(bodies[1].body)),
            machine.stator.n_coordinates,
            bodies[1].body.n_coordinates,
            seconds,
            len(whirls),
            max((abs(change) for _, change, _ in whirls), default=0.0) / TWO_PI,
            max((abs(change - stated) for _, change, stated in whirls), default=0.0) / TWO_PI,
            sum(abs(change - stated) > max(0.1 * abs(stated), 1e-10 * abs(Psi)) for Psi, change, stated in whirls),
            None if skew or tolerance == TOLERANCES[0] else counted(bodies, Omega, friction),
            float(np.abs(shift / Psi).max(initial=0.0)),
        )
        rows.append(row)
        rotors.append(bodies[0].body)
    others = {IN_SERIES: in_series(true, rotors)}
    return rows, others | {name: needed(true, basis) for name, basis in bases(true.body).items()}


def unequal_row(seed, tolerance):
    """A random rotor on unequal bearings: its coordinates, those of the mean, the error stated, the true one, seconds."""
    rng, machine = np.random.default_rng([3, seed]), random_machine(np.random.default_rng(seed))
    body, unequal = on_unequal_bearings(rng, machine.rotor)
    mean = reduce(body, machine.band, machine.speeds, tolerance)
    begun = time.process_time()
    reduced = reduce_unequal(body, unequal, machine.band, machine.speeds, tolerance)
    seconds = time.process_time() - begun
    (stated,) = (check.error for check in reduced.checks if check.response == BOTH_LINES)
    reach, places = -machine.band[0], []
    for Omega in rng.uniform(*machine.speeds, 3).tolist():
        natural = directions.natural_frequencies(reduced.full, unequal, Omega)
        near = np.outer(natural[natural < reach], 1.0 + rng.uniform(-0.01, 0.01, 5)).ravel()
        places += [Place(Psi, Omega, [0, 1]) for Psi in (*rng.uniform(0.0, reach, 60), *near)]
    places += [Place(Omega, Omega, [2]) for Omega in rng.uniform(*machine.speeds, 100)]
    static, small, worst = static_solver(reduced.full), unequal.projected(reduced.basis), 0.0
    scale = Scale(reduced.full, static(reduced.full.inputs), static(reduced.full.outputs.T))
    for place in places:
        true, found = (
            np.kron(np.eye(2), part.contact) @ responses(part, acting, place)
            for part, acting in ((reduced.full, unequal), (reduced.body, small))
        )
        column = np.maximum(np.array(place.columns) - 1, 0)
        at = Points(*(np.full(column.shape, one) for one in (place.Psi, place.Omega)), column, true, {})
        size = scale.of(at, abs(true).max(axis=0)[:, None])[:, 0]
        worst = max(worst, float((abs(true - found).max(axis=0) / size).max()))
    return reduced.body.n_coordinates, mean.body.n_coordinates, stated, worst, seconds


def unequal_table():
    """Rows for each tolerance of `MACHINES` rotors whose directions differ."""
    lines = [
        "| tolerance | coordinates | mean alone | true above stated | largest true / stated | largest true / tolerance | "
        "seconds |",
        "|---" * 7 + "|",
    ]
    for tolerance in TOLERANCES[1:]:
        found = [unequal_row(seed, tolerance) for seed in range(MACHINES)]
        counts, means, stated, true, seconds = map(np.array, zip(*found, strict=True))
        lines.append(
            f"| {tolerance:.0e} | {_spread(counts.tolist())} | {_spread(means.tolist())} | "
            f"{np.sum(true > stated)} of {MACHINES} | {(true / stated).max():.2f} | {true.max() / tolerance:.2f} | "
            f"{np.median(seconds):.2f}, {seconds.max():.2f} |"
        )
        print(lines[-1], file=sys.stderr, flush=True)
    return "\n".join(lines)


def compared_whirls(bodies, Omega, friction):
    """[(Psi, change, shift stated)] of every root of Im(c H) in the band, rad/s."""

    def condition(parts):
        def value(Psi):
            Psi = np.atleast_1d(Psi)
            H = sum(
                solutions(b, Psi, np.full(Psi.shape, Omega), np.repeat(b.inputs[:, :1], Psi.size, 1)) @ b.contact for b in parts
            )
            return ((1.0 + 1j * friction) * H).imag

        return value

    full, reduced = condition([body.full for body in bodies]), condition([body.body for body in bodies])
    grid = np.linspace(*bodies[0].band, 4001)
    values, found = reduced(grid), []
    for i in np.flatnonzero((values[:-1] * values[1:] < 0.0) & (grid[:-1] * grid[1:] > 0.0)):
        root = scipy.optimize.brentq(lambda Psi: reduced(Psi)[0], grid[i], grid[i + 1], xtol=1e-13, rtol=1e-14)
        stated = whirl_shift(bodies, root, Omega, friction)
        guess = (root, root + stated + 1e-9 * abs(root))
        true = scipy.optimize.newton(lambda Psi: full(Psi)[0], guess[0], x1=guess[1], tol=1e-9 * abs(root), rtol=1e-13)
        found.append((root, float(true - root), stated))
    return found


def counted(bodies, Omega, friction):
    """Whether `whirl_roots` finds as many roots in the band for the reduced machine as for the full one."""
    counts = []
    for rotor, stator in ([body.full for body in bodies], [body.body for body in bodies]):
        parts = (rotor.mass, rotor.damping, rotor.stiffness, rotor.gyroscopic), (stator.mass, stator.damping, stator.stiffness)
        places = (int(np.argmax(rotor.contact)), int(np.argmax(stator.contact)))
        system = make_system(*parts, (*places, friction, np.inf))
        roots = np.atleast_1d(whirl_roots(system, Omega))
        counts.append(int(np.sum((roots > bodies[0].band[0]) & (roots < bodies[0].band[1]))))
    return counts[0] == counts[1]


def rotor_table():
    """Coordinates of the rub rotor by method and tolerance, with the highest frequency left by `reduce`, Hz."""
    body = rub_rotor()
    true = truth(body, BAND, SPEEDS, np.random.default_rng(0))
    lines = ["| method | " + " | ".join(f"{tolerance:.0e}" for tolerance in TOLERANCES) + " |", "|---" * 5 + "|"]
    cells, bodies = [], []
    for tolerance in TOLERANCES:
        times = []
        for _ in range(5):
            start = time.process_time()
            reduced = reduce(body, BAND, SPEEDS, tolerance)
            times.append(time.process_time() - start)
        cells.append(
            f"{reduced.body.n_coordinates} ({reduced.highest_after / TWO_PI:.0f} Hz, true error {true.error(reduced.body):.1e} "
            f"of {reduced.error:.1e} stated, {np.median(times):.2f} s)"
        )
        bodies.append(reduced.body)
    lines.append(f"| {GREEDY} | " + " | ".join(cells) + " |")
    lines.append(f"| {IN_SERIES} | " + " | ".join(map(str, in_series(true, bodies))) + " |")
    for name, basis in bases(true.body).items():
        lines.append(f"| {name} | " + " | ".join("-" if r is None else str(r) for r in needed(true, basis)) + " |")
    model = read_ross(ROOT / "data" / "reference" / "machines" / "ross_rub_rotor.mat", SPEEDS[1] / TWO_PI)
    node = tomllib.loads((ROOT / "data" / "reference" / "raw" / "ross_rub_rotor.toml").read_text())["rub"]["node"]
    own = body_of(model, node, [Unbalance(node, 1e-4)])
    unequal = Unequal(model.anisotropic_stiffness, model.anisotropic_damping)
    both = [reduce_unequal(own, unequal, BAND, SPEEDS, tolerance) for tolerance in TOLERANCES]
    texts = (f"{one.body.n_coordinates} ({one.highest_after / TWO_PI:.0f} Hz, {one.error:.1e} stated)" for one in both)
    lines.append("| its own, unequal bearings (`reduce_unequal`) | " + " | ".join(texts) + " |")
    return "\n".join(lines) + f"\n\nHighest frequency of the full rotor: {reduced.highest_before / TWO_PI:.0f} Hz.\n"


def machine_tables(rows, others):
    """The tables of the random machines."""
    lines = ["| method | " + " | ".join(f"{tolerance:.0e}" for tolerance in TOLERANCES) + " |", "|---" * 5 + "|"]
    ours = [[row.reduced for row in rows if row.tolerance == tolerance] for tolerance in TOLERANCES]
    lines.append(f"| {GREEDY} | " + " | ".join(_spread(counts) for counts in ours) + " |")
    for name in others[0]:
        lines.append(
            f"| {name} | " + " | ".join(_spread([other[name][i] for other in others]) for i in range(len(TOLERANCES))) + " |"
        )
    lines += [
        "",
        "| tolerance | true above stated | largest true / stated | largest true / tolerance | whirls | largest change, Hz | "
        "largest change less shift, Hz | not the shift stated | counts of `whirl_roots` agree | seconds, median and largest |",
        "|---" * 10 + "|",
    ]
    for tolerance in TOLERANCES:
        chosen = [row for row in rows if row.tolerance == tolerance]
        counts = [row.counts_agree for row in chosen if row.counts_agree is not None]
        seconds = [row.seconds for row in chosen]
        lines.append(
            f"| {tolerance:.0e} | {sum(row.true > row.stated for row in chosen)} of {len(chosen)} | "
            f"{max(row.true / row.stated for row in chosen):.2f} | {max(row.true for row in chosen) / tolerance:.2f} | "
            f"{sum(row.whirls for row in chosen)} | {max(row.largest_change for row in chosen):.1e} | "
            f"{max(row.largest_surprise for row in chosen):.1e} | "
            f"{sum(row.off for row in chosen)} | {sum(counts)} of {len(counts)} | "
            f"{np.median(seconds):.2f}, {max(seconds):.2f} |"
        )
    return "\n".join(lines)


def _spread(counts):
    """Median and range; how many do not reach the tolerance with all coordinates, for rounding."""
    reached = [count for count in counts if count is not None]
    lost = f", {len(counts) - len(reached)} never" if len(reached) < len(counts) else ""
    return f"{np.median(reached):.0f} ({min(reached)} to {max(reached)}{lost})"


def casing_line():
    """Time, memory and result of a large casing, in this process."""
    mass, damping, stiffness, contact = casing()
    start = time.process_time()
    reduced = reduce(Body(mass, damping, stiffness, contact), BAND, SPEEDS, 1e-4)
    seconds = time.process_time() - start
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return (
        f"A casing of {len(contact)} complex coordinates, tolerance 1e-4: {reduced.body.n_coordinates} coordinates, error "
        f"stated {reduced.error:.1e}, highest frequency {reduced.highest_before / TWO_PI:.3g} -> "
        f"{reduced.highest_after / TWO_PI:.0f} Hz, {seconds:.0f} s of processor time, {memory:.1f} GB."
    )


def main(arguments):
    """Print the tables, and keep them."""
    large = casing_line()  # first: the memory of the process is its largest so far
    print(large, flush=True)
    if "--casing" in arguments:
        return
    results = []
    for seed in range(MACHINES):
        results.append(machine_rows(seed))
        print(f"{seed + 1} of {MACHINES} machines", file=sys.stderr, flush=True)
    rows = [row for part, _ in results for row in part]
    text = (
        f"Coordinates needed for the largest relative error of contact receptance and unbalance response.\n\n## The rub rotor\n\n"
        f"68 coordinates, whirls of -500 to 200 Hz, speeds of 0 to 150 Hz; all rows but the last are of the rotor with its "
        f"bearings as stiff in all directions as in x.\n\n{rotor_table()}\n## {MACHINES} random machines\n\n"
        f"Median (least to most) of rotors of {min(row.coordinates for row in rows)} to {max(row.coordinates for row in rows)} "
        f"coordinates.\n\n{machine_tables(rows, [other for _, other in results])}\n\n"
        f"## {MACHINES} rotors on unequal bearings\n\n{unequal_table()}\n\n## A large body\n\n{large}\n"
    )
    print(text)
    if "--write" in arguments:
        write_page(RESULTS / "reduction.md", "Reduction", "python bench/reduction.py --write", text)
        with (RESULTS / "reduction.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(Row._fields)
            writer.writerows([[f"{x:.3e}" if isinstance(x, float) else x for x in row] for row in rows])


if __name__ == "__main__":
    main(sys.argv[1:])
