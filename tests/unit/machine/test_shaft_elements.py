"""Shafts by their stations: elements against closed forms and the exact transfer matrix, ROSS's own matrices, refinement."""

import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import brentq

from rsc.machine.imports.ross import read_ross
from rsc.machine.model.modes import slowest_modes
from rsc.machine.shaft.assembly import bare_model, model_of
from rsc.machine.shaft.division import CHANGE, divided, natural_frequencies
from rsc.machine.shaft.element import element, shear_factor
from rsc.machine.shaft.parts import Disk, Material, Section, Shaft, Support, disk_inertias
from tiers import first

DATA = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists()) / "data" / "reference"
STEEL = Material(7850.0, 210e9, 0.3)
ROSS_STEEL = Material(7810.0, 211e9, 0.5 * 211e9 / 81.2e9 - 1.0)


def bearing(place, stiffness, damping=0.0, other=None):
    k_yy, c_yy = (stiffness, damping) if other is None else other
    return Support(place, np.zeros(1), np.array([[stiffness, 0.0, 0.0, k_yy, damping, 0.0, 0.0, c_yy]]))


def cylinder(length, diameter, bore=0.0, material=STEEL):
    return Section(length, (diameter, diameter), (bore, bore), material)


def free_or_pinned(shaft, elements, pinned):
    """Natural frequencies in rad/s of the bare shaft without rigid motions, lowest first."""
    model = bare_model(shaft, np.linspace(0.0, shaft.length, elements + 1))
    kept = np.ones(model.n, bool)
    if pinned:
        kept[[0, -2]] = False
    mass, stiffness = (matrix[np.ix_(kept, kept)] for matrix in (model.mass, model.stiffness))
    return np.sqrt(np.abs(scipy.linalg.eigh(stiffness, mass, eigvals_only=True)[0 if pinned else 2 :]))


def exact(section, omega, pinned):
    """Zero at a natural frequency: the determinant of what both ends leave free, from y' = A y of deflection, slope, moment and
    shear force of Timoshenko's beam. Scaled, so that entries have one magnitude."""
    d, b, m = section.outer[0], section.inner[0], section.material
    area, inertia = np.pi / 4.0 * (d**2 - b**2), np.pi / 64.0 * (d**4 - b**4)
    bend, slide = m.young * inertia, shear_factor(m.poisson, b / d) * m.shear_modulus * area
    scale = np.array([1.0, 1.0 / section.length, bend / section.length**2, bend / section.length**3])
    # Q = slide (w' - psi), M = bend psi', Q' = -rho A omega^2 w, M' + Q = -rho I omega^2 psi
    line = np.zeros((4, 4))
    line[0, 1], line[0, 3] = 1.0, 1.0 / slide
    line[1, 2] = 1.0 / bend
    line[2, 1], line[2, 3] = -m.density * inertia * omega**2, -1.0
    line[3, 0] = -m.density * area * omega**2
    across = scipy.linalg.expm(section.length * line * scale / scale[:, None])
    ends, begins = ([0, 2], [1, 3]) if pinned else ([2, 3], [0, 1])
    return np.linalg.det(across[np.ix_(ends, begins)])


def order_and_error(shaft, roots, pinned):
    """Orders of convergence of the lowest frequencies from 10 to 20 elements, and their relative errors with 40."""
    coarse, middle, fine = (np.abs(free_or_pinned(shaft, n, pinned)[: len(roots)] / roots - 1.0) for n in (10, 20, 40))
    return np.log2(coarse / middle), fine


@pytest.mark.parametrize("pinned", [True, False])
@pytest.mark.parametrize("section", [cylinder(1.0, 0.02), cylinder(1.0, 0.1), cylinder(1.0, 0.2, 0.15)])
def test_beams_with_shear_converge_with_order_two_to_timoshenkos_exact_ones(section, pinned):
    """The shear force is constant along an element, which is order two in what shear takes: 1 % of the first frequency at ten
    diameters. With 40 elements the error is below 6e-3 of that, whatever the shaft."""
    shaft = Shaft((section,))
    near = free_or_pinned(shaft, 80, pinned)[:2]
    roots = [brentq(lambda w: exact(section, w, pinned), 0.99 * w, 1.01 * w, rtol=1e-14) for w in near]
    order, error = order_and_error(shaft, roots, pinned)
    stiff = free_or_pinned(Shaft((section,), shear=False), 80, pinned)[:2] / roots - 1.0
    assert (order > 1.9).all() and (error < 6e-3 * stiff).all() and (error[0] < 2e-6 or section.outer[0] > 0.05)


def test_beams_without_shear_converge_with_order_four_to_rayleighs_closed_form():
    shaft, k = Shaft((cylinder(1.0, 0.1),), shear=False), np.pi * np.arange(1, 4)
    gyration = 0.1 / 4.0
    roots = k**2 * gyration * np.sqrt(STEEL.young / STEEL.density / (1.0 + (gyration * k) ** 2))
    order, error = order_and_error(shaft, roots, pinned=True)
    assert order == pytest.approx([4.0] * 3, abs=0.1) and (error < 1e-6 * np.array([1.0, 2.0, 9.0])).all()


@pytest.mark.parametrize("pinned, numbers", [(True, np.pi * np.arange(1, 4)), (False, [4.730040744862704, 7.853204624095838])])
def test_a_slender_beam_has_the_frequencies_of_euler_and_bernoulli(pinned, numbers):
    shaft = Shaft((cylinder(1.0, 1e-3),), shear=False)
    wanted = np.array(numbers) ** 2 * np.sqrt(STEEL.young / STEEL.density) * 1e-3 / 4.0
    found = free_or_pinned(shaft, 40, pinned)[: len(wanted)]
    assert found == pytest.approx(wanted, rel=4e-6)  # the rotary inertia of the cross-sections takes up to 2.8e-6


def test_a_pinned_rayleigh_beam_turning_has_its_closed_form():
    """w = sin(n pi s) turns at p: p^2 (A + I k^2) - 2 Omega p I k^2 = E/rho I k^4."""
    shaft, k, Omega = Shaft((cylinder(1.0, 0.1),), shear=False), np.pi, 2.0 * np.pi * 500.0
    area, inertia = np.pi * 0.05**2, np.pi / 4.0 * 0.05**4
    square = STEEL.young / STEEL.density * inertia * k**4
    wanted = np.sort(np.roots([area + inertia * k**2, -2.0 * Omega * inertia * k**2, -square]))
    model = bare_model(shaft, np.linspace(0.0, 1.0, 41))
    kept = np.setdiff1d(np.arange(model.n), [0, model.n - 2])
    m, g, k = (matrix[np.ix_(kept, kept)] for matrix in (model.mass, model.gyroscopic, model.stiffness))
    zero, one = np.zeros_like(m), np.eye(len(m))
    inverse = scipy.linalg.eigvals(np.linalg.solve(np.block([[zero, one], [k, Omega * g]]), np.block([[one, zero], [zero, m]])))
    assert [1.0 / inverse.real[np.abs(inverse - 1.0 / w).argmin()] for w in wanted] == pytest.approx(wanted, rel=1e-6)


def test_a_cone_is_the_limit_of_its_steps():
    """Mass exactly; stiffness and natural frequencies of a hollow cone, of a few elements, are those of 4000 cylinders."""
    cone = Section(0.5, (0.08, 0.04), (0.03, 0.01), STEEL)
    numbers = (np.arange(800) + 0.5) / 800.0
    steps = [cylinder(0.5 / 800, 0.08 - 0.04 * s, 0.03 - 0.02 * s) for s in numbers]
    assert cone.mass == pytest.approx(sum(step.mass for step in steps), rel=1e-5)
    assert element(cone).mass[[0, 0, 2, 2], [0, 2, 0, 2]].sum() == pytest.approx(cone.mass, rel=1e-12)
    whole = bare_model(Shaft(tuple(steps)), np.linspace(0.0, 0.5, 801))
    inner = np.arange(2, 1600)
    ends = np.setdiff1d(np.arange(1602), inner)
    a, b = whole.stiffness[np.ix_(inner, inner)], whole.stiffness[np.ix_(inner, ends)]
    static = whole.stiffness[np.ix_(ends, ends)] - b.T @ scipy.linalg.solve(a, b, assume_a="pos")
    assert element(cone).stiffness == pytest.approx(static, rel=2e-5, abs=1e-6 * abs(static).max())
    few = free_or_pinned(Shaft((cone,)), 40, False)[:3]
    coarser = tuple(cylinder(0.5 / 160, 0.08 - 0.04 * s, 0.03 - 0.02 * s) for s in (np.arange(160) + 0.5) / 160.0)
    assert few == pytest.approx(free_or_pinned(Shaft(coarser), 160, False)[:3], rel=1e-3)


def lateral(model, reference):
    """Largest difference of each matrix from ROSS's, as a share of its largest entry."""
    names = ("mass", "stiffness", "damping", "gyroscopic", "anisotropic_stiffness", "anisotropic_damping")
    differences = {}
    for name in names:
        own, other = getattr(model, name), getattr(reference, name)
        assert (own is None) == (other is None)
        if own is not None and abs(other).max():
            differences[name] = abs(own - other).max() / abs(other).max()
    return differences


def test_the_rotor_of_ross_tutorial_typed_as_stations_has_its_matrices():
    sections = tuple(cylinder(0.25, 0.05, material=ROSS_STEEL) for _ in range(6))
    disks = tuple(Disk(place, *disk_inertias(0.28, 0.05, 0.07, ROSS_STEEL.density)) for place in (0.5, 1.0))
    supports = tuple(bearing(place, 1e6, other=(8e5, 0.0)) for place in (0.0, 1.5))
    shaft = Shaft(sections, disks=disks, supports=supports)
    model = model_of(shaft, shaft.stations, "typed")
    assert max(lateral(model, read_ross(DATA / "machines" / "ross_rotor.mat")).values()) < 1e-9


def rub_rotor():
    """ROSS's rub rotor typed as stations, and its own matrices."""
    data = tomllib.loads((DATA / "raw" / "ross_rub_rotor.toml").read_text())
    places = 1e-3 * np.array(data["shaft"]["node_positions_mm"])
    material = Material(data["shaft"]["density"], data["shaft"]["youngs_modulus"], 0.2992610837438423)  # as in its source
    sections = tuple(cylinder(length, data["shaft"]["outer_diameter"], material=material) for length in np.diff(places))
    disc = data["disc"]
    disks = tuple(Disk(places[n], disc["mass"], disc["polar_inertia"], disc["diametral_inertia"]) for n in disc["nodes"])
    supports = tuple(bearing(places[b["node"]], b["kxx"], b["cxx"], (b["kyy"], b["cyy"])) for b in data["bearing"])
    rayleigh = data["shaft"]["rayleigh_alpha"], data["shaft"]["rayleigh_beta"]
    shaft = Shaft(sections, disks=disks, supports=supports, rayleigh=rayleigh)
    return model_of(shaft, shaft.stations, "typed"), read_ross(DATA / "machines" / "ross_rub_rotor.mat", 20.0)


def test_the_rub_rotor_of_ross_typed_as_stations_has_its_matrices():
    assert max(lateral(*rub_rotor()).values()) < 1e-9


@pytest.mark.nightly
def test_the_rub_rotor_of_ross_typed_as_stations_has_its_modes():
    own, other = ([(m.frequency, m.decrement) for m in slowest_modes(each, 20.0, 8)] for each in rub_rotor())
    assert np.array(own) == pytest.approx(np.array(other), rel=1e-6, abs=2e-7)


def random_shaft(number):
    """Sections, cones, disks and bearings that no machine has, but could have."""
    draw = np.random.default_rng(number)
    sections = []
    for _ in range(draw.integers(2, 8)):
        outer = draw.uniform(0.02, 0.15)
        ends = (outer, outer * draw.uniform(0.6, 1.4)) if draw.random() < 0.3 else (outer, outer)
        bore = draw.uniform(0.0, 0.6) * min(ends) if draw.random() < 0.4 else 0.0
        sections.append(Section(draw.uniform(0.02, 0.5), ends, (bore, bore), STEEL))
    length = sum(section.length for section in sections)
    disks = []
    for place in np.sort(draw.uniform(0.0, length, draw.integers(0, 4))):
        disks.append(Disk(place, *disk_inertias(draw.uniform(0.2, 0.5), 0.1, draw.uniform(0.01, 0.05), 7850.0)))
    shares = draw.uniform(0.0, 0.2), draw.uniform(0.7, 1.0)
    supports = tuple(bearing(share * length, 10.0 ** draw.uniform(6.0, 8.5)) for share in shares)
    return Shaft(tuple(sections), disks=tuple(disks), supports=supports, places={"contact": draw.uniform(0.0, length)})


@pytest.mark.parametrize("number", first(range(20), 3))
def test_what_is_stated_of_the_refinement_is_true(number):
    """Halved twice, and turning, the lowest modes change by hardly more than what was stated of halving once."""
    shaft, top = random_shaft(number), 600.0
    made = divided(shaft, top, "random")
    assert made.change <= CHANGE and made.modes >= 4
    quarters = [a + (b - a) * share for a, b in pairwise(made.nodes) for share in (0.0, 0.25, 0.5, 0.75)]
    fine = model_of(shaft, [*quarters, made.nodes[-1]], "four times as many")
    own, other = (natural_frequencies(model)[: made.modes] for model in (made.model, fine))
    # by order two the stated change and a quarter of it; where a coarse shaft does not converge so yet, up to a half
    assert np.abs(own / other - 1.0).max() <= 1.5 * made.change + 1e-9
    own, other = ([mode.frequency for mode in slowest_modes(model, 50.0, 4)] for model in (made.model, fine))
    assert own == pytest.approx(other, rel=2.0 * CHANGE)


def test_elements_may_be_given():
    shaft = Shaft((cylinder(0.5, 0.05), cylinder(0.5, 0.04)), supports=(bearing(0.0, 1e8), bearing(1.0, 1e8)))
    made = divided(shaft, 500.0, "given", elements=1)
    assert len(made.nodes) == 3 and made.change > CHANGE and f"{made.change:.1e}" in made.words


def test_massless_journals_are_condensed_and_change_nothing_but_their_mass():
    """A disk between massless halves on massless journals is Jeffcott's: 48 E I / L^3 in series with the bearings."""
    bare = Material(0.0, 210e9, 0.3)
    shaft = Shaft(
        tuple(cylinder(0.1, 0.02, material=bare) for _ in range(5)),
        disks=(Disk(0.25, 10.0, 0.05, 0.03),), supports=(bearing(0.0, 1e6), bearing(0.5, 1e6)), places={"contact": 0.25},
        shear=False,
    )  # fmt: skip
    model = divided(shaft, 200.0, "Jeffcott").model
    assert model.n == 4  # displacement and tilt of the disk, displacements of both journals
    stiff = 48.0 * 210e9 * np.pi / 64.0 * 0.02**4 / 0.5**3
    wanted = np.sqrt(1.0 / (1.0 / stiff + 1.0 / 2e6) / 10.0) / (2.0 * np.pi)
    assert natural_frequencies(model)[0] == pytest.approx(wanted, rel=1e-9)
    assert np.trace(model.mass) == pytest.approx(10.03)


def test_a_sleeve_adds_mass_and_stiffness():
    """A shaft of 40 mm in a sleeve of 40 to 60 mm is one of 60 mm, but for the shear of the cross-section."""
    supports = bearing(0.0, 1e9), bearing(1.0, 1e9)
    sleeve = Section(1.0, (0.06, 0.06), (0.04, 0.04), STEEL)
    both = Shaft((cylinder(1.0, 0.04),), sleeves=((0.0, sleeve),), supports=supports, shear=False)
    one = Shaft((cylinder(1.0, 0.06),), supports=supports, shear=False)
    assert both.mass == pytest.approx(one.mass) and both.diameter_at(0.3) == 0.06
    places = np.linspace(0.0, 1.0, 9)
    a, b = (model_of(shaft, places, "sleeve") for shaft in (both, one))
    for name in ("mass", "stiffness", "gyroscopic"):
        own, other = getattr(a, name), getattr(b, name)  # entries in which two elements cancel are rounding
        assert own == pytest.approx(other, rel=1e-9, abs=1e-14 * np.abs(other).max())


def test_the_mass_of_a_rotor_is_shared_among_planes():
    shaft = Shaft((cylinder(1.0, 0.05),), disks=(Disk(0.2, 3.0, 0.02, 0.01), Disk(0.8, 5.0, 0.03, 0.02)))
    own = shaft.sections[0].mass
    assert shaft.masses_near([0.2, 0.8]) == pytest.approx([3.0 + 0.5 * own, 5.0 + 0.5 * own])
    assert sum(shaft.masses_near([0.1, 0.4, 0.9])) == pytest.approx(shaft.mass)
    assert shaft.masses_near([0.4]) == [pytest.approx(8.0 + own)]


def test_internal_damping_makes_a_fast_rotor_unstable():
    """Above the critical speed multiplied by 1 + (damping at rest over damping that turns), of a rotor on stiff bearings."""
    supports = bearing(0.0, 1e10), bearing(1.0, 1e10)
    shaft = Shaft((cylinder(1.0, 0.03),), supports=supports, rotating_damping=1e-5, rayleigh=(0.0, 1e-5))
    model = divided(shaft, 100.0, "damped").model
    critical = natural_frequencies(model)[0]
    slow, fast = (max(mode.growth_rate for mode in slowest_modes(model, share * critical, 2)) for share in (1.9, 2.1))
    assert slow < 0.0 < fast


@pytest.mark.parametrize(("places", "free"), [((), True), ((0.5,), True), ((0.1, 0.9), False)])
def test_a_shaft_that_nothing_holds_is_divided_by_its_bending_modes(places, free):
    supports = tuple(bearing(place, 1e7) for place in places)
    made = divided(Shaft((cylinder(1.0, 0.05),), supports=supports, shear=False), 500.0, "free")
    assert made.model.free == free and made.change <= CHANGE
    if not places:  # a uniform beam with free ends
        bending = 4.7300407**2 / (2.0 * np.pi) * np.sqrt(210e9 * 0.05**2 / 16.0 / 7850.0)
        bending /= np.sqrt(1.0 + 0.05**2 / 16.0 * 49.4809)  # rotary inertia: mean square slope of that mode (Rayleigh's quotient)
        assert natural_frequencies(made.model, 500.0)[0] == pytest.approx(bending, rel=1e-4)
