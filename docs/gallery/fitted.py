"""Fitting a scene to a measured run: friction, gap and stiffnesses that explain a whirl measured by two probes.

The "measurement" is a simulated run, seen by two probes with noise and runout, so that the truth is known. The scene that is
fitted to it begins 15 to 25 % off, where it has no such whirl. The fit tells friction, gap and casing; the contact's stiffness
it tells worst, and says by how much.
"""

import math

import rsc

TRUTH = rsc.Scene.from_toml("""
title = "Pump rotor in its casing ring, fitted"
rotor = {model = "laval", mass = "12 kg", frequency = "2600 rpm", damping_ratio = 0.02, eccentricity = "0.02 mm"}
stator = {model = "laval", mass = "3 kg", frequency = "160 Hz", damping_ratio = 0.1}
contact = {gap = "0.25 mm", friction = 0.2, stiffness = "50 kN/mm", damping_ratio = 0.05}
drive = {speed = ["40 Hz", "60 Hz"], duration = "8 s"}
start = {whirl = "backward"}
output = {rate = 5000.0}
""")
GUESS = TRUTH.with_values(
    {"contact.friction": 0.24, "contact.gap": 2.1e-4, "contact.stiffness": 4e7, "stator.frequency": 140.0}
)
FREE = ("contact.friction", "contact.gap", "contact.stiffness", "stator.stiffness")

table = rsc.write_measured(rsc.simulate(TRUTH), "bench.toml", noise=2e-6, runout=3e-6)  # as `rsc run --as-measured`
measured = rsc.read_measured(table)
before = rsc.compare(GUESS, measured)
print(f"the scene as guessed: {before.agreement.partition(';')[0]}")

fit = rsc.fit(GUESS, measured, FREE)
print(f"fitted in {fit.runs} runs, misfit {fit.misfit:.1f}, {'converged' if fit.converged else 'not converged'}")
casing = 3.0 * (2.0 * math.pi * 160.0) ** 2
for value, truth in zip(fit.values, (0.2, 2.5e-4, 5e7, casing), strict=True):
    off = 100.0 * (value.value / truth - 1.0)
    wide, unit = 50.0 * (value.high - value.low) / value.value, value.unit.strip("1")
    print(f"{value.name}: {value.value:.3g} {unit}".rstrip() + f", 68 % within {wide:.1f} %; {off:+.1f} % from the truth")

report = rsc.compare(fit.scene, measured)
print(f"the scene as fitted: {report.agreement}")
report.save_html("fitted.html")
report.plot("amplitude").figure.savefig("fitted.png")
