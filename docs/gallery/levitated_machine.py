"""A compressor shaft in two magnetic bearings: what its controllers make of its modes, and the drop when both of them fail.

The shaft is described by its stations; the sensors are not where the magnets are. It is reduced with its controllers switched on.
Left: its modes while the derivative gains change. Right: the drop into two auxiliary bearings, whose races turn.
"""

import matplotlib.pyplot as plt
import numpy as np

import rsc

SCENE = """
stator = {model = "matrices", mass = [[1.2, 0], [0, 1.2]], stiffness = [[2e7, 0], [0, 2e7]], damping = [[3e3, 0], [0, 3e3]]}
drive = {speed = "60 Hz", duration = "0.2 s"}
start = {running = true}
reduction = {band = ["-800 Hz", "800 Hz"]}
[rotor]
model = "shaft"
sections = [{length = 0.9, diameter = 0.05}]
disks = [{at = 0.5, diameter = 0.3, width = 0.03}]
rayleigh = [0.0, 2e-5]
unbalance = "G 2.5"
gravity = 9.81
"""
MAGNET = """
[[rotor.magnetic_bearings]]
at = {at}
sensor_at = {sensor}
off = 0.02                   # both fail
negative_stiffness = 4e5
proportional = 2e6
integral = 1e7
derivative = 1200
derivative_filter = 2e4
amplifier = 1500
"""
LAW = "gap = 2.5e-4\nfriction = 0.2\nstiffness = 1e7\ndamping = 500\nslip_velocity = 0.02\nrace_inertia = 2e-4\nrace_drag = 2e-5"
CATCHER = """
[[contact]]
name = "{name}"
at = {at}
stator_coordinate = {i}
""" + LAW
PLACES = {"front": 0.15, "rear": 0.75}
magnets = [MAGNET.format(at=at, sensor=sensor) for at, sensor in ((0.1, 0.06), (0.8, 0.84))]
catchers = [CATCHER.format(name=name, at=at, i=i) for i, (name, at) in enumerate(PLACES.items())]
scene = rsc.Scene.from_toml(SCENE + "".join(magnets + catchers))

figure, (roots, orbit, force) = plt.subplots(1, 3, figsize=(11, 4), layout="constrained", width_ratios=(1.3, 1, 1.3))
for factor in np.geomspace(0.1, 4.0, 41):
    modes = rsc.modes(scene.with_values({f"rotor.magnetic_bearings[{i}].derivative": 1200.0 * factor for i in (0, 1)}))
    swinging = [mode for mode in modes.rotor if 0.0 < mode.frequency < 800.0]
    roots.scatter([m.growth_rate for m in swinging], [m.frequency for m in swinging], s=9, c="C3" if factor < 1.0 else "C0")
roots.axvline(0.0, color="k", linewidth=0.8)
roots.set(xlabel="growth rate in 1/s", ylabel="forward modes in Hz", xlim=(-800, 50), title="derivative gains times 0.1 to 4")

result, angle = rsc.simulate(scene), np.linspace(0.0, 2.0 * np.pi, 200)
for i, name in enumerate(PLACES):
    orbit.plot(result.rotor[:, i].real * 1e3, result.rotor[:, i].imag * 1e3, linewidth=0.6, label=name)
    force.plot(result.time, result.normal_force[:, i], linewidth=0.6, label=name)
    most, last = (result.stretches(name).between(begin, 0.2).force_max / 1e3 for begin in (0.0, 0.15))
    print(f"{name}: up to {most:.1f} kN, in the last 50 ms {last:.1f} kN")
orbit.plot(0.25 * np.cos(angle), 0.25 * np.sin(angle), "k", linewidth=0.8)
orbit.set(title="orbits in the auxiliary bearings", aspect="equal", xlabel="y in mm", ylabel="z in mm")
force.set(title="both magnetic bearings fail at 20 ms", xlabel="time in s", ylabel="normal force in N")
figure.savefig("levitated_machine.png", dpi=75)
held = [mode for mode in rsc.modes(scene).rotor if 0.0 < mode.frequency < 300.0 and mode.growth_rate > -1e3]
print("levitated:", ", ".join(f"{mode.frequency:.1f} Hz with {mode.growth_rate:+.0f} 1/s" for mode in held))
after = f"{scene.rotor.n_coordinates}, with an error of {scene.rotor.error:.1e}"
print(f"{scene.reductions[0].full.n_coordinates} coordinates reduced to {after}")
