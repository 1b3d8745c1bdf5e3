"""Drop of a finite-element rotor from two bearings into two auxiliary bearings with inner races.

The shaft is described by its stations, 30 elements with 62 complex coordinates, and reduced to its motions below 1 kHz. The
titles of the plot have the processor time of reduction and simulation.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import rsc

ROTOR = """
stator = {model = "matrices", mass = [[1.2, 0], [0, 1.2]], stiffness = [[2e7, 0], [0, 2e7]], damping = [[3e3, 0], [0, 3e3]]}
drive = {speed = "100 Hz", duration = "0.5 s"}
start = {running = true}
reduction = {band = ["-1000 Hz", "1000 Hz"]}
[rotor]
model = "shaft"
elements = 3                 # between neighbouring stations
sections = [{length = 0.3, diameter = 0.05}, {length = 0.6, diameter = 0.07}, {length = 0.3, diameter = 0.05}]
disks = [{at = 0.5, diameter = 0.3, width = 0.03, name = "one"}, {at = 0.7, diameter = 0.3, width = 0.03, name = "two"}]
rayleigh = [0.0, 1e-6]
bearings = [
    {at = 0.15, stiffness = 2e6, damping = 2e3, off = "20 ms"},
    {at = 1.05, stiffness = 2e6, damping = 2e3, off = "20 ms"},
]
unbalance = [{at = "one", amount = "200 g*mm"}]
observers = [0.6]            # midspan
gravity = 9.81
"""
AUXILIARY = 'gap = "0.25 mm"\nfriction = 0.3\nstiffness = 1e7\ndamping = 1000\nslip_velocity = 0.02\nrace_drag = 2e-5'
PLACES = {"front": "0.2 m", "rear": "1.0 m"}
RACES = {"races that do not turn": 1e6, "races that spin up": 2e-4}  # inertia in kg m2


def dropped(inertia):
    contact = '\n[[contact]]\nname = "{}"\nat = "{}"\nstator_coordinate = {}\nrace_inertia = {}\n' + AUXILIARY
    ends = [contact.format(name, at, i, inertia) for i, (name, at) in enumerate(PLACES.items())]
    return rsc.Scene.from_toml(ROTOR + "".join(ends))


def with_all_coordinates(scene):
    """The same rotor as matrices, in the first auxiliary bearing only."""
    body, content = scene.reductions[0].full, scene.to_dict()
    names = "mass", "stiffness", "damping", "gyroscopic"
    content["rotor"] = {"model": "matrices", **{name: getattr(body, name).tolist() for name in names}}
    content["contact"] = {**content["contact"][0], "rotor_coordinate": int(np.argmax(body.contact[0]))}
    return rsc.Scene.from_dict({**content, "start": {"centre": True}})


figure, panels = plt.subplots(2, 2, figsize=(9, 7), layout="constrained", width_ratios=(1, 1.5))
for (race, inertia), (orbits, forces) in zip(RACES.items(), panels, strict=True):
    begin = time.process_time()
    scene = dropped(inertia)
    result = rsc.simulate(scene)
    forces.set(title=f"{time.process_time() - begin:.1f} s of processor time", xlabel="time in s", ylabel="normal force in kN")
    forces.set(yscale="log", ylim=(0.01, 1e3))
    for i, name in enumerate(PLACES):
        orbits.plot(result.rotor[:, i].real * 1e3, result.rotor[:, i].imag * 1e3, linewidth=0.6, label=name)
        forces.plot(result.time, result.normal_force[:, i] / 1e3, linewidth=0.6, label=name)
        last = result.stretches(name).between(0.48, 0.5)
        print(f"{race}, {name}: in the last 20 ms up to {last.force_max / 1e3:.1f} kN, {round(last.turning)} turns per second")
    orbits.set(title=race, aspect="equal", xlabel="y in mm", ylabel="z in mm", xlim=(-0.8, 0.8), ylim=(-0.8, 0.8))
panels[0, 1].legend(title="auxiliary bearing", loc="upper left")
figure.savefig("shaft_drop.png", dpi=80)
print(f"{scene.reductions[0].full.n_coordinates} coordinates reduced to {scene.rotor.n_coordinates}")
whirls = rsc.predict(with_all_coordinates(scene)), [one for one in rsc.predict(scene) if one.pressed == ("front",)]
print("whirl at the front alone:", " and ".join(f"{whirl.frequency:.3f} Hz, {whirl.growth_rate:+.1f} 1/s" for (whirl,) in whirls))
