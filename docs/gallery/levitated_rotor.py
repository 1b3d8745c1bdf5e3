"""Magnetic bearing: a rotor that loses it and drops, and one that it catches again, with an inner race that turns or does not.

A rotor of 5 kg turns at 100 Hz in a magnetic bearing with its controller, inside an auxiliary bearing. Either the bearing
fails and the rotor drops, or a blow throws the levitated rotor against the auxiliary bearing while the controller goes on.
"""

import matplotlib.pyplot as plt
import numpy as np

import rsc

CONTROLLER = "proportional = 3e5, integral = 1e6, derivative = 200, derivative_filter = 1e4, amplifier = 500"
MAGNET = f"negative_stiffness = 5e4, {CONTROLLER}"
SCENE = """
[rotor]
model = "laval"
mass = 5.0
stiffness = 0.0              # nothing but the magnetic bearing holds it
eccentricity = "20 um"
gravity = 9.81
magnetic_bearings = [[0, {{{magnet}{off}}}]]
[stator]                     # housing of the auxiliary bearing
model = "laval"
mass = 1.5
frequency = "180 Hz"
damping_ratio = 0.1
[contact]
gap = "0.25 mm"
friction = 0.3
stiffness = "20 kN/mm"
damping = 500
diameter = "60 mm"
slip_velocity = 0.02
race_inertia = {inertia}
race_drag = 2e-5
[drive]
speed = "100 Hz"
duration = "0.8 s"
[start]
running = true
"""
EVENTS = {  # off, start
    "bearing fails": (', off = "0.1 s"', ""),
    "blow, bearing stays": ("", 'impulse = ["2 N*s", 0.0]'),
}
RACES = {"race that does not turn": 1e6, "race that spins up": 2e-4}  # inertia in kg m2
angle = np.linspace(0.0, 2.0 * np.pi, 200)

figure, panels = plt.subplots(2, 3, figsize=(10, 6.4), layout="constrained", width_ratios=(1, 1, 1.5))
for (event, (off, blow)), row in zip(EVENTS.items(), panels, strict=True):
    for (race, inertia), ax, colour in zip(RACES.items(), row, ("C3", "C0"), strict=False):
        scene = rsc.Scene.from_toml(SCENE.format(magnet=MAGNET, off=off, inertia=inertia) + blow)
        result = rsc.simulate(scene)
        orbit, gap = result.rotor[:, 0], scene.contact.gap
        ax.plot(orbit.real * 1e3, orbit.imag * 1e3, color=colour, linewidth=0.5)
        ax.plot(*(gap * 1e3 * np.array([np.cos(angle), np.sin(angle)])), "k", linewidth=0.8)
        ax.set(title=f"{event}:\n{race}", aspect="equal", xlabel="y in mm", xlim=(-1.4, 1.4), ylim=(-1.4, 1.4))
        row[2].plot(result.time, result.normal_force, color=colour, linewidth=0.8, label=race)
        last = result.stretches().between(0.6, 0.8)
        print(f"{event}, {race}: {result.stretches().whole().force_max / 1e3:.1f} kN at most;", end=" ")
        print(f"in the last 0.2 s in contact for {last.share:.0%}, up to {last.force_max:.0f} N,", end=" ")
        print(f"{round(last.turning)} turns per second")
    for one in rsc.predict(scene):
        print(f"{event}, predicted: {one.frequency:.1f} Hz, {one.normal_force:.0f} N, growth rate {one.growth_rate:+.0f} 1/s")
    row[0].set(ylabel="z in mm")
    row[2].set(xlabel="time in s", ylabel="normal force in N", title=event)
panels[0, 2].legend()
figure.savefig("levitated_rotor.png", dpi=80)
