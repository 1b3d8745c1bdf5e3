"""Rotor on journal bearings: speed-dependent coefficients; above a threshold the oil film drives a forward whirl into the seal.

Coefficients at each speed are those of a short plain bearing: the film's force, differentiated where it carries the weight.
Deflections are counted from that place, so the scene has no gravity. The clearance that is watched is the film left below the
journal: beyond it no linear film holds.
"""

import numpy as np
from scipy.optimize import root

import rsc
from rsc.show.words.answer import answer

RADIUS, LENGTH, CLEARANCE, OIL = 0.025, 0.02, 5e-5, 0.015  # m, m, m, Pa s
WEIGHT = 22.0 * 9.81  # N on each bearing
ANGLE = np.linspace(0.0, 2.0 * np.pi, 20000, endpoint=False)


def film(place, velocity, Omega):
    """Force of the oil on the journal, complex N: the pressure of a short bearing, where it is positive."""
    h = CLEARANCE - (place * np.exp(-1j * ANGLE)).real
    slope, rate = -(place * np.exp(-1j * ANGLE)).imag, -(velocity * np.exp(-1j * ANGLE)).real
    pressure = np.maximum(-0.5 * OIL * LENGTH**3 * (Omega * slope + 2.0 * rate) / h**3, 0.0)
    return -np.mean(pressure * np.exp(1j * ANGLE)) * 2.0 * np.pi * RADIUS


def knot(speed):
    """(speed in Hz, four stiffnesses, four dampings, eccentricity over the clearance) of one bearing under its weight."""
    Omega = 2.0 * np.pi * speed

    def left(x):
        force = film(CLEARANCE * complex(*x), 0.0, Omega) - 1j * WEIGHT
        return force.real, force.imag

    place = CLEARANCE * complex(*root(left, (0.3, -0.5)).x)
    step, speed_step = 1e-3 * CLEARANCE, 1e-3 * CLEARANCE * Omega
    k = [(film(place - step * e, 0.0, Omega) - film(place + step * e, 0.0, Omega)) / (2.0 * step) for e in (1.0, 1j)]
    c = [(film(place, -speed_step * e, Omega) - film(place, speed_step * e, Omega)) / (2.0 * speed_step) for e in (1.0, 1j)]
    return speed, *([one.real, two.real, one.imag, two.imag] for one, two in (k, c)), abs(place) / CLEARANCE


knots = [knot(speed) for speed in np.linspace(20.0, 170.0, 11)]
print("eccentricity of the journal:", ", ".join(f"{share:.2f} at {speed:.0f} Hz" for speed, _, _, share in knots[::5]))
supports = [list(one[:3]) for one in knots]
film_left = CLEARANCE * (1.0 - knots[-1][3])

scene = rsc.Scene.from_dict({
    "title": "Rotor on two journal bearings, seal at the disc",
    "rotor": {
        "model": "chain", "masses": [2.0, 40.0, 2.0], "stiffnesses": [0.0, 4e6, 4e6, 0.0], "dampings": [0.0, 200.0, 200.0, 0.0],
        "eccentricity": [0.0, 5e-6, 0.0], "supports_by_speed": [[0, supports], [2, supports]],
    },
    "stator": {"model": "laval", "mass": 15.0, "frequency": 80.0, "damping_ratio": 0.1},
    "contact": {"rotor_coordinate": 1, "gap": 1.5e-4, "friction": 0.1, "stiffness": 2e7, "damping_ratio": 0.05, "diameter": 0.12},
    "clearance": [{"name": "oil_film", "rotor_coordinate": 0, "gap": film_left}],
    "drive": {"speed": [30.0, 137.0], "duration": 10.7},
})  # fmt: skip

for speed in (80.0, 100.0, 120.0, 140.0, 160.0):
    mode = max(rsc.modes(scene, speed).rotor, key=lambda mode: mode.growth_rate)
    print(f"{speed:.0f} Hz: {mode.frequency:.1f} Hz, growth {mode.growth_rate:+.1f} 1/s")

report = rsc.check(scene)
told = dict(answer(report))
print(f"{told['whirl']}; {told['clearances']}")
report.save_html("journal_bearings.html")
report.plot("campbell").figure.savefig("journal_bearings.png")
